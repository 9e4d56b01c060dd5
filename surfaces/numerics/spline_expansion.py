"""Value and derivatives of the quintic B-spline.

Written with vectors because the automatic vectorizer does not find them in a loop of six taps: the
six weights of an axis are one polynomial in vector coefficients, and each of the six rows of
coefficients is one load and one multiply-add for every derivative over y that is asked for. The
lanes that fill the vector have the weight zero.

Values are found at eight points together, which shares the sums over the lanes, and takes the
weights over y from memory, where spreading one over all lanes costs nothing.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from .compiled import BORROWING, inner
from .vectors import lane, loader, multiply_add, repeater, splatter, store, sums, total

__all__ = ["LANES", "TAPS", "WEIGHTS", "spline_expansion", "spline_values"]

LANES = 8
TAPS = 6

load, repeat, splat = loader(LANES), repeater(LANES), splatter(LANES)


def _weights() -> NDArray[np.float64]:
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


@inner(**BORROWING)
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


@inner(**BORROWING)
def spline_expansion(flat, corner, width, t_y, t_x):
    """Value and derivatives per pixel (h, h_y, h_x, h_yy, h_xy, h_xx) at one point.

    The coefficients are the 6 x 6 from `corner` on, t_y and t_x the fractions of a pixel.
    """
    y, x = splat(t_y), splat(t_x)
    down, falling, bending = _taps(0, y), _taps(1, y), _taps(2, y)
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
    across, steep, bent = _taps(0, x), _taps(1, x), _taps(2, x)
    return (
        total(level * across),
        total(slope * across),
        total(level * steep),
        total(bend * across),
        total(slope * steep),
        total(level * bent),
    )
