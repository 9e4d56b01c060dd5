"""Mean, rms height, slope and curvature of a map in one pass."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from surfaces.arrays import Array, Index
from surfaces.numerics import parallel
from surfaces.numerics.compiled import SUMS, compiled, inner
from surfaces.numerics.stored_array import Source, sampled_lines, windows

__all__ = ["Roughness", "line_power", "roughness"]


ROW_BANDS = 32
"""Bands of rows whose highest points are kept."""


@dataclass(frozen=True)
class Roughness:
    """Means over the points present; differences that meet a missing point are left out, and those
    across the border of a periodic map counted.

    Attributes
    ----------
    mean
        Mean height [m].
    rms_height
        Root-mean-square height about the mean [m].
    lowest, highest
        Extreme heights [m].
    slope
        Root-mean-square slopes (along y, along x) by forward differences [-].
    curvature
        Root-mean-square second differences (along y, along x) over the squared spacing [1/m].
    kurtosis
        Kurtosis of the second differences (along y, along x): 3 for random waves, more for spikes,
        steps and worn plateaus; infinite along an axis that does not vary.
    missing
        Number of missing points.
    tops, rows
        Height [m] and row of the highest point of each column in each of `ROW_BANDS` bands of rows,
        shape (ROW_BANDS, nx); fewer bands if there are fewer rows.
    """

    mean: float
    rms_height: float
    lowest: float
    highest: float
    slope: tuple[float, float]
    curvature: tuple[float, float]
    kurtosis: tuple[float, float]
    missing: int
    tops: Array = field(repr=False, compare=False)
    rows: Index = field(repr=False, compare=False)

    @property
    def largest(self) -> float:
        """Largest absolute height [m]."""
        return max(abs(self.highest), abs(self.lowest))

    @property
    def summit(self) -> tuple[int, int]:
        """Row and column of the highest point."""
        band, col = np.unravel_index(int(np.argmax(self.tops)), self.tops.shape)
        return int(self.rows[band, col]), int(col)

    @property
    def rms_slope(self) -> float:
        """Root-mean-square gradient [-]."""
        return math.hypot(*self.slope)

    @property
    def length(self) -> float:
        """Length over which the slope turns [m]: rms slope over rms curvature; infinite if flat."""
        bend = math.hypot(*self.curvature)
        return self.rms_slope / bend if bend > 0.0 else math.inf


def roughness(heights: Source, spacing: tuple[float, float], periodic: bool) -> Roughness:
    """Means over a map of heights [m], (ny, nx), NaN where missing, which `HeightMap` keeps.

    Heights are summed relative to the first one present.
    """
    ny, nx = heights.shape
    bands = min(ROW_BANDS, ny)
    bounds = ny * np.arange(bands + 1) // bands
    lows, tops = np.full((bands, nx), np.inf), np.full((bands, nx), -np.inf)
    rows = np.zeros((bands, nx), np.int64)
    start = _first_present(heights)

    def part(first: int, last: int) -> Array:
        out = np.zeros(23)
        for begin, end, window in windows(heights, bounds[first], bounds[last], below=2):
            _sums(
                *(window, ny, begin, end, start, bounds, first, last),
                *(lows, tops, rows, out),
            )
        return out

    total = np.sum(parallel.run(part, parallel.lines(bands, ny * nx)), axis=0)
    number, first, second = total[0], total[1], total[2]
    differences = total[3:13] + total[13:] if periodic else total[3:13]
    mean = first / number
    dy, dx = spacing
    rms = [
        math.sqrt(differences[k + 1] / differences[k]) / scale if differences[k] else 0.0
        for k, scale in ((0, dy), (5, dx), (2, dy * dy), (7, dx * dx))
    ]
    return Roughness(
        mean=float(start + mean),
        rms_height=math.sqrt(max(second / number - mean * mean, 0.0)),
        lowest=float(lows.min()),
        highest=float(tops.max()),
        slope=(rms[0], rms[1]),
        curvature=(rms[2], rms[3]),
        kurtosis=(_kurtosis(differences[2:5]), _kurtosis(differences[7:10])),
        missing=int(ny * nx - number),
        tops=tops,
        rows=rows,
    )


def _kurtosis(sums: Array) -> float:
    """Kurtosis of second differences from their number and sums of squares and fourth powers."""
    number, square, fourth = sums.tolist()
    return number * fourth / square**2 if square > 0.0 else math.inf


def _first_present(heights: Source) -> float:
    """The first height that is not missing."""
    if heights[0, 0] == heights[0, 0]:
        return float(heights[0, 0])
    for _, _, held in windows(heights):
        present = held[held == held]
        if present.size:
            return float(present[0])
    return 0.0


@compiled(fastmath=SUMS)
def _sums(
    window: Array,
    ny: int,
    begin: int,
    end: int,
    start: float,
    bounds: Index,
    first: int,
    last: int,
    lows: Array,
    tops: Array,
    rows: Index,
    out: Array,
) -> None:
    """Sums over the rows [begin, end) in the bands [first, last) and the differences that begin
    there, of a map of `ny` rows of which row i is ``window[(i - begin) % len(window)]``.

    Adds to `out` (23,) the number, sum and sum of squares of the heights about `start`; along y and
    then x the number and sum of squares of the first differences, and the number, sums of squares
    and of fourth powers of the second ones; and these ten of the differences that cross the border
    as if the map were repeated. The lowest height of every column of a band lowers
    `lows`, the highest raises `tops`, and its row is kept in `rows`, all of shape (bands, nx).
    """
    held, nx = window.shape
    for band in range(first, last):
        for i in range(max(begin, bounds[band]), min(end, bounds[band + 1])):
            here, below = window[(i - begin) % held], window[(i + 1 - begin) % held]
            beneath = window[(i + 2 - begin) % held]
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
                _add_point(z, below[j], beneath[j], ny - i, out, 3)
                _add_point(z, here[(j + 1) % nx], here[(j + 2) % nx], nx - j, out, 8)


@inner(fastmath=SUMS)
def _add_row(
    here: Array,
    below: Array,
    beneath: Array,
    start: float,
    i: int,
    ny: int,
    lows: Array,
    tops: Array,
    rows: Index,
    out: Array,
) -> int:
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
    steps = 3 if i + 1 < ny else 13
    out[steps] += count
    out[steps + 1] += down
    bends = 5 if i + 2 < ny else 15
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
def _add_point(a: float, b: float, c: float, left: int, out: Array, at: int) -> None:
    """Add the differences present of three points in a line, of which `left` are in the map."""
    d = b - a
    e = (c - b) - d
    if d == d:
        steps = at if left > 1 else at + 10
        out[steps] += 1.0
        out[steps + 1] += d * d
    if e == e:
        bends = at + 2 if left > 2 else at + 12
        out[bends] += 1.0
        out[bends + 1] += e * e
        out[bends + 2] += (e * e) * (e * e)


def line_power(heights: Source, periodic: bool) -> tuple[Array, Array]:
    """Mean squares [m^2] of the waves along y and x in some lines of a map (ny, nx).

    The k-th wave has k periods over the length of the map; k / 2 in a map that is not periodic,
    which is continued by its mirror images. No point may be missing.
    """
    from scipy import fft

    def along(axis: int) -> Array:
        count, lines = heights.shape[axis], sampled_lines(heights, axis)
        if periodic:
            waves = fft.rfft(lines, axis=1)
            squares = np.square(waves.real) + np.square(waves.imag)
        else:
            squares = np.square(0.5 * fft.dct(lines, axis=1))
        power: Array = squares.mean(axis=0) * (2.0 / count**2)
        power[0] *= 0.5
        if periodic and count % 2 == 0:
            power[-1] *= 0.5
        return power

    y, x = parallel.each(along, (0, 1))
    return y, x
