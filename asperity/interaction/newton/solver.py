"""Convex coupled solve: which contacts close, and how far, at one separation."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from surfaces.arrays import Array

from .final_step import LINEAR_TOLERANCE, Solution, finished, shared, tangent_of
from .state import CandidateValues, Problem, State
from .step import Step, conjugate_gradients

__all__ = ["descent"]

MAX_NEWTON_STEPS = 60
"""Newton steps before a solve is given up and begun again from a point nearer the last. Some solves
with elongated footprints need 40."""

MAX_CUTS = 20
"""Halvings of a Newton step in the line search: shorter steps still lower the energy, but settle
nothing. Crowded ridges that stood still halved every step 22 to 27 times; of contacts that settled
in the end, some steps were halved up to 19 times."""

ENERGY_NOISE = 1e-10
"""Change of energy, over the sum of the energies, that is within the error of the pair tables."""

EARLY_RELAXATION, RELAXATION, EARLY_STEPS = 0.8, 0.6, 3
"""Shares of the change of the contact shifts that the first steps take, and the later ones, and how
many are the first. Where forces rise, those of the neighbors fall, so that the full change
overshoots: contacts on one ridge pass their load back and forth. Smaller shares, and those of
Aitken's method down to 0.2, lose more where contacts pull each other along."""

PREDICTED_SHIFT_SHARE = 0.6
"""Share of the last change of the contact shifts that the next prediction starts from: the
extrapolation doubles the differences between points, and with 1 they grew from point to point."""

ARMIJO_SHARE = 1e-4
"""Share of the predicted fall of energy that a step must reach (Armijo 1966)."""

REFINED_RESIDUAL = 0.03
"""Residual above which a step evaluates the laws twice (`Step.refine`)."""

AVERAGING_CONTACTS = 400
"""Number of closed contacts whose errors of both signs average out. The steps of fewer contacts aim
at a residual that is smaller in proportion."""

MISSED_LOAD = 1e-3
"""Relative error of the load above which the last step counts as failed."""

CLOSER = 0.1
"""Factor of the tolerance with which a point is solved again if its last step failed."""

ROUGH_LINEAR_TOLERANCE = 0.3
"""Relative accuracy of the linear solve above `REFINED_RESIDUAL`; half of it in `Step.refine`."""


def descent(
    problem: Problem,
    separation: float,
    start: CandidateValues,
    *,
    tolerance: float,
    load: float | None = None,
) -> Solution:
    """Minimize the energy of the contacts over non-negative forces.

    Laws that are missing are made when their contacts are about to close.

    Parameters
    ----------
    separation
        Separation s [m]; a first guess if there is a `load`.
    start
        Values of the contacts to start from: positive interferences are the first approaches, the
        contact shifts start from the tilts, and the response is the first guess of how contacts
        share a missing load, 1 where it is not positive.
    tolerance
        Bound on `Solution.residual`; under a `load`, half of it bounds the error of the load.
    load
        Sum of the forces [N] to reach, positive; None: the separation is given.

    Notes
    -----
    The energy is that of `State`. Newton steps go over the closed contacts, and over the open ones
    that would overlap. The matrix is positive definite at every point (`Tangent`), so each step
    descends. A step is taken in the approach, cut back to non-negative values, and halved until
    the energy falls by a fixed share of its slope (Armijo). At a given separation the energy falls
    at every step and is bounded below. Under a given load the separation is one more unknown of
    each step, the multiplier of sum F = load; the energy has to fall at the new separation.

    The contact shifts are held during a step, and follow one step behind the forces. The solve ends
    if the residual plus the effect of the last change of the shifts (`State.lag`) is small.
    """
    approach, tilt = start.interference, np.ascontiguousarray(start.tilt)
    response = np.where(start.response > 0, start.response, 1.0)
    problem.laws.make(approach > 0)
    for bound in (tolerance, CLOSER * tolerance):
        # a call of its own, so that the arrays of its last step are freed before `finished`
        solution = _newton_steps(problem, separation, approach, tilt, load, response, bound)
        if load is None or solution.reason:
            return solution
        assert solution.linearized is not None
        final = finished(solution.linearized, solution, load, bound)
        missed = abs(final.load / load - 1.0)
        if missed <= MISSED_LOAD:
            return final
        separation, approach, tilt = solution.separation, solution.approach, solution.tilt
    return replace(solution, reason=f"the last step missed the load by {100 * missed:.2g} %")


def _newton_steps(
    problem: Problem,
    separation: float,
    approach: Array,
    tilt: Array,
    load: float | None,
    response: Array,
    tolerance: float,
) -> Solution:
    """`descent` without the last step under a load (`finished`); arguments as there."""
    state = State(problem, np.maximum(approach, 0.0), tilt)
    reason, held = "", None
    for step in range(MAX_NEWTON_STEPS + 1):
        state.balance(separation, load is not None)
        separation = state.separation
        missing = 0.0 if load is None else load - float(state.laws.force.sum())
        error, wrong = state.relative + state.lag, abs(missing) / (load or 1.0)
        closed = int(np.count_nonzero(state.approach))
        few = min(1.0, closed / AVERAGING_CONTACTS)
        if error <= few * tolerance and wrong <= 0.5 * tolerance:
            break
        if load is not None and not state.active.any():
            reason = "no contact is left to carry the load"
            break
        if step == MAX_NEWTON_STEPS:
            if error > tolerance or wrong > 0.5 * tolerance:
                reason = f"{MAX_NEWTON_STEPS} Newton steps left a residual of {error:.1e}"
            break
        share = EARLY_RELAXATION if step < EARLY_STEPS else RELAXATION
        held = state.risen if held is None else held + share * (state.risen - held)
        tilt = tilt + share * (state.field.tilt - tilt)
        state.raised(held - state.risen)
        tangent = tangent_of(state)
        solved = conjugate_gradients(
            tangent,
            state.error[state.active],
            tolerance=_forcing(state.relative, tolerance),
            start=None if load is None else shared(missing, response, tangent),
            held=load is not None,
        )
        if not math.isfinite(solved.constant):
            reason = f"the step from a residual of {error:.1e} is not finite"
            break
        separation += solved.constant
        state.raised(-solved.constant)
        move, found = Step(state, tangent), None
        if state.relative > REFINED_RESIDUAL:
            refined, change, constant = move.refine(
                solved.solution, tolerance=0.5 * ROUGH_LINEAR_TOLERANCE, load=load
            )
            state.raised(-constant)
            found = _taken(state, refined, change, tilt)
            state.raised(0.0 if found else constant)
            separation += constant if found else 0.0
            del refined, change
        if not found:
            found = _line_search(state, move, solved.solution, tilt)
        if not found:
            reason = f"no step lowers the energy, residual {state.relative:.1e}"
            break
        state = found
        del tangent, solved, move, found  # before the next ones are made
    return Solution(
        separation=separation,
        approach=state.approach,
        interference=state.interference,
        laws=state.laws,
        tilt=tilt + PREDICTED_SHIFT_SHARE * (state.field.tilt - tilt),
        residual=error,
        steps=step,
        reason=reason,
        response=response,
        linearized=state,
    )


def _forcing(residual: float, tolerance: float) -> float:
    """Relative accuracy of the linear solve of a step, looser where the residual is large (inexact
    Newton method, Eisenstat & Walker 1996)."""
    if not 0.0 < residual < REFINED_RESIDUAL:
        return ROUGH_LINEAR_TOLERANCE
    return min(0.5 * LINEAR_TOLERANCE, max(0.02, 0.5 * tolerance / residual))


def _line_search(state: State, move: Step, change: Array, tilt: Array) -> State | None:
    """First state along the step at which the energy has fallen enough; None if there is none."""
    for _ in range(MAX_CUTS):
        found = _taken(state, move, change, tilt)
        if found:
            return found
        change = 0.5 * change
    return None


def _taken(state: State, move: Step, change: Array, tilt: Array) -> State | None:
    """The state after a change of the forces [N], None if its energy has not fallen enough."""
    approach = np.zeros(len(state.approach))
    approach[move.rows] = move.approach(change)
    trial = State(state.problem, approach, tilt)
    fall, slope, scale = state.energy_change(trial)
    noise = ENERGY_NOISE * scale
    return trial if slope < noise and fall <= ARMIJO_SHARE * slope + noise else None
