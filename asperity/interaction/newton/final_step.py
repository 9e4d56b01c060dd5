"""End of a descent: the last Newton step, and the response to a fall of the flat."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import numpy as np

from asperity.interaction.ewald.tangent import Tangent
from surfaces.arrays import Array

from .laws import Evaluated
from .state import CandidateValues, State
from .step import Step, conjugate_gradients

__all__ = ["Solution", "finished", "shared", "tangent_of"]

LINEAR_TOLERANCE = 0.2
"""Relative accuracy of the linear solve of a step."""

RESPONSE_TOLERANCE = 0.1
"""Relative accuracy of the response to a fall of the flat. The error of the sum of the response is
of second order in it."""

MAX_FALLS = 2
"""Number of small falls of the flat that bring a point to its load after the last Newton step."""

LARGEST_STRAY = 0.15
"""Change of the load by the last step, which holds it but for the curvature of the laws, over load
and tolerance, up to which the step is taken. Most change it by less than 0.05. Those of crowded
contacts on ridges (lay of 4:1 to the pixel, 10 % of contact) changed it by 1.4 to 2, and moved the
flat by 1 to 2 % of the load, where the steps before them had moved it by 0.1 %."""


@dataclass(frozen=True, eq=False)
class Solution:
    """Solution that `descent` reached.

    Attributes
    ----------
    separation
        Separation s [m] of the point.
    approach
        Approach d [m] of each contact, zero where it is open.
    interference
        `CandidateValues.interference` [m], shape (n,).
    laws
        Laws at the approach.
    tilt
        Gradients [-] of the displacement, shape (n, 2), for the prediction of the next point.
    residual
        sum |r_i| k_i over sum F_i, and what the last change of the contact shifts can still change
        of the load (`State.lag`): an upper estimate of its relative error. Under a load, that
        before the last step.
    steps
        Number of Newton steps.
    reason
        Why the solve failed; empty if it converged.
    response
        `CandidateValues.response` [-], shape (n,): a guess while `slope` is None.
    slope
        Minus the slope of the load over the separation [N/m]; None if `tangent` has to solve it.
    linearized
        State whose tangent matrix `tangent` solves, if `slope` is None.
    """

    separation: float
    approach: Array
    interference: Array
    laws: Evaluated
    tilt: Array
    residual: float
    steps: int
    reason: str
    response: Array
    slope: float | None = None
    linearized: State | None = None

    @functools.cached_property
    def load(self) -> float:
        """Sum of the forces [N]."""
        return float(self.laws.force.sum())

    @property
    def values(self) -> CandidateValues:
        """Values of the contacts, from which those of the next point are predicted."""
        force = self.laws.force.copy()  # part of a larger array, which could not be freed
        return CandidateValues(self.interference, force, self.tilt, self.response)

    @functools.cached_property
    @np.errstate(all="ignore")  # of a point that is refused
    def tangent(self) -> tuple[float, Array]:
        """Minus the slope of the load over the separation [N/m], and the response [-], (n,)."""
        if self.slope is not None:
            return self.slope, self.response
        state = self.linearized
        assert state is not None
        return tangent_response(tangent_of(state), state, self.response)


def finished(state: State, found: Solution, load: float, tolerance: float) -> Solution:
    """The solution after one more Newton step from `state`, brought to the `load` [N].

    The residual after this step is not computed, which would cost another field. The load that the
    step misses is made up by a fall of the flat, with the response of the same tangent matrix. A
    step along which the load strays by much of the `tolerance` is not taken: where contacts crowd
    the matrix can be nearly singular, and the step leads far from where the laws are linear.
    """
    tangent = tangent_of(state)
    rows, error = tangent.index, state.error[tangent.index]
    move = Step(state, tangent)
    solved = conjugate_gradients(tangent, error, tolerance=LINEAR_TOLERANCE, held=True)
    closed, constant = move.approach(solved.solution), solved.constant
    approach, interference = np.zeros(len(state.approach)), state.interference - constant
    interference[rows] = move.interference_after(constant, solved.solution, error - solved.residual)
    strayed = float(move.laws(closed).force.sum() - state.laws.force.sum()) / load
    if not abs(strayed) <= LARGEST_STRAY * tolerance:
        closed, constant, interference = state.approach[rows], 0.0, state.interference.copy()
    approach[rows] = closed
    separation = found.separation + constant
    slope, response = tangent_response(tangent, state, found.response)
    for _ in range(MAX_FALLS if slope > 0 else 0):
        fall = (load - float(move.laws(approach[rows]).force.sum())) / slope
        touching = approach > 0
        approach[touching] = np.maximum(approach + fall * response, 0.5 * approach)[touching]
        separation, interference = separation - fall, interference + fall
    return replace(
        found,
        separation=separation,
        approach=approach,
        interference=interference,
        laws=state.problem.laws(approach),
        response=response,
        slope=slope,
        linearized=None,
    )


def tangent_response(tangent: Tangent, state: State, guess: Array) -> tuple[float, Array]:
    """Response of the contacts to a fall of the flat, with the tangent matrix of a state.

    Starts from a `guess` of the response. Overwrites the matrix.

    Returns
    -------
    slope, response
        Minus the slope of the load over the separation [N/m], and the approach that each contact
        gains per fall of the flat [-], shape (n,).
    """
    response, rows = np.ones(len(state.error)), tangent.index
    if not len(rows):
        return 0.0, response
    # without the growth of the footprints (`State.extra`), which makes the response too soft
    tangent.stiffen(1 / state.stiffness[rows] - tangent.compliance)
    solved = conjugate_gradients(
        tangent,
        np.ones(len(rows)),
        tolerance=RESPONSE_TOLERANCE,
        start=guess[rows] / tangent.compliance,
    )
    response[rows] = solved.solution * tangent.compliance
    # x.(1 + residual) is stationary in the solution x: its error is of second order
    return float(np.sum(solved.solution * (1 + solved.residual))), response


def tangent_of(state: State) -> Tangent:
    """Tangent matrix of the active contacts."""
    return Tangent(state.problem.coupling, state.active, state.stiffness, state.extra)


def shared(missing: float, response: Array, tangent: Tangent) -> Array:
    """Guess of the forces [N] by which the contacts share a `missing` load [N], from the `response`
    of each to a fall of the flat [-], shape (n,)."""
    slope = response[tangent.index] / tangent.compliance
    total = float(slope.sum()) or 1.0  # zero if no contact has a stiffness
    return missing / total * slope
