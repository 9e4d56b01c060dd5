"""Slope, curvature and developed area of a map by finite differences."""

from __future__ import annotations

import math

import numpy as np

from surfaces.arrays import Array
from surfaces.heightmap import HeightMap
from surfaces.numerics import parallel
from surfaces.numerics.stored_array import rows_around, spans

__all__ = ["differences"]

_BLOCK = 200_000  # points


def differences(hm: HeightMap) -> dict[str, float]:
    """Sdq, rms gradient [-], Sdr, additional area [-], and ``curvature``, rms mean curvature [1/m].

    Notes
    -----
    Forward differences, and (h_xx + h_yy) / 2 of second central differences; around the seam only
    for a periodic map, and without those that meet a missing point. Both fall below the spectral
    values where waves of a few pixels count. The additional area is that of the triangulated
    surface over its projection.
    """
    dy, dx = hm.spacing

    def squares(first: int, last: int) -> list[tuple[float, int]]:
        z = _bordered(hm, first, last)
        middle = z[1:-1, 1:-1]
        bend = (z[2:, 1:-1] + z[:-2, 1:-1] - 2.0 * middle) / dy**2
        bend += (z[1:-1, 2:] + z[1:-1, :-2] - 2.0 * middle) / dx**2
        step_y, step_x = np.diff(z[1:, 1:], axis=0) / dy, np.diff(z[1:, 1:]) / dx
        step_y, step_x = np.square(step_y) + 1.0, np.square(step_x)
        ends = (slice(None, -1), slice(1, None))
        corners = [np.sqrt(step_y[:, one] + step_x[other]) for one in ends for other in ends]
        slope_y, slope_x = (z[2:, 1:-1] - middle) / dy, (z[1:-1, 2:] - middle) / dx
        found = np.square(slope_y), np.square(slope_x), np.square(bend), np.mean(corners, axis=0)
        return [(float(np.nansum(v)), int(np.count_nonzero(v == v))) for v in found]

    blocks = spans(hm.shape[0], max(1, _BLOCK // hm.shape[1]))
    totals = np.sum(parallel.run(squares, blocks), axis=0)
    with np.errstate(invalid="ignore"):
        slope_y, slope_x, bend, area = (totals[:, 0] / totals[:, 1]).tolist()
    return {
        "Sdq": math.sqrt(slope_y + slope_x),
        "Sdr": area - 1.0,
        "curvature": 0.5 * math.sqrt(bend),
    }


def _bordered(hm: HeightMap, first: int, last: int) -> Array:
    """Rows [first, last) of the map with one more point on every side.

    Beyond the border of a map that is not periodic there are missing points.
    """
    rows = rows_around(hm.source, first - 1, last + 1, hm.periodic)
    if hm.periodic:
        return np.pad(rows, ((0, 0), (1, 1)), mode="wrap")
    ends = int(first == 0), int(last == hm.shape[0])
    return np.pad(rows, (ends, (1, 1)), constant_values=np.nan)
