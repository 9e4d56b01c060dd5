"""One Newton step of the contacts: conjugate gradients for the tangent matrix, from forces to
approaches with the laws at both ends, and a prediction put right before its field is taken.
"""

from __future__ import annotations

import copy
import functools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.ewald.tangent import Tangent

from . import _newton_kernels
from .state import Problem, State

__all__ = ["Solved", "Step", "conjugate_gradients", "corrected_prediction"]

Array = NDArray[np.float64]

OPENED_COMPLIANCE = 1e6
"""Compliance, over that in the tangent, of contacts that a step has opened: they stay open while
their neighbors change."""

BEST_LINEAR_TOLERANCE = 0.05
"""Relative accuracy of the linear solve at best: of many contacts a rougher one left a third of the
points to a Newton step, which costs twice as much as the rest."""


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
    many, by cells of them (`TwoLevelPreconditioner`), in `limit` products at most.

    The tolerance is the fall of the residual, weighted by stiffness, against that of x = 0. From a
    `start` of zero (None) any iterate is a direction of descent. With `held` it solves `matrix` x +
    c = `right` for x and the number c instead, with the sum of x held as in `start`.
    """
    stiffness, cell = 1 / matrix.compliance, matrix.cell
    inverse, total = matrix.far
    far = np.empty((3, len(total)))
    system = stiffness, cell, inverse, total, held, far
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
    while error > goal and count < limit:
        taken, after = _newton_kernels.advance(
            product, direction, matrix(direction), solution, residual, *system
        )
        if not taken:
            # pairs of elongated footprints are approximate, and the matrix with them
            solution = solution + direction if count == first else solution
            break
        (error, mean, product), count = after, count + 1
    return Solved(solution, residual, mean, count)


class Step:
    """The active contacts of a state after `State.balance`, their displacement linear in the change
    of their forces. All arrays run over the points of the tangent matrix there, which `refine`
    changes."""

    def __init__(self, state: State, tangent: Tangent) -> None:
        self.rows = rows = tangent.index
        self.tangent = tangent
        self.laws = state.problem.laws.rows(rows)
        self.before = state.laws.force[rows]
        self.wanted = state.wanted[rows]
        self.own = self.stiffness = state.stiffness[rows]
        self.base, self.force = state.base[rows], state.force[rows]
        approach = state.approach[rows]
        self.lower, self.upper = _bounds(approach, self.wanted, state.error[rows])

    def approach(self, change: Array) -> Array:
        """Approach [m] after a change [N] of the forces, by the power law that a contact follows at
        its force and stiffness."""
        exponent = np.minimum(self.force / (self.stiffness * self.base), 1.0)
        grown = np.maximum((self.before + change) / self.force, 0.0)
        wanted: Array = self.base * grown**exponent
        return np.minimum(np.maximum(wanted, self.lower), self.upper)

    def wanted_after(self, constant: float, change: Array, image: Array) -> Array:
        """z - s - u [m] after a change of the separation [m] and of the forces [N], of which the
        tangent at the start makes the `image` [m]."""
        return self.wanted - constant - image + change / self.own

    def refine(
        self, change: Array, *, tolerance: float, load: float | None
    ) -> tuple[Step, Array, float, int]:
        """A second Newton step at the forces after `change` [N], with the laws there: the step with
        these laws, the whole change of the forces, that of the separation [m], and products spent.

        Notes
        -----
        The laws bend much more than the displacements do, and contacts close and open: their part
        of the tangent is renewed, that of the displacements, which costs more, is kept.
        """
        after = copy.copy(self)
        approach = self.approach(change)
        found = self.laws(approach)
        change, closed = found.force - self.before, found.force > 0
        error = self.wanted_after(0.0, change, self.tangent(change)) - approach
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
        return after, change + solved.solution, constant, solved.products + 1


def _bounds(approach: Array, wanted: Array, error: Array) -> tuple[Array, Array]:
    """Approaches [m] within which a step stays: a contact that overlaps still keeps a tenth of its
    approach, one that does not may open."""
    lower = np.where(wanted > 0, 0.1 * approach, 0.0)
    return lower, approach + np.maximum(2 * approach, np.abs(error))


def corrected_prediction(
    problem: Problem, wanted: Array, force: Array, *, tolerance: float
) -> tuple[Array, int]:
    """Approaches that agree with the forces of a forecast, and the products spent.

    The forecasts of z - s - u [m] and of the forces [N], shape (n,) each, have the same weights of
    the same points; the point will be solved to a residual of the tolerance.

    Notes
    -----
    Displacements are linear in the forces but for the growth of the footprints: the forecast of u
    is right for the forecast of the forces, whether the points before were solved well or not. It
    is the laws that bend. With F(d) the laws, the approaches that fit are the solution of
    d = wanted - G (F(d) - force), G the interaction of the contacts: one Newton step of it.
    """
    law = problem.laws(wanted)
    closed = law.force > 0
    tangent = Tangent(problem.plan, closed, law.stiffness, None, problem.form)
    rows = tangent.index
    own, stiffness, force = law.force[rows], law.stiffness[rows], force[rows]
    lack = own - force
    # the residual, sum |r| k, is at most the root of sum k r^2 times sum k
    most = math.sqrt(float(stiffness.sum()) * float(np.sum(lack * lack / stiffness)))
    enough = tolerance * float(own.sum()) / most if most > 0 else 1.0
    enough = min(max(BEST_LINEAR_TOLERANCE, enough), 1.0)
    solved = conjugate_gradients(tangent, lack / stiffness, tolerance=enough)
    share = np.maximum((force + solved.solution) / own, 0.0)
    approach = np.maximum(wanted, 0.0)
    approach[rows] *= share ** np.minimum(own / (stiffness * wanted[rows]), 1.0)
    return approach, solved.products
