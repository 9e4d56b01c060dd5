"""Compiled parts of the split operator: near stencil, spreading and interpolation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics.compiled import SUMS, compiled

from ._stencil_kernels import LANES, RADIUS, SHORT_RADIUS
from ._stencil_kernels import tile as stencil_of_tile

_KEPT = 32
COARSENING = 4
TAPS = 4
Single = NDArray[np.float32]
Index = NDArray[np.int64]


@compiled()
def cut_tiles(start: Index, columns: NDArray[np.int32], stride: int) -> Any:
    """Cover the points of a list by tiles of 16 neighbors of a row, each from a point on.

    Returns place in the padded grid, first entry and number of entries of each tile.
    """
    tiles = np.empty((columns.size, 3), np.int32)
    n = 0
    for y in range(start.size - 1):
        origin = (RADIUS + y) * stride + LANES
        k = start[y]
        while k < start[y + 1]:
            m = 1
            while k + m < start[y + 1] and columns[k + m] < columns[k] + LANES:
                m += 1
            tiles[n, 0], tiles[n, 1], tiles[n, 2] = origin + columns[k], k, m
            n += 1
            k += m
    return tiles[:n].copy()


@compiled()
def place(
    grid: Single,
    shape: tuple[int, int],
    periodic: bool,
    start: Index,
    columns: NDArray[np.int32],
    values: Single,
) -> None:
    """Write the listed values into the padded grid (ny + 2 R + 1, stride), zero off the list, and
    what lies beyond the borders of a map that repeats."""
    ny, nx = shape
    for y in range(ny):
        for k in range(start[y], start[y + 1]):
            grid[RADIUS + y, LANES + columns[k]] = values[k]
        if periodic:
            row = grid[RADIUS + y]
            for x in range(LANES):
                row[x] = row[x + nx]
                row[LANES + nx + x] = row[LANES + x]
    if periodic:
        for y in range(RADIUS):
            for x in range(grid.shape[1]):
                grid[y, x] = grid[y + ny, x]
                grid[RADIUS + ny + y, x] = grid[RADIUS + y, x]


@compiled()
def near_tiles(
    grid: Single,
    tiles: NDArray[np.int32],
    columns: NDArray[np.int32],
    quadrant: Single,
    short: bool,
    result: Single,
) -> None:
    """Stencil sums of the values on the padded grid at the points of tiles.

    `tiles` come from `cut_tiles`, `quadrant` from `stencil.quadrant`.
    """
    flat, stride = grid.reshape(grid.size), grid.shape[1]
    sums = np.empty(LANES, np.float32)
    for t in range(tiles.shape[0]):
        k, n = tiles[t, 1], tiles[t, 2]
        out = result[k:] if n == LANES else sums
        if short:
            stencil_of_tile(SHORT_RADIUS, flat, tiles[t, 0], stride, quadrant, out)
        else:
            stencil_of_tile(RADIUS, flat, tiles[t, 0], stride, quadrant, out)
        if n < LANES:
            for i in range(n):
                result[k + i] = sums[columns[k + i] - columns[k]]


@compiled(fastmath=SUMS)
def spread(
    rows: tuple[int, int],
    start: Index,
    columns: NDArray[np.int32],
    values: Single,
    first_x: Index,
    weight_x: Single,
    rows_of: Index,
    weight_of: Single,
    coarse: Single,
) -> None:
    """Spread the listed values on rows of the coarse grid by B-splines, along x, then along y.

    `rows_of`, `weight_of` (nyc, k) list the fine rows of each coarse row, filled up with weights of
    zero. A row that is spread along x is kept while coarse rows that follow want it.
    """
    nxc = coarse.shape[1]
    kept = np.empty((_KEPT, nxc + TAPS), np.float32)
    place = np.full(_KEPT, -1)
    for y in range(rows[0], rows[1]):
        target = coarse[y]
        target[:] = np.float32(0.0)
        for k in range(rows_of.shape[1]):
            source, weight = rows_of[y, k], weight_of[y, k]
            if weight == 0.0 or start[source + 1] == start[source]:
                continue
            row = kept[source % _KEPT]
            if place[source % _KEPT] != source:
                place[source % _KEPT] = source
                row[:] = np.float32(0.0)
                for i in range(start[source], start[source + 1]):
                    x, value = np.uint64(columns[i]), values[i]
                    first = np.uint64(first_x[x])
                    for t in range(np.uint64(TAPS)):
                        row[first + t] += weight_x[x, t] * value
                for t in range(TAPS):
                    row[t] += row[nxc + t]
            for x in range(nxc):
                target[x] += weight * row[x]


@compiled(fastmath=SUMS)
def gather(
    rows: tuple[int, int],
    start: Index,
    columns: NDArray[np.int32],
    coarse: Single,
    first_y: Index,
    weight_y: Single,
    first_x: Index,
    weight_x: Single,
    nxc: int,
    result: Single,
) -> None:
    """Add the coarse field (nyc, nxc), interpolated by B-splines, to the result at the points of
    some rows. `coarse` may be wider."""
    nyc = coarse.shape[0]
    row = np.empty(nxc + TAPS, np.float32)
    for y in range(rows[0], rows[1]):
        if start[y + 1] == start[y]:
            continue
        first = first_y[y]
        a, b, c, d = weight_y[y, 0], weight_y[y, 1], weight_y[y, 2], weight_y[y, 3]
        c0, c1 = coarse[first], coarse[(first + 1) % nyc]
        c2, c3 = coarse[(first + 2) % nyc], coarse[(first + 3) % nyc]
        for x in range(nxc):
            row[x] = a * c0[x] + b * c1[x] + c * c2[x] + d * c3[x]
        for t in range(TAPS):
            row[nxc + t] = row[t]
        for k in range(start[y], start[y + 1]):
            x = np.uint64(columns[k])
            first = np.uint64(first_x[x])
            total = np.float32(0.0)
            for t in range(np.uint64(TAPS)):
                total += weight_x[x, t] * row[first + t]
            result[k] += total
