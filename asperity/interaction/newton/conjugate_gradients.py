"""Conjugate gradients for the tangent matrix of the contacts."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.ewald.tangent import Tangent

from . import _gradient_kernels as kernels

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
    """Solve `matrix` x = `right`, preconditioned by the contacts' own stiffness and, if they are
    many, by cells of them (`TwoLevelPreconditioner`).

    Parameters
    ----------
    matrix, right
        Positive definite system.
    tolerance
        Fall of the residual, weighted by stiffness, against that of x = 0.
    start
        First x; zero if None, and then any iterate is a direction of descent.
    held
        Solve `matrix` x + c = `right` for x and the number c instead, with the sum of x held as in
        `start`.
    limit
        Products spent at most.
    """
    stiffness, cell = 1 / matrix.compliance, matrix.cell
    inverse, total = matrix.far
    far = np.empty((3, len(total)))
    system = stiffness, cell, inverse, total, held, far
    solution, residual, count = np.zeros(len(right)), right.copy(), 0
    goal = tolerance**2 * kernels.weigh(stiffness, right, held)
    if start is not None and start.any():
        solution, count = start.copy(), 1
        image = matrix(start)
        residual -= image
        if held:
            goal = max(goal, tolerance**2 * kernels.weigh(stiffness, image, held))
    direction = np.zeros(len(right))
    error, mean, product = kernels.aim(math.inf, direction, residual, *system)
    while error > goal and count < limit:
        taken, after = kernels.advance(
            product, direction, matrix(direction), solution, residual, *system
        )
        if not taken:
            # pairs of elongated footprints are approximate, and the matrix with them
            solution = solution if solution.any() else direction
            break
        (error, mean, product), count = after, count + 1
    return Solved(solution, residual, mean, count)
