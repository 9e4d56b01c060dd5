"""One load point: the state of the contacts, the whole surface at this state, and the spots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.scene import pressure_scale
from asperity.multiscale.sub_contact_law import SurfacePoint, closed_areas, surface_point
from surfaces.arrays import Array, Index
from surfaces.numerics.compiled import compiled
from surfaces.patches import root

from .corrections import tilted_basins

if TYPE_CHECKING:
    from asperity.interaction.population import PopulationState
    from surfaces.peaks.summits import Summits

    from .decomposition import Decomposition

__all__ = [
    "LoadPoint",
    "joined_spots",
    "load_difference",
    "load_point",
    "plastic_share",
    "point_at_separation",
    "spot_count",
    "spot_of_contacts",
]


MAX_TRIES = 12
"""Further loads tried to reach one separation of the whole surface."""

FIRST_LOAD = 1e-3
"""First of these loads, over E* times the rms slope."""

LARGEST_GROWTH = 3.0
"""Largest change of the logarithm of the load between two of them."""

LOAD_ERROR = 5e-4
"""Relative error of the load at which the search for a separation of the whole surface ends."""

END_TO_END = "the contacts on the ridges of the lay are so long that they overlap end to end"
"""Reason for which a load point and all heavier ones are refused."""


@dataclass(frozen=True, eq=False)
class LoadPoint:
    """One load point of a surface.

    Attributes
    ----------
    state
        State of the contacts. Without a sub-contact law they hold all waves of the map, with one
        only the longer waves.
    surface
        Separation, contact area and stiffness of the whole surface.
    closed_area
        Area [m^2] that touches within each contact, shape (n,).
    overlap
        How far the flat passes through the surface beside interacting contacts [-]
        (`Blocks.overlap`).
    reason
        Why the point cannot be used, in one sentence; empty if it can.
    """

    state: PopulationState
    surface: SurfacePoint
    closed_area: Array
    overlap: float
    reason: str

    @property
    def converged(self) -> bool:
        """Whether the point can be used."""
        return not self.reason

    @property
    def end_to_end(self) -> bool:
        """Whether the point is refused for long contacts that overlap end to end. They overlap
        under any heavier load too, so the curve solves none of these: that may take minutes."""
        return self.reason == END_TO_END


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
    overlap = _overlap(decomposition, state) if plan.interaction and state.active else 0.0
    reason = _refusal(decomposition, state, surface, overlap) or state.reason
    return LoadPoint(state, surface, area, overlap, reason)


def point_at_separation(
    decomposition: Decomposition, separation: float, last: LoadPoint | None, tolerance: float
) -> LoadPoint:
    """The load point at which the flat stands at a separation [m] from the whole surface.

    The search starts from the `last` load point, if there is one; `tolerance` as in
    `Population.solve` under a load.

    Notes
    -----
    The fine waves lift the flat by an amount that follows from the load. Newton's method finds the
    logarithm of the load, in which separations are nearly linear.
    """
    population, heights = decomposition.population, decomposition.hm.roughness
    highest = heights.highest - heights.mean
    if separation >= highest:
        above = population.highest + separation - highest
        return load_point(decomposition, population.solve(separation=above))
    pressure, state = FIRST_LOAD * pressure_scale(decomposition.hm, population.material), None
    if last is not None and last.state.mean_pressure > 0.0:
        state, pressure = last.state, _pressure_at(last, separation)
    for _ in range(MAX_TRIES + 1):
        # from the last load point, not from the last try: found is then what its load alone gives
        found = population.solve(pressure=pressure, state=state, tolerance=tolerance)
        point = load_point(decomposition, found)
        error = separation - point.surface.separation
        # a refusal of a flat that stands too low (error > 0) does not hold at the separation asked
        if not found.converged and not error > 0.0:
            return point
        if abs(error) * point.surface.stiffness <= LOAD_ERROR * pressure:
            return point
        pressure = _pressure_at(point, separation)
    why = f"{MAX_TRIES + 1} loads did not bring the flat to {separation:g} m: its lift jumps there"
    return load_point(decomposition, point.state.refused(why))


def _pressure_at(point: LoadPoint, separation: float) -> float:
    """Mean pressure [Pa] extrapolated from a load point to a separation [m], exponentially."""
    pressure, surface = point.state.mean_pressure, point.surface
    growth = (surface.separation - separation) * surface.stiffness / pressure
    return pressure * float(np.exp(min(max(growth, -LARGEST_GROWTH), LARGEST_GROWTH)))


def load_difference(alone: LoadPoint, interacting: PopulationState) -> float:
    """Load of independent contacts over that of interacting ones, less one; NaN if not known."""
    if not (alone.converged and interacting.converged):
        return np.nan
    pressure = alone.state.mean_pressure
    if interacting.mean_pressure == 0.0:
        return np.inf if pressure else 0.0
    return pressure / interacting.mean_pressure - 1.0


def plastic_share(load: Array, area: Array, hardness: float) -> Array:
    """Share of the contact area that bears the hardness [Pa], of loads [N] on areas [m^2].

    Notes
    -----
    The cube of mean contact pressure over hardness, (p/H)^3, a fit: boundary elements give up to
    0.1 less for H/(E* h') from 0.02 to 1, at 0.2 to 15 % of contact
    (docs/development/hardness.md).
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.nan_to_num(np.minimum(load / (area * hardness), 1.0) ** 3))


def _overlap(decomposition: Decomposition, state: PopulationState) -> float:
    """Overlap of flat and surface (`Blocks.overlap`). Joined summits share the force of their
    contact as separate paraboloids of one curvature would."""
    summits = decomposition.summits
    weight = np.maximum(_single_contacts(summits, state)[0], 0.0) ** 1.5
    total = np.bincount(summits.owner, weight, len(weight))[summits.owner]
    share = np.divide(weight, total, out=np.zeros(len(weight)), where=total > 0.0)
    covered = state.contact_area / decomposition.population.nominal_area
    return decomposition.blocks.overlap(
        share * state.force[summits.owner], state.separation, covered
    )


def _refusal(
    decomposition: Decomposition, state: PopulationState, surface: SurfacePoint, overlap: float
) -> str:
    """Why separate contacts do not describe a point that was solved; empty if they do."""
    plan = decomposition.plan
    if state.mean_pressure > 0.0 and not surface.contact_area > 0.0:
        return "the contacts carry a load on no area: their laws do not hold there"
    if not plan.interaction:
        return ""
    if overlap > plan.parameters.limits.overlap:
        return (
            "beside the contacts the flat would pass through the surface: what touches there has "
            "no summit of its own"
        )
    closed = np.flatnonzero(state.force > 0)
    share = state.force[closed] / max(state.force.sum(), np.finfo(float).tiny)
    longer = np.exp(-np.sum(share * np.log(decomposition.aspect[closed])))
    if (
        longer * surface.contact_area
        > plan.parameters.limits.long_area * decomposition.population.nominal_area
    ):
        return END_TO_END
    return ""


def spot_count(decomposition: Decomposition, point: LoadPoint) -> int:
    """Number of contact spots that boundary elements on the pixels of the map would count, where
    pixels that meet at an edge or a corner belong to one spot.

    Notes
    -----
    Contacts of adjoining basins have joined where the mean of their approaches exceeds 1.6 times
    the depth of the pass below their summits (1.7 for two equal summits in a double well, boundary
    elements). A sub-contact law parts contacts into more spots, per wave of its mean wave number q

        0.35 P^-0.23 (1 - f)/f,   of A (q/2 pi)^2 waves,

    where the contacts have the area A, cover the share P of the map, and touch on the share f of A.
    Both are fits on seeds 1, 2 and 11 (`parameters.Spots`, docs/development/errors.md).
    """
    fitted = decomposition.plan.parameters.spots
    first = spot_of_contacts(decomposition, point)
    count = float(np.count_nonzero(first == np.arange(len(first))))
    fine, area = decomposition.plan.sub_contact_law, point.state.contact_area
    if fine is not None and area > 0.0:
        closed = float(point.closed_area.sum()) / area
        share = (area / decomposition.hm.area) ** -fitted.crowding
        waves = area * (fine.number / (2.0 * np.pi)) ** 2
        count += fitted.parted * share * waves * (1.0 - closed) / closed
    return round(count)


def spot_of_contacts(decomposition: Decomposition, point: LoadPoint) -> Index:
    """Spot of each contact, shape (n,): the lowest index of the contacts that have joined in it; -1
    for a summit without contact."""
    fitted = decomposition.plan.parameters.spots
    pairs, depth = decomposition.passes
    single = _single_contacts(decomposition.summits, point.state)
    return np.asarray(joined_spots(pairs, 2.0 * fitted.joined * depth, *single))


def _single_contacts(summits: Summits, state: PopulationState) -> tuple[Array, Array]:
    """Approaches [m] and areas [m^2] of all summits, (n,).

    A summit that was joined to another has no state of its own: its approach follows from the
    heights of both, and while that is positive it gets the area of the other.
    """
    lost = np.flatnonzero(summits.owner != summits.single)
    into = summits.owner[lost]
    approach, area = state.approach.copy(), state.area.copy()
    approach[lost] = approach[into] - (summits.height[into] - summits.height[lost])
    area[lost] = np.where((summits.single[lost] == lost) & (approach[lost] > 0.0), area[into], 0.0)
    return approach, area


@compiled()
def joined_spots(pairs: NDArray[np.int32], depth: Array, approach: Array, area: Array) -> Index:
    """Spot of each contact, shape (n,): its contact of lowest index; -1 for a contact without area.

    The two contacts of a pair, `pairs` (k, 2), have joined if the sum of their approaches [m]
    exceeds the `depth` [m] of the pair, (k,). Spots are found by union-find.
    """
    parent = np.empty(area.size, np.int64)
    for i in range(area.size):
        parent[i] = i
    for k in range(pairs.shape[0]):
        a = pairs[k, 0]
        b = pairs[k, 1]
        if area[a] <= 0.0 or area[b] <= 0.0 or approach[a] + approach[b] <= depth[k]:
            continue
        a, b = root(parent, a), root(parent, b)
        if a != b:
            parent[max(a, b)] = min(a, b)
    for i in range(area.size):
        parent[i] = root(parent, i) if area[i] > 0.0 else -1
    return parent
