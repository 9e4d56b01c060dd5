"""Compiled parts of the split operator: near stencil, spreading and interpolation."""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ._simd import LANES, RADIUS, stencil_dot4

_FAST = {"reassoc", "contract", "nsz"}
Single = NDArray[np.float32]
Index = NDArray[np.int64]


@njit(cache=True, nogil=True, parallel=True)
def near(
    grid: Single,
    shape: tuple[int, int],
    periodic: bool,
    places: Index,
    values: Single,
    weights: Single,
    result: Single,
) -> None:
    """Stencil sums of the listed values at the listed points.

    `grid` is the padded grid (ny + 2 R, stride), zero off the list; `places` are flat indices.
    """
    ny, nx = shape
    stride = grid.shape[1]
    flat = grid.reshape(grid.size)
    n = places.size
    for i in prange(n):
        flat[places[i]] = values[i]
    if periodic:
        for y in prange(RADIUS, ny + RADIUS):
            for x in range(LANES):
                grid[y, x] = grid[y, x + nx]
                grid[y, LANES + nx + x] = grid[y, LANES + x]
        for y in prange(RADIUS):
            for x in range(stride):
                grid[y, x] = grid[y + ny, x]
                grid[RADIUS + ny + y, x] = grid[RADIUS + y, x]
    corner = RADIUS * stride + RADIUS
    last = n - 1
    for k in prange((n + 3) // 4):
        i = 4 * k
        j, k2, m = min(i + 1, last), min(i + 2, last), min(i + 3, last)
        a, b, c, d = stencil_dot4(  # type: ignore[call-arg, var-annotated]
            flat,
            places[i] - corner,
            places[j] - corner,
            places[k2] - corner,
            places[m] - corner,
            stride,
            weights,
        )
        result[m] = d
        result[k2] = c
        result[j] = b
        result[i] = a


@njit(cache=True, nogil=True, parallel=True, fastmath=_FAST)
def spread(
    start: Index,
    columns: NDArray[np.int32],
    values: Single,
    first_x: Index,
    weight_x: Single,
    rows_of: Index,
    weight_of: Single,
    rows: Single,
    coarse: Single,
) -> None:
    """Spread the listed values on the coarse grid by B-splines, first along x, then along y.

    `rows` (ny, nxc) is scratch; `rows_of`, `weight_of` (nyc, k) list the fine rows of each coarse
    row, filled up with weights of zero.
    """
    taps = weight_x.shape[1]
    nyc, nxc = rows_of.shape[0], rows.shape[1]
    for y in prange(start.size - 1):
        if start[y + 1] > start[y]:
            row = rows[y]
            row[:] = np.float32(0.0)
            for k in range(start[y], start[y + 1]):
                x = columns[k]
                first, value = first_x[x], values[k]
                if first + taps <= nxc:
                    for t in range(taps):
                        row[first + t] += weight_x[x, t] * value
                else:
                    for t in range(taps):
                        row[(first + t) % nxc] += weight_x[x, t] * value
    for y in prange(nyc):
        target = coarse[y]
        target[:nxc] = np.float32(0.0)
        for k in range(rows_of.shape[1]):
            source, weight = rows_of[y, k], weight_of[y, k]
            if weight != 0.0 and start[source + 1] > start[source]:
                row = rows[source]
                for x in range(nxc):
                    target[x] += weight * row[x]


@njit(cache=True, nogil=True, parallel=True, fastmath=_FAST)
def gather(
    start: Index,
    columns: NDArray[np.int32],
    coarse: Single,
    first_y: Index,
    weight_y: Single,
    first_x: Index,
    weight_x: Single,
    rows: Single,
    result: Single,
) -> None:
    """Add the coarse field, interpolated by B-splines, to the result at the listed points."""
    taps = weight_x.shape[1]
    nxc = rows.shape[1]
    nyc = coarse.shape[0]
    for y in prange(start.size - 1):
        if start[y + 1] > start[y]:
            row = rows[y]
            row[:] = np.float32(0.0)
            for t in range(taps):
                weight = weight_y[y, t]
                source = coarse[(first_y[y] + t) % nyc]
                for x in range(nxc):
                    row[x] += weight * source[x]
            for k in range(start[y], start[y + 1]):
                x = columns[k]
                first = first_x[x]
                total = np.float32(0.0)
                if first + taps <= nxc:
                    for t in range(taps):
                        total += weight_x[x, t] * row[first + t]
                else:
                    for t in range(taps):
                        total += weight_x[x, t] * row[(first + t) % nxc]
                result[k] += total
