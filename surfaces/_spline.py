# mypy: disallow-untyped-defs=False
"""Quintic B-spline interpolation of a map: coefficients once, then values and derivatives.

The coefficients lie in a padded array: pixel (i, j) has index (i + PAD, j + PAD). The padding
holds the periodic images, or a quadratic continuation of the three points next to the border, so
that evaluation needs no case distinction and the end conditions of the filter do not matter
(its slower pole is 0.43, and 0.43 ** PAD is below 1e-9).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from . import _threads

__all__ = ["PAD", "coefficients", "evaluate", "expand"]

PAD = 25
_POLE_1 = -0.43057534709997379
_POLE_2 = -0.043096288203264654
_LANES = 16


def coefficients(heights: NDArray[np.float64], periodic: bool) -> NDArray[np.float64]:
    """Spline coefficients, shape (ny + 2 PAD, nx + 2 PAD), that interpolate `heights` exactly."""
    ny, nx = heights.shape
    width = nx + 2 * PAD
    out = np.empty((ny + 2 * PAD, width))
    out[PAD : PAD + ny, PAD : PAD + nx] = heights
    flat = out.ravel()
    _threads.run(
        lambda a, b: _filter_lines(flat, nx, 1, width, periodic, PAD + a, PAD + b),
        _threads.blocks(ny, 64),
    )
    _threads.run(
        lambda a, b: _filter_lines(flat, ny, width, 1, periodic, a, b), _threads.blocks(width, 64)
    )
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _filter_lines(flat, m, along, across, periodic, start, stop):
    """Filter the lines [start, stop) in place, several at a time: m points and the padding.

    `along` and `across` are the strides inside a line and from one line to the next.
    """
    buffer = np.empty((m + 2 * PAD, _LANES))
    first = np.zeros(_LANES)
    second = np.zeros(_LANES)
    for left in range(start, stop, _LANES):
        lanes = min(_LANES, stop - left)
        for i in range(PAD, PAD + m):
            for k in range(lanes):
                buffer[i, k] = flat[i * along + (left + k) * across]
        for ghost in range(1, PAD + 1):
            low, high = PAD - ghost, PAD + m - 1 + ghost
            if periodic:
                for k in range(lanes):
                    buffer[low, k] = buffer[PAD + (-ghost) % m, k]
                    buffer[high, k] = buffer[PAD + (m - 1 + ghost) % m, k]
            else:
                bend = 0.5 * ghost * (ghost + 1)
                for k in range(lanes):
                    for edge, way, place in ((PAD, 1, low), (PAD + m - 1, -1, high)):
                        a = buffer[edge, k]
                        b = buffer[edge + way, k]
                        c = buffer[edge + 2 * way, k]
                        buffer[place, k] = a + ghost * (a - b) + bend * (a - 2.0 * b + c)
        for k in range(_LANES):
            first[k] = 120.0 * buffer[0, k] / (1.0 - _POLE_1)
            second[k] = first[k] / (1.0 - _POLE_2)
        for i in range(m + 2 * PAD):
            for k in range(_LANES):
                first[k] = 120.0 * buffer[i, k] + _POLE_1 * first[k]
                second[k] = first[k] + _POLE_2 * second[k]
                buffer[i, k] = second[k]
        for k in range(_LANES):
            first[k] = -_POLE_1 * second[k] / (1.0 - _POLE_1)
            second[k] = -_POLE_2 * first[k] / (1.0 - _POLE_2)
        for i in range(m + 2 * PAD - 1, -1, -1):
            for k in range(_LANES):
                first[k] = _POLE_1 * (first[k] - buffer[i, k])
                second[k] = _POLE_2 * (second[k] - first[k])
                buffer[i, k] = second[k]
        for i in range(m + 2 * PAD):
            for k in range(lanes):
                flat[i * along + (left + k) * across] = buffer[i, k]


@njit(cache=True, nogil=True, error_model="numpy")
def _weights(t):
    """The six weights at a fraction t of a pixel, times 120."""
    u = 1.0 - t
    return (
        u * u * u * u * u,
        26.0 + t * (-50.0 + t * (20.0 + t * (20.0 + t * (-20.0 + t * 5.0)))),
        66.0 + t * t * (-60.0 + t * t * (30.0 - t * 10.0)),
        26.0 + t * (50.0 + t * (20.0 + t * (-20.0 + t * (-20.0 + t * 10.0)))),
        1.0 + t * (5.0 + t * (10.0 + t * (10.0 + t * (5.0 - t * 5.0)))),
        t * t * t * t * t,
    )


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def evaluate(flat, width, y, x):
    """Height at the pixel coordinates (y, x), anywhere within PAD - 3 pixels of the map.

    `flat` holds the coefficients row by row, `width` in a row. The unsigned index spares the test
    for negative ones, and six running columns let the compiler use vector instructions: this
    takes two thirds of the time of the plain double sum.
    """
    row = math.floor(y)
    col = math.floor(x)
    wy = _weights(y - row)
    wx = _weights(x - col)
    one = np.uint64(1)
    k = np.uint64((row + PAD - 2) * width + col + PAD - 2)
    c0, c1, c2, c3, c4, c5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for a in range(6):
        w = wy[a]
        c0 += w * flat[k]
        c1 += w * flat[k + one]
        c2 += w * flat[k + np.uint64(2)]
        c3 += w * flat[k + np.uint64(3)]
        c4 += w * flat[k + np.uint64(4)]
        c5 += w * flat[k + np.uint64(5)]
        k += np.uint64(width)
    total = wx[0] * c0 + wx[1] * c1 + wx[2] * c2 + wx[3] * c3 + wx[4] * c4 + wx[5] * c5
    return total * (1.0 / 14400.0)


@njit(cache=True, nogil=True, error_model="numpy")
def expand(flat, width, y, x):
    """Height, gradient and second derivatives (h, h_y, h_x, h_yy, h_xy, h_xx) per pixel."""
    row = math.floor(y)
    col = math.floor(x)
    table = np.empty((2, 3, 6))
    for axis in range(2):
        t = y - row if axis == 0 else x - col
        u = 1.0 - t
        w = _weights(t)
        for k in range(6):
            table[axis, 0, k] = w[k]
        table[axis, 1, 0] = -5.0 * u**4
        table[axis, 1, 1] = -50.0 + t * (40.0 + t * (60.0 + t * (-80.0 + t * 25.0)))
        table[axis, 1, 2] = t * (-120.0 + t * t * (120.0 - t * 50.0))
        table[axis, 1, 3] = 50.0 + t * (40.0 + t * (-60.0 + t * (-80.0 + t * 50.0)))
        table[axis, 1, 4] = 5.0 + t * (20.0 + t * (30.0 + t * (20.0 - t * 25.0)))
        table[axis, 1, 5] = 5.0 * t**4
        table[axis, 2, 0] = 20.0 * u**3
        table[axis, 2, 1] = 40.0 + t * (120.0 + t * (-240.0 + t * 100.0))
        table[axis, 2, 2] = -120.0 + t * t * (360.0 - t * 200.0)
        table[axis, 2, 3] = 40.0 + t * (-120.0 + t * (-240.0 + t * 200.0))
        table[axis, 2, 4] = 20.0 + t * (60.0 + t * (60.0 - t * 100.0))
        table[axis, 2, 5] = 20.0 * t**3
    corner = (row + PAD - 2) * width + col + PAD - 2
    h, h_y, h_x, h_yy, h_xy, h_xx = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for a in range(6):
        c0, c1, c2 = 0.0, 0.0, 0.0
        for b in range(6):
            c = flat[corner + a * width + b]
            c0 += c * table[1, 0, b]
            c1 += c * table[1, 1, b]
            c2 += c * table[1, 2, b]
        h += c0 * table[0, 0, a]
        h_y += c0 * table[0, 1, a]
        h_x += c1 * table[0, 0, a]
        h_yy += c0 * table[0, 2, a]
        h_xy += c1 * table[0, 1, a]
        h_xx += c2 * table[0, 0, a]
    s = 1.0 / 14400.0
    return h * s, h_y * s, h_x * s, h_yy * s, h_xy * s, h_xx * s
