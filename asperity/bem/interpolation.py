"""A long curve from a few solved loads, by monotone interpolation in the logarithm of the load."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from asperity.results.curve import ContactCurve

__all__ = ["interpolated", "loads_to_solve"]

_LEAST = 10
"""Loads that are solved in any case."""

_PER_DECADE = 4.5
"""Loads solved per decade."""

_WORST_OF_NEIGHBORS = (
    "load_error",
    "complementarity",
    "penetration",
    "area_error_estimate",
)
"""Columns of which an interpolated point has the larger value of its neighbors."""

_COST = ("iterations", "fft_pairs", "seconds")
"""Columns that are zero at interpolated points."""


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
    places = np.searchsorted(curve.mean_pressure, pressures * (1.0 - 1e-9))
    above = np.clip(places, 0, len(curve) - 1)
    solved = np.abs(curve.mean_pressure[above] - pressures) <= 1e-9 * pressures
    below = np.where(solved, above, np.maximum(above - 1, 0))
    loaded = curve.mean_pressure > 0.0
    x = np.log(curve.mean_pressure[loaded])

    def between(values: NDArray[np.float64]) -> NDArray[np.float64]:
        result = np.array(values[above], np.float64)
        spline = PchipInterpolator(x, values[loaded])
        result[~solved] = spline(np.log(pressures[~solved]))
        return result

    def worse(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.maximum(values[below], values[above])

    extra = {"interpolated": (~solved).astype(float)}
    for name, values in curve.extra.items():
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
        area_fraction=between(curve.area_fraction),
        contact_area=between(curve.contact_area),
        contacts=np.rint(between(curve.contacts.astype(np.float64))).astype(np.int64),
        stiffness=between(curve.stiffness),
        converged=curve.converged[below] & curve.converged[above],
        residual=worse(curve.residual),
        error_estimate=worse(curve.error_estimate),
        settings={**curve.settings, "solved_loads": len(curve)},
        extra=extra,
        reasons=tuple(
            curve.reasons[i] or curve.reasons[j] for i, j in zip(below, above, strict=True)
        ),
    )
