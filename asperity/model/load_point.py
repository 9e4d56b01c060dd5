"""One load point of a surface: its contacts, their spots, and the whole surface at their state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.multiscale.sub_contact_law import SurfacePoint, closed_areas, surface_point
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


Array = NDArray[np.float64]

MAX_TRIES = 12
"""Separations of the longer waves tried for one of the whole surface."""

LOAD_ERROR = 5e-4
"""Relative error of the load that a separation may leave."""

END_TO_END = "the contacts on the ridges of the lay are so long that they overlap end to end"
"""Why a load point is refused, and all heavier ones with it."""


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

    @property
    def end_to_end(self) -> bool:
        """Whether it is refused for long contacts that overlap, as they do under any heavier load:
        none of these is solved, which may take minutes."""
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
    reason = state.reason or _refusal(decomposition, state, surface)
    return LoadPoint(state, surface, area, reason)


def point_at_separation(
    decomposition: Decomposition,
    separation: float,
    last: LoadPoint | None,
    tolerance: float,
) -> LoadPoint:
    """The load point at which the flat is at a separation [m] from the whole surface, from the
    `last` one, of a near separation; `tolerance` as in `Population.solve`.

    Notes
    -----
    The fine waves lift the flat; the lift changes slowly with the load, so that the secant of the
    separation of the longer waves is near the step itself.
    """
    lift = 0.0 if last is None else last.surface.separation - last.state.separation
    state = None if last is None else last.state
    coarse, before = separation - lift, None
    for _ in range(MAX_TRIES + 1):
        state = decomposition.population.solve(separation=coarse, state=state, tolerance=tolerance)
        point = load_point(decomposition, state)
        error = separation - point.surface.separation
        close = abs(error) * point.surface.stiffness <= LOAD_ERROR * state.mean_pressure
        # refused nearer than the flat shall be, it is not refused there
        refused = not state.converged and not error > 0.0
        if refused or (error >= 0.0 if state.active == 0 else close):
            return point
        step = error
        if before is not None and before[1] != error:
            secant = error * (coarse - before[0]) / (before[1] - error)
            step = error * min(max(secant / error, 0.2), 3.0)
        before = coarse, error
        coarse += step
    why = f"{MAX_TRIES + 1} solves did not bring the flat to {separation:g} m: its lift jumps there"
    return load_point(decomposition, point.state.refused(why))


def load_difference(alone: LoadPoint, interacting: PopulationState) -> float:
    """Load of independent contacts over that of interacting ones, less one; NaN if not known."""
    if not (alone.converged and interacting.converged):
        return np.nan
    pressure = alone.state.mean_pressure
    if interacting.mean_pressure == 0.0:
        return np.inf if pressure else 0.0
    return pressure / interacting.mean_pressure - 1.0


def plastic_share(load: Array, area: Array, hardness: float) -> Array:
    """Share of contact areas [m^2] under loads [N] whose pressure is the hardness [Pa].

    Notes
    -----
    The cube of mean contact pressure over hardness: boundary elements give up to 0.1 less for
    H/(E* h') from 0.02 to 1, at 0.2 to 15 % of contact (docs/development/hardness.md).
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.nan_to_num(np.minimum(load / (area * hardness), 1.0) ** 3))


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
        return END_TO_END
    return ""


def spot_count(decomposition: Decomposition, point: LoadPoint) -> int:
    """Number of separate spots: of what touches on the pixels of the map, where pixels that meet at
    an edge or a corner belong together, as boundary elements on these pixels count them.

    Notes
    -----
    Contacts of adjoining basins have joined where their mean approach is 1.6 times the mean depth
    of the pass under their summits (1.7 for two equal summits in a double well, boundary elements:
    docs/development/errors.md). Where the finest waves act as a law, contacts of the area A that
    stay closed on its share f and cover the share P of the map are parted into
    0.35 P^-0.23 (1 - f)/f more spots per wave, A (q/2 pi)^2 waves of the mean wave number q of the
    fine waves.
    The constants were found on seeds 1, 2 and 11 (docs/development/errors.md).
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


def spot_of_contacts(decomposition: Decomposition, point: LoadPoint) -> NDArray[np.int64]:
    """The spot of each contact, shape (n,): the first of the contacts that have joined it over the
    passes between them; -1 without contact."""
    fitted = decomposition.plan.parameters.spots
    pairs, depth = decomposition.passes
    each = _each(decomposition.summits, point.state)
    return np.asarray(joined_spots(pairs, 2.0 * fitted.joined * depth, *each))


def _each(summits: Summits, state: PopulationState) -> tuple[Array, Array]:
    """Approaches [m] and areas of all summits, (n,), some for those that were joined to others."""
    lost = np.flatnonzero(summits.owner != summits.single)
    into = summits.owner[lost]
    approach, area = state.approach.copy(), state.area.copy()
    approach[lost] = approach[into] - (summits.height[into] - summits.height[lost])
    area[lost] = np.where((summits.single[lost] == lost) & (approach[lost] > 0.0), area[into], 0.0)
    return approach, area


@compiled()
def joined_spots(
    pairs: NDArray[np.int32], depth: Array, approach: Array, area: Array
) -> NDArray[np.int64]:
    """First contact of the spot that each contact belongs to, -1 without area, shape (n,).

    The contacts of each of the `pairs` (k, 2) have joined where their approaches [m] add up to more
    than its `depth` [m].
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
