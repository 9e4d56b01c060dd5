"""What a reader sees: fields on matplotlib axes, figures as images of a page, quantities with the
prefix that suits them."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "averaged",
    "color_range",
    "draw_field",
    "figure_height",
    "image",
    "logarithmic",
    "prefixed_unit",
    "shown_shape",
    "thinning",
    "with_unit",
]

PICTURE_SIDE = 1200
"""Largest side of a picture."""

LOGARITHMIC_RATIO = 10.0
"""Ratio of the largest to the smallest value from which on an axis is logarithmic."""

_PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


def draw_field(
    axes: Axes | None,
    values: Array,
    size: tuple[float, float],
    name: str,
    unit: str,
    *,
    origin: tuple[float, float] = (0.0, 0.0),
    **style: Any,
) -> Axes:
    """Draw a field, (ny, nx), in true proportions with a color bar, on new axes if None.

    Values of the `name` are in the SI `unit`, or have none; `size` is (Ly, Lx) [m], the lower left
    corner lies at the `origin` (y, x) [m], and `style` goes to ``imshow``. Missing ones stay white;
    large fields are averaged.
    """
    from matplotlib.ticker import EngFormatter

    if axes is None:
        from matplotlib import pyplot

        axes = pyplot.subplots(layout="constrained")[1]
    largest = float(np.nanmax(np.abs(values)))
    scale, unit = prefixed_unit(largest, unit) if unit else (1.0, unit)
    shown = averaged(values, PICTURE_SIDE) / scale
    low, high = color_range(shown)
    look: dict[str, Any] = {"cmap": "cividis", "vmin": low, "vmax": high, "aspect": "equal"}
    extent = (origin[1], origin[1] + size[1], origin[0], origin[0] + size[0])
    drawn = axes.imshow(shown, origin="lower", extent=extent, **look | style)
    bar = axes.inset_axes((1.03, 0.0, 0.035, 1.0))
    axes.figure.colorbar(drawn, cax=bar, label=f"{name} [{unit}]" if unit else name, extend="both")
    for axis, label in ((axes.xaxis, "x"), (axes.yaxis, "y")):
        axis.set_major_formatter(EngFormatter(unit="m"))
        axis.set_label_text(label)
    return axes


def color_range(values: NDArray[Any]) -> tuple[float, float]:
    """Ends of the colors of a field: they leave out the outermost 0.2 % of the points present on
    either side, unless nearly all of them are equal."""
    present = values[np.isfinite(values)]
    if not present.size:
        return math.nan, math.nan
    low, high = np.quantile(present, (0.002, 0.998))
    if low == high:
        low, high = present.min(), present.max()
    return float(low), float(high)


def averaged(values: NDArray[Any], most: int) -> NDArray[Any]:
    """A field with at most `most` points along a side: means of the points present that they cover,
    NaN where none is."""
    if max(values.shape) <= most:
        return values
    import cv2

    ny, nx = shown_shape(values.shape, most)

    def means(field: NDArray[Any]) -> NDArray[Any]:
        return np.asarray(cv2.resize(field, (nx, ny), interpolation=cv2.INTER_AREA))

    present = np.isfinite(values)
    if present.all():
        return means(values)
    share = means(present.astype(values.dtype))
    return means(np.where(present, values, 0)) / np.where(share > 0, share, np.nan)


def shown_shape(shape: Sequence[int], most: int) -> tuple[int, int]:
    """Shape of a field that is shown with at most `most` points along a side."""
    ny, nx = (max(1, round(n * most / max(shape))) for n in shape)
    return ny, nx


def logarithmic(values: Array) -> bool:
    """Whether an axis is better logarithmic: no value is negative, and they span a decade."""
    shown = values[np.isfinite(values) & (values != 0.0)]
    return bool(shown.size and shown.min() > 0.0 and shown.max() >= LOGARITHMIC_RATIO * shown.min())


def thinning(shape: tuple[int, ...]) -> int:
    """Every how many points of a map are drawn."""
    return max(1, -(-max(shape) // PICTURE_SIDE))


def figure_height(width: float, size: tuple[float, float]) -> float:
    """Height [inches] of a picture of a map of lengths (Ly, Lx), from its width."""
    return float(np.clip(width * size[0] / size[1], 1.2, 9.0))


def image(figure: Figure) -> str:
    """A figure as an image of an HTML page that needs no other file."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100, bbox_inches="tight")
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    return f'<img alt="" src="data:image/png;base64,{data}">'


def prefixed_unit(largest: float, unit: str, power: int = 1) -> tuple[float, str]:
    """SI units in the unit with the prefix that suits a quantity, and its name.

    The `largest` magnitude is given in the SI unit to its power: 2 for an area, 3 for a volume.

    Examples
    --------
    >>> from surfaces.drawing import prefixed_unit
    >>> prefixed_unit(3.2e-6, "m"), prefixed_unit(5e7, "Pa"), prefixed_unit(4e-11, "m", 2)
    ((1e-06, 'µm'), (1000000.0, 'MPa'), (1e-12, 'µm²'))
    """
    usable = math.isfinite(largest) and largest != 0.0
    exponent = 3 * math.floor(math.log10(abs(largest)) / (3 * power) + 1e-9) if usable else 0
    exponent = min(max(exponent, min(_PREFIXES)), 0 if unit == "m" else max(_PREFIXES))
    return 10.0 ** (exponent * power), _PREFIXES[exponent] + unit + {2: "²", 3: "³"}.get(power, "")


def with_unit(value: float, unit: str, power: int = 1, digits: int = 3) -> str:
    """A quantity with the prefix that suits it; a dash where it is no number.

    Examples
    --------
    >>> from surfaces.drawing import with_unit
    >>> with_unit(5.04e7, "Pa"), with_unit(9.99e-7, "m", 2), with_unit(float("nan"), "Pa")
    ('50.4 MPa', '999000 µm²', '–')
    """
    if not math.isfinite(value):
        return "–"
    rounded = float(f"{value:.{digits}g}")
    factor, name = prefixed_unit(rounded, unit, power)
    return f"{rounded / factor:.12g} {name}"  # no power of ten beside an area
