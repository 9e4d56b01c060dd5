"""One Newton step of the contacts: the linear solve by conjugate gradients, the step from forces to
approaches, and a Newton step that corrects a prediction before its field is computed.
"""

from __future__ import annotations

import copy
import functools
import math
from typing import NamedTuple

import numpy as np

from asperity.interaction.ewald.tangent import Tangent
from surfaces.arrays import Array

from . import _newton_kernels
from .state import CandidateValues, Problem, State

__all__ = ["Solved", "Step", "conjugate_gradients", "corrected_prediction"]


OPENED_COMPLIANCE = 1e6
"""Factor on the compliance of contacts that a step has opened: they stay open while their neighbors
change."""

BEST_LINEAR_TOLERANCE = 0.05
"""Best relative accuracy of the linear solve of a prediction. With less accuracy a third of the
points of many contacts needed a Newton step, which costs twice as much as the rest."""


MOST_PRODUCTS = 200
"""Largest number of products with the matrix in one linear solve."""


class Solved(NamedTuple):
    """Result of `conjugate_gradients`: x, the residual b - A x, c, and the number of products."""

    solution: Array
    residual: Array
    constant: float
    products: int


def conjugate_gradients(
    matrix: Tangent,
    right: Array,
    *,
    tolerance: float,
    start: Array | None = None,
    held: bool = False,
) -> Solved:
    """Solve `matrix` x = `right` by at most `MOST_PRODUCTS` products.

    The preconditioner is the stiffness of the contacts; for many contacts a solve on coarse cells
    is added (`TwoLevelPreconditioner`). `tolerance` bounds the residual, weighted by stiffness,
    over that of x = 0. From a `start` of zero (None) every iterate is a direction of descent. With
    `held` the system is `matrix` x + c = `right` for x and the number c, and the sum of x stays
    that of `start`.
    """
    stiffness, cell = 1 / matrix.compliance, matrix.cell
    inverse, total = matrix.coarse
    scratch = np.empty((3, len(total)))
    system = stiffness, cell, inverse, total, held, scratch
    solution, residual, count = np.zeros(len(right)), right.copy(), 0
    direction = np.zeros(len(right))
    aim = functools.partial(_newton_kernels.aim, math.inf, direction)
    goal = tolerance**2 * aim(right, *system)[0]
    if start is not None and start.any():
        solution, count = start.copy(), 1
        image = matrix(start)
        residual -= image
        if held:
            goal = max(goal, tolerance**2 * aim(image, *system)[0])
    error, mean, product = aim(residual, *system)
    first = count
    while error > goal and count < MOST_PRODUCTS:
        taken, after = _newton_kernels.advance(
            product, direction, matrix(direction), solution, residual, *system
        )
        if not taken:
            # not positive definite: the matrix of elongated footprints is an approximation
            solution = solution + direction if count == first else solution
            break
        (error, mean, product), count = after, count + 1
    return Solved(solution, residual, mean, count)


class Step:
    """A Newton step from a state after `State.balance`: displacements are linear in the change of
    the forces, laws are not. Arrays run over the points of the tangent matrix, which `refine`
    changes."""

    def __init__(self, state: State, tangent: Tangent) -> None:
        self.rows = rows = tangent.index
        self.tangent = tangent
        self.laws = state.problem.laws.rows(rows)
        self.before = state.laws.force[rows]
        self.interference = state.interference[rows]
        self.own = self.stiffness = state.stiffness[rows]
        self.base, self.force = state.base[rows], state.force[rows]
        approach = state.approach[rows]
        self.lower, self.upper = _bounds(approach, self.interference, state.error[rows])

    def approach(self, change: Array) -> Array:
        """Approaches [m] after a change [N] of the forces, by the power law d ~ F^(F/(k d)) through
        the force F and stiffness k of each contact at its base d."""
        exponent = np.minimum(self.force / (self.stiffness * self.base), 1.0)
        grown = np.maximum((self.before + change) / self.force, 0.0)
        approach: Array = self.base * grown**exponent
        return np.minimum(np.maximum(approach, self.lower), self.upper)

    def interference_after(self, constant: float, change: Array, image: Array) -> Array:
        """Interference [m] after the change `constant` [m] of the separation and `change` [N] of
        the forces, whose product with the tangent matrix of the start is `image` [m]."""
        return self.interference - constant - image + change / self.own

    def refine(
        self, change: Array, *, tolerance: float, load: float | None
    ) -> tuple[Step, Array, float]:
        """A second Newton step from the forces after `change` [N], with the laws at these forces.

        Returns the step with these laws, the change of the forces by both steps, and the change of
        the separation [m] by the second.

        Notes
        -----
        Displacements are nearly linear in the forces; laws are not, and contacts close and open.
        The laws' part of the tangent matrix is therefore computed anew, the part of the
        displacements, which costs more, is kept.
        """
        after = copy.copy(self)
        approach = self.approach(change)
        found = self.laws(approach)
        change, closed = found.force - self.before, found.force > 0
        error = self.interference_after(0.0, change, self.tangent(change)) - approach
        after.stiffness = np.where(closed, found.stiffness, self.stiffness)
        after.base = np.where(closed, approach, self.base)
        after.force = np.where(closed, found.force, self.force)
        after.lower, after.upper = _bounds(approach, approach + error, error)
        opened = ~closed & (error <= 0)
        own = 1 / after.stiffness
        own[opened] *= OPENED_COMPLIANCE
        self.tangent.stiffen(own - 1 / self.stiffness)
        constant, start = 0.0, None
        if load is not None and closed.any():
            total = float(found.stiffness.sum())
            constant = float(np.sum(found.stiffness * error)) / total
            start = (load - float(found.force.sum())) / total * found.stiffness
        error -= constant
        solved = conjugate_gradients(
            self.tangent,
            np.where(opened, 0.0, error),
            tolerance=tolerance,
            start=start,
            held=load is not None,
        )
        constant += solved.constant
        return after, change + solved.solution, constant


def _bounds(approach: Array, interference: Array, error: Array) -> tuple[Array, Array]:
    """Bounds [m] on the approach after a step: a contact keeps at least a tenth of its approach
    where `interference` is positive, else it may open."""
    lower = np.where(interference > 0, 0.1 * approach, 0.0)
    return lower, approach + np.maximum(2 * approach, np.abs(error))


def corrected_prediction(
    problem: Problem, predicted: CandidateValues, *, tolerance: float
) -> CandidateValues:
    """The predicted values with the interference corrected by the laws, which are made; the values
    as they were if a corrected one is not finite.

    Interference and force have to be extrapolated with equal weights. `tolerance` is that of the
    solve that follows.

    Notes
    -----
    Apart from the growth of the footprints, displacements are linear in the forces. The predicted u
    is therefore that of the predicted forces, however well the earlier points were solved; but the
    laws F(d) do not give these forces. Approaches that agree with the laws solve
    d = interference - G (F(d) - force), with the interaction matrix G: this is one Newton step for
    this equation.
    """
    interference = predicted.interference
    problem.laws.make(interference > 0)
    law = problem.laws(interference)
    closed = law.force > 0
    tangent = Tangent(problem.coupling, closed, law.stiffness)
    rows = tangent.index
    own, stiffness, force = law.force[rows], law.stiffness[rows], predicted.force[rows]
    lack = own - force
    # the residual, sum |r| k, is at most the root of sum k r^2 times sum k
    most = math.sqrt(float(stiffness.sum()) * float(np.sum(lack * lack / stiffness)))
    enough = tolerance * float(own.sum()) / most if most > 0 else 1.0
    enough = min(max(BEST_LINEAR_TOLERANCE, enough), 1.0)
    solved = conjugate_gradients(tangent, lack / stiffness, tolerance=enough)
    share = np.maximum((force + solved.solution) / own, 0.0)
    approach = np.maximum(interference, 0.0)
    approach[rows] *= share ** np.minimum(own / (stiffness * interference[rows]), 1.0)
    finite = math.isfinite(float(approach.sum()))
    return predicted._replace(interference=approach) if finite else predicted
