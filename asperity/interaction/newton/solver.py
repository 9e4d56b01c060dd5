"""Convex coupled solve: which contacts close, and how far, at one separation."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .final_step import LINEAR_TOLERANCE, Solution, finished, shared, tangent_of
from .state import Problem, State
from .step import Step, conjugate_gradients

__all__ = ["descent"]

MAX_NEWTON_STEPS = 60
MAX_LOADED_STEPS = 30
"""Newton steps under a load before its separation is searched for instead."""

MAX_LONG_STEPS = 24
"""Newton steps with elongated footprints before round ones are taken instead: long ones can overlap
so far that their approximate sum has no solution, or several."""

MAX_CUTS = 20
"""Times that a step is halved: shorter ones still lower the energy, but settle nothing. Of crowded
ridges that stood still, every step took 22 to 27; of others that settled, some took up to 19."""

ENERGY_NOISE = 1e-10
"""Share of the energies below which a change of energy is not known: pairs are tabulated."""

EARLY_RELAXATION = 0.8
"""Share of the change of the contact shifts that an early step takes: more force here means less
there, so that the full change overshoots."""

PREDICTED_SHIFT_SHARE = 0.6
"""Share of the change of the contact shifts that a point leaves for the next prediction: what is
extrapolated doubles the differences that points leave, and overshoots grew from point to point."""

FIXED_RELAXATION_STEPS = 3
"""Newton steps from which on the share is taken from how the last change went."""

RELAXATION_BOUNDS = (0.2, 1.0)
"""Least and largest share."""

ARMIJO_SHARE = 1e-4
"""Share of the predicted fall of energy that a step must reach (Armijo)."""

REFINED_RESIDUAL = 0.03
"""Residual above which the laws are taken anew within a step."""

AVERAGING_CONTACTS = 400
"""Closed contacts from which on the errors of both signs average out: under a load, the residual of
fewer is held to a bound smaller in proportion."""

MISSED_LOAD = 1e-3
"""Relative error of the load after the last step, beyond which it went astray."""

CLOSER = 0.1
"""Tolerance with which a last step that went astray is tried again, over that asked for."""

ROUGH_LINEAR_TOLERANCE = 0.3
"""Relative accuracy of the linear solve of such a step; half of it after the laws are renewed."""

Array = NDArray[np.float64]


def descent(
    problem: Problem,
    separation: float,
    start: Array,
    *,
    tolerance: float,
    tilt: Array | None = None,
    load: float | None = None,
    compliance: Array | None = None,
) -> Generator[NDArray[np.int64], None, Solution]:
    """Minimize the energy over non-negative forces.

    Yields the contacts whose laws it lacks, which are to be made before it goes on, and returns the
    solution.

    It starts from approaches [m], shape (n,), whose laws are made where they are positive, and from
    the gradients [-] `tilt` of the contact shifts, shape (n, 2), none if None. At a separation s
    [m] the tolerance bounds `Solution.residual`; if the sum of the forces is to reach a `load` [N],
    positive, the separation is a first guess, and half of the tolerance bounds the relative error
    of the load. `compliance` is how much of a small fall of the plane each contact takes up as
    approach [-], shape (n,), the first guess of how a missing load is shared; all of it if None.

    Notes
    -----
    Newton steps on the closed contacts, and on the open ones that would overlap. The matrix is
    positive definite at every point (`Tangent`), so each step descends; it is taken in the
    approach, cut back to non-negative values, and shortened until the energy falls by a fixed share
    of its slope (Armijo). At a given separation the energy falls at every step and is bounded
    below. Under a given load the separation is one more unknown of each step, the multiplier of
    sum F = load, and the step has to lower the energy at its own new separation.

    The contact shifts are held while a step is taken, and follow one step behind the forces.
    A point is final if its residual is small together with what the last change of the shifts can
    still do to it (`State.lag`).
    """
    tilt = np.zeros((len(start), 2)) if tilt is None else np.ascontiguousarray(tilt)
    if compliance is None:
        compliance = np.ones(len(start))
    for bound in (tolerance, CLOSER * tolerance):
        # what the steps held is gone before the last one
        solution = yield from _newton_steps(
            problem, separation, start, tilt, load, compliance, bound
        )
        if load is None or solution.reason:
            return solution
        assert solution.linearized is not None
        final = finished(solution.linearized, solution, load)
        missed = abs(final.load / load - 1.0)
        if missed <= MISSED_LOAD:
            return final
        separation, start, tilt = solution.separation, solution.approach, solution.tilt
    return replace(solution, reason=f"the last step missed the load by {100 * missed:.2g} %")


def _newton_steps(
    problem: Problem,
    separation: float,
    start: Array,
    tilt: Array,
    load: float | None,
    compliance: Array,
    tolerance: float,
) -> Generator[NDArray[np.int64], None, Solution]:
    """`descent` up to its last step."""
    state = State(problem, np.maximum(start, 0.0), tilt)
    limit = MAX_NEWTON_STEPS if load is None else MAX_LOADED_STEPS
    limit = limit if problem.elongation is None else MAX_LONG_STEPS
    products, reason, held, share = 1, "", None, EARLY_RELAXATION
    last = np.zeros(len(start))
    for step in range(limit + 1):
        state.balance(separation, load is not None)
        lacking = problem.laws.lacking(state.wanted)
        if lacking.size:
            yield lacking
        state.linearize()
        separation = state.separation
        missing = 0.0 if load is None else load - float(state.laws.force.sum())
        error, wrong = state.relative + state.lag, abs(missing) / (load or 1.0)
        closed = int(np.count_nonzero(state.approach))
        few = 1.0 if load is None else min(1.0, closed / AVERAGING_CONTACTS)
        if error <= few * tolerance and wrong <= 0.5 * tolerance:
            break
        if load is not None and not state.active.any():
            reason = "no contact is left to carry the load"
            break
        if step == limit:
            if error > tolerance or wrong > 0.5 * tolerance:
                reason = f"{limit} Newton steps left a residual of {error:.1e}"
            break
        behind = state.risen - (state.risen if held is None else held)
        if step >= FIXED_RELAXATION_STEPS:
            share = _relaxed(share, last, behind, state.laws.stiffness)
        held = state.risen if held is None else held + share * behind
        tilt = tilt + (share if step >= FIXED_RELAXATION_STEPS else 1.0) * (state.field.tilt - tilt)
        last = behind
        state.raised(held - state.risen)
        tangent = tangent_of(state)
        solved = conjugate_gradients(
            tangent,
            state.error[state.active],
            tolerance=_forcing(state.relative, tolerance),
            start=None if load is None else shared(missing, compliance, tangent),
            held=load is not None,
        )
        if not math.isfinite(solved.constant):
            reason = f"the step from a residual of {error:.1e} is not finite"
            break
        separation += solved.constant
        state.raised(-solved.constant)
        move = Step(state, tangent)
        products, found = products + solved.products, None
        if state.relative > REFINED_RESIDUAL:
            refined, change, constant, spent = move.refine(
                solved.solution, tolerance=0.5 * ROUGH_LINEAR_TOLERANCE, load=load
            )
            state.raised(-constant)
            found = _taken(state, refined, change, tilt)
            state.raised(0.0 if found else constant)
            separation += constant if found else 0.0
            products += spent + 1
            del refined, change
        if not found:
            found, tried = _line_search(state, move, solved.solution, tilt)
            products += tried
        if not found:
            reason = f"no step lowers the energy, residual {state.relative:.1e}"
            break
        state = found
        del tangent, solved, move, found  # before the next ones are made
    return Solution(
        separation=separation,
        approach=state.approach,
        wanted=state.wanted,
        laws=state.laws,
        tilt=tilt + PREDICTED_SHIFT_SHARE * (state.field.tilt - tilt),
        residual=error,
        steps=step,
        products=products,
        reason=reason,
        shares=compliance,
        linearized=state,
    )


def _relaxed(
    share: float,
    last: Array,
    behind: Array,
    stiffness: Array,
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
    return min(max(found, RELAXATION_BOUNDS[0]), RELAXATION_BOUNDS[1])


def _forcing(residual: float, tolerance: float) -> float:
    """Relative accuracy of the linear solve: no better than the step deserves."""
    if not 0.0 < residual < REFINED_RESIDUAL:
        return ROUGH_LINEAR_TOLERANCE
    return min(0.5 * LINEAR_TOLERANCE, max(0.02, 0.5 * tolerance / residual))


def _line_search(state: State, move: Step, change: Array, tilt: Array) -> tuple[State | None, int]:
    """First point along the step at which the energy has fallen enough, and how many were tried."""
    for tried in range(1, MAX_CUTS + 1):
        found = _taken(state, move, change, tilt)
        if found:
            return found, tried
        change = 0.5 * change
    return None, MAX_CUTS


def _taken(state: State, move: Step, change: Array, tilt: Array) -> State | None:
    """The point after a change of the forces, if the energy has fallen enough there."""
    approach = np.zeros(len(state.approach))
    approach[move.rows] = move.approach(change)
    trial = State(state.problem, approach, tilt)
    fall, slope, scale = state.energy_change(trial)
    noise = ENERGY_NOISE * scale
    return trial if slope < noise and fall <= ARMIJO_SHARE * slope + noise else None
