"""What an accuracy asked for saves: the coarsest grid that holds it, and a curve from few solved
loads, by monotone interpolation in the logarithm of the load.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from asperity.errors import InputError
from asperity.halfspace.scene import Boundary
from asperity.results.curve import ContactCurve
from surfaces.errors import as_number
from surfaces.heightmap import HeightMap

from .grids import coarse_maps

__all__ = [
    "LOOSEST",
    "choose_grid",
    "coarsened",
    "interpolated",
    "loads_to_solve",
    "require_accuracy",
]

LOOSEST = 1e-2
"""Tolerance that each load is solved to first; looser saves little."""

_POINTS_TIMES_ACCURACY = 7.5
"""Points per axis times the accuracy."""

_SLOPE_SHARE = 1.0 / 3.0
"""Share of the accuracy that may be lost from the rms slope."""

_CONTACT_POINTS = 60
"""Least number of pixels in contact at the lightest load."""

_LARGEST_RATIO = 0.8
"""Points per axis over those of the full grid above which the full grid is taken."""

_LEAST = 10
"""Loads that are solved in any case."""

_PER_DECADE = 4.5
"""Loads solved per decade."""

_WORST_OF_NEIGHBORS = (
    "load_error",
    "complementarity",
    "penetration",
    "lift",
    "area_error_estimate",
)
"""Columns of which an interpolated point has the larger value of its neighbors."""

_COST = ("iterations", "fft_pairs", "seconds")
"""Columns that are zero at interpolated points."""


def require_accuracy(accuracy: float) -> float:
    """Refuse an accuracy that is no relative error from 1e-4 to 0.2."""
    if not 1e-4 <= as_number("accuracy", accuracy) <= 0.2:
        raise InputError(f"accuracy is {accuracy!r}; give a relative error from 1e-4 to 0.2")
    return accuracy


def choose_grid(
    hm: HeightMap, accuracy: float, lightest_area: float, boundary: Boundary
) -> tuple[tuple[int, int], str]:
    """Points (ny, nx) of the coarsest grid for an accuracy, and why.

    The accuracy is the relative error allowed in the load at equal separation, and about that in
    the corrected area at equal load; `lightest_area` the area fraction expected at the lightest
    load. Calibrated on self-affine maps solved on every coarser grid: two points per wave that
    still carries slope (a third of the accuracy may be lost from the rms slope, to which the area
    at given load is inversely proportional), 7.5 / accuracy points per axis, and 60 contact points
    at the lightest load.
    """
    ny, nx = hm.shape
    needs = {
        "the waves that carry its slope": _slope_share(hm, 1.0 - _SLOPE_SHARE * accuracy, boundary),
        "the points per axis": _POINTS_TIMES_ACCURACY / accuracy / min(ny, nx),
        "the contact at the lightest load": math.sqrt(
            _CONTACT_POINTS / max(lightest_area, 1e-9) / (ny * nx)
        ),
    }
    rule, share = max(needs.items(), key=lambda item: item[1])
    if boundary == "free":
        share = 0.5 ** math.floor(-math.log2(share)) if share < 1.0 else 1.0
    if share > _LARGEST_RATIO:
        return hm.shape, f"full grid: {rule} ask for it"
    rows, columns = (scipy.fft.next_fast_len(math.ceil(share * n), real=True) for n in (ny, nx))
    shape = (min(rows, ny), min(columns, nx))
    return shape, f"{shape[0]} x {shape[1]} points: set by {rule}"


def _slope_share(hm: HeightMap, kept: float, boundary: Boundary) -> float:
    """Share of the band of each axis that must be kept to keep a share of the rms slope."""
    heights = hm.heights
    if boundary == "free":
        heights = np.pad(heights, [(0, n) for n in hm.shape], mode="symmetric")
    ny, nx = heights.shape
    power = np.abs(scipy.fft.rfft2(heights)) ** 2
    fy = np.abs(np.fft.fftfreq(ny))[:, None]
    fx = np.fft.rfftfreq(nx)[None, :]
    power *= (fy / hm.spacing[0]) ** 2 + (fx / hm.spacing[1]) ** 2
    power[:, 1 : (nx + 1) // 2] *= 2.0
    band = np.maximum(fy, fx)
    edges = np.linspace(0.0, 0.5, 129)
    inside = np.cumsum(np.histogram(band, bins=edges, weights=power)[0])
    if inside[-1] == 0.0:
        return 0.0
    return float(2.0 * edges[1:][np.searchsorted(inside, kept**2 * inside[-1])])


def coarsened(hm: HeightMap, shape: tuple[int, int], boundary: Boundary) -> HeightMap:
    """The map on a coarser grid: Fourier truncation (periodic) or means over the new pixels."""
    size = hm.size
    spacing = (size[0] / shape[0], size[1] / shape[1])
    (heights,) = coarse_maps(hm.heights, boundary, [shape])
    step = {"step": "coarsen", "shape": list(shape)}
    return hm.replace(heights=heights, spacing=spacing, step=step)


def loads_to_solve(pressures: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Loads among those asked for that are enough for all; None if that is all of them.

    Ten, or 4.5 per decade if that is more, spaced as evenly in their logarithm as they can be; the
    others are then known to 0.5 % in area and 0.2 % in load. A load of zero is kept.
    """
    loads = np.unique(pressures)
    loaded = loads[loads > 0.0]
    if loaded.size <= _LEAST:
        return None
    decades = math.log10(loaded[-1] / loaded[0])
    count = max(_LEAST, math.ceil(_PER_DECADE * decades) + 1)
    wanted = np.linspace(math.log(loaded[0]), math.log(loaded[-1]), count)
    nearest = np.abs(np.log(loaded)[:, None] - wanted).argmin(axis=0)
    chosen = loaded[np.unique(nearest)]
    if chosen.size == loaded.size:
        return None
    return np.asarray(np.append(loads[loads == 0.0], chosen))


def interpolated(curve: ContactCurve, pressures: NDArray[np.float64]) -> ContactCurve:
    """The curve at more mean pressures [Pa], all within the solved range or zero if that is solved.

    `extra["interpolated"]` marks the points that were not solved. Such a point has the larger
    certificate of its neighbors, and counts as converged if both are.
    """
    asked = curve.asked["asked_pressure"]
    above = np.clip(np.searchsorted(asked, pressures * (1.0 - 1e-9)), 0, len(curve) - 1)
    solved = np.abs(asked[above] - pressures) <= 1e-9 * pressures
    below = np.where(solved, above, np.maximum(above - 1, 0))
    loaded = curve.converged & (curve.mean_pressure > 0.0)
    x = np.log(curve.mean_pressure[loaded])

    def between(values: NDArray[np.float64]) -> NDArray[np.float64]:
        result = np.array(values[above], np.float64)
        if len(x) > 1:
            spline = PchipInterpolator(x, values[loaded])
            result[~solved] = spline(np.log(pressures[~solved]))
        return result

    def worse(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.maximum(values[below], values[above])

    with np.errstate(divide="ignore"):  # none without load, infinite in full contact
        stiffness = 1.0 / between(1.0 / curve.stiffness)
    hardness = curve.settings.get("hardness", math.inf)
    area_fraction = np.maximum(between(curve.area_fraction), pressures / hardness)
    extra = {"asked_pressure": pressures, "interpolated": ~solved}
    for name, values in curve.extra.items():
        if name in extra:
            continue
        if name in _WORST_OF_NEIGHBORS:
            extra[name] = worse(values)
        elif name in _COST:
            extra[name] = np.where(solved, values[above], 0.0)
        else:
            extra[name] = between(values)
    return replace(
        curve,
        separation=between(curve.separation),
        mean_pressure=np.where(solved, curve.mean_pressure[above], pressures),
        load=between(curve.load),
        area_fraction=area_fraction,
        contact_area=area_fraction * curve.nominal_area,
        contacts=np.rint(between(curve.contacts)),
        stiffness=stiffness,
        converged=curve.converged[below] & curve.converged[above],
        residual=worse(curve.residual),
        error_estimate=worse(curve.error_estimate),
        settings={**curve.settings, "solved_loads": len(curve)},
        extra=extra,
        reasons=tuple(
            curve.reasons[i] or curve.reasons[j] for i, j in zip(below, above, strict=True)
        ),
    )
