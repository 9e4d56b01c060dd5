"""Nested grids: coarser height maps, and pressures carried from one grid to the next."""

from __future__ import annotations

import math

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from asperity.halfspace.scene import Boundary
from surfaces.numerics import parallel

from ._grid_kernels import interpolate
from .transform import Scratch

__all__ = ["CoarseMaps", "level_shapes", "prolong"]

_SMALLEST = 48
"""Points of the shorter side at which the nested grids end."""

_LARGE = 1400 * 1400
"""Points from which on the next grid has a quarter of them along each axis, else half. Passes over
so many are bound by memory: one of half the points costs a third of the finest grid, and saves less
there than on smaller ones."""

_ROWS = 32
"""Rows transformed at a time."""


def level_shapes(shape: tuple[int, int]) -> list[tuple[int, int]]:
    """Shapes of the nested grids, coarsest first; each has about half the points of the next along
    each axis, or a quarter."""
    shapes = [shape]
    while min(shapes[0]) > _SMALLEST:
        step = 4 if math.prod(shapes[0]) > _LARGE else 2
        ny, nx = (scipy.fft.next_fast_len(-(-n // step), real=True) for n in shapes[0])
        shapes.insert(0, (ny, nx))
    return shapes


class CoarseMaps:
    """Coarser maps of one height map.

    Parameters
    ----------
    heights
        Heights [m], shape (ny, nx).
    boundary
        Periodic: Fourier truncation, the Nyquist lines left out. Free: means over the pixels.
    shapes
        Shapes of the coarser grids, coarsest first.
    threads
        Threads of the transforms.
    scratch
        Where the memory comes from.
    origin
        Row and column of the point that is the first of every coarser grid of a periodic map. About
        one that belongs to the surface, maps that are moved or mirrored have equal coarser maps.
    """

    def __init__(
        self,
        heights: NDArray[np.float64],
        boundary: Boundary,
        shapes: list[tuple[int, int]],
        *,
        threads: int = 1,
        scratch: Scratch | None = None,
        origin: tuple[int, int] = (0, 0),
    ) -> None:
        self._threads = threads
        self._averages: list[NDArray[np.float64]] = []
        self._low: NDArray[np.complex128] | None = None
        if boundary == "free":
            for shape in reversed(shapes):
                heights = _averaged(_averaged(heights, shape[0]).T, shape[1]).T
                self._averages.insert(0, _frozen(np.ascontiguousarray(heights)))
        elif shapes:
            kept = (shapes[-1][1] - 1) // 2 + 1
            low = _low_columns(heights, kept, threads, scratch or Scratch())
            low = scipy.fft.fft(low, axis=0, workers=threads, overwrite_x=True, norm="forward")
            self._low = _low_waves(low, shapes[-1])
            for axis, (first, count) in enumerate(zip(origin, heights.shape, strict=True)):
                waves = scipy.fft.fftfreq(shapes[-1][axis], 1.0 / shapes[-1][axis])
                turn = np.exp(2j * np.pi * first / count * waves[: self._low.shape[axis]])
                self._low *= turn[:, None] if axis == 0 else turn

    def level(self, index: int, shape: tuple[int, int]) -> NDArray[np.float64]:
        """Heights of the grid number `index`."""
        if self._low is None:
            return self._averages[index]
        low = _low_waves(self._low, shape)
        heights = scipy.fft.irfft2(
            low, s=shape, workers=self._threads, overwrite_x=True, norm="forward"
        )
        return _frozen(np.asarray(heights))


def _low_columns(
    heights: NDArray[np.float64], kept: int, threads: int, scratch: Scratch
) -> NDArray[np.complex128]:
    """First columns of the half spectrum along the rows, over their length."""
    low = scratch.zeros((heights.shape[0], kept), np.complex128)

    def transform(start: int, stop: int) -> None:
        for y in range(start, stop, _ROWS):
            rows = scipy.fft.rfft(heights[y : min(y + _ROWS, stop)], axis=1, norm="forward")
            low[y : y + len(rows)] = rows[:, :kept]

    n = heights.shape[0]
    parallel.run(transform, [(n * i // threads, n * (i + 1) // threads) for i in range(threads)])
    return low


def _low_waves(spectrum: NDArray[np.complex128], shape: tuple[int, int]) -> NDArray[np.complex128]:
    """Half spectrum of a coarser grid: the waves that it holds, without the Nyquist lines."""
    rows, columns = (shape[0] - 1) // 2, (shape[1] - 1) // 2
    kept = np.zeros((shape[0], shape[1] // 2 + 1), np.complex128)
    kept[: rows + 1, : columns + 1] = spectrum[: rows + 1, : columns + 1]
    kept[-rows:, : columns + 1] = spectrum[-rows:, : columns + 1]
    return kept


def _frozen(values: NDArray[np.float64]) -> NDArray[np.float64]:
    values.setflags(write=False)
    return values


def _averaged(values: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Means over `count` equal intervals of the first axis."""
    n = values.shape[0]
    if count == n:
        return values
    if n == 2 * count:
        return 0.5 * (values[::2] + values[1::2])
    integral = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    edges = np.arange(count + 1) * (n / count)
    below = np.minimum(edges.astype(int), n - 1)
    share = (edges - below)[:, None]
    at_edges = (1.0 - share) * integral[below] + share * integral[below + 1]
    return np.asarray(np.diff(at_edges, axis=0) * (count / n))


def prolong(
    coarse: NDArray[np.float64],
    shape: tuple[int, int],
    fine: NDArray[np.float64],
    fine_shape: tuple[int, int],
    boundary: Boundary,
    mean: float,
    origin: tuple[int, int] = (0, 0),
) -> None:
    """Bilinear interpolation of a coarse pressure into a finer grid, scaled to a mean pressure.

    Parameters
    ----------
    coarse, shape
        Coarse pressure, at least of the given shape.
    fine, fine_shape
        Result, at least of the given shape.
    boundary
        Whether the map continues across its border.
    mean
        Mean of the result; not scaled if zero.
    origin
        Row and column of the finer grid at which the coarse one begins, if periodic.
    """
    rows = _places(shape[0], fine_shape[0], boundary, origin[0])
    columns = _places(shape[1], fine_shape[1], boundary, origin[1])
    # each coarse value times the shares of all fine points in it: the sum of the fine pressure
    down, across = (_shares(n, *axis) for n, axis in zip(shape, (rows, columns), strict=True))
    total = float(down @ coarse[: shape[0], : shape[1]] @ across)
    factor = mean * fine_shape[0] * fine_shape[1] / total if mean > 0.0 and total > 0.0 else 1.0
    parallel.by_rows(interpolate, fine_shape, coarse, fine, *rows, *columns, factor)


def _shares(
    n: int, below: NDArray[np.int64], above: NDArray[np.int64], share: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Shares of all fine points in each of n coarse ones, along one axis."""
    return np.asarray(np.bincount(below, 1.0 - share, n) + np.bincount(above, share, n))


def _places(
    n: int, count: int, boundary: Boundary, first: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
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
