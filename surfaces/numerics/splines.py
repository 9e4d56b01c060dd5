"""Quintic B-spline interpolation of a map: coefficients once, then values and derivatives.

The coefficients lie in a padded array: pixel (i, j) has index (i + PAD, j + PAD). The padding
holds the periodic images, or a quadratic continuation of the three points next to the border, so
that evaluation needs no case distinction and the end conditions of the filter do not matter
(its slower pole is 0.43, and 0.43 ** PAD is below 1e-9).

The filter that turns points into coefficients takes lines several at a time, one per lane, in a
buffer that holds them side by side: row i of it is point i of every line. The two causal and the
two anticausal poles go together, as one recursion over the last two points each.

Values are written with vectors because the automatic vectorizer does not find them in a loop of six
taps: the six weights of an axis are one polynomial in vector coefficients, and each of the six rows
of coefficients is one load and one multiply-add for every derivative over y that is asked for. The
lanes that fill the vector have the weight zero. At eight points together, the sums over the lanes
are shared, and the weights over y are taken from memory, where spreading one over all lanes costs
nothing.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from numpy.polynomial import polynomial

from surfaces.arrays import Array

from . import parallel
from .compiled import BORROWING, compiled, inner
from .stored_array import BLOCK_BYTES, Source, StoredArray, rows_around
from .vectors import lane, loader, multiply_add, repeater, splatter, store, sums, total, transposer

__all__ = [
    "LANES",
    "PAD",
    "TAPS",
    "WEIGHTS",
    "coefficients",
    "expand",
    "load",
    "splat",
    "spline_values",
]


PAD = 25
"""Points before and after a line."""

LINES = 16
"""Lines filtered at a time."""

HALO = 48
"""Points from which on a border is no longer felt: the slower pole to this power is 1e-18."""

_POLES = -0.43057534709997379, -0.043096288203264654
_SUM, _PRODUCT = _POLES[0] + _POLES[1], _POLES[0] * _POLES[1]
_GAIN = 120.0
_REST = 1.0 / ((1.0 - _POLES[0]) * (1.0 - _POLES[1]))
_SIDE = 8
"""Rows and columns that are transposed at a time."""

load_lines, turn = loader(LINES), transposer(_SIDE)


LANES = 8
TAPS = 6
load, repeat, splat = loader(LANES), repeater(LANES), splatter(LANES)


@inner(forceinline=True)
def _step(line, at, last, before, gain):
    """Filter the row of the buffer at a place, given the places of the last two and the gain."""
    value = multiply_add(load_lines(line, before), -_PRODUCT, gain * load_lines(line, at))
    store(line, at, multiply_add(load_lines(line, last), _SUM, value))


@inner()
def _filter(line, m, periodic):
    """Fill the padding of the m points of the lines and filter them in place."""
    n = m + 2 * PAD
    for ghost in range(1, PAD + 1):
        low, high = (PAD - ghost) * LINES, (PAD + m - 1 + ghost) * LINES
        if periodic:
            store(line, low, load_lines(line, (PAD + (-ghost) % m) * LINES))
            store(line, high, load_lines(line, (PAD + (m - 1 + ghost) % m) * LINES))
            continue
        bend = 0.5 * ghost * (ghost + 1)
        for edge, way, place in ((PAD, LINES, low), (PAD + m - 1, -LINES, high)):
            at = edge * LINES
            for k in range(LINES):
                a, b, c = line[at + k], line[at + way + k], line[at + 2 * way + k]
                line[place + k] = a + ghost * (a - b) + bend * (a - 2.0 * b + c)
    for k in range(LINES):
        line[k] *= _GAIN * _REST
    _step(line, LINES, 0, 0, _GAIN)
    for i in range(2, n):
        _step(line, i * LINES, (i - 1) * LINES, (i - 2) * LINES, _GAIN)
    last = (n - 1) * LINES
    for k in range(LINES):
        line[last + k] *= _PRODUCT * _REST
    _step(line, last - LINES, last, last, _PRODUCT)
    for i in range(n - 3, -1, -1):
        _step(line, i * LINES, (i + 1) * LINES, (i + 2) * LINES, _PRODUCT)


@compiled()
def _filter_columns(heights, periodic, flat, start, stop):
    """Filter the columns [start, stop) of the map into the padded array `flat`."""
    ny, nx = heights.shape
    width, line = nx + 2 * PAD, np.empty((ny + 2 * PAD) * LINES)
    source = heights.ravel()
    for left in range(start, stop, LINES):
        lanes = min(LINES, stop - left)
        for i in range(ny):
            if lanes == LINES:
                store(line, (PAD + i) * LINES, load_lines(source, i * nx + left))
                continue
            for k in range(lanes):
                line[(PAD + i) * LINES + k] = source[i * nx + left + k]
        _filter(line, ny, periodic)
        for i in range(ny + 2 * PAD):
            place = i * width + PAD + left
            if lanes == LINES:
                store(flat, place, load_lines(line, i * LINES))
                continue
            for k in range(lanes):
                flat[place + k] = line[i * LINES + k]


@compiled()
def _filter_rows(flat, nx, periodic, start, stop):
    """Filter the rows [start, stop) of the padded array in place."""
    width, line = nx + 2 * PAD, np.empty((nx + 2 * PAD) * LINES)
    for top in range(start, stop, LINES):
        lanes = min(LINES, stop - top)
        for k in range(0, lanes, _SIDE):
            row, whole = (top + k) * width, lanes >= k + _SIDE
            tail = PAD + nx - nx % _SIDE if whole else PAD
            for j in range(PAD, tail, _SIDE):
                turn(flat, row + j, width, line, j * LINES + k, LINES)
            for at in range(k, min(k + _SIDE, lanes)):
                for j in range(tail, PAD + nx):
                    line[j * LINES + at] = flat[(top + at) * width + j]
        _filter(line, nx, periodic)
        for k in range(0, lanes, _SIDE):
            row, whole = (top + k) * width, lanes >= k + _SIDE
            tail = width - width % _SIDE if whole else 0
            for j in range(0, tail, _SIDE):
                turn(line, j * LINES + k, LINES, flat, row + j, width)
            for at in range(k, min(k + _SIDE, lanes)):
                for j in range(tail, width):
                    flat[(top + at) * width + j] = line[j * LINES + at]


def _weights() -> Array:
    """Coefficients (derivative, power of t, lane) of the weights of the taps -2 to 3.

    The quintic B-spline is sum_k (-1)^k binomial(6, k) (x + 3 - k)_+^5 / 120, at x = t - tap.
    """
    out = np.zeros((3, TAPS, LANES))
    for tap in range(TAPS):
        terms = [
            (-1) ** k * math.comb(6, k) * polynomial.polypow([5 - tap - k, 1.0], 5) / 120.0
            for k in range(6 - tap)
        ]
        weight = np.sum(terms, axis=0)
        for order in range(3):
            values = polynomial.polyder(weight, order)
            out[order, : values.size, tap] = values
    return out


WEIGHTS = _weights()


@inner(forceinline=True, **BORROWING)
def _taps(order, t):
    """Weights of all taps, or their derivative, at a fraction that stands in all lanes."""
    last = TAPS * (order + 1) - 1 - order
    found = load(WEIGHTS, last * LANES)
    for k in range(last - 1, TAPS * order - 1, -1):
        found = multiply_add(found, t, load(WEIGHTS, k * LANES))
    return found


@inner(forceinline=True, **BORROWING)
def _products(flat, width, corners, weights, t, point, share):
    """Products of which the sum is the spline at a point; its weights over y are LANES apart."""
    corner = corners[point]
    along = repeat(weights, share) * load(flat, corner)
    for row in range(1, TAPS):
        corner += width
        along = multiply_add(repeat(weights, share + row * LANES), load(flat, corner), along)
    return along * _taps(0, repeat(t, point))


@inner(forceinline=True, **BORROWING)
def spline_values(flat, width, corners, first, weights, t, out, into):
    """Spline at the eight points from `first` on, into `out` from `into` on.

    The coefficients of a point are 6 x 6 from its corner on in `flat`, which holds them row by
    row, `width` in a row; two more than six are read in each row. `weights` are those over y,
    `t` the fractions of a pixel over x.
    """
    share = first * TAPS
    found = (
        _products(flat, width, corners, weights, t, first, share),
        _products(flat, width, corners, weights, t, first + 1, share + 1),
        _products(flat, width, corners, weights, t, first + 2, share + 2),
        _products(flat, width, corners, weights, t, first + 3, share + 3),
        _products(flat, width, corners, weights, t, first + 4, share + 4),
        _products(flat, width, corners, weights, t, first + 5, share + 5),
        _products(flat, width, corners, weights, t, first + 6, share + 6),
        _products(flat, width, corners, weights, t, first + 7, share + 7),
    )
    store(out, into, sums(found))


@compiled(**BORROWING)
def expand(flat, width, y, x):
    """Height, gradient and second derivatives (h, h_y, h_x, h_yy, h_xy, h_xx) per pixel.

    At the pixel coordinates (y, x), anywhere within PAD - 5 pixels of the map. `flat` holds the
    coefficients row by row, `width` in a row; those of the point are 6 x 6 from its corner on.
    """
    row, col = math.floor(y), math.floor(x)
    corner = (row + PAD - 2) * width + col + PAD - 2
    part_y, part_x = splat(y - row), splat(x - col)
    down, falling, bending = _taps(0, part_y), _taps(1, part_y), _taps(2, part_y)
    values = load(flat, corner)
    level, slope, bend = (
        lane(down, 0) * values,
        lane(falling, 0) * values,
        lane(bending, 0) * values,
    )
    for row in range(1, TAPS):
        values = load(flat, corner + row * width)
        level = multiply_add(lane(down, row), values, level)
        slope = multiply_add(lane(falling, row), values, slope)
        bend = multiply_add(lane(bending, row), values, bend)
    across, steep, bent = _taps(0, part_x), _taps(1, part_x), _taps(2, part_x)
    return (
        total(level * across),
        total(slope * across),
        total(level * steep),
        total(bend * across),
        total(slope * steep),
        total(level * bent),
    )


def coefficients(heights: Source, periodic: bool) -> Array:
    """Spline coefficients, shape (ny + 2 PAD, nx + 2 PAD), that interpolate `heights` exactly.

    Those of heights on disk are made in strips of rows, and are mapped.
    """
    if isinstance(heights, np.ndarray):
        return _coefficients(heights, periodic, periodic)
    ny, nx = heights.shape
    out = StoredArray((ny + 2 * PAD, nx + 2 * PAD), np.float64)
    step = max(4 * HALO, BLOCK_BYTES // (8 * nx))
    for first in range(-PAD, ny + PAD, step):
        last = min(first + step, ny + PAD)
        top = first - HALO if periodic else max(first - HALO, 0)
        window = rows_around(heights, top, last + HALO, periodic)
        part = _coefficients(window, False, periodic)
        out.write(first + PAD, part[first - top + PAD : last - top + PAD])
    return out.mapped


def _coefficients(heights: Array, around_y: bool, around_x: bool) -> Array:
    """Those of heights that are repeated along an axis or continued beyond its border."""
    ny, nx = heights.shape
    heights = np.ascontiguousarray(heights)
    out = np.empty((ny + 2 * PAD, nx + 2 * PAD))
    flat = out.ravel()

    columns, rows = parallel.lines(nx, out.size), parallel.lines(len(out), out.size)
    parallel.run(partial(_filter_columns, heights, around_y, flat), columns)
    parallel.run(partial(_filter_rows, flat, nx, around_x), rows)
    return out
