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
from ._spline_form import spline_expansion

__all__ = ["PAD", "coefficients", "evaluate_all", "expand"]

PAD = 25
_POLE_1 = -0.43057534709997379
_POLE_2 = -0.043096288203264654
_LINES = 16


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
    buffer = np.empty((m + 2 * PAD, _LINES))
    first = np.zeros(_LINES)
    second = np.zeros(_LINES)
    for left in range(start, stop, _LINES):
        lanes = min(_LINES, stop - left)
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
        for k in range(_LINES):
            first[k] = 120.0 * buffer[0, k] / (1.0 - _POLE_1)
            second[k] = first[k] / (1.0 - _POLE_2)
        for i in range(m + 2 * PAD):
            for k in range(_LINES):
                first[k] = 120.0 * buffer[i, k] + _POLE_1 * first[k]
                second[k] = first[k] + _POLE_2 * second[k]
                buffer[i, k] = second[k]
        for k in range(_LINES):
            first[k] = -_POLE_1 * second[k] / (1.0 - _POLE_1)
            second[k] = -_POLE_2 * first[k] / (1.0 - _POLE_2)
        for i in range(m + 2 * PAD - 1, -1, -1):
            for k in range(_LINES):
                first[k] = _POLE_1 * (first[k] - buffer[i, k])
                second[k] = _POLE_2 * (second[k] - first[k])
                buffer[i, k] = second[k]
        for i in range(m + 2 * PAD):
            for k in range(lanes):
                flat[i * along + (left + k) * across] = buffer[i, k]


@njit(cache=True, nogil=True, error_model="numpy")
def expand(flat, width, y, x):
    """Height, gradient and second derivatives (h, h_y, h_x, h_yy, h_xy, h_xx) per pixel.

    At the pixel coordinates (y, x), anywhere within PAD - 5 pixels of the map. `flat` holds the
    coefficients row by row, `width` in a row.
    """
    row = math.floor(y)
    col = math.floor(x)
    corner = (row + PAD - 2) * width + col + PAD - 2
    return spline_expansion(flat, corner, width, y - row, x - col)


@njit(cache=True, nogil=True, error_model="numpy")
def evaluate_all(flat, width, ys, xs, out):
    """Heights at several points."""
    for k in range(ys.size):
        out[k] = expand(flat, width, ys[k], xs[k])[0]
