"""The elastic half-space as a convolution: Fourier symbol and cell-integrated influence.

Pressures are carried as p~ = compliance * p, a length, so that the operator p~ -> u is
dimensionless and of order one at the pixel scale.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import hyp2f1

from surfaces.arrays import Array
from surfaces.numerics.compiled import compiled
from surfaces.numerics.parallel import by_rows

from .footprint import Footprints
from .material import HalfSpace

__all__ = ["compliance", "influence", "near_influence", "symbol_quadrant"]

_NEAR_CELLS = 8
"""Distance in cells up to which the corner function is used."""

_MIDDLE_CELLS = 100
"""Distance in cells up to which a Gauss rule is used, beyond it a Taylor series."""


Grid = NDArray[np.floating[Any]]


def compliance(spacing: tuple[float, float], material: HalfSpace) -> float:
    """Symbol at the wave number of one inverse pixel [m/Pa]: the unit of pressure inside.

    Notes
    -----
    ``Lambda(q) = 2**(1-m) pi / (E_m* Gamma((1+m)/2)**2) |q|**(m-1)`` at ``|q| = (dy dx)**-1/2``.
    """
    pixel = math.sqrt(spacing[0] * spacing[1])
    unit = Footprints(1.0, material.m).symbol
    return float(unit * pixel ** (1.0 - material.m) / material.modulus)


def symbol_quadrant(
    shape: tuple[int, int], spacing: tuple[float, float], power: float, factor: float
) -> Array:
    """Factor times |q|**power at frequencies from zero on, shape (ny//2+1, nx//2+1); 0 at q = 0."""
    pixel = math.sqrt(spacing[0] * spacing[1])
    squares = [
        np.square(2.0 * np.pi * pixel / step * np.arange(n // 2 + 1) / n)
        for n, step in zip(shape, spacing, strict=True)
    ]
    values = np.add.outer(*squares)
    values[0, 0] = 1.0
    np.sqrt(values, out=values)
    values **= power
    values *= factor
    values[0, 0] = 0.0
    return values


def influence(
    shape: tuple[int, int], spacing: tuple[float, float], m: float, factor: float = 1.0
) -> Array:
    """Displacement at cell offsets (0..ny-1, 0..nx-1) per pressure p~ on one cell, shape (ny, nx).

    Times a factor.

    Notes
    -----
    ``K = C_m int int r**-(1+m) dA`` over the cell, exact within 8 cells (corner function with
    2F1), a 5 x 5 Gauss rule to 100 cells, and beyond it the mean over the cell by its Taylor
    series to fourth order (relative error below 1e-13).
    """
    pixel = math.sqrt(spacing[0] * spacing[1])
    hy, hx = spacing[0] / pixel, spacing[1] / pixel
    factor *= _point_factor(m)
    kernel = np.empty(shape)
    by_rows(_far_cells, shape, hy, hx, m, factor, kernel)
    near = _near_cells(hy, hx, m)
    rows, columns = (min(n, k) for n, k in zip(shape, near.shape, strict=True))
    np.multiply(near[:rows, :columns], factor, out=kernel[:rows, :columns])
    return kernel


def near_influence(shape: tuple[int, int], spacing: tuple[float, float], m: float) -> Array:
    """`influence` over a few cells, all by the corner function: nothing to compile, 1e-9."""
    pixel = math.sqrt(spacing[0] * spacing[1])
    hy, hx = spacing[0] / pixel, spacing[1] / pixel
    y, x = (h * np.arange(n, dtype=float) for h, n in zip((hy, hx), shape, strict=True))
    return _corner_mean(y, x, hy, hx, m) * _point_factor(m)


def _point_factor(m: float) -> float:
    """C_m over the compliance of a cell of unit area."""
    unit = Footprints(1.0, m)
    return unit.point / unit.symbol


@lru_cache(maxsize=8)
def _near_cells(hy: float, hx: float, m: float) -> Array:
    """Integral of r**-(1+m) over the cells within 100 of the longer side."""
    longest = max(hx, hy)
    y, x = (h * np.arange(int(_MIDDLE_CELLS * longest / h) + 1, dtype=float) for h in (hy, hx))
    cells = _gauss_mean(y, x, hy, hx, m)
    rows, columns = (int(_NEAR_CELLS * longest / h) + 1 for h in (hy, hx))
    cells[:rows, :columns] = _corner_mean(y[:rows], x[:columns], hy, hx, m)
    return cells


def _gauss_mean(y: Array, x: Array, hy: float, hx: float, m: float) -> Array:
    """Integral of r**-(1+m) over cells by a tensor Gauss-Legendre rule of 5 x 5 points."""
    nodes, weights = np.polynomial.legendre.leggauss(5)
    total = np.zeros((y.size, x.size))
    for node_y, weight_y in zip(nodes, weights, strict=True):
        for node_x, weight_x in zip(nodes, weights, strict=True):
            square = (y + 0.5 * hy * node_y)[:, None] ** 2 + (x + 0.5 * hx * node_x)[None, :] ** 2
            square[0, 0] = 1.0
            total += 0.25 * weight_y * weight_x * square ** (-0.5 * (1.0 + m))
    return total * (hx * hy)


def _corner_mean(y: Array, x: Array, hy: float, hx: float, m: float) -> Array:
    """Integral of r**-(1+m) over cells by differences of the corner function."""
    edges_y = np.append(y - 0.5 * hy, y[-1] + 0.5 * hy)
    edges_x = np.append(x - 0.5 * hx, x[-1] + 0.5 * hx)
    corner = _corner(np.abs(edges_x)[None, :], np.abs(edges_y)[:, None], m)
    corner *= np.sign(edges_y)[:, None] * np.sign(edges_x)[None, :]
    result: Array = np.diff(np.diff(corner, axis=0), axis=1)
    return result


def _corner(x: Array, y: Array, m: float) -> Array:
    """Integral of r**-(1+m) over the rectangle (0, x) by (0, y), x and y positive."""
    a = 0.5 * (1.0 + m)
    along_x = x ** (-2 * a) * hyp2f1(0.5, a, 1.5, -((y / x) ** 2))
    along_y = y ** (-2 * a) * hyp2f1(0.5, a, 1.5, -((x / y) ** 2))
    return np.asarray(x * y / (1.0 - m) * (along_x + along_y))


@compiled()
def _far_cells(
    rows: tuple[int, int], hy: float, hx: float, m: float, factor: float, result: Grid
) -> None:
    """Factor times the integral of r**-(1+m) over cells far from the origin.

    The mean over a cell by its Taylor series: value and even derivatives to the fourth.
    """
    a = 1.0 + m
    yy, xx = hy * hy, hx * hx
    for i in range(rows[0], rows[1]):
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
