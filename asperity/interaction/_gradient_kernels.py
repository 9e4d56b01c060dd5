"""Compiled loops of the conjugate gradients."""

from __future__ import annotations

from surfaces._compiled import compiled


@compiled()
def weigh(stiffness, residual, held):
    """sum k (r - c)^2, c the mean of r weighted by k if the sum is held, else zero."""
    square = 0.0
    first = 0.0
    total = 0.0
    for i in range(residual.size):
        moment = stiffness[i] * residual[i]
        total += stiffness[i]
        first += moment
        square += moment * residual[i]
    return max(square - first * first / total, 0.0) if held else square


@compiled()
def aim(residual, stiffness, cell, inverse, total, held, far):
    """Preconditioned residual z_i = k_i (r_i + far_c), c the cell of i, its sum zero if held.

    Fills `far` by cells, where `inverse` and `total` are E and K of `Afar`. Returns what `weigh`
    does, the mean of r weighted by k if held, and the sum of r z.
    """
    count = far.size
    square = 0.0
    first = 0.0
    whole = 0.0
    far[:] = 0.0
    for i in range(residual.size):
        moment = stiffness[i] * residual[i]
        far[cell[i]] += moment
        square += moment * residual[i]
    moments = far.copy()
    product = square
    response = 0.0
    answer = 0.0
    even = far.copy()
    for c in range(count):
        first += moments[c]
        whole += total[c]
        far[c] = 0.0
        even[c] = 1.0
        for e in range(count):
            far[c] += inverse[c, e] * moments[e]
            even[c] += inverse[c, e] * total[e]
        product += moments[c] * far[c]
        response += moments[c] + total[c] * far[c]
        answer += total[c] * even[c]
    if not held:
        return square, 0.0, product
    shift = response / answer
    for c in range(count):
        far[c] -= shift * even[c]
    mean = first / whole
    return max(square - mean * first, 0.0), mean, max(product - shift * response, 0.0)


@compiled()
def advance(length, direction, image, solution, residual):
    """One step of conjugate gradients along `direction` with the matrix's `image` of it."""
    for i in range(solution.size):
        solution[i] += length * direction[i]
        residual[i] -= length * image[i]


@compiled()
def redirect(ratio, stiffness, residual, cell, far, direction):
    """New direction: the preconditioned residual of `aim` plus `ratio` times the old one."""
    for i in range(direction.size):
        direction[i] = stiffness[i] * (residual[i] + far[cell[i]]) + ratio * direction[i]


@compiled()
def dot(a, b):
    """Scalar product, in one thread."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total
