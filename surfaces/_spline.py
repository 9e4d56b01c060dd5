"""Quintic B-spline interpolation of a map: coefficients once, then values and derivatives.

The coefficients lie in a padded array: pixel (i, j) has index (i + PAD, j + PAD). The padding
holds the periodic images, or a quadratic continuation of the three points next to the border, so
that evaluation needs no case distinction and the end conditions of the filter do not matter
(its slower pole is 0.43, and 0.43 ** PAD is below 1e-9).
"""

from __future__ import annotations

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
    out = np.empty((ny + 2 * PAD, nx + 2 * PAD))
    inner = out[PAD : PAD + ny]
    _threads.run(
        lambda a, b: _filter_columns(heights.T, inner.T, periodic, a, b), _threads.blocks(ny, 64)
    )
    _threads.run(
        lambda a, b: _filter_columns(inner, out, periodic, a, b), _threads.blocks(nx + 2 * PAD, 64)
    )
    return out


@njit(cache=True, nogil=True)
def _filter_columns(source, target, periodic, start, stop):
    """Filter the columns [start, stop) of `source` (m, k) into `target` (m + 2 PAD, k)."""
    m = source.shape[0]
    buffer = np.empty((m + 2 * PAD, _LANES))
    first = np.zeros(_LANES)
    second = np.zeros(_LANES)
    for left in range(start, stop, _LANES):
        width = min(_LANES, stop - left)
        for i in range(m):
            for k in range(width):
                buffer[i + PAD, k] = source[i, left + k]
        for ghost in range(1, PAD + 1):
            low, high = PAD - ghost, PAD + m - 1 + ghost
            if periodic:
                for k in range(width):
                    buffer[low, k] = buffer[PAD + (-ghost) % m, k]
                    buffer[high, k] = buffer[PAD + (m - 1 + ghost) % m, k]
            else:
                bend = 0.5 * ghost * (ghost + 1)
                for k in range(width):
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
            for k in range(width):
                target[i, left + k] = buffer[i, k]


@njit(cache=True, nogil=True, inline="always")
def _weights(t):
    u = 1.0 - t
    return (
        u * u * u * u * u / 120.0,
        (26.0 + t * (-50.0 + t * (20.0 + t * (20.0 + t * (-20.0 + t * 5.0))))) / 120.0,
        (66.0 + t * t * (-60.0 + t * t * (30.0 - t * 10.0))) / 120.0,
        (26.0 + t * (50.0 + t * (20.0 + t * (-20.0 + t * (-20.0 + t * 10.0))))) / 120.0,
        (1.0 + t * (5.0 + t * (10.0 + t * (10.0 + t * (5.0 - t * 5.0))))) / 120.0,
        t * t * t * t * t / 120.0,
    )


@njit(cache=True, nogil=True)
def evaluate(spline, y, x):
    """Height at the pixel coordinates (y, x), anywhere within PAD - 3 pixels of the map."""
    row = int(np.floor(y))
    col = int(np.floor(x))
    wy = _weights(y - row)
    wx = _weights(x - col)
    row += PAD - 2
    col += PAD - 2
    total = 0.0
    for a in range(6):
        line = spline[row + a]
        total += wy[a] * (
            wx[0] * line[col]
            + wx[1] * line[col + 1]
            + wx[2] * line[col + 2]
            + wx[3] * line[col + 3]
            + wx[4] * line[col + 4]
            + wx[5] * line[col + 5]
        )
    return total


@njit(cache=True, nogil=True)
def expand(spline, y, x):
    """Height, gradient and second derivatives (h, h_y, h_x, h_yy, h_xy, h_xx) per pixel."""
    row = int(np.floor(y))
    col = int(np.floor(x))
    table = np.empty((2, 3, 6))
    for axis in range(2):
        t = y - row if axis == 0 else x - col
        u = 1.0 - t
        table[axis, 0, :] = _weights(t)
        table[axis, 1, 0] = -(u**4) / 24.0
        table[axis, 1, 1] = (-50.0 + t * (40.0 + t * (60.0 + t * (-80.0 + t * 25.0)))) / 120.0
        table[axis, 1, 2] = t * (-120.0 + t * t * (120.0 - t * 50.0)) / 120.0
        table[axis, 1, 3] = (50.0 + t * (40.0 + t * (-60.0 + t * (-80.0 + t * 50.0)))) / 120.0
        table[axis, 1, 4] = (5.0 + t * (20.0 + t * (30.0 + t * (20.0 - t * 25.0)))) / 120.0
        table[axis, 1, 5] = t**4 / 24.0
        table[axis, 2, 0] = u**3 / 6.0
        table[axis, 2, 1] = (40.0 + t * (120.0 + t * (-240.0 + t * 100.0))) / 120.0
        table[axis, 2, 2] = (-120.0 + t * t * (360.0 - t * 200.0)) / 120.0
        table[axis, 2, 3] = (40.0 + t * (-120.0 + t * (-240.0 + t * 200.0))) / 120.0
        table[axis, 2, 4] = (20.0 + t * (60.0 + t * (60.0 - t * 100.0))) / 120.0
        table[axis, 2, 5] = t**3 / 6.0
    out = np.zeros(6)
    for a in range(6):
        for b in range(6):
            c = spline[row + PAD - 2 + a, col + PAD - 2 + b]
            out[0] += c * table[0, 0, a] * table[1, 0, b]
            out[1] += c * table[0, 1, a] * table[1, 0, b]
            out[2] += c * table[0, 0, a] * table[1, 1, b]
            out[3] += c * table[0, 2, a] * table[1, 0, b]
            out[4] += c * table[0, 1, a] * table[1, 1, b]
            out[5] += c * table[0, 0, a] * table[1, 2, b]
    return out
