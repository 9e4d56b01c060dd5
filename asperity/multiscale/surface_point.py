"""Separation, area and stiffness of the whole surface at a state of the contacts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from asperity.interaction.population import Population, PopulationState

    from .sub_contact_law import SubContactLaw

__all__ = ["SurfacePoint", "closed_areas", "surface_point"]

Array = NDArray[np.float64]

STEP = 0.02
"""Change of the load, relative, over which energies are compared."""


@dataclass(frozen=True)
class SurfacePoint:
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


def surface_point(
    population: Population,
    law: SubContactLaw | None,
    state: PopulationState,
    area: float,
    highest: float,
) -> SurfacePoint:
    """The point of the whole surface that belongs to a state of its contacts.

    Parameters
    ----------
    population, state
        Contacts of the longer waves.
    law
        Law of the fine waves; None if all waves are in the contacts.
    area
        Contact area [m^2] that the fine waves leave closed.
    highest
        Highest point of the whole surface above its mean plane [m]: the flat stands no higher.

    Notes
    -----
    The lift d(sum Phi)/dF is taken along the answer of all contacts to a small fall of the flat
    (the tangent of the coupled problem), by central differences.
    """
    if law is None:
        return SurfacePoint(state.separation, state.contact_area, state.normal_stiffness)
    closed = np.flatnonzero(state.force > 0)
    if not closed.size:
        top = population.highest
        return SurfacePoint(max(state.separation, highest + state.separation - top), 0.0, 0.0)
    nominal, contacts = population.nominal_area, population.laws.rows(closed)
    share = 0.5 * (state.contact_area + area) / nominal
    stiffness, gained = state.normal_stiffness, state.response[closed]
    if not stiffness > 0.0:  # a failed solve, marked as such
        return SurfacePoint(state.separation, area, stiffness)
    fall = STEP * state.mean_pressure / stiffness

    def energy(step: float) -> tuple[float, float]:
        here = contacts(np.maximum(state.approach[closed] + step * gained, 0.0))
        kept = here.force > 0
        force, width = here.force[kept], here.area[kept]
        stored = law.stored(force / width, share)
        return float(np.sum(width * stored)), float(force.sum())

    (low, less), (middle, load), (high, more) = (energy(step) for step in (-fall, 0.0, fall))
    factor = law.lift(share)
    lift = factor * (high - low) / (more - less)
    change = factor * ((high - middle) / (more - load) - (middle - low) / (load - less))
    compliance = 1.0 / stiffness - change / (0.5 * (more - less)) * nominal
    return SurfacePoint(min(state.separation + lift, highest), area, 1.0 / compliance)


def closed_areas(population: Population, law: SubContactLaw, state: PopulationState) -> Array:
    """Area [m^2] of each contact that the fine waves leave closed, shape (n,)."""
    closed, nominal = np.flatnonzero(state.force > 0), population.nominal_area
    area = np.zeros(len(state.force))
    whole = state.area[closed]
    pressure = state.force[closed] / whole
    share = state.contact_area / nominal
    for _ in range(2):
        area[closed] = whole * law.remaining(pressure, share, whole)
        share = 0.5 * (state.contact_area + float(area.sum())) / nominal
    return area
