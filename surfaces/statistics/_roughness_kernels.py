"""Compiled sums over the heights of a map and their differences."""

from __future__ import annotations

import numpy as np

from .._compiled import compiled


@compiled(error_model="numpy", fastmath={"reassoc", "contract"})
def sums(heights, start, bounds, first, last, tops, rows):
    """Sums over the bands [first, last) of rows and over the differences that begin there.

    Returns the lowest and highest height, the number, sum and sum of squares of the heights about
    `start`, pairs of a number and a sum of squares of the first differences along y and x, and
    numbers, sums of squares and of fourth powers of the second ones along y and x. The highest
    point of every column of a band is kept: its height in `tops`, its row in `rows`, (bands, nx).
    """
    ny, nx = heights.shape
    out = np.zeros(15)
    lows = np.full(nx, np.inf)  # of the columns, which the vectorizer takes at once
    for band in range(first, last):
        highs, places = tops[band], rows[band]
        highs[:] = -np.inf
        for i in range(bounds[band], bounds[band + 1]):
            count, total, square = 0.0, 0.0, 0.0
            for j in range(nx):
                z = heights[i, j]
                lows[j] = z if z < lows[j] else lows[j]
                places[j] = i if z > highs[j] else places[j]
                highs[j] = z if z > highs[j] else highs[j]
                z -= start
                there = z == z
                z = z if there else 0.0
                count += 1.0 if there else 0.0
                total += z
                square += z * z
            out[2] += count
            out[3] += total
            out[4] += square
            below = heights[min(i + 1, ny - 1)]
            found = _differences(heights[i], below, heights[min(i + 2, ny - 1)])
            if i + 1 < ny:
                out[5] += found[0]
                out[6] += found[1]
            if i + 2 < ny:
                out[9] += found[2]
                out[10] += found[3]
                out[11] += found[4]
            found = _differences(heights[i, :-2], heights[i, 1:-1], heights[i, 2:])
            out[12] += found[2]
            out[13] += found[3]
            out[14] += found[4]
            end = heights[i, -1] - heights[i, -2]
            there = end == end
            out[7] += found[0] + (1.0 if there else 0.0)
            out[8] += found[1] + (end * end if there else 0.0)
    out[0], out[1] = lows.min(), tops[first:last].max()
    return out


@compiled(error_model="numpy", fastmath={"reassoc", "contract"})
def _differences(a, b, c):
    """Number and sum of squares of b - a; number, sums of squares and of fourth powers of c - b
    less that; of those that are present."""
    square, bend, fourth = 0.0, 0.0, 0.0
    for j in range(a.size):
        d = b[j] - a[j]
        e = (c[j] - b[j]) - d
        square += d * d
        bend += e * e
        fourth += (e * e) * (e * e)
    number, bends = float(a.size), float(a.size)
    if fourth != fourth:  # some are missing
        number, square, bends, bend, fourth = 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(a.size):
            d = b[j] - a[j]
            e = (c[j] - b[j]) - d
            if d == d:
                number += 1.0
                square += d * d
            if e == e:
                bends += 1.0
                bend += e * e
                fourth += (e * e) * (e * e)
    return number, square, bends, bend, fourth
