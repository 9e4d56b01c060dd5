"""Slope, curvature and developed area of a map by finite differences."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.heightmap import HeightMap
from surfaces.numerics import parallel

from .rows import rows_of

__all__ = ["differences"]

_BLOCK = 200_000  # points


def differences(hm: HeightMap) -> dict[str, float]:
    """Sdq, rms gradient [-], Sdr, additional area [-], and ``curvature``, rms mean curvature [1/m].

    Parameters
    ----------
    hm
        The map; differences that meet a missing point are left out.

    Notes
    -----
    Forward differences, and (h_xx + h_yy) / 2 of second central differences; around the seam only
    for a periodic map. Both fall below the spectral values where waves of a few pixels count. The
    additional area is that of the triangulated surface over its projection.
    """
    dy, dx = hm.spacing

    def squares(z: NDArray[np.float64]) -> list[tuple[float, int]]:
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

    totals = np.zeros((4, 2))
    parts = _bordered(hm)
    while batch := list(itertools.islice(parts, 4 * parallel.threads())):
        for part in parallel.each(squares, batch):
            totals += part
    with np.errstate(invalid="ignore"):
        slope_y, slope_x, bend, area = (totals[:, 0] / totals[:, 1]).tolist()
    return {
        "Sdq": math.sqrt(slope_y + slope_x),
        "Sdr": area - 1.0,
        "curvature": 0.5 * math.sqrt(bend),
    }


def _bordered(hm: HeightMap) -> Iterator[NDArray[np.float64]]:
    """Rows of the map in blocks that fit the cache, each with one more point on every side.

    Beyond the border of a map that is not periodic there are missing points.
    """
    nx = hm.shape[1]
    outside = np.full((1, nx), np.nan)
    border: dict[str, Any] = {"mode": "wrap"} if hm.periodic else {"constant_values": np.nan}
    rows = max(1, _BLOCK // nx)
    parts = (
        block[first : first + rows] for block in rows_of(hm) for first in range(0, len(block), rows)
    )
    above = hm.source[-1:] if hm.periodic else outside
    here = next(parts)
    end = here[:1].copy() if hm.periodic else outside
    for below in itertools.chain(parts, [end]):
        yield np.pad(np.vstack([above, here, below[:1]]), ((0, 0), (1, 1)), **border)
        above, here = here[-1:], below
