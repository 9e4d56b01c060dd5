"""Interactive figures: lines and maps whose numbers a reader can point at and take along.

Colors of ink and grid come from the style sheet of the page, so that one figure serves light, dark
and paper.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from bokeh.models import (
    BasicTicker,
    ColumnDataSource,
    DataRange1d,
    HoverTool,
    InlineStyleSheet,
    LinearColorMapper,
    LogTicker,
    NoOverlap,
    PrintfTickFormatter,
)
from bokeh.models.annotations import ColorBar
from bokeh.plotting import figure as new_plot
from numpy.typing import ArrayLike, NDArray

from surfaces.units import suited

__all__ = [
    "Figure",
    "Layer",
    "Line",
    "line_figure",
    "map_figure",
    "reduced",
    "reduction",
    "touched",
]

TOOLS = "pan,box_zoom,wheel_zoom,reset,save"

HEIGHT = 360
"""Height of a figure of lines [CSS pixels]."""

DECADE = 10.0
"""Ratio of the largest to the smallest value from which on an axis is logarithmic."""

LEVELS = 4096
"""Values between the lowest and the highest of a map, to which those shown are rounded."""

SHOWN = 512
"""Points along the longer side up to which a map is shown as it is."""

WIDTH, BESIDE, BELOW, BARE = 480, 85, 112, 55
"""Width of a map, what its axis and tools take of it, and its axis and bar below it, or its axis
alone [CSS pixels]; a page scales them."""

LEGEND, KEY = 60, 5
"""Letters that fit beside each other in a legend, also on a phone, and those that a key takes."""

INK = "#7d8791"
"""Color of text that no style sheet reaches, legible on white and on black."""

CLEAR = "rgba(0, 0, 0, 0)"

NO_PRINT = "@media print { :host { display: none; } }"


@dataclass(frozen=True)
class Figure:
    """A figure on a page.

    Attributes
    ----------
    plot
        The Bokeh model.
    title
        What it shows; also the name of its CSV file.
    note
        What to know when reading it.
    keys
        Colors and what they mean, where neither a legend nor a bar of colors says it.
    """

    plot: Any
    title: str
    note: str = ""
    keys: Sequence[tuple[str, str]] = ()


@dataclass(frozen=True)
class Line:
    """A line of a figure.

    Attributes
    ----------
    label
        Name in the legend and in the CSV file.
    columns
        Its numbers by their names with unit, one value per point each; all of them are told of a
        point.
    color, marker, dash
        Looks; without marker a line alone, without dash points alone.
    band
        Names of the columns that bound the shaded band, if there is one.
    """

    label: str
    columns: Mapping[str, ArrayLike]
    color: str
    marker: str = "circle"
    dash: str = "solid"
    band: tuple[str, str] | None = None

    @property
    def name(self) -> str:
        """The label, in which nothing is a formula."""
        return self.label.replace("$$", "$ $").replace("\\(", "\\ (").replace("\\[", "\\ [")


def line_figure(lines: Sequence[Line], x: str, y: str, *, linear: str = "") -> Any:
    """Lines over a common column.

    Parameters
    ----------
    lines
        What to draw; points that lack either number are left out.
    x, y
        Names of the columns on the axes.
    linear
        Axes ("x", "y") that stay linear however far the values reach; others are logarithmic from
        a decade on.
    """
    kinds: dict[str, Any] = {
        name: "linear" if name in linear else _axis_kind(lines, column)
        for name, column in (("x", x), ("y", y))
    }
    plot: Any = new_plot(
        height=HEIGHT,
        sizing_mode="stretch_width",
        tools=TOOLS,
        active_drag=None,
        x_axis_label=x,
        y_axis_label=y,
        x_axis_type=kinds["x"],
        y_axis_type=kinds["y"],
        **_BARE,
    )
    hovered: list[Any] = []
    for line in lines:
        source = _source(line, x, y, kinds)
        if line.band is not None:
            plot.varea(x, *line.band, source=source, color=line.color, alpha=0.18)
        legend = {"legend_label": line.name}
        if line.dash:
            drawn = plot.line(
                x, y, source=source, color=line.color, width=2, line_dash=line.dash, **legend
            )
        if line.marker:
            drawn = plot.scatter(
                x, y, source=source, color=line.color, marker=line.marker, size=7, **legend
            )
        names = [("", line.name), *((name, f"@{{{name}}}{{%.4g}}") for name in line.columns)]
        how: dict[str, Any] = {f"@{{{name}}}": "printf" for name in line.columns}
        hovered.append(HoverTool(renderers=[drawn], tooltips=names, formatters=how))
    plot.add_tools(*hovered)
    for axis, kind in ((plot.xaxis, kinds["x"]), (plot.yaxis, kinds["y"])):
        axis.formatter = PrintfTickFormatter(format="%.4g")
        if kind == "log":
            axis.ticker = LogTicker(mantissas=[1, 2, 5], desired_num_ticks=5)
    if plot.legend:
        plot.add_layout(plot.legend[0], "above")
        plot.legend.update(
            orientation="horizontal",
            ncols=max(1, LEGEND // (max(len(line.name) for line in lines) + KEY)),
            click_policy="hide",
            border_line_color=None,
            label_text_color=INK,
            background_fill_color=None,
            padding=0,
            margin=0,
        )
    return _finished(plot)


@dataclass(frozen=True)
class Layer:
    """A field over a map.

    Attributes
    ----------
    label, unit
        What it is, and the unit in which it is shown.
    values
        In that unit, shape (ny, nx); NaN is transparent.
    palette
        Colors from low to high.
    low, high
        Values of the ends of the palette.
    told
        Whether a bar explains the colors, and the reader may point at values; of the others what
        lies below `low` is transparent.
    alpha
        Opacity.
    """

    label: str
    unit: str
    values: NDArray[Any]
    palette: Sequence[str]
    low: float
    high: float
    told: bool = True
    alpha: float = field(default=1.0, kw_only=True)

    @property
    def name(self) -> str:
        """Label and unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


def map_figure(
    layers: Sequence[Layer],
    size: tuple[float, float],
    *,
    along: Any = None,
    origin: tuple[float, float] = (0.0, 0.0),
) -> Any:
    """Fields in true proportions, one over the other.

    Parameters
    ----------
    layers
        Fields of one shape, the lowest first.
    size
        Lengths (Ly, Lx) [m] of the map.
    along
        Another map that is to move along.
    origin
        Place (y, x) of the lower left corner [m].
    """
    factor, unit = suited(max(size), "m")
    (height, width), (bottom, left) = (np.divide(pair, factor) for pair in (size, origin))
    if along is None:
        across, up = DataRange1d(range_padding=0.0), DataRange1d(range_padding=0.0)
    else:
        across, up = along.x_range, along.y_range
    tall = float(np.clip(height / width, 0.35, 1.6))
    plot: Any = new_plot(
        width=WIDTH,
        height=int((WIDTH - BESIDE) * tall) + (BELOW if any(one.told for one in layers) else BARE),
        sizing_mode="scale_width",
        match_aspect=True,
        x_range=across,
        y_range=up,
        tools=TOOLS,
        active_drag=None,
        x_axis_label=f"x [{unit}]",
        y_axis_label=f"y [{unit}]",
        **_BARE,
    )
    data: dict[str, Any] = {layer.name: [reduced(layer.values)] for layer in layers}
    place = {"map x": left, "map y": bottom, "map width": width, "map height": height}
    source = ColumnDataSource(
        {**data, **{k: [float(v)] for k, v in place.items()}}, name=unit, tags=list(data)
    )
    hovered: list[Any] = []
    tips = [(f"x, y [{unit}]", "$x{0.[000]}, $y{0.[000]}")]
    for layer in layers:
        mapper = LinearColorMapper(
            palette=list(layer.palette),
            low=float(layer.low),
            high=float(layer.high),
            nan_color=CLEAR,
            low_color=None if layer.told else CLEAR,
        )
        drawn = plot.image(
            layer.name,
            **dict(zip(("x", "y", "dw", "dh"), place, strict=True)),
            source=source,
            color_mapper=mapper,
            global_alpha=layer.alpha,
        )
        if layer.told:
            tips.append((layer.name, f"@{{{layer.name}}}{{0.[0000]}}"))
            bar = ColorBar(
                color_mapper=mapper,
                title=layer.name,
                height=10,
                padding=4,
                ticker=BasicTicker(desired_num_ticks=5),
                formatter=PrintfTickFormatter(format="%.3g"),
                background_fill_color=None,
                title_text_font_style="normal",
                title_text_color=INK,
                major_label_text_color=INK,
            )
            plot.add_layout(bar, "below")
            hovered = [drawn]
    if hovered:
        plot.add_tools(HoverTool(renderers=hovered, tooltips=tips))
    plot.grid.visible = False
    return _finished(plot)


def reduced(values: NDArray[Any]) -> NDArray[Any]:
    """A map with at most `SHOWN` points along a side, means of what they cover, rounded to a
    four-thousandth of its range; whole numbers as they are."""
    if values.dtype.kind in "biu":
        return values
    shown = _averaged(values)
    finite = shown[np.isfinite(shown)]
    span = float(np.ptp(finite)) if finite.size else 0.0
    if span == 0.0:
        return shown
    unit = np.float32(2.0 ** np.floor(np.log2(span / LEVELS)))
    return np.asarray(np.round(shown / unit) * unit)


def touched(mask: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """A mask with at most `SHOWN` points along a side, 1 wherever any point that it covers is."""
    return (_averaged(mask) > 0.0).astype(np.uint8)


def reduction(shape: tuple[int, int]) -> str:
    """How a map is reduced for display, in words; nothing of a small one."""
    if max(shape) <= SHOWN:
        return ""
    ny, nx = _shown_shape(shape)
    return f"Shown are {ny} × {nx} means of the {shape[0]} × {shape[1]} points."


def _averaged(values: NDArray[Any]) -> NDArray[np.float32]:
    shown = np.asarray(values, np.float32)
    if max(shown.shape) <= SHOWN:
        return shown
    ny, nx = _shown_shape(shown.shape)
    return np.asarray(cv2.resize(shown, (nx, ny), interpolation=cv2.INTER_AREA), np.float32)


def _shown_shape(shape: Sequence[int]) -> tuple[int, int]:
    ny, nx = (max(1, round(n * SHOWN / max(shape))) for n in shape)
    return ny, nx


_BARE: dict[str, Any] = {
    "background_fill_color": None,
    "border_fill_color": None,
    "outline_line_color": None,
    "toolbar_location": "right",
}


def _finished(plot: Any) -> Any:
    """Plain toolbar, fonts and margins."""
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    plot.toolbar.stylesheets = [InlineStyleSheet(css=NO_PRINT)]
    plot.axis.axis_label_text_font_style = "normal"
    plot.axis.minor_tick_line_color = None
    plot.axis.major_label_policy = NoOverlap(min_distance=8)
    plot.min_border_right = 12
    return plot


def _axis_kind(lines: Sequence[Line], column: str) -> str:
    values = [np.asarray(line.columns[column], float) for line in lines]
    all_values = np.concatenate([part[np.isfinite(part)] for part in values] or [np.empty(0)])
    positive = all_values[all_values > 0.0]
    if positive.size < len(all_values) and (all_values < 0.0).any():
        return "linear"
    wide = positive.size > 0 and positive.max() >= DECADE * positive.min()
    return "log" if wide else "linear"


def _source(line: Line, x: str, y: str, kinds: Mapping[str, str]) -> ColumnDataSource:
    """Points of a line in the order of x, without those that cannot be drawn."""
    columns = {name: np.asarray(column) for name, column in line.columns.items()}
    usable = np.ones(len(columns[x]), bool)
    for axis, name in (("x", x), ("y", y)):
        usable &= np.isfinite(columns[name].astype(float))
        if kinds[axis] == "log":
            usable &= columns[name] > 0.0
    order = np.flatnonzero(usable)[np.argsort(columns[x][usable], kind="stable")]
    return ColumnDataSource({k: v[order] for k, v in columns.items()}, name=line.name)
