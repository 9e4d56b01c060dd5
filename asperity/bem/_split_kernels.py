"""Compiled parts of the split operator: near stencil, spreading and interpolation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Index
from surfaces.numerics.compiled import SUMS, compiled

from ._stencil_kernels import LANES, RADIUS, SHORT_RADIUS
from ._stencil_kernels import tile as stencil_of_tile

_KEPT = 32
_DENSE = 4
COARSENING = 4
TAPS = 4
_FOUR = np.uint64(COARSENING)
Single = NDArray[np.float32]


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

    `tiles` come from `cut_tiles`; `quadrant` is that of the stencil (`stencil`), flat.
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
def _spread_row(
    columns: NDArray[np.int32],
    values: Single,
    first_x: Index,
    weight_x: Single,
    whole: bool,
    dense: Single,
    wide: Single,
    row: Single,
) -> None:
    """Spread the points of one row along x; `dense` and `wide` are scratch."""
    nxc = row.size
    wide[:] = np.float32(0.0)
    if whole and columns.size * _DENSE > nxc:
        width = nxc + 2 * TAPS
        dense[:] = np.float32(0.0)
        for k in range(columns.size):
            place = np.uint64(columns[k])
            place = (place % _FOUR) * np.uint64(width) + place // _FOUR + np.uint64(TAPS)
            dense[place] = values[k]
        for phase in range(COARSENING):
            a, b = weight_x[phase, 0], weight_x[phase, 1]
            c, d = weight_x[phase, 2], weight_x[phase, 3]
            own = dense[phase * width :]
            for x in range(nxc + TAPS):
                wide[x] += a * own[x + 4] + b * own[x + 3] + c * own[x + 2] + d * own[x + 1]
    else:
        for k in range(columns.size):
            x = columns[k]
            for t in range(TAPS):
                wide[first_x[x] + 1 + t] += weight_x[x, t] * values[k]
    for x in range(nxc):
        row[x] = wide[x + 1]
    row[nxc - 1] += wide[0]
    for x in range(TAPS - 1):
        row[x % nxc] += wide[nxc + 1 + x]


@compiled(fastmath=SUMS)
def spread(
    rows: tuple[int, int],
    start: Index,
    columns: NDArray[np.int32],
    values: Single,
    first_x: Index,
    weight_x: Single,
    bounds: NDArray[np.int32],
    rows_of: NDArray[np.int32],
    weight_of: Single,
    whole: bool,
    coarse: Single,
) -> None:
    """Spread the listed values on rows of the coarse grid by B-splines, along x, then along y.

    `first_x` is -1 or more: points before and after a row of the coarse grid are those at its other
    end. `rows_of`, `weight_of` list the fine rows of each coarse row, within its `bounds`
    (nyc + 1,). `whole` says that there are just 4 fine columns to a coarse one: then the weights
    repeat, and a row with many points is spread phase by phase. A row is kept while coarse rows
    that follow want it.
    """
    nxc = coarse.shape[1]
    dense = np.empty(COARSENING * (nxc + 2 * TAPS), np.float32)
    wide = np.empty(nxc + TAPS, np.float32)
    kept = np.empty((_KEPT, nxc), np.float32)
    place = np.full(_KEPT, -1)
    for y in range(rows[0], rows[1]):
        target = coarse[y]
        target[:] = np.float32(0.0)
        for k in range(bounds[y], bounds[y + 1]):
            source, weight = rows_of[k], weight_of[k]
            first, last = start[source], start[source + 1]
            if last == first:
                continue
            row = kept[source % _KEPT]
            if place[source % _KEPT] != source:
                place[source % _KEPT] = source
                own, held = columns[first:last], values[first:last]
                _spread_row(own, held, first_x, weight_x, whole, dense, wide, row)
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
    whole: bool,
    result: Single,
) -> None:
    """Add the coarse field (nyc, nxc), interpolated by B-splines, to the result at the points of
    some rows.

    `coarse` may be wider; `first_y`, `first_x` and `whole` as in `spread`.
    """
    nyc = coarse.shape[0]
    dense = np.empty(COARSENING * nxc, np.float32)
    row = np.empty(nxc + TAPS, np.float32)
    for y in range(rows[0], rows[1]):
        n = start[y + 1] - start[y]
        if n == 0:
            continue
        first = first_y[y]
        a, b, c, d = weight_y[y, 0], weight_y[y, 1], weight_y[y, 2], weight_y[y, 3]
        c0, c1 = coarse[first % nyc], coarse[(first + 1) % nyc]
        c2, c3 = coarse[(first + 2) % nyc], coarse[(first + 3) % nyc]
        for x in range(nxc):
            row[x + 1] = a * c0[x] + b * c1[x] + c * c2[x] + d * c3[x]
        row[0] = row[nxc]
        for x in range(TAPS - 1):
            row[nxc + 1 + x] = row[1 + x % nxc]
        if whole and n * _DENSE > nxc:
            for phase in range(COARSENING):
                a, b = weight_x[phase, 0], weight_x[phase, 1]
                c, d = weight_x[phase, 2], weight_x[phase, 3]
                own = dense[phase * nxc :]
                for x in range(nxc):
                    own[x] = a * row[x] + b * row[x + 1] + c * row[x + 2] + d * row[x + 3]
            for k in range(start[y], start[y + 1]):
                place = np.uint64(columns[k])
                result[k] += dense[(place % _FOUR) * np.uint64(nxc) + place // _FOUR]
            continue
        for k in range(start[y], start[y + 1]):
            x = columns[k]
            total = np.float32(0.0)
            for t in range(TAPS):
                total += weight_x[x, t] * row[first_x[x] + 1 + t]
            result[k] += total
