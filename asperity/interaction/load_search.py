"""The state of a population at a mean pressure."""

from __future__ import annotations

import math

import numpy as np

from asperity.interaction.newton.laws import BLOCK

from .contact_system import ContactSystem
from .continuation import Continuation
from .coupled_solve import CROWDED, solve_at
from .population_state import PopulationState

__all__ = ["solve_under"]

MAX_SEARCH = 40
"""Separations tried to reach a mean pressure."""

SEARCH_TOLERANCE = 5e-3
"""Tolerance of a solve on the way to a mean pressure."""

NEAR = 1e-3
"""Relative error of the load at which the search ends; where separations do not tell loads so near
each other apart, half the tolerance."""

EXACT = 1e-6
"""Relative error of the load of independent contacts, for which a step costs no field."""


def solve_under(
    last: Continuation, pressure: float, tolerance: float, state: PopulationState | None
) -> PopulationState:
    """State at a mean pressure [Pa], with the separation as one more unknown of the Newton steps;
    by search for the separation where these fail, and of independent contacts.

    Parameters
    ----------
    last
        What is taken over from the last point.
    pressure
        Mean pressure [Pa].
    tolerance
        Bound on the residual.
    state
        The last point itself, if there is one.
    """
    system = last.system
    if pressure == 0:
        return solve_at(last, system.highest, tolerance)
    if not system.interaction:
        return _searched(last, pressure, tolerance, state)
    guess = last.predicted_separation(pressure)
    if guess is None:
        guess = _independent_separation(system, pressure)
    found = solve_at(last, guess, tolerance, pressure)
    if found.converged or found.contact_area > CROWDED * system.nominal_area:
        return found
    searched = _searched(last, pressure, tolerance, state)
    return searched if searched.converged or searched.residual < found.residual else found


def _searched(
    last: Continuation, pressure: float, tolerance: float, state: PopulationState | None
) -> PopulationState:
    """Safeguarded Newton iteration for the logarithm of the mean pressure."""
    system = last.system
    top = system.highest
    low, high, step = -math.inf, top, 0.1 * float(np.ptp(system.height)) or 0.1 * abs(top)
    if state is None or not state.mean_pressure > 0:
        state = solve_at(last, _independent_separation(system, pressure), tolerance)
    bound = NEAR if system.interaction else EXACT
    best, least = state, math.inf
    for _ in range(MAX_SEARCH):
        if not state.converged:
            return state
        error = math.log(state.mean_pressure / pressure) if state.mean_pressure > 0 else -1e3
        if abs(error) < least and state.residual <= tolerance:
            best, least = state, abs(error)
        if least <= bound:
            return best
        here = state.separation
        # a rough pressure near the wanted one does not tell on which side it lies
        if abs(error) > 5 * state.residual:
            low, high = (here, high) if error > 0 else (low, min(high, here))
        guess = high - step
        if state.mean_pressure > 0:
            guess = here + error * state.mean_pressure / state.normal_stiffness
        if not low < guess < high:
            guess = 0.5 * (low + high) if math.isfinite(low) else high - step
        step *= 2
        # far from the pressure a rough solve shows the way
        rough = max(tolerance, SEARCH_TOLERANCE if abs(error) > 10 * SEARCH_TOLERANCE else 0.0)
        state = solve_at(state.continuation, guess, rough)
    if least <= 0.5 * tolerance:  # heights do not tell smaller loads apart
        return best
    return state.refused(
        f"{MAX_SEARCH} separations did not bring the mean pressure to {pressure:g} Pa"
    )


def _independent_separation(system: ContactSystem, pressure: float) -> float:
    """Separation at which independent contacts would carry the pressure, within a few %."""
    summits, height = system.by_height, system.height
    system.laws.rows(summits[:BLOCK]).make()  # one by one they would cost more

    def carried(separation: float) -> float:
        above = system.above(separation)
        laws = system.laws.rows(above)(height[above] - separation)
        return float(laws.force.sum()) / system.nominal_area

    # by numbers of summits: one that stands out must not lead far down among the others
    high, end = system.highest, BLOCK
    width = 0.01 * float(np.ptp(height)) or 0.01 * abs(high)
    low = float(height[summits[min(end, len(summits) - 1)]])
    while carried(low) < pressure:
        high, end, width = low, 2 * end, 2 * width
        low = float(height[summits[end]]) if end < len(summits) else low - width
    for _ in range(8):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if carried(middle) > pressure else (low, middle)
    return 0.5 * (low + high)
