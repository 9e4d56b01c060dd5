"""Compiled loops of the conjugate gradients."""

from __future__ import annotations

from numba import njit


@njit(cache=True, nogil=True)
def weigh(stiffness, residual, held):
    """sum k (r - c)^2 and c: the mean of r weighted by k if the sum is held, else zero."""
    square = 0.0
    first = 0.0
    total = 0.0
    for i in range(residual.size):
        moment = stiffness[i] * residual[i]
        total += stiffness[i]
        first += moment
        square += moment * residual[i]
    if not held:
        return square, 0.0
    mean = first / total
    return max(square - mean * first, 0.0), mean


@njit(cache=True, nogil=True)
def advance(length, direction, image, solution, residual):
    """One step of conjugate gradients along `direction` with the matrix's `image` of it."""
    for i in range(solution.size):
        solution[i] += length * direction[i]
        residual[i] -= length * image[i]


@njit(cache=True, nogil=True)
def redirect(ratio, stiffness, residual, mean, direction):
    """New direction: scaled residual, less its mean, plus `ratio` times the old one."""
    for i in range(direction.size):
        direction[i] = stiffness[i] * (residual[i] - mean) + ratio * direction[i]


@njit(cache=True, nogil=True)
def dot(a, b):
    """Scalar product, in one thread."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total
