"""Compiled sums over the heights of a map and their differences."""

from __future__ import annotations

import numpy as np

from .._compiled import compiled


@compiled(error_model="numpy", fastmath={"reassoc", "contract"})
def sums(heights, start, first, last):
    """Sums over the rows [first, last) and over the differences that begin there.

    Returns the lowest and highest height, the number, sum and sum of squares of the heights about
    `start`, pairs of a number and a sum of squares of the first differences along y and x, and
    numbers, sums of squares and of fourth powers of the second ones along y and x.
    """
    ny, nx = heights.shape
    out = np.zeros(15)
    lows, highs = np.empty(nx), np.empty(nx)  # of the columns, which the vectorizer takes at once
    for j in range(nx):
        lows[j], highs[j] = np.inf, -np.inf
    for i in range(first, last):
        count, total, square = 0.0, 0.0, 0.0
        for j in range(nx):
            z = heights[i, j]
            lows[j] = z if z < lows[j] else lows[j]
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
        if i + 1 < ny:
            number, square = _squares(heights[i, :], heights[i + 1, :])
            out[5] += number
            out[6] += square
        number, square = _squares(heights[i, : nx - 1], heights[i, 1:])
        out[7] += number
        out[8] += square
        if i + 2 < ny:
            number, square, fourth = _bends(heights[i, :], heights[i + 1, :], heights[i + 2, :])
            out[9] += number
            out[10] += square
            out[11] += fourth
        number, square, fourth = _bends(
            heights[i, : nx - 2], heights[i, 1 : nx - 1], heights[i, 2:]
        )
        out[12] += number
        out[13] += square
        out[14] += fourth
    out[0], out[1] = lows[0], highs[0]
    for j in range(1, nx):
        out[0], out[1] = min(out[0], lows[j]), max(out[1], highs[j])
    return out


@compiled(error_model="numpy", fastmath={"reassoc", "contract"})
def _squares(a, b):
    """Number and sum of squares of the differences present."""
    number, total = 0.0, 0.0
    for j in range(a.size):
        d = b[j] - a[j]
        there = d == d
        d = d if there else 0.0
        number += 1.0 if there else 0.0
        total += d * d
    return number, total


@compiled(error_model="numpy", fastmath={"reassoc", "contract"})
def _bends(a, b, c):
    """Number, sum of squares and of fourth powers of the second differences present."""
    number, total, fourth = 0.0, 0.0, 0.0
    for j in range(a.size):
        d = (c[j] - b[j]) - (b[j] - a[j])
        there = d == d
        d = d if there else 0.0
        number += 1.0 if there else 0.0
        square = d * d
        total += square
        fourth += square * square
    return number, total, fourth
