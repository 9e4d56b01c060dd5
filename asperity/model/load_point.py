"""One load point of a surface: its contacts, and the whole surface at their state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.multiscale.surface_point import (
    SurfacePoint,
    closed_areas,
    surface_point,
)

from .corrections import tilted_basins

if TYPE_CHECKING:
    from asperity.interaction.population import PopulationState

    from .decomposition import Decomposition

__all__ = ["LoadPoint", "load_point", "point_at_separation"]

Array = NDArray[np.float64]

MAX_TRIES = 12
"""Separations of the longer waves tried for one of the whole surface."""

LOAD_ERROR = 5e-4
"""Relative error of the load that a separation may leave."""


@dataclass(frozen=True, eq=False)
class LoadPoint:
    """One load point of a surface.

    Attributes
    ----------
    state
        The contacts.
    surface
        Separation, contact area and stiffness of the whole surface.
    closed_area
        Area [m^2] that touches within each contact, shape (n,).
    reason
        Why the point cannot be used, in one sentence; empty if it can.
    """

    state: PopulationState
    surface: SurfacePoint
    closed_area: Array
    reason: str

    @property
    def converged(self) -> bool:
        """Whether the point can be used."""
        return not self.reason


def load_point(decomposition: Decomposition, state: PopulationState) -> LoadPoint:
    """The load point at a state of the contacts of a decomposition."""
    population, law = decomposition.population, decomposition.plan.sub_contact_law
    plan = decomposition.plan
    if plan.law == "auto" and plan.parameters.corrections.tilted_basins:
        fitted = plan.parameters.tilted_basins
        state = tilted_basins.correct(population, decomposition.summits, state, fitted)
    area = state.area if law is None else closed_areas(population, law, state)
    found = decomposition.hm.roughness
    highest = found.highest - found.mean
    surface = surface_point(population, law, state, float(area.sum()), highest)
    reason = state.reason or _refusal(decomposition, state, surface)
    return LoadPoint(state, surface, area, reason)


def point_at_separation(
    decomposition: Decomposition,
    separation: float,
    last: LoadPoint | None,
    tolerance: float,
) -> LoadPoint:
    """The load point at which the flat is at a separation [m] from the whole surface.

    Parameters
    ----------
    decomposition
        The contacts.
    separation
        Separation wanted [m].
    last
        The load point of a near separation, to start from.
    tolerance
        As in `Population.solve`.

    Notes
    -----
    The fine waves lift the flat; the lift changes slowly with the load, so that the secant of the
    separation of the longer waves is near the step itself.
    """
    lift = 0.0 if last is None else last.surface.separation - last.state.separation
    state = None if last is None else last.state
    coarse, before = separation - lift, None
    for left in reversed(range(MAX_TRIES + 1)):
        state = decomposition.population.solve(separation=coarse, state=state, tolerance=tolerance)
        point = load_point(decomposition, state)
        error = separation - point.surface.separation
        close = abs(error) * point.surface.stiffness <= LOAD_ERROR * state.mean_pressure
        if not (left and state.converged) or (error >= 0.0 if state.active == 0 else close):
            break
        step = error
        if before is not None and before[1] != error:
            secant = error * (coarse - before[0]) / (before[1] - error)
            step = error * min(max(secant / error, 0.2), 3.0)
        before = coarse, error
        coarse += step
    return point


def _refusal(decomposition: Decomposition, state: PopulationState, surface: SurfacePoint) -> str:
    """Why a point that was solved lies beyond what separate contacts describe; empty if not."""
    plan = decomposition.plan
    if state.mean_pressure > 0.0 and not surface.contact_area > 0.0:
        return "the contacts carry a load on no area: their laws do not hold there"
    if not plan.interaction:
        return ""
    if surface.separation < 0.0 and plan.boundary == "periodic":
        return "the mean gap would be negative: the contacts overlap too far to be separate"
    closed = np.flatnonzero(state.force > 0)
    share = state.force[closed] / max(state.force.sum(), np.finfo(float).tiny)
    longer = np.exp(-np.sum(share * np.log(decomposition.aspect[closed])))
    if (
        longer * surface.contact_area
        > plan.parameters.limits.long_area * decomposition.population.nominal_area
    ):
        return "the contacts on the ridges of the lay are so long that they overlap end to end"
    return ""
