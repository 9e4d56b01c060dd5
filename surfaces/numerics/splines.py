"""Quintic B-spline interpolation of a map: coefficients once, then values and derivatives.

The coefficients lie in a padded array: pixel (i, j) has index (i + PAD, j + PAD). The padding
holds the periodic images, or a quadratic continuation of the three points next to the border, so
that evaluation needs no case distinction and the end conditions of the filter do not matter
(its slower pole is 0.43, and 0.43 ** PAD is below 1e-9).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from . import parallel
from .compiled import compiled
from .spline_expansion import spline_expansion
from .spline_filter import LINES, PAD, filter_columns, filter_rows

__all__ = ["PAD", "coefficients", "evaluate_all", "expand"]


def coefficients(heights: NDArray[np.float64], periodic: bool) -> NDArray[np.float64]:
    """Spline coefficients, shape (ny + 2 PAD, nx + 2 PAD), that interpolate `heights` exactly."""
    ny, nx = heights.shape
    heights = np.ascontiguousarray(heights)
    out = np.empty((ny + 2 * PAD, nx + 2 * PAD))
    flat = out.ravel()

    def columns(start: int, stop: int) -> None:
        filter_columns(heights, periodic, flat, np.empty(len(out) * LINES), start, stop)

    def rows(start: int, stop: int) -> None:
        filter_rows(flat, nx, periodic, np.empty(out.shape[1] * LINES), start, stop)

    parallel.run(columns, parallel.lines(nx, out.size))
    parallel.run(rows, parallel.lines(len(out), out.size))
    return out


@compiled()
def expand(flat, width, y, x):
    """Height, gradient and second derivatives (h, h_y, h_x, h_yy, h_xy, h_xx) per pixel.

    At the pixel coordinates (y, x), anywhere within PAD - 5 pixels of the map. `flat` holds the
    coefficients row by row, `width` in a row.
    """
    row = math.floor(y)
    col = math.floor(x)
    corner = (row + PAD - 2) * width + col + PAD - 2
    return spline_expansion(flat, corner, width, y - row, x - col)


@compiled()
def evaluate_all(flat, width, ys, xs, out):
    """Heights at several points."""
    for k in range(ys.size):
        out[k] = expand(flat, width, ys[k], xs[k])[0]
