"""Drawing of heights on matplotlib axes, and figures as images of a page."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_heights", "figure_height", "image", "length_unit", "thinning"]

PIXELS = 1200
"""Largest side of a picture."""


def draw_heights(
    axes: Axes, heights: NDArray[np.float64], size: tuple[float, float], **style: Any
) -> None:
    """Draw heights [m] about their mean in true proportions, with a color bar.

    Parameters
    ----------
    axes
        Axes to draw on.
    heights
        Heights [m], shape (ny, nx); missing ones stay white. Large maps are thinned.
    size
        Lengths (Ly, Lx) [m] of the map.
    style
        Further arguments of `matplotlib.axes.Axes.imshow`.
    """
    from matplotlib.ticker import EngFormatter

    stride = thinning(heights.shape)
    about_mean = heights[::stride, ::stride] - np.nanmean(heights[::stride, ::stride])
    scale, unit = length_unit(float(np.nanmax(np.abs(about_mean))))
    shown = about_mean / scale
    low, high = np.nanquantile(shown, (0.002, 0.998))
    look: dict[str, Any] = {"cmap": "cividis", "vmin": low, "vmax": high, "aspect": "equal"}
    extent = (0.0, size[1], 0.0, size[0])
    drawn = axes.imshow(shown, origin="lower", extent=extent, **look | style)
    bar = axes.inset_axes((1.03, 0.0, 0.035, 1.0))
    axes.figure.colorbar(drawn, cax=bar, label=f"height [{unit}]", extend="both")
    for axis, label in ((axes.xaxis, "x"), (axes.yaxis, "y")):
        axis.set_major_formatter(EngFormatter(unit="m"))
        axis.set_label_text(label)


def thinning(shape: tuple[int, ...]) -> int:
    """Every how many points of a map are drawn."""
    return max(1, -(-max(shape) // PIXELS))


def figure_height(width: float, size: tuple[float, float]) -> float:
    """Height [inches] of a picture of a map of lengths (Ly, Lx), from its width."""
    return float(np.clip(width * size[0] / size[1], 1.2, 9.0))


def length_unit(largest: float) -> tuple[float, str]:
    """Metres in the unit that suits a length, and its name."""
    for factor, unit in ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")):
        if largest >= factor:
            return factor, unit
    return 1e-12, "pm"


def image(figure: Figure, dpi: int = 120) -> str:
    """A figure as an image of an HTML page that needs no other file."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi, bbox_inches="tight")
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    return f'<img alt="" src="data:image/png;base64,{data}">'
