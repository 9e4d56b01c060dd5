"""Conjugate gradients for the tangent matrix of the contacts."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _gradient_kernels as kernels
from .tangent import Tangent

__all__ = ["Solved", "conjugate_gradients"]


class Solved(NamedTuple):
    """Result of `conjugate_gradients`: x, what is left of the right side, c, and products spent."""

    solution: NDArray[np.float64]
    residual: NDArray[np.float64]
    constant: float
    products: int


def conjugate_gradients(
    matrix: Tangent,
    right: NDArray[np.float64],
    *,
    tolerance: float,
    start: NDArray[np.float64] | None = None,
    held: bool = False,
    limit: int = 200,
) -> Solved:
    """Solve `matrix` x = `right`, preconditioned by the contacts' own stiffness.

    Parameters
    ----------
    matrix, right
        Positive definite system.
    tolerance
        Fall of the preconditioned residual against that of x = 0.
    start
        First x; zero if None, and then any iterate is a direction of descent.
    held
        Solve `matrix` x + c = `right` for x and the number c instead, with the sum of x held as in
        `start`.
    limit
        Products spent at most.
    """
    stiffness = 1 / matrix.compliance
    solution, residual, count = np.zeros(len(right)), right.copy(), 0
    product, mean = kernels.weigh(stiffness, residual, held)
    goal = tolerance**2 * product
    if start is not None and start.any():
        solution, count = start.copy(), 1
        image = matrix(start)
        residual -= image
        if held:
            goal = max(goal, tolerance**2 * kernels.weigh(stiffness, image, held)[0])
        product, mean = kernels.weigh(stiffness, residual, held)
    direction, last = np.zeros(len(right)), math.inf
    while product > goal and count < limit:
        kernels.redirect(product / last, stiffness, residual, mean, direction)
        image = matrix(direction)
        curvature = kernels.dot(direction, image)
        if curvature <= 0.0:
            # pairs of elongated footprints are approximate, and the matrix with them
            solution = solution if solution.any() else direction
            break
        length = product / curvature
        last = product
        kernels.advance(length, direction, image, solution, residual)
        product, mean = kernels.weigh(stiffness, residual, held)
        count += 1
    return Solved(solution, residual, mean, count)
