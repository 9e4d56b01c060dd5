"""Convex coupled solve: which contacts close, and how far, at one separation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _state_kernels, _vectors
from .laws import Evaluated
from .state import Problem, State
from .tangent import Tangent

__all__ = ["Solution", "conjugate_gradients", "descend"]

MAX_STEPS = 60
MAX_LOADED_STEPS = 30
"""Newton steps under a load before its separation is searched for instead."""

MAX_LONG_STEPS = 16
"""Newton steps with elongated footprints before round ones are taken instead."""

MAX_CUTS = 30
NOISE = 1e-10
"""Share of the energies below which a change of energy is not known: pairs are tabulated."""

RELAXATION = 0.8
"""Share of the change of the deflection that an early step takes: more force here means less there,
so that the full change overshoots."""

EARLY = 3
"""Newton steps from which on the share is taken from how the last change went."""

SHARES = (0.2, 1.0)
"""Least and largest share."""

SUFFICIENT = 1e-4
"""Share of the predicted fall of energy that a step must reach (Armijo)."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What `descend` reached.

    Attributes
    ----------
    separation
        Separation s [m] of the point.
    approach
        Approach d [m] of each contact, zero where it is open.
    wanted
        z - s - u [m]: the approach where the contact is closed, minus the gap where it is open.
    laws
        Laws at the approach.
    tilt
        Gradients [-] of the displacement at this point, shape (n, 2).
    residual
        sum |r_i| k_i over sum F_i, an upper estimate of the relative error of the load.
    steps, products
        Newton steps, and applications of the interaction in all.
    reason
        "" if converged.
    """

    separation: float
    approach: NDArray[np.float64]
    wanted: NDArray[np.float64]
    laws: Evaluated
    tilt: NDArray[np.float64]
    residual: float
    steps: int
    products: int
    reason: str


def descend(
    problem: Problem,
    separation: float,
    start: NDArray[np.float64],
    *,
    tolerance: float,
    tilt: NDArray[np.float64] | None = None,
    load: float | None = None,
    compliance: NDArray[np.float64] | float = 1.0,
) -> Solution:
    """Minimize the energy over non-negative forces.

    Parameters
    ----------
    problem
        Contacts.
    separation
        Separation s [m]; the first guess of it if a load is given.
    start
        Approaches to start from [m], shape (n,).
    tolerance
        Bound on `Solution.residual`; half of it bounds the relative error of the load.
    tilt
        Gradients [-] to start the deflection from, shape (n, 2); none if None.
    load
        Sum of the forces [N] to reach, positive; at the separation given if None.
    compliance
        How much of a small fall of the plane each contact takes up as approach [-], shape (n,): the
        first guess of how a missing load is shared.

    Notes
    -----
    Newton steps on the closed contacts, and on the open ones that would overlap. The matrix is
    positive definite at every point (`Tangent`), so each step descends; it is taken in the
    approach, cut back to non-negative values, and shortened until the energy falls by a fixed share
    of its slope (Armijo). At a given separation the energy falls at every step and is bounded
    below. Under a given load the separation is one more unknown of each step, the multiplier of
    sum F = load, and the step has to lower the energy at its own new separation.

    The deflection is held while a step is taken, and the shifts follow one step behind the forces.
    A point is final if its residual is small together with what the last change of the shifts can
    still do to it (`State.lag`).
    """
    if tilt is None:
        tilt = np.zeros((len(start), 2))
    state = State.at(problem, np.maximum(start, 0.0), tilt)
    limit = MAX_STEPS if load is None else MAX_LOADED_STEPS
    limit = limit if problem.elongation is None else MAX_LONG_STEPS
    products, reason, held, share = 1, "", None, RELAXATION
    last = np.zeros(len(start))
    for step in range(limit + 1):
        if load is not None:
            separation = _balanced(problem, state, separation)
        residual = _Residual(problem, state, problem.height - separation + state.shift)
        missing = 0.0 if load is None else load - float(state.laws.force.sum())
        error, wrong = residual.relative + state.lag, abs(missing) / (load or 1.0)
        if error <= tolerance and wrong <= 0.5 * tolerance:
            break
        if step == limit:
            reason = f"{limit} Newton steps left a residual of {error:.1e}"
            break
        behind = state.risen - (state.risen if held is None else held)
        if step >= EARLY:
            share = _relaxed(share, last, behind, state.laws.stiffness)
        held = state.risen if held is None else held + share * behind
        tilt = tilt + (share if step >= EARLY else 1.0) * (state.field.tilt - tilt)
        last = behind
        residual.raised(held - state.risen)
        tangent = Tangent(
            problem.plan, residual.active, residual.stiffness, residual.extra, problem.form
        )
        first = None
        if load is not None:
            shares = np.broadcast_to(compliance, start.shape)[residual.active] / tangent.compliance
            first = missing / float(shares.sum()) * shares
        solved = conjugate_gradients(
            tangent,
            residual.error[residual.active],
            tolerance=_forcing(residual.relative, tolerance),
            start=first,
            held=load is not None,
        )
        change = np.zeros(len(start))
        change[residual.active] = solved.solution
        separation += solved.constant
        residual.raised(-solved.constant)
        found, tried = _line_search(problem, state, residual, change, tilt)
        products += solved.products + tried
        if found is None:
            reason = f"no step lowers the energy, residual {residual.relative:.1e}"
            break
        state = found
    return Solution(
        separation,
        state.approach,
        residual.wanted,
        state.laws,
        state.field.tilt,
        error,
        step,
        products,
        reason,
    )


def _relaxed(
    share: float,
    last: NDArray[np.float64],
    behind: NDArray[np.float64],
    stiffness: NDArray[np.float64],
) -> float:
    """Share that would have removed the most of the last difference (Aitken), within bounds.

    Contacts on one ridge can pass their load back and forth, or pull each other along: no fixed
    share settles both.
    """
    change = behind - last
    whole = float(np.sum(stiffness * change * change))
    if not whole:
        return share
    found = -share * float(np.sum(stiffness * last * change)) / whole
    return min(max(found, SHARES[0]), SHARES[1])


def _balanced(problem: Problem, state: State, separation: float) -> float:
    """The separation at which the errors of the closed contacts, times stiffness, cancel."""
    error = problem.height - separation + state.shift - state.displacement - state.approach
    return separation + float(_state_kernels.balance(state.laws.stiffness, error))


def _forcing(residual: float, tolerance: float) -> float:
    """Relative accuracy of the linear solve: no better than the step deserves."""
    return min(0.15, max(0.02, 0.5 * tolerance / residual)) if residual > 0.0 else 0.15


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
        error = float(_state_kernels.size(stiffness, self.error))
        fresh = np.flatnonzero(self.active & ~closed)
        if fresh.size:
            law = problem.laws.rows(fresh)(0.5 * self.wanted[fresh])
            stiffness, growth, force = stiffness.copy(), growth.copy(), force.copy()
            stiffness[fresh], growth[fresh], force[fresh] = law.stiffness, law.growth, law.force
            error += float(law.force.sum())
        self.relative = error / load if load > 0 else math.inf if error > 0 else 0.0
        pull = np.maximum(growth * state.field.slope, 0.0)
        self.stiffness, self.force = stiffness, force
        self.base = np.where(closed, state.approach, 0.5 * self.wanted)
        self.extra = np.divide(5 / 3 * pull, force, out=np.zeros(len(force)), where=force > 0)

    def raised(self, change: NDArray[np.float64] | float) -> None:
        """Take the same state with all summits higher by `change` [m]."""
        self.gap, self.wanted = self.gap + change, self.wanted + change
        self.error = self.error + change


def _line_search(
    problem: Problem,
    state: State,
    residual: _Residual,
    change: NDArray[np.float64],
    tilt: NDArray[np.float64],
) -> tuple[State | None, int]:
    """First point along the cut-back step at which the energy has fallen enough.

    The approaches of the new forces are those of the power law that a contact follows at its
    present force and stiffness.
    """
    upper = state.approach + np.maximum(2 * state.approach, np.abs(residual.error))
    # a contact that overlaps still keeps a tenth of its approach; one that does not may open
    lower = np.where(residual.wanted > 0, 0.1 * state.approach, 0.0)
    moved = np.flatnonzero(change)
    base, force = residual.base[moved], residual.force[moved]
    held = state.laws.force[moved] / force
    exponent = np.minimum(force / (residual.stiffness[moved] * base), 1.0)
    length = 1.0
    for tried in range(1, MAX_CUTS + 1):
        approach = state.approach.copy()
        grown = np.maximum(held + length * change[moved] / force, 0.0)
        approach[moved] = base * grown**exponent
        trial = State.at(problem, np.clip(approach, lower, upper), tilt)
        fall, slope, scale = state.fall(trial, residual.gap, residual.error)
        noise = NOISE * scale
        if slope < noise and fall <= SUFFICIENT * slope + noise:
            return trial, tried
        length *= 0.5
    return None, MAX_CUTS


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
    product, mean = _vectors.weigh(stiffness, residual, held)
    goal = tolerance**2 * product
    if start is not None and start.any():
        solution, count = start.copy(), 1
        image = matrix(start)
        residual -= image
        if held:
            goal = max(goal, tolerance**2 * _vectors.weigh(stiffness, image, held)[0])
        product, mean = _vectors.weigh(stiffness, residual, held)
    direction, last = np.zeros(len(right)), math.inf
    while product > goal and count < limit:
        _vectors.redirect(product / last, stiffness, residual, mean, direction)
        image = matrix(direction)
        curvature = _vectors.dot(direction, image)
        if curvature <= 0.0:
            # pairs of elongated footprints are approximate, and the matrix with them
            solution = solution if solution.any() else direction
            break
        length = product / curvature
        last = product
        _vectors.advance(length, direction, image, solution, residual)
        product, mean = _vectors.weigh(stiffness, residual, held)
        count += 1
    return Solved(solution, residual, mean, count)
