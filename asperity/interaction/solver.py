"""Convex coupled solve: which contacts close, and how far, at one separation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import _kernels
from .laws import Evaluated, Laws
from .operator import Interaction, Tangent

__all__ = ["Problem", "Solution", "conjugate_gradients", "descend"]

MAX_STEPS = 60
MAX_CUTS = 30
SUFFICIENT = 1e-4
"""Share of the predicted fall of energy that a step must reach (Armijo)."""


@dataclass(frozen=True, eq=False)
class Problem:
    """Contacts that may close, their laws and their interaction.

    Attributes
    ----------
    height
        Summit heights z [m], shape (n,).
    laws, plan
        Laws and interaction in the same order.
    """

    height: NDArray[np.float64]
    laws: Laws
    plan: Interaction


@dataclass(eq=False)
class State:
    """A trial point: approaches d >= 0, the laws there, and the field of the forces.

    Notes
    -----
    With the pair energy F_i F_j N(r; m_i, m_j), the energy at separation s is
    E = sum_i [U*_i(F_i) - (z_i - s) F_i] + 1/2 sum_ij F_i F_j N_ij, U* = F d - U, and its gradient
    is dE/dF_i = d_i + u_i - (z_i - s), u_i = v0_i + growth_i v1_i: the growth of the footprint with
    its force is part of the gradient, so that the residual is that of one energy.
    """

    approach: NDArray[np.float64]
    laws: Evaluated
    value: NDArray[np.float64]
    slope: NDArray[np.float64]

    @property
    def displacement(self) -> NDArray[np.float64]:
        """u [m]."""
        return self.value + self.laws.growth * self.slope

    @classmethod
    def at(cls, problem: Problem, approach: NDArray[np.float64]) -> State:
        laws = problem.laws(approach)
        return cls(approach, laws, *problem.plan.field(laws.force, laws.moment))

    def energy(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Energy of each contact [J]; `gap` is z - s."""
        force = self.laws.force
        return force * (self.approach + 0.5 * self.value - gap) - self.laws.energy


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
    residual: float
    steps: int
    products: int
    reason: str


def descend(
    problem: Problem, separation: float, start: NDArray[np.float64], *, tolerance: float
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
    tolerance
        Bound on `Solution.residual`.

    Notes
    -----
    Newton steps on the closed contacts, and on the open ones that would overlap. The matrix is
    positive definite at every point (`Tangent`), so each step descends; it is taken in the
    approach, cut back to non-negative values, and shortened until the energy falls by a fixed share
    of its slope (Armijo). The energy falls at every step and is bounded below.
    """
    gap = problem.height - separation
    state = State.at(problem, np.maximum(start, 0.0))
    products = 1
    for step in range(MAX_STEPS):
        wanted = gap - state.displacement
        closed = state.approach > 0
        active = closed | (wanted > 0)
        residual, stiffness, extra = _residual(problem, state, wanted, closed, active)
        if residual <= tolerance:
            return Solution(state.approach, wanted, state.laws, residual, step, products, "")
        tangent = problem.plan.tangent(active, stiffness, extra)
        force, count = conjugate_gradients(
            tangent, (wanted - state.approach)[active], tolerance=_forcing(residual, tolerance)
        )
        change = np.zeros(len(gap))
        change[active] = force * tangent.compliance
        found, tried = _line_search(problem, state, gap, wanted, change)
        products += count + tried
        if found is None:
            return Solution(
                state.approach,
                wanted,
                state.laws,
                residual,
                step,
                products,
                f"no step lowers the energy, residual {residual:.1e}",
            )
        state = found
    return Solution(
        state.approach,
        gap - state.displacement,
        state.laws,
        residual,
        MAX_STEPS,
        products,
        f"{MAX_STEPS} Newton steps left a residual of {residual:.1e}",
    )


def _forcing(residual: float, tolerance: float) -> float:
    """Relative accuracy of the linear solve: no better than the step deserves."""
    return min(0.15, max(0.02, 0.5 * tolerance / residual))


def _residual(
    problem: Problem,
    state: State,
    wanted: NDArray[np.float64],
    closed: NDArray[np.bool_],
    active: NDArray[np.bool_],
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Relative residual; stiffness and extra compliance of the active contacts.

    A contact about to close has no stiffness yet: it gets that at half the approach it wants, and
    counts with its force there. The extra compliance is what the growth of a contact's own
    footprint in the field of the others adds to its tangent, dv/dF dN/dm, with
    dv/dF = 5/3 (v - m)/F as for Hertz; only its positive part is kept, which leaves the matrix
    positive definite.
    """
    stiffness, growth, force = state.laws.stiffness, state.laws.growth, state.laws.force
    error = float(np.abs(wanted - state.approach)[closed] @ stiffness[closed])
    fresh = np.flatnonzero(active & ~closed)
    if fresh.size:
        law = problem.laws.rows(fresh)(0.5 * wanted[fresh])
        stiffness, growth, force = stiffness.copy(), growth.copy(), force.copy()
        stiffness[fresh], growth[fresh], force[fresh] = law.stiffness, law.growth, law.force
        error += float(law.force.sum())
    load = float(state.laws.force.sum())
    relative = error / load if load > 0 else math.inf if error > 0 else 0.0
    pull = np.maximum(growth * state.slope, 0.0)
    extra = np.divide(5 / 3 * pull, force, out=np.zeros(len(force)), where=force > 0)
    return relative, stiffness, extra


def _line_search(
    problem: Problem,
    state: State,
    gap: NDArray[np.float64],
    wanted: NDArray[np.float64],
    change: NDArray[np.float64],
) -> tuple[State | None, int]:
    """First point along the cut-back step at which the energy has fallen enough."""
    before = state.energy(gap)
    residual = wanted - state.approach
    upper = state.approach + np.maximum(2 * state.approach, np.abs(residual))
    # a contact that overlaps still keeps a tenth of its approach; one that does not may open
    lower = np.where(wanted > 0, 0.1 * state.approach, 0.0)
    noise = 1e-12 * float(np.abs(before).sum())
    length = 1.0
    for tried in range(1, MAX_CUTS + 1):
        trial = State.at(problem, np.clip(state.approach + length * change, lower, upper))
        slope = -float(residual @ (trial.laws.force - state.laws.force))
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
