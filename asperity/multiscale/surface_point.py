"""What the fine waves of a surface make of a load point of its contacts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from asperity.interaction.population import Population, PopulationState
    from asperity.model.decomposition import Asperities
    from asperity.model.plan import Plan

    from .sub_contact_law import FineScales

__all__ = [
    "FinePoint",
    "at_separation",
    "closed_area",
    "fine_point",
    "without_gap",
]

STEP = 0.02
"""Change of the load, relative, over which energies are compared."""

MAX_TRIES = 12
"""Separations of the longer waves tried for one of the whole surface."""

CLOSE = 5e-4
"""Relative error of the load that a separation may leave."""


@dataclass(frozen=True)
class FinePoint:
    """A load point of the whole surface.

    Attributes
    ----------
    separation
        Distance of the flat from the mean plane [m].
    contact_area
        Contact area [m^2].
    stiffness
        Minus the slope of mean pressure over separation [Pa/m].
    """

    separation: float
    contact_area: float
    stiffness: float

    @classmethod
    def plain(cls, state: PopulationState) -> FinePoint:
        """The point of a surface all of whose waves are in its contacts."""
        return cls(state.separation, state.contact_area, state.normal_stiffness)


def fine_point(
    population: Population, fine: FineScales, state: PopulationState, highest: float
) -> FinePoint:
    """The point of the whole surface that belongs to a state of its contacts.

    Parameters
    ----------
    population, state
        Contacts of the longer waves.
    fine
        Law of the fine waves.
    highest
        Highest point of the whole surface above its mean plane [m]: the flat stands no higher.

    Notes
    -----
    The lift d(sum Phi)/dF is taken along the answer of all contacts to a small fall of the flat
    (the tangent of the coupled problem), by central differences.
    """
    closed = np.flatnonzero(state.force > 0)
    if not closed.size:
        top = float(population.height[population.falling[0]])
        return FinePoint(max(state.separation, highest + state.separation - top), 0.0, 0.0)
    nominal, law = population.nominal_area, population.laws.rows(closed)
    area = float(closed_area(population, fine, state).sum())
    share = 0.5 * (state.contact_area + area) / nominal
    stiffness, gained = state.normal_stiffness, state.response[closed]
    if not stiffness > 0.0:  # a failed solve, marked as such
        return FinePoint(state.separation, area, stiffness)
    fall = STEP * state.mean_pressure / stiffness

    def energy(step: float) -> tuple[float, float]:
        here = law(np.maximum(state.approach[closed] + step * gained, 0.0))
        kept = here.force > 0
        force, width = here.force[kept], here.area[kept]
        stored = fine.stored(force / width, share)
        return float(np.sum(width * stored)), float(force.sum())

    (low, less), (middle, load), (high, more) = (energy(step) for step in (-fall, 0.0, fall))
    factor = fine.lift(share)
    lift = factor * (high - low) / (more - less)
    change = factor * ((high - middle) / (more - load) - (middle - low) / (load - less))
    compliance = 1.0 / stiffness - change / (0.5 * (more - less)) * nominal
    return FinePoint(min(state.separation + lift, highest), area, 1.0 / compliance)


def closed_area(
    population: Population, fine: FineScales, state: PopulationState
) -> NDArray[np.float64]:
    """Area [m^2] of each contact that the fine waves leave closed, shape (n,)."""
    closed, nominal = np.flatnonzero(state.force > 0), population.nominal_area
    area = np.zeros(len(state.force))
    whole = state.area[closed]
    pressure = state.force[closed] / whole
    share = state.contact_area / nominal
    for _ in range(2):
        area[closed] = whole * fine.remaining(pressure, share, whole)
        share = 0.5 * (state.contact_area + float(area.sum())) / nominal
    return area


def at_separation(
    bodies: Asperities,
    separation: float,
    lift: float,
    state: PopulationState | None,
    tolerance: float,
) -> PopulationState:
    """State of the contacts at which the flat is at a separation [m] from the whole surface.

    Parameters
    ----------
    bodies
        The surface taken apart.
    separation
        Separation wanted [m].
    lift
        Separation of the whole surface less that of the longer waves [m] to start from.
    state
        A state at a near separation, to start from.
    tolerance
        As in `Population.solve`.
    """
    place, last = separation - lift, None
    state = bodies.population.solve(separation=place, state=state, tolerance=tolerance)
    for _ in range(MAX_TRIES):
        found = bodies.point(state)
        error = separation - found.separation
        close = abs(error) * found.stiffness <= CLOSE * state.mean_pressure
        if not state.converged or (error >= 0.0 if state.active == 0 else close):
            break
        step = error
        if last is not None and last[1] != error:
            # the lift changes slowly: the secant is near the step itself
            secant = error * (place - last[0]) / (last[1] - error)
            step = error * min(max(secant / error, 0.2), 3.0)
        last = place, error
        place += step
        state = bodies.population.solve(separation=place, state=state, tolerance=tolerance)
    return state


def without_gap(plan: Plan, state: PopulationState, place: FinePoint) -> PopulationState:
    """The state, refused where the mean gap of a periodic surface would be negative."""
    if place.separation >= 0.0 or plan.boundary == "free" or not plan.interaction:
        return state
    reason = "the mean gap would be negative: the contacts overlap too far to be separate"
    return replace(state, converged=False, reason=state.reason or reason)
