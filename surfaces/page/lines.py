"""Figures of lines: curves with their stated band, points, spectra."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, CustomJSTicker, HoverTool, PrintfTickFormatter
from numpy.typing import ArrayLike

from surfaces.drawing import logarithmic

from .figures import INK, bare_plot

__all__ = ["Line", "line_figure"]

HEIGHT = 360
"""Height of a figure of lines [CSS pixels]."""

SIDES: Any = ("right", "left", "below", "above")
"""Where a line tells of its points, in turn: beside those of lines that run along it."""

TICKS = """
const [low, high] = [cb_data.range.start, cb_data.range.end].sort((a, b) => a - b);
const decades = Math.log10(high / low), every = Math.ceil(decades / 8);
if (decades < 0.7) {
  const step = 10 ** Math.floor(Math.log10((high - low) / 2)), first = Math.ceil(low / step);
  return Array.from({length: Math.floor(high / step) - first + 1}, (_, i) => (first + i) * step);
}
const digits = decades < 3 ? [1, 2, 5] : [1], ticks = [];
for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++)
  if (power % every === 0) ticks.push(...digits.map((digit) => Number(`${digit}e${power}`)));
return ticks.filter((tick) => low <= tick && tick <= high);
"""
"""Where a logarithmic axis has numbers; those of Bokeh on less than two decades are equally far
apart, and leave most of the axis without any."""

LEGEND, KEY = 50, 5
"""Letters that fit beside each other in a legend, also on a phone, and those that a key takes."""

LEGEND_ROWS, LEGEND_ROW = 3, 24
"""Rows of a legend that the height of a figure has room for, and what each more takes [pixels]."""


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
    across = max(1, LEGEND // (max((len(line.name) for line in lines), default=1) + KEY))
    rows = -(-len(lines) // across)
    plot = bare_plot(
        height=HEIGHT + LEGEND_ROW * max(0, rows - LEGEND_ROWS),
        sizing_mode="stretch_width",
        x_axis_label=x,
        y_axis_label=y,
        x_axis_type=kinds["x"],
        y_axis_type=kinds["y"],
    )
    hovered: list[Any] = []
    for line, side in zip(lines, itertools.cycle(SIDES), strict=False):
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
        hovered.append(
            HoverTool(renderers=[drawn], tooltips=names, formatters=how, attachment=side)
        )
    plot.add_tools(*hovered)
    for axis, kind in ((plot.xaxis, kinds["x"]), (plot.yaxis, kinds["y"])):
        if kind == "log":  # others show as many digits as tell their labels apart
            axis.formatter = PrintfTickFormatter(format="%.4g")
            axis.ticker = CustomJSTicker(major_code=TICKS)
    if plot.legend:
        plot.add_layout(plot.legend[0], "above")
        plot.legend.update(
            orientation="horizontal",
            ncols=across,
            click_policy="hide",
            border_line_color=None,
            label_text_color=INK,
            background_fill_color=None,
            padding=0,
            margin=0,
        )
    return plot


def _axis_kind(lines: Sequence[Line], column: str) -> str:
    values = [np.asarray(line.columns[column], float) for line in lines]
    return "log" if logarithmic(np.concatenate([*values, np.empty(0)])) else "linear"


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
