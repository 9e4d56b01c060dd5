"""Convex coupled solve: which contacts close, and how far, at one separation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import _kernels
from .deflection import deflection
from .laws import Evaluated
from .state import Problem, State
from .tangent import Tangent

__all__ = ["Solution", "conjugate_gradients", "descend"]

MAX_STEPS = 60
MAX_CUTS = 30
RELAXATION = 0.7
"""Share of the change of the deflection that is taken when the first did not settle."""

SUFFICIENT = 1e-4
"""Share of the predicted fall of energy that a step must reach (Armijo)."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What `descend` reached.

    Attributes
    ----------
    approach
        Approach d [m] of each contact, zero where it is open.
    wanted
        z - s - u [m]: the approach where the contact is closed, minus the gap where it is open.
    laws
        Laws at the approach.
    shift
        Height [m] gained by deflection that belongs to this point.
    residual
        sum |r_i| k_i over sum F_i, an upper estimate of the relative error of the load.
    steps, products
        Newton steps, and applications of the interaction in all.
    reason
        "" if converged.
    """

    approach: NDArray[np.float64]
    wanted: NDArray[np.float64]
    laws: Evaluated
    shift: NDArray[np.float64]
    residual: float
    steps: int
    products: int
    reason: str


def descend(
    problem: Problem,
    separation: float,
    start: NDArray[np.float64],
    *,
    shift: NDArray[np.float64] | float = 0.0,
    tolerance: float,
) -> Solution:
    """Minimize the energy over non-negative forces.

    Parameters
    ----------
    problem
        Contacts.
    separation
        Separation s [m].
    start
        Approaches to start from [m], shape (n,).
    shift
        Deflection to start from [m], shape (n,).
    tolerance
        Bound on `Solution.residual`.

    Notes
    -----
    Newton steps on the closed contacts, and on the open ones that would overlap. The matrix is
    positive definite at every point (`Tangent`), so each step descends; it is taken in the
    approach, cut back to non-negative values, and shortened until the energy falls by a fixed share
    of its slope (Armijo). The energy falls at every step and is bounded below.

    The deflection is held while a step is taken. A point that satisfies the rest gets the
    deflection of its own forces, and is final if its residual is small with that one too.
    """
    shift = np.broadcast_to(np.asarray(shift, float), start.shape)
    state = State.at(problem, np.maximum(start, 0.0))
    products, current, refreshed, reason = 1, not problem.deflects, 0, ""
    for step in range(MAX_STEPS + 1):
        residual = _Residual(problem, state, problem.height - separation + shift)
        if residual.relative <= tolerance and not current:
            fresh = deflection(problem.laws, problem.plan, state)
            products, current, refreshed = products + 2, True, refreshed + 1
            last, shift = shift, fresh
            residual = _Residual(problem, state, problem.height - separation + shift)
            if residual.relative > tolerance and refreshed > 1:
                shift = last + RELAXATION * (fresh - last)
                residual = _Residual(problem, state, problem.height - separation + shift)
        if residual.relative <= tolerance and current:
            break
        if step == MAX_STEPS:
            reason = f"{MAX_STEPS} Newton steps left a residual of {residual.relative:.1e}"
            break
        tangent = Tangent(problem.plan, residual.active, residual.stiffness, residual.extra)
        force, count = conjugate_gradients(
            tangent,
            residual.error[residual.active],
            tolerance=_forcing(residual.relative, tolerance),
        )
        change = np.zeros(len(start))
        change[residual.active] = force * tangent.compliance
        found, tried = _line_search(problem, state, residual, change)
        products += count + tried
        if found is None:
            reason = f"no step lowers the energy, residual {residual.relative:.1e}"
            break
        state, current = found, not problem.deflects
    return Solution(
        state.approach,
        residual.wanted,
        state.laws,
        np.asarray(shift),
        residual.relative,
        step,
        products,
        reason,
    )


def _forcing(residual: float, tolerance: float) -> float:
    """Relative accuracy of the linear solve: no better than the step deserves."""
    return min(0.15, max(0.02, 0.5 * tolerance / residual))


class _Residual:
    """How far a state is from balance, and the tangent data of its contacts.

    A contact about to close has no stiffness yet: it gets that at half the approach it wants, and
    counts with its force there. The extra compliance is what the growth of a contact's own
    footprint in the field of the others adds to its tangent, dv/dF dN/dm, with
    dv/dF = 5/3 (v - m)/F as for Hertz; only its positive part is kept, which leaves the matrix
    positive definite.
    """

    def __init__(self, problem: Problem, state: State, gap: NDArray[np.float64]) -> None:
        self.gap = gap
        self.wanted = gap - state.displacement
        self.error = self.wanted - state.approach
        closed = state.approach > 0
        problem.laws.expect(self.wanted)
        self.active = closed | ((self.wanted > 0) & problem.laws.usable)
        stiffness, growth, force = state.laws.stiffness, state.laws.growth, state.laws.force
        load = float(force.sum())
        error = float(np.abs(self.error * stiffness).sum())
        fresh = np.flatnonzero(self.active & ~closed)
        if fresh.size:
            law = problem.laws.rows(fresh)(0.5 * self.wanted[fresh])
            stiffness, growth, force = stiffness.copy(), growth.copy(), force.copy()
            stiffness[fresh], growth[fresh], force[fresh] = law.stiffness, law.growth, law.force
            error += float(law.force.sum())
        self.relative = error / load if load > 0 else math.inf if error > 0 else 0.0
        pull = np.maximum(growth * state.slope, 0.0)
        self.stiffness = stiffness
        self.extra = np.divide(5 / 3 * pull, force, out=np.zeros(len(force)), where=force > 0)


def _line_search(
    problem: Problem, state: State, residual: _Residual, change: NDArray[np.float64]
) -> tuple[State | None, int]:
    """First point along the cut-back step at which the energy has fallen enough."""
    gap = residual.gap
    before = state.energy(gap)
    upper = state.approach + np.maximum(2 * state.approach, np.abs(residual.error))
    # a contact that overlaps still keeps a tenth of its approach; one that does not may open
    lower = np.where(residual.wanted > 0, 0.1 * state.approach, 0.0)
    noise = 1e-12 * float(np.abs(before).sum())
    length = 1.0
    for tried in range(1, MAX_CUTS + 1):
        trial = State.at(problem, np.clip(state.approach + length * change, lower, upper))
        slope = -float(residual.error @ (trial.laws.force - state.laws.force))
        fall = float((trial.energy(gap) - before).sum())
        if slope < noise and fall <= SUFFICIENT * slope + noise:
            return trial, tried
        length *= 0.5
    return None, MAX_CUTS


def conjugate_gradients(
    matrix: Tangent, right: NDArray[np.float64], *, tolerance: float, limit: int = 200
) -> tuple[NDArray[np.float64], int]:
    """Solve `matrix` x = `right`, preconditioned by the contacts' own stiffness.

    Returns the solution and the number of products; the preconditioned residual has fallen by
    `tolerance`, or `limit` products were spent. Any iterate is a direction of descent.
    """
    stiffness = 1 / matrix.compliance
    solution = np.zeros(len(right))
    residual = right.copy()
    direction = stiffness * residual
    product = _kernels.dot(residual, direction)
    goal = tolerance**2 * product
    for count in range(1, limit + 1):
        image = matrix(direction)
        length = product / _kernels.dot(direction, image)
        last = product
        product = _kernels.advance(length, stiffness, direction, image, solution, residual)
        if product <= goal:
            return solution, count
        _kernels.redirect(product / last, stiffness, residual, direction)
    return solution, limit
