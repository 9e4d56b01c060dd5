"""The coarsest grid that still holds a map, judged from the map itself."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from . import _spline, _threads
from .filtering import resample
from .heightmap import HeightMap

__all__ = ["coarse_map", "shortest_wave"]

_POINTS = 8.0
"""Points per shortest wave: the contact curve then changes no more than by half a pixel's shift of
the full grid."""

_SLOPE_LOST = 2e-3
"""Share of the slope variance that waves shorter than the shortest one may carry."""

_SMOOTH = 2.0
"""Length over which the slope turns [pixels] below which no coarser grid can hold the map."""

_LINES = 128
"""Rows and columns that suffice to find the shortest wave."""

_WORTH_IT = 0.75
"""Largest ratio of the points per axis."""

_FEWEST = 64
"""Least points of the shorter side of a coarser grid."""

_BLOCKS = 32
"""Blocks per axis whose highest points must come back."""

_MISSED, _MISSED_MOST = 5e-4, 5e-3
"""Rms and largest deviation of those points, over the rms height."""


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
    wave = min(_threads.each(functools.partial(shortest_wave, hm), (0, 1)))
    ratio = max(_POINTS / wave, _FEWEST / min(hm.shape))
    if ratio > _WORTH_IT:
        return None
    ny, nx = (min(n, fft.next_fast_len(math.ceil(ratio * n), real=True)) for n in hm.shape)
    coarse = resample(hm, (hm.size[0] / ny, hm.size[1] / nx))
    return coarse if _holds(coarse, hm) else None


def shortest_wave(hm: HeightMap, axis: int) -> float:
    """Length [pixels] of the shortest wave along an axis that carries slope, from some lines."""
    count = hm.shape[axis]
    stride = max(1, hm.shape[1 - axis] // _LINES)
    lines = hm.heights[::stride] if axis else np.ascontiguousarray(hm.heights[:, ::stride].T)
    waves = fft.rfft(lines, axis=1)
    power = np.sum(np.square(waves.real) + np.square(waves.imag), axis=0)
    inside = np.cumsum(power * np.arange(power.size) ** 2)
    if inside[-1] == 0.0:
        return float(count)
    return count / max(1, int(np.searchsorted(inside, (1.0 - _SLOPE_LOST) * inside[-1])))


def _holds(coarse: HeightMap, hm: HeightMap) -> bool:
    """Whether the highest point of every block of a map lies on the surface of a coarser one."""
    rows, cols = _highest(hm.heights)
    spline = _spline.coefficients(coarse.heights, coarse.periodic)
    scale_y, scale_x = (n / m for n, m in zip(coarse.shape, hm.shape, strict=True))
    off = np.empty(rows.size)
    _spline.evaluate_all(
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


def _highest(heights: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Row and column of the highest point of each block."""
    ny, nx = (n // _BLOCKS for n in heights.shape)
    lines = heights[: ny * _BLOCKS, : nx * _BLOCKS].reshape(_BLOCKS, ny, _BLOCKS * nx)
    first = np.arange(_BLOCKS)
    tops = lines.max(axis=1).reshape(_BLOCKS, _BLOCKS, nx)  # of the columns of each block
    cols = tops.argmax(axis=2) + nx * first
    inside = lines[first[:, None, None], np.arange(ny)[:, None], cols[:, None, :]]
    return (inside.argmax(axis=1) + ny * first[:, None]).ravel(), cols.ravel()
