"""Compiled sums over the heights of a map and their differences."""

from __future__ import annotations

from surfaces.numerics.compiled import SUMS, compiled, inner


@compiled(fastmath=SUMS)
def sums(heights, start, bounds, first, last, lows, tops, rows, out):
    """Sums over the bands [first, last) of rows and over the differences that begin there.

    Adds to `out` (19,) the number, sum and sum of squares of the heights about `start`; along y and
    then x the number and sum of squares of the first differences, and the number, sums of squares
    and of fourth powers of the second ones; and the last three of those second differences that
    cross the border as if the map were repeated. The lowest height of every column of a band lowers
    `lows`, the highest raises `tops`, and its row is kept in `rows`, all of shape (bands, nx).
    """
    ny, nx = heights.shape
    for band in range(first, last):
        for i in range(bounds[band], bounds[band + 1]):
            here, below, beneath = heights[i], heights[(i + 1) % ny], heights[(i + 2) % ny]
            plain = _add_row(
                here, below, beneath, start, i, ny, lows[band], tops[band], rows[band], out
            )
            for j in range(plain, nx):
                z = here[j]
                if z < lows[band, j]:
                    lows[band, j] = z
                if z > tops[band, j]:
                    tops[band, j], rows[band, j] = z, i
                if z == z:
                    out[0] += 1.0
                    out[1] += z - start
                    out[2] += (z - start) * (z - start)
                _add_point(z, below[j], beneath[j], ny - i, out, 3, 13)
                _add_point(z, here[(j + 1) % nx], here[(j + 2) % nx], nx - j, out, 8, 16)


@inner(fastmath=SUMS)
def _add_row(here, below, beneath, start, i, ny, lows, tops, rows, out):
    """Add all points of a row but the last two; returns how many, none if some are missing."""
    count = here.size - 2
    total, square = 0.0, 0.0
    down, down_bend, down_fourth = 0.0, 0.0, 0.0
    along, along_bend, along_fourth = 0.0, 0.0, 0.0
    for j in range(count):
        z = here[j]
        lows[j] = z if z < lows[j] else lows[j]
        rows[j] = i if z > tops[j] else rows[j]
        tops[j] = z if z > tops[j] else tops[j]
        total += z - start
        square += (z - start) * (z - start)
        d = below[j] - z
        e = (beneath[j] - below[j]) - d
        down += d * d
        down_bend += e * e
        down_fourth += (e * e) * (e * e)
        d = here[j + 1] - z
        e = (here[j + 2] - here[j + 1]) - d
        along += d * d
        along_bend += e * e
        along_fourth += (e * e) * (e * e)
    if along_bend + down_bend != along_bend + down_bend:
        return 0
    out[0] += count
    out[1] += total
    out[2] += square
    if i + 1 < ny:
        out[3] += count
        out[4] += down
    bends = 5 if i + 2 < ny else 13
    out[bends] += count
    out[bends + 1] += down_bend
    out[bends + 2] += down_fourth
    out[8] += count
    out[9] += along
    out[10] += count
    out[11] += along_bend
    out[12] += along_fourth
    return count


@inner()
def _add_point(a, b, c, left, out, at, seam):
    """Add the differences present of three points in a line, of which `left` are in the map."""
    d = b - a
    e = (c - b) - d
    if d == d and left > 1:
        out[at] += 1.0
        out[at + 1] += d * d
    if e == e:
        bends = at + 2 if left > 2 else seam
        out[bends] += 1.0
        out[bends + 1] += e * e
        out[bends + 2] += (e * e) * (e * e)
