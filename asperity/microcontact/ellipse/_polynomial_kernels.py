"""Numba kernels of the parts of one Newton step: polynomials moved, a small system.

Everything is done for eight profiles at once (`_lanes`). Coefficients run over the monomials
x**i y**j of `ellipse_operator.monomials`.
"""

from __future__ import annotations

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.lanes import load, store

from .ellipse_operator import DEGREE

TERMS = (DEGREE + 1) * (DEGREE + 2) // 2
"""Number of monomials: a constant, so that the loops unroll."""


@inner(fastmath=QUOTIENTS)
def move(x0, y0, sine, tangent, out):
    """Coefficients about (x0, y0) in turned axes, by Taylor shifts and three shears.

    Given are the sine of the turn and the tangent of half of it.
    """
    for j in range(DEGREE):
        top = DEGREE - j
        for p in range(top):
            for i in range(top - 1, p - 1, -1):
                k = i + j
                low, high = k * (k + 1) // 2 + j, (k + 1) * (k + 2) // 2 + j
                store(out, low, load(out, low) + x0 * load(out, high))
    for i in range(DEGREE):
        top = DEGREE - i
        for p in range(top):
            for j in range(top - 1, p - 1, -1):
                k = i + j
                low, high = k * (k + 1) // 2 + j, (k + 1) * (k + 2) // 2 + j + 1
                store(out, low, load(out, low) + y0 * load(out, high))
    for k in range(1, DEGREE + 1):
        o = k * (k + 1) // 2
        for shear in range(3):
            for p in range(k):
                for j in range(k - 1, p - 1, -1):
                    if shear == 1:
                        store(out, o + j, load(out, o + j) + sine * load(out, o + j + 1))
                    else:
                        above = tangent * load(out, o + k - j - 1)
                        store(out, o + k - j, load(out, o + k - j) - above)


@compiled(fastmath=QUOTIENTS)
def solve(matrix, vector):
    """Gaussian elimination in place of a positive system of five; upper triangle given."""
    n = 5
    for i in range(n):
        pivot = 1.0 / load(matrix, n * i + i)
        store(matrix, n * i + i, pivot)
        for r in range(i + 1, n):
            f = load(matrix, n * i + r) * pivot
            for c in range(r, n):
                store(matrix, n * r + c, load(matrix, n * r + c) - f * load(matrix, n * i + c))
            store(vector, r, load(vector, r) - f * load(vector, i))
    for i in range(n - 1, -1, -1):
        v = load(vector, i)
        for c in range(i + 1, n):
            v -= load(matrix, n * i + c) * load(vector, c)
        store(vector, i, v * load(matrix, n * i + i))
