"""Pressures of few elements that close their overlaps with a flat."""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import inner

__all__ = ["CHUNK", "LONGEST", "MOST", "REACH", "relieve", "solve"]

REACH = 64
"""Largest number of elements along a side of the grid of one contact."""

MOST = 700
"""Largest number of elements of one contact."""

CHUNK = 16
"""Influences copied at a time: what follows is overwritten, and rows are as much longer."""

LONGEST = 200
"""Steps of conjugate gradients."""


@inner(fastmath=True)
def relieve(count, amounts, row, col, kernel, system, out):
    """Take the displacements of all elements by the pressures `amounts` off `out`.

    Rows of the matrix are made when they are first needed: elements that stay open need none.
    """
    matrix, made, ends = system
    for i in range(count):
        amount = amounts[i]
        if amount == 0.0:
            continue
        line = matrix[i]
        if not made[i]:
            made[i], last = True, 0
            while last < count:  # elements that follow each other in a row of the grid
                first, last = last, ends[last]
                begin, offsets = REACH + col[first] - col[i], kernel[abs(row[first] - row[i])]
                for at in range(0, last - first, CHUNK):
                    to, some = line[first + at :], offsets[begin + at :]
                    for k in range(CHUNK):
                        to[k] = some[k]
        for k in range(count):
            out[k] -= amount * line[k]


@inner(fastmath=True)
def solve(count, row, col, gap, kernel, tolerance, system, pressure, work):
    """Pressures p >= 0 that close the overlaps: the minimum of p G p / 2 - p gap.

    Conjugate gradients that are restricted to the closed elements (Polonsky & Keer 1999), from the
    pressures of a paraboloid of this depth. `gap` is the overlap over its largest value. Leaves the
    overlap that remains in the first row of `work`; `system` is scratch (`elements`).
    """
    made, ends = system[1], system[2]
    first = 0
    for i in range(1, count + 1):
        if i == count or row[i] != row[first] or col[i] - col[first] != i - first:
            ends[first] = i
            first = i
    left, way, change, beside = work[0], work[1], work[2], work[3]
    scale = 4.0 / math.pi * math.sqrt(2.0 * math.pi / count)
    for i in range(count):
        pressure[i] = scale * math.sqrt(max(2.0 * gap[i] - 1.0, 0.0))
        left[i], way[i], made[i] = gap[i], 0.0, False
    relieve(count, pressure, row, col, kernel, system, left)
    before, fresh = 1.0, True
    for _ in range(LONGEST):
        total, error, square = 0.0, 0.0, 0.0
        for i in range(count):
            total += pressure[i] * gap[i]
            if pressure[i] > 0.0:
                square += left[i] * left[i]
                error += abs(left[i]) * pressure[i]
        if error <= tolerance * total:
            break
        share = np.float32(0.0 if fresh else square / before)
        before = square
        for i in range(count):
            way[i] = left[i] + share * way[i] if pressure[i] > 0.0 else np.float32(0.0)
            change[i] = 0.0
        relieve(count, way, row, col, kernel, system, change)
        above, below = 0.0, 0.0
        for i in range(count):
            below -= change[i] * way[i]
            above += left[i] * way[i]
        step, fresh = np.float32(above / below), False
        for i in range(count):
            beside[i] = 0.0  # what the pressure changes by beyond a step along the way
            if pressure[i] > 0.0:
                pressure[i] += step * way[i]
                if pressure[i] < 0.0:
                    beside[i], pressure[i] = -pressure[i], np.float32(0.0)
            elif left[i] > 0.0:
                pressure[i] = beside[i] = step * left[i]
                fresh = True
        for i in range(count):
            left[i] += step * change[i]
        relieve(count, beside, row, col, kernel, system, left)
