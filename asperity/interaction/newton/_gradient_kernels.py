"""Compiled loops of the conjugate gradients.

Preconditioned conjugate gradients for A x = b, and for A x + c = b with the sum of x held, with the
inverse D^-1 + D^-1 P E P' D^-1 of `TwoLevelPreconditioner`.
"""

from __future__ import annotations

from surfaces.numerics.compiled import compiled, inner

LONGEST = 5.0
"""Steps over the preconditioned residual that are longer meet next to no resistance: they are 0.4
to 0.9 where the matrix is positive definite, 1.8 at most on random maps, 3 to 5 where a lattice of
equal summits is about to fill."""


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


@inner()
def _aim(last, direction, residual, stiffness, cell, inverse, total, held, far):
    """`aim`, within compiled loops."""
    count = total.size
    square = 0.0
    first = 0.0
    whole = 0.0
    for c in range(count):
        far[1, c] = 0.0
    for i in range(residual.size):
        moment = stiffness[i] * residual[i]
        far[1, cell[i]] += moment
        square += moment * residual[i]
    product = square
    response = 0.0
    answer = 0.0
    for c in range(count):
        first += far[1, c]
        whole += total[c]
        here = 0.0
        even = 1.0
        for e in range(count):
            here += inverse[c, e] * far[1, e]
            even += inverse[c, e] * total[e]
        product += far[1, c] * here
        response += far[1, c] + total[c] * here
        answer += total[c] * even
        far[0, c] = here
        far[2, c] = even
    mean = 0.0
    if held:
        shift = response / answer
        for c in range(count):
            far[0, c] -= shift * far[2, c]
        mean = first / whole
        square = max(square - mean * first, 0.0)
        product = max(product - shift * response, 0.0)
    ratio = product / last
    for i in range(direction.size):
        direction[i] = stiffness[i] * (residual[i] + far[0, cell[i]]) + ratio * direction[i]
    return square, mean, product


@compiled()
def aim(last, direction, residual, stiffness, cell, inverse, total, held, far):
    """New `direction`: the preconditioned residual z_i = k_i (r_i + far_c), c the cell of i, its
    sum zero if held, plus the old one times the sum of r z over the `last` such sum.

    `inverse` and `total` are E and K of `TwoLevelPreconditioner`, `far` (3, cells) is scratch.
    Returns what `weigh` does, the mean of r weighted by k if held, and the sum of r z.
    """
    return _aim(last, direction, residual, stiffness, cell, inverse, total, held, far)


@compiled()
def advance(
    product, direction, image, solution, residual, stiffness, cell, inverse, total, held, far
):
    """One step of conjugate gradients along `direction` with the matrix's `image` of it, and the
    next direction. Returns whether one was taken, which is not done along directions of negative or
    next to no curvature, and what `aim` does."""
    curvature = 0.0
    for i in range(direction.size):
        curvature += direction[i] * image[i]
    if LONGEST * curvature <= product:
        return False, (0.0, 0.0, 0.0)
    length = product / curvature
    for i in range(solution.size):
        solution[i] += length * direction[i]
        residual[i] -= length * image[i]
    after = _aim(product, direction, residual, stiffness, cell, inverse, total, held, far)
    return True, after
