"""Slope, curvature and developed area of a map by finite differences."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .rows import Source, heights_of, rows_of

__all__ = ["differences"]

_BLOCK = 200_000  # points


def differences(source: Source) -> dict[str, float]:
    """Sdq, rms gradient [-], Sdr, additional area [-], and ``curvature``, rms mean curvature [1/m].

    Parameters
    ----------
    source
        The map; differences that meet a missing point are left out.

    Notes
    -----
    Forward differences, and (h_xx + h_yy) / 2 of second central differences; around the seam only
    for a periodic map. Both fall below the spectral values where waves of a few pixels count. The
    additional area is that of the triangulated surface over its projection.
    """
    dy, dx = source.spacing
    slopes_y, slopes_x, bends, area = _Mean(), _Mean(), _Mean(), _Mean()
    for z in _bordered(source):
        middle = z[1:-1, 1:-1]
        slopes_y.add(np.square((z[2:, 1:-1] - middle) / dy))
        slopes_x.add(np.square((z[1:-1, 2:] - middle) / dx))
        bend = (z[2:, 1:-1] + z[:-2, 1:-1] - 2.0 * middle) / dy**2
        bend += (z[1:-1, 2:] + z[1:-1, :-2] - 2.0 * middle) / dx**2
        bends.add(np.square(bend))
        step_y, step_x = np.diff(z[1:, 1:], axis=0) / dy, np.diff(z[1:, 1:]) / dx
        step_y, step_x = np.square(step_y) + 1.0, np.square(step_x)
        ends = (slice(None, -1), slice(1, None))
        corners = [np.sqrt(step_y[:, one] + step_x[other]) for one in ends for other in ends]
        area.add(np.mean(corners, axis=0))
    return {
        "Sdq": math.sqrt(slopes_y.value + slopes_x.value),
        "Sdr": area.value - 1.0,
        "curvature": 0.5 * math.sqrt(bends.value),
    }


class _Mean:
    """Mean of the numbers present in arrays that come one after the other."""

    def __init__(self) -> None:
        self.total, self.count = 0.0, 0

    def add(self, values: NDArray[np.float64]) -> None:
        self.total += float(np.nansum(values))
        self.count += values.size - int(np.count_nonzero(np.isnan(values)))

    @property
    def value(self) -> float:
        return self.total / self.count if self.count else math.nan


def _bordered(source: Source) -> Iterator[NDArray[np.float64]]:
    """Rows of the map in blocks that fit the cache, each with one more point on every side.

    Beyond the border of a map that is not periodic there are missing points.
    """
    ny, nx = source.shape
    outside = np.full((1, nx), np.nan)
    border: dict[str, Any] = {"mode": "wrap"} if source.periodic else {"constant_values": np.nan}
    rows = max(1, _BLOCK // nx)
    parts = (
        block[first : first + rows]
        for block in rows_of(source)
        for first in range(0, len(block), rows)
    )
    above = heights_of(source, (ny - 1, ny)) if source.periodic else outside
    here = next(parts)
    end = here[:1].copy() if source.periodic else outside
    for below in itertools.chain(parts, [end]):
        yield np.pad(np.vstack([above, here, below[:1]]), ((0, 0), (1, 1)), **border)
        above, here = here[-1:], below
