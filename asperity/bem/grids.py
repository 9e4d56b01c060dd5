"""Nested grids: coarser height maps, and pressures carried from one grid to the next."""

from __future__ import annotations

import math

import numpy as np
import scipy.fft

from asperity.halfspace.scene import Boundary
from surfaces.arrays import Array, Index
from surfaces.numerics import parallel
from surfaces.preparation.resampling import resample_waves

from ._grid_kernels import interpolate
from .correction import NestedGrid

__all__ = ["coarse_maps", "nested_shapes", "prolong"]

_COARSEST_POINTS = 48
"""Points of the shorter side at which the nested grids end."""

_LARGE_GRID = 1400 * 1400
"""Points from which on the next grid has a quarter of them along each axis, else half. Passes over
so many are bound by memory: one of half the points costs a third of the finest grid, and saves less
there than on smaller ones."""


def nested_shapes(shape: tuple[int, int]) -> list[tuple[int, int]]:
    """Shapes of the nested grids, coarsest first; each has about half the points of the next along
    each axis, or a quarter."""
    shapes = [shape]
    while min(shapes[0]) > _COARSEST_POINTS:
        step = 4 if math.prod(shapes[0]) > _LARGE_GRID else 2
        ny, nx = (scipy.fft.next_fast_len(-(-n // step), real=True) for n in shapes[0])
        shapes.insert(0, (ny, nx))
    return shapes


def coarse_maps(
    heights: Array, boundary: Boundary, shapes: list[tuple[int, int]], origin: tuple[int, int]
) -> list[Array]:
    """Coarser maps [m] of these shapes, coarsest first, of one map (ny, nx).

    Free: means over the pixels. Periodic: Fourier truncation, the Nyquist lines left out; `origin`
    is row and column of the point that is the first of every coarser grid. About one that belongs
    to the surface, maps that are moved or mirrored have equal coarser maps.
    """
    import cv2

    maps: list[Array] = []
    for ny, nx in reversed(shapes):
        if boundary == "free":
            heights = np.asarray(cv2.resize(heights, (nx, ny), interpolation=cv2.INTER_AREA), float)
        else:
            y, x = (
                (first + 0.5) / old - 0.5 / new
                for first, old, new in zip(origin, heights.shape, (ny, nx), strict=True)
            )
            heights, origin = resample_waves(heights, ny, nx, corner=(y, x)), (0, 0)
        heights.setflags(write=False)  # as those of a HeightMap: loops are compiled for one kind
        maps.insert(0, heights)
    return maps


def prolong(coarse: NestedGrid, fine: NestedGrid, mean: float, origin: tuple[int, int]) -> None:
    """Bilinear interpolation of a coarse pressure into a finer grid, scaled to a mean, if any.

    The coarse map of a periodic cell begins at the row and column `origin` of the finer one.
    """
    shape, fine_shape = coarse.heights.shape, fine.heights.shape
    rows, columns = (
        _places(*axis, fine.exact.boundary) for axis in zip(shape, fine_shape, origin, strict=True)
    )
    # each coarse value times the shares of all fine points in it: the sum of the fine pressure
    down, across = (_shares(n, *axis) for n, axis in zip(shape, (rows, columns), strict=True))
    # not by BLAS, whose threads would wait beside ours
    total = float(np.sum(down * np.einsum("ij,j", coarse.pressure, across)))
    factor = mean * fine.heights.size / total if mean > 0.0 and total > 0.0 else 1.0
    pressures = coarse.exact.pressure, fine.exact.pressure
    parallel.by_rows(interpolate, fine_shape, *pressures, *rows, *columns, factor)


def _shares(n: int, below: Index, above: Index, share: Array) -> Array:
    """Shares of all fine points in each of n coarse ones, along one axis."""
    return np.asarray(np.bincount(below, 1.0 - share, n) + np.bincount(above, share, n))


def _places(n: int, count: int, first: int, boundary: Boundary) -> tuple[Index, Index, Array]:
    """Coarse points below and above each point of the fine grid along one axis, and their shares.

    Fourier truncation keeps the first point of the coarse grid on the point `first`, averaging the
    borders of both.
    """
    if boundary == "periodic":
        place = (np.arange(count) - first) % count * np.float64(n / count)
    else:
        place = np.clip((np.arange(count) + 0.5) * (n / count) - 0.5, 0.0, n - 1.0)
    below = place.astype(np.int64)
    above = np.asarray((below + 1) % n if boundary == "periodic" else np.minimum(below + 1, n - 1))
    return below, above, np.asarray(place - below, np.float64)
