"""Compiled influence functions and symbols over whole grids."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import prange
from numpy.typing import NDArray

from surfaces.numerics.compiled import compiled

Grid = NDArray[np.floating[Any]]


@compiled(parallel=True)
def powers(ky: Grid, kx: Grid, power: float, factor: float, result: Grid) -> None:
    """Factor times (ky + kx)**power on the grid of both, zero at the first point."""
    for y in prange(ky.size):
        row = result[y]
        if power == -0.5:
            for x in range(kx.size):
                row[x] = factor / np.sqrt(max(ky[y] + kx[x], 1e-300))
        else:
            for x in range(kx.size):
                row[x] = factor * max(ky[y] + kx[x], 1e-300) ** power
    result[0, 0] = 0.0


@compiled(parallel=True)
def far_cells(hy: float, hx: float, m: float, factor: float, result: Grid) -> None:
    """Factor times the integral of r**-(1+m) over cells far from the origin.

    The mean over a cell by its Taylor series: value and even derivatives to the fourth.
    """
    a = 1.0 + m
    yy, xx = hy * hy, hx * hx
    for i in prange(result.shape[0]):
        y = (hy * i) ** 2
        for j in range(result.shape[1]):
            inverse = 1.0 / max(y + (hx * j) ** 2, 1e-300)
            cx = (hx * j) ** 2 * inverse
            cy = 1.0 - cx
            second = a * (a + 2.0) * inverse * inverse
            mean = 1.0 + a * inverse / 24.0 * (xx * ((a + 2) * cx - 1) + yy * ((a + 2) * cy - 1))
            fourth = 3.0 + (a + 4) * cx * ((a + 6) * cx - 6.0)
            mean += second * xx * xx / 1920.0 * fourth
            fourth = 3.0 + (a + 4) * cy * ((a + 6) * cy - 6.0)
            mean += second * yy * yy / 1920.0 * fourth
            mean += second * xx * yy / 576.0 * (1.0 - (a + 4) + (a + 4) * (a + 6) * cx * cy)
            result[i, j] = factor * hx * hy * mean * inverse ** (0.5 * a)
