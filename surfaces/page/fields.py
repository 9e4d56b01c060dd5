"""Figures of maps: fields in true proportions, reduced to what a page can hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from bokeh.models import (
    BasicTicker,
    ColumnDataSource,
    DataRange1d,
    HoverTool,
    LinearColorMapper,
    PrintfTickFormatter,
)
from bokeh.models.annotations import ColorBar
from numpy.typing import NDArray

from surfaces.arrays import Mask
from surfaces.drawing import averaged, color_range, prefixed_unit, shown_shape

from .figures import INK, bare_plot

__all__ = ["SHOWN", "Layer", "map_figure", "reduced", "reduction", "touched"]

LEVELS = 4096
"""Values between the lowest and the highest color of a map, to which those shown are rounded."""

SHOWN = 512
"""Points along the longer side up to which a map is shown as it is."""

WIDTH, BESIDE, BELOW, BARE = 480, 85, 112, 55
"""Width of a map, what its axis and tools take of it, and its axis and bar below it, or its axis
alone [CSS pixels]; a page scales them."""

CLEAR = "rgba(0, 0, 0, 0)"


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
    explained
        Whether a bar explains the colors, and the reader may point at values; of the others what
        lies below `low` is transparent.
    """

    label: str
    unit: str
    values: NDArray[Any]
    palette: Sequence[str]
    low: float
    high: float
    explained: bool = True

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
    """Fields of one shape in true proportions, one over the other, the lowest first.

    The map has the size (Ly, Lx) [m], and its lower left corner lies at the origin (y, x) [m];
    another one may move along.
    """
    factor, unit = prefixed_unit(max(size), "m")
    (height, width), (bottom, left) = (np.divide(pair, factor) for pair in (size, origin))
    if along is None:
        across, up = DataRange1d(range_padding=0.0), DataRange1d(range_padding=0.0)
    else:
        across, up = along.x_range, along.y_range
    tall = float(np.clip(height / width, 0.35, 1.6))
    plot = bare_plot(
        width=WIDTH,
        height=int((WIDTH - BESIDE) * tall)
        + (BELOW if any(one.explained for one in layers) else BARE),
        sizing_mode="scale_width",
        match_aspect=True,
        x_range=across,
        y_range=up,
        x_axis_label=f"x [{unit}]",
        y_axis_label=f"y [{unit}]",
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
            low_color=None if layer.explained else CLEAR,
        )
        drawn = plot.image(
            layer.name,
            **dict(zip(("x", "y", "dw", "dh"), place, strict=True)),
            source=source,
            color_mapper=mapper,
        )
        if layer.explained:
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
    return plot


def reduced(values: NDArray[Any], most: int = SHOWN) -> NDArray[Any]:
    """A map with at most `most` points along a side, means of the points present that they
    cover, rounded to a four-thousandth of its colors; whole numbers as they are."""
    if values.dtype.kind in "biu":
        return values
    shown = averaged(np.asarray(values, np.float32), most)
    low, high = color_range(shown)
    if not high > low:
        return shown
    unit = np.float32(2.0 ** np.floor(np.log2((high - low) / LEVELS)))
    return np.asarray(np.round(shown / unit) * unit)


def touched(mask: Mask, most: int = SHOWN) -> NDArray[np.uint8]:
    """A mask with at most `most` points along a side, 1 wherever any point that it covers is."""
    return (averaged(mask.astype(np.float32), most) > 0.0).astype(np.uint8)


def reduction(shape: tuple[int, int], most: int = SHOWN) -> str:
    """How a map is reduced for display, in words; nothing of a small one."""
    if max(shape) <= most:
        return ""
    ny, nx = shown_shape(shape, most)
    return f"Shown are {ny} × {nx} means of the {shape[0]} × {shape[1]} points."
