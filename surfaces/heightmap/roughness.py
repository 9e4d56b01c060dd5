"""Mean, rms height, slope and curvature of a map in one pass."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics import parallel

from . import _roughness_kernels as kernels

__all__ = ["Roughness", "roughness"]

BANDS = 32
"""Bands of rows whose highest points are kept."""


@dataclass(frozen=True)
class Roughness:
    """Means over the points present; differences that meet a missing point are left out.

    Attributes
    ----------
    mean
        Mean height [m].
    rms_height
        Root-mean-square height about the mean [m].
    lowest, highest
        Extreme heights [m].
    slope
        Root-mean-square slopes (along y, along x) by forward differences [-].
    curvature
        Root-mean-square second differences (along y, along x) over the squared spacing [1/m].
    kurtosis
        Kurtosis of the second differences (along y, along x), those across the border of a periodic
        map among them: 3 for random waves, more for spikes, steps and worn plateaus; infinite
        along an axis that does not vary.
    missing
        Number of missing points.
    tops, rows
        Height [m] and row of the highest point of each column in each of `BANDS` bands of rows,
        shape (BANDS, nx); fewer bands if there are fewer rows.
    """

    mean: float
    rms_height: float
    lowest: float
    highest: float
    slope: tuple[float, float]
    curvature: tuple[float, float]
    kurtosis: tuple[float, float]
    missing: int
    tops: NDArray[np.float64] = field(repr=False, compare=False)
    rows: NDArray[np.int64] = field(repr=False, compare=False)

    @property
    def largest(self) -> float:
        """Largest absolute height [m]."""
        return max(abs(self.highest), abs(self.lowest))

    @property
    def rms_slope(self) -> float:
        """Root-mean-square gradient [-]."""
        return math.hypot(*self.slope)

    @property
    def length(self) -> float:
        """Length over which the slope turns [m]: rms slope over rms curvature; infinite if flat."""
        bend = math.hypot(*self.curvature)
        return self.rms_slope / bend if bend > 0.0 else math.inf


def roughness(
    heights: NDArray[np.float64], spacing: tuple[float, float], periodic: bool
) -> Roughness:
    """Means over a map; `HeightMap.roughness` keeps them.

    Parameters
    ----------
    heights
        Heights [m], shape (ny, nx); NaN where missing.
    spacing
        Pixel size (dy, dx) [m].
    periodic
        Whether the map continues across its border as if repeated.

    Notes
    -----
    Differences do not cross the border, but for those of the kurtosis. Heights are summed relative
    to the first one present.
    """
    ny, nx = heights.shape
    bands = min(BANDS, ny)
    bounds = ny * np.arange(bands + 1) // bands
    lows, tops = np.full((bands, nx), np.inf), np.full((bands, nx), -np.inf)
    rows = np.zeros((bands, nx), np.int64)
    start = heights[0, 0] if heights[0, 0] == heights[0, 0] else np.nanmean(heights)

    def part(first: int, last: int) -> NDArray[np.float64]:
        out = np.zeros(19)
        kernels.sums(heights, start, bounds, first, last, lows, tops, rows, out)
        return out

    total = np.sum(parallel.run(part, parallel.lines(bands, heights.size)), axis=0)
    number, first, second = total[0], total[1], total[2]
    seam = total[13:] if periodic else np.zeros(6)
    mean = first / number
    dy, dx = spacing
    rms = [
        math.sqrt(total[k + 1] / total[k]) / scale if total[k] else 0.0
        for k, scale in ((3, dy), (8, dx), (5, dy * dy), (10, dx * dx))
    ]
    return Roughness(
        mean=float(start + mean),
        rms_height=math.sqrt(max(second / number - mean * mean, 0.0)),
        lowest=float(lows.min()),
        highest=float(tops.max()),
        slope=(rms[0], rms[1]),
        curvature=(rms[2], rms[3]),
        kurtosis=(_kurtosis(total[5:8] + seam[:3]), _kurtosis(total[10:13] + seam[3:])),
        missing=int(heights.size - number),
        tops=tops,
        rows=rows,
    )


def _kurtosis(sums: NDArray[np.float64]) -> float:
    """Kurtosis of second differences from their number and sums of squares and fourth powers."""
    number, square, fourth = sums.tolist()
    return number * fourth / square**2 if square > 0.0 else math.inf
