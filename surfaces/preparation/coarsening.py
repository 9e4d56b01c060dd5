"""The coarsest grid that represents a smooth map."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from surfaces.heightmap import HeightMap
from surfaces.heightmap.roughness import BANDS
from surfaces.numerics import splines

from .filtering import resample_waves

__all__ = ["coarse_map", "shortest_wave"]

_POINTS = 8.0
"""Points per shortest wave: the contact curve then changes no more than by half a pixel's shift of
the full grid."""

_SLOPE_LOST = 2e-3
"""Share of the slope variance that waves shorter than the shortest one may carry."""

_SMOOTH = 2.0
"""Length over which the slope turns [pixels] below which no coarser grid can hold the map."""

_WORTH_IT = 0.75
"""Largest ratio of the points per axis."""

_FEWEST = 64
"""Least points of the shorter side of a coarser grid."""

_MISSED, _MISSED_MOST = 5e-4, 5e-3
"""Rms and largest deviation of the highest point of every block of a map that a coarser grid may
have, over the rms height."""


def coarse_map(hm: HeightMap) -> HeightMap | None:
    """A smooth periodic map on the coarsest grid that holds it; None if that is its own.

    Parameters
    ----------
    hm
        Height map without missing points.

    Notes
    -----
    Fourier truncation to eight points per shortest wave (`shortest_wave`), both axes by the same
    ratio. The highest point of every block of the map must lie on the surface through the coarse
    points: features too few to show in the spectrum, such as single spikes, keep the full grid.
    """
    if not hm.periodic or min(hm.shape) <= _FEWEST:
        return None
    turns = [
        slope / (bend * step) if bend > 0.0 else math.inf
        for slope, bend, step in zip(
            hm.roughness.slope, hm.roughness.curvature, hm.spacing, strict=True
        )
    ]
    if min(turns) < _SMOOTH:
        return None
    wave = min(shortest_wave(hm, axis) for axis in (0, 1))
    ratio = max(_POINTS / wave, _FEWEST / min(hm.shape))
    if ratio > _WORTH_IT:
        return None
    ny, nx = (min(n, fft.next_fast_len(math.ceil(ratio * n), real=True)) for n in hm.shape)
    # of all points there are more than enough to find waves that the coarse grid holds
    fewer = [_divisor(n, n // m) for n, m in zip(hm.shape, (ny, nx), strict=True)]
    coarse = hm.replace(
        heights=resample_waves(hm.heights, ny, nx, (fewer[0], fewer[1])),
        spacing=(hm.size[0] / ny, hm.size[1] / nx),
        step={"step": "resample", "from": list(hm.shape), "to": [ny, nx]},
    )
    return coarse if _holds(coarse, hm) else None


def _divisor(count: int, most: int) -> int:
    """Largest divisor of `count` that is no larger than `most`."""
    return next(part for part in range(most, 0, -1) if count % part == 0)


def shortest_wave(hm: HeightMap, axis: int) -> float:
    """Length [pixels] of the shortest wave along an axis of a periodic map that carries slope."""
    power, count = hm.line_power[axis], hm.shape[axis]
    inside = np.cumsum(power * np.arange(power.size) ** 2)
    if inside[-1] == 0.0:
        return float(count)
    return count / max(1, int(np.searchsorted(inside, (1.0 - _SLOPE_LOST) * inside[-1])))


def _holds(coarse: HeightMap, hm: HeightMap) -> bool:
    """Whether the highest point of every block of a map lies on the surface of a coarser one."""
    rows, cols = _highest(hm)
    spline = splines.coefficients(coarse.heights, coarse.periodic)
    scale_y, scale_x = (n / m for n, m in zip(coarse.shape, hm.shape, strict=True))
    off = np.empty(rows.size)
    splines.evaluate_all(
        spline.ravel(),
        spline.shape[1],
        (rows + 0.5) * scale_y - 0.5,
        (cols + 0.5) * scale_x - 0.5,
        off,
    )
    off -= hm.heights[rows, cols]
    rms = hm.roughness.rms_height
    return bool(
        np.sqrt(np.mean(off**2)) <= _MISSED * rms and np.abs(off).max() <= _MISSED_MOST * rms
    )


def _highest(hm: HeightMap) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Row and column of the highest point of each of `BANDS` times `BANDS` blocks."""
    nx, found, band = hm.shape[1], hm.roughness, np.arange(BANDS)
    bounds = nx * np.arange(BANDS + 1) // BANDS
    columns = np.minimum(bounds[:-1, None] + np.arange(-(-nx // BANDS)), bounds[1:, None] - 1)
    cols = columns[band, found.tops[:, columns].argmax(axis=2)]
    return found.rows[band[:, None], cols].ravel(), cols.ravel()
