"""Compiled passes over whole grids.

Pressure and displacement grids may be wider than the map (padding); the map's shape rules. A pass
that takes `rows` does the rows from the first to before the last of them: threads share the grid.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Index
from surfaces.numerics.compiled import EXTREMES, compiled

BLOCK = 64
Grid = NDArray[np.floating[Any]]


@compiled(fastmath=EXTREMES)
def contact_sums(
    rows: tuple[int, int],
    pressure: Grid,
    displacement: Grid,
    heights: Grid,
    cap: float,
    block_low: Grid,
) -> Any:
    """Sums and extremes over the rows of a grid, with gap = u - h.

    Sums: count and gap where 0 < p < cap; p gap where p < cap; p and p u everywhere; count, gap and
    p - cap where p >= cap. Extremes: lowest gap where p < cap, highest where p >= cap, largest |u|.

    `block_low` (ny, blocks) receives the lowest gap of each run of 64 points, -inf if one of them
    has a pressure, which may be negative if it was predicted.
    """
    nx = heights.shape[1]
    count = held = 0
    gap_sum = total = work = moment = largest = held_sum = excess = 0.0
    lowest, highest = np.inf, -np.inf
    for y in range(rows[0], rows[1]):
        for b in range(block_low.shape[1]):
            low, marked = np.inf, 0
            for x in range(b * BLOCK, min(nx, (b + 1) * BLOCK)):
                u = displacement[y, x]
                gap = u - heights[y, x]
                p = pressure[y, x]
                below = p < cap
                low = min(low, gap)
                lowest = min(lowest, gap if below else np.inf)
                highest = max(highest, -np.inf if below else gap)
                largest = max(largest, abs(u))
                total += p
                excess += max(p - cap, 0.0)
                work += p * gap if below else 0.0
                held_sum += 0.0 if below else gap
                moment += p * u
                touching = (p > 0.0) & below
                count += touching
                held += not below
                marked += p != 0.0
                gap_sum += gap if touching else 0.0
            block_low[y, b] = low if marked == 0 else -np.inf
    sums = count, gap_sum, work, total, moment, held, held_sum, excess
    return (*sums, lowest, highest, largest)


@compiled()
def select(
    pressure: Grid, displacement: Grid, heights: Grid, block_low: Grid, threshold: float
) -> Any:
    """Points with a pressure or with a gap up to the threshold, row by row.

    `block_low` comes from `contact_sums`. Returns row pointers (ny + 1,), columns, pressures and
    gaps of the points.
    """
    ny, nx = heights.shape
    start = np.zeros(ny + 1, np.int64)
    for y in range(ny):
        k = 0
        for b in range(block_low.shape[1]):
            if block_low[y, b] <= threshold:
                for x in range(b * BLOCK, min(nx, (b + 1) * BLOCK)):
                    gap = displacement[y, x] - heights[y, x]
                    k += (gap <= threshold) | (pressure[y, x] != 0.0)
        start[y + 1] = k
    for y in range(ny):
        start[y + 1] += start[y]
    n = start[ny]
    columns = np.empty(n, np.int32)
    p = np.empty(n)
    g = np.empty(n)
    for y in range(ny):
        k = start[y]
        for b in range(block_low.shape[1]):
            if block_low[y, b] <= threshold:
                for x in range(b * BLOCK, min(nx, (b + 1) * BLOCK)):
                    gap = displacement[y, x] - heights[y, x]
                    if gap <= threshold or pressure[y, x] != 0.0:
                        columns[k] = x
                        p[k] = pressure[y, x]
                        g[k] = gap
                        k += 1
    return start, columns, p, g


@compiled()
def extrapolate(
    rows: tuple[int, int], now: Grid, old: Grid, share_now: float, share_old: float
) -> None:
    """Replace (now, old) by (share_now now + share_old old, now)."""
    for y in range(rows[0], rows[1]):
        for x in range(now.shape[1]):
            value = now[y, x]
            now[y, x] = share_now * value + share_old * old[y, x]
            old[y, x] = value


@compiled()
def put(
    rows: tuple[int, int], grid: Grid, start: Index, columns: NDArray[np.int32], values: Grid
) -> None:
    """Write the values of a list into the grid, zero elsewhere."""
    for y in range(rows[0], rows[1]):
        grid[y, :] = 0.0
        for k in range(start[y], start[y + 1]):
            grid[y, columns[k]] = values[k]


@compiled()
def take(
    rows: tuple[int, int], grid: Grid, start: Index, columns: NDArray[np.int32], values: Grid
) -> None:
    """Read the values of a list out of the grid."""
    for y in range(rows[0], rows[1]):
        for k in range(start[y], start[y + 1]):
            values[k] = grid[y, columns[k]]


@compiled(fastmath=EXTREMES)
def multiply(rows: tuple[int, int], parts: Grid, symbol: Grid) -> None:
    """Scale a half spectrum, seen as its real and imaginary parts, in place.

    `symbol` is real and even: its first ny // 2 + 1 rows are given.
    """
    ny = parts.shape[0]
    for y in range(rows[0], rows[1]):
        factor = symbol[min(y, ny - y)]
        row = parts[y]
        for x in range(symbol.shape[1]):
            row[2 * x] *= factor[x]
            row[2 * x + 1] *= factor[x]


@compiled()
def scale_columns(symbol: Grid, first: int, count: int, parts: Grid) -> None:
    """Scale lines of columns, seen as real and imaginary parts, by an even symbol."""
    n = parts.shape[1] // 2
    for c in range(count):
        line = parts[c]
        for y in range(n):
            factor = symbol[min(y, n - y), first + c]
            line[2 * y] *= factor
            line[2 * y + 1] *= factor


@compiled(fastmath=EXTREMES)
def interpolate(
    rows: tuple[int, int],
    coarse: Grid,
    fine: Grid,
    below_y: Index,
    above_y: Index,
    share_y: Grid,
    below_x: Index,
    above_x: Index,
    share_x: Grid,
    factor: float,
) -> None:
    """Bilinear interpolation of a pressure, times a factor."""
    for y in range(rows[0], rows[1]):
        low, high = coarse[below_y[y]], coarse[above_y[y]]
        t = share_y[y]
        for x in range(below_x.size):
            left = (1.0 - t) * low[below_x[x]] + t * high[below_x[x]]
            right = (1.0 - t) * low[above_x[x]] + t * high[above_x[x]]
            fine[y, x] = factor * ((1.0 - share_x[x]) * left + share_x[x] * right)
