"""The state of a population at one separation, or under a load near it."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from asperity.interaction.newton.final_step import Solution
from asperity.interaction.newton.solver import descent
from asperity.interaction.newton.state import CandidateValues
from asperity.interaction.newton.step import corrected_prediction
from surfaces.arrays import Array, Index

from .candidates import CandidateList
from .population_state import Contacts, Continuation, PopulationState

__all__ = ["Start", "solve_at", "start_of"]


SPARE_CANDIDATES = 1.5
"""Candidates over the summits that can touch now: a list then serves several separations."""

FIELD_GROWTH = 1.1
"""Depth of the field that a list allows for at the next separation, over the last depth."""

SPARE_CANDIDATES_OF_LOAD = 1.05
"""`SPARE_CANDIDATES` of load points: most loads lie too far apart for a list to serve two."""

MAX_LISTS = 8
"""Largest number of new lists at one separation, deeper ones or ones for moved contacts."""

FIRST_TOLERANCE = 0.1
"""Tolerance of the very first solve: its candidates and their centres are guessed."""

LACKING_CANDIDATES = 0.05
"""Overlapping summits that a list may lack after a solve, over closed contacts times tolerance."""

RISE_BY_ROUNDING = 1e-9
"""Largest rise of the flat under more load that counts as rounding, over the fall of the flat since
first touch."""


@np.errstate(all="ignore")  # a step that is not finite is refused with its reason
def solve_at(
    last: Continuation,
    separation: float,
    tolerance: float,
    pressure: float | None = None,
    *,
    settled: bool = False,
) -> PopulationState:
    """State at a separation [m], or at a mean pressure [Pa].

    With a pressure the separation is a first guess. `last` holds the points solved before, from
    which this one is predicted; `tolerance` bounds the residual. With `settled` a state whose
    contacts stand elsewhere than their points after all lists is refused, unless they are crowded.

    Notes
    -----
    The stages are prediction, candidates, Newton steps, state. If the solution shows that summits
    were missing in the list, or that contacts stand elsewhere, a new list is made from the solution
    and solved again.
    """
    system = last.system
    if not system.interaction:
        return _independent(last, separation)
    load = None if pressure is None else pressure * system.nominal_area
    rows, values, growth, spare, rise, candidates = start_of(last, separation, pressure, tolerance)
    field = last.field
    good: tuple[CandidateList, Solution] | None = None
    steps, blind, stands = 0, not last.points, False
    for placed in range(MAX_LISTS + 1):
        if candidates is None:
            candidates = CandidateList.of(
                system,
                rows,
                values,
                field=field,
                separation=separation + rise,
                growth=growth,
                spare=spare,
            )
        problem = candidates.problem
        if rows is not candidates.index:
            values = _along(candidates.index, rows, values, len(system))
            rows = candidates.index
        start = values
        if load is None and placed == 0 and len(last.points) > 1:
            start = corrected_prediction(problem, values, tolerance=tolerance)
        bound = max(tolerance, FIRST_TOLERANCE) if blind else tolerance
        found = descent(problem, separation, start, tolerance=bound, load=load)
        solution = _ordered(last, found, tolerance)
        steps += solution.steps
        field, values = problem.coupling.smooth, solution.values
        separation = solution.separation
        current = candidates
        if solution.reason:
            if good is not None:
                current, solution = good  # the solution before its points were moved
            break
        growth, rise = 1.0, 0.0
        # a missing summit that just touches would carry less than the mean load of a contact
        few = LACKING_CANDIDATES * tolerance * np.count_nonzero(values.interference > 0)
        again = not (candidates.lacks(field, separation, growth, few) or blind)
        candidates = current.recentred(rows, values, tolerance) if again else None
        blind = False
        if candidates is current:
            stands = True
            break
        good = None if candidates is None else (current, solution)
    reason, share = solution.reason, float(solution.laws.area.sum()) / system.nominal_area
    crowded = share > system.parameters.limits.unsettled_area
    if reason and crowded:
        reason = (
            f"contacts fill {100 * share:.0f} % of the nominal area and do not settle ({reason}): "
            "they are too crowded to be separate"
        )
    elif settled and not (reason or stands or crowded):
        reason = f"after {MAX_LISTS} lists the contacts stand elsewhere than their points"
    solution = replace(solution, reason=reason, steps=steps)
    area = current.areas(solution)
    return _state(last.after(solution, current), current.index, area, solution)


class Start(NamedTuple):
    """Start of the solve of a point.

    `values` are predicted, of the summits `rows`; `growth` and `spare` are those of
    `CandidateList.of`, whose separation is to be raised by `rise` [m]. `candidates` is the list of
    the last point if it serves this point too, else None.
    """

    rows: Index
    values: CandidateValues
    growth: float
    spare: float
    rise: float
    candidates: CandidateList | None


def start_of(
    last: Continuation, separation: float, pressure: float | None, tolerance: float
) -> Start:
    """Start of the solve of a point; arguments as in `solve_at`."""
    candidates = last.candidates
    rows, values = last.predicted(separation, pressure)
    growth, spare = FIELD_GROWTH, SPARE_CANDIDATES
    if pressure is not None and last.points and last.points[-1].pressure > 0:
        growth, spare = max(1.0, pressure / last.points[-1].pressure), SPARE_CANDIDATES_OF_LOAD
    rise = last.rise(separation, values)
    if candidates is not None:
        lacks = candidates.lacks(last.field, separation + rise, growth)
        candidates = None if lacks else candidates.recentred(rows, values, tolerance)
    return Start(rows, values, growth, spare, rise, candidates)


def _along(index: Index, rows: Index, values: CandidateValues, count: int) -> CandidateValues:
    """The values of the summits `index`, of `count` in all: the `values` of those among `rows`,
    zero for the others."""
    known = CandidateValues(*(np.zeros((count, *array.shape[1:])) for array in values))
    for array, part in zip(known, values, strict=True):
        array[rows] = part
    return known.rows(index)


def _ordered(last: Continuation, solution: Solution, tolerance: float) -> Solution:
    """The solution, refused if the flat would stand higher than under less load.

    No elastic body does that. Footprints that overlap far can, by passing their load to each other
    until few contacts carry it.
    """
    load = solution.load / last.system.nominal_area
    if solution.reason or not load > 0:
        return solution
    top = last.system.highest
    for separation, pressure in ((top, 0.0), last.heaviest or (top, 0.0)):
        apart = abs(load - pressure) > 2 * tolerance * max(load, pressure)
        over = (solution.separation - separation) * (1 if load > pressure else -1)
        if apart and over > RISE_BY_ROUNDING * (top - separation):
            reason = (
                f"at {load:.3g} Pa the flat would stand higher than under less load: the "
                "contacts overlap too far to be separate"
            )
            return replace(solution, reason=reason)
    return solution


def _independent(last: Continuation, separation: float) -> PopulationState:
    """State of independent contacts at a separation."""
    system = last.system
    approach = np.maximum(system.height - separation, 0.0)
    system.laws.make(approach > 0)
    laws, count = system.laws(approach), len(approach)
    solution = Solution(
        separation=separation,
        approach=approach,
        interference=approach,
        laws=laws,
        tilt=np.zeros((count, 2)),
        residual=0.0,
        steps=0,
        reason="",
        response=np.ones(count),
        slope=float(laws.stiffness.sum()),
    )
    last = replace(last, candidates=None, field=None, solution=solution)
    return _state(last, np.arange(count), laws.area, solution)


def _state(
    continuation: Continuation, rows: Index, area: Array, solution: Solution
) -> PopulationState:
    """The state of a solution, with the contact areas [m^2] of the summits `rows`."""
    system, field = continuation.system, continuation.field
    law, load = solution.laws, solution.load
    lowest = 0.0 if field is None else field.lowest
    filled = float(law.force[system.laws.rows(rows).filled(law)].sum())
    return PopulationState(
        separation=solution.separation,
        mean_pressure=load / system.nominal_area,
        contact_area=float(area.sum()),
        active=int(np.count_nonzero(law.force)),
        filled_share=filled / load if load > 0 else 0.0,
        residual=solution.residual,
        converged=not solution.reason,
        reason=solution.reason,
        iterations=solution.steps,
        lowest_candidate=solution.separation + 1.1 * lowest,
        rows=rows,
        contacts=Contacts(solution.approach, law.force, law.stiffness, area),
        tilt=solution.tilt,
        continuation=continuation,
    )
