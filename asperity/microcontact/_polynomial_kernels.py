"""Numba kernels of the parts of one Newton step: polynomials moved, table rows, a small system.

Coefficient vectors run over the monomials x**i y**j of `ellipse_tables.monomials`.
"""

from __future__ import annotations

import math

from numba import njit

from ._directions import FAST
from .ellipse_tables import DEGREE

TERMS = (DEGREE + 1) * (DEGREE + 2) // 2
"""Number of monomials: a constant, so that the loops unroll."""


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def move(x0, y0, turn, out):
    """Coefficients about (x0, y0) in axes turned by `turn`, by Taylor shifts and three shears."""
    degree = DEGREE
    if x0 != 0.0:
        for j in range(degree + 1):
            top = degree - j
            for p in range(top):
                for i in range(top - 1, p - 1, -1):
                    k = i + j
                    out[k * (k + 1) // 2 + j] += x0 * out[(k + 1) * (k + 2) // 2 + j]
    if y0 != 0.0:
        for i in range(degree + 1):
            top = degree - i
            for p in range(top):
                for j in range(top - 1, p - 1, -1):
                    k = i + j
                    out[k * (k + 1) // 2 + j] += y0 * out[(k + 1) * (k + 2) // 2 + j + 1]
    if turn == 0.0:
        return
    s, t = math.sin(turn), -math.tan(0.5 * turn)
    for k in range(1, degree + 1):
        o = k * (k + 1) // 2
        for shear in range(3):
            if shear == 1:
                for p in range(k):
                    for j in range(k - 1, p - 1, -1):
                        out[o + j] += s * out[o + j + 1]
            else:
                for p in range(k):
                    for i in range(k - 1, p - 1, -1):
                        out[o + k - i] += t * out[o + k - i - 1]


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def table_row(rows, start, inverse, position, out):
    """Row of the tables at a logarithm of the axis ratio, by local cubics."""
    x = (position - start) * inverse
    x = min(max(x, 1.0), rows.shape[0] - 2.001)
    i = int(x)
    u = x - i
    w0 = -u * (u - 1) * (u - 2) / 6
    w1 = (u + 1) * (u - 1) * (u - 2) / 2
    w2 = -(u + 1) * u * (u - 2) / 2
    w3 = (u + 1) * u * (u - 1) / 6
    for n in range(out.size):
        out[n] = w0 * rows[i - 1, n] + w1 * rows[i, n] + w2 * rows[i + 1, n] + w3 * rows[i + 2, n]


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def solve(matrix, vector):
    """Gaussian elimination in place of a positive system of five; upper triangle given."""
    n = 5
    for i in range(n):
        pivot = 1.0 / matrix[i, i]
        for r in range(i + 1, n):
            f = matrix[i, r] * pivot
            for c in range(r, n):
                matrix[r, c] -= f * matrix[i, c]
            vector[r] -= f * vector[i]
    for i in range(n - 1, -1, -1):
        v = vector[i]
        for c in range(i + 1, n):
            v -= matrix[i, c] * vector[c]
        vector[i] = v / matrix[i, i]
