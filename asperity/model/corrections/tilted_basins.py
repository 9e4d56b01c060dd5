"""Areas of contacts whose basins the field of the other contacts tilts, or that have yielded: each
is pressed anew on its tilted basin, under its force.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from asperity.errors import Flag
from asperity.microcontact.basin_bem.press import areas_under
from asperity.microcontact.capped_table import LEAST_YIELD
from asperity.microcontact.laws import tabulate
from surfaces.arrays import Array, Index
from surfaces.peaks.peaks import SUMMIT

if TYPE_CHECKING:
    from asperity.interaction.population import Population, PopulationState
    from asperity.microcontact.law_table import LawTable
    from asperity.parameters import TiltedBasins
    from surfaces.peaks.summits import Summits

__all__ = ["area_under", "correct"]


def correct(
    population: Population, summits: Summits, state: PopulationState, fitted: TiltedBasins
) -> PopulationState:
    """The state with the areas of contacts on tilted basins corrected; forces do not change.

    Notes
    -----
    The gradient g of the field would shift the contact on a paraboloid of radius R by R |g|. A
    basin counts as tilted if this shift is large beside the contact radius and the contact reaches
    beyond the paraboloid of its summit. If contacts on tilted basins hold much of the area, the
    basin of each is tilted by g, and its force presses the next summit uphill
    (docs/development/interaction.md).

    The law of a yielded contact is made from the elastic contact of the same area, which may have
    another shape. If contacts have yielded, boundary elements under the hardness therefore press
    those of large area that reach beyond the paraboloid, but for flat tops that have not yielded;
    the areas count as far as they refute the laws (docs/development/hardness.md). If the total area
    is near its lower bound, the load over the hardness, none is pressed. The contact radius in
    R |g| is that of the elastic contact of the same area: yielding does not change how far a basin
    tilts.
    """
    if not (population.contact_shift and state.contact_area > 0.0):
        return state
    approach, force, stiffness, area = state.contacts
    closed = np.flatnonzero(force > 0.0)
    punch, yielded = stiffness[closed], False
    if population.material.hardness < np.inf:
        least = float(force.sum()) / population.material.hardness
        if state.contact_area <= (1.0 + fitted.confirmed) * least:
            return state
        elastic = population.table.elastic_at(state.rows[closed], approach[closed])
        capped = elastic[0] < 1.0 - LEAST_YIELD
        yielded = bool(capped.any())
        punch = elastic[1] if yielded else punch
    flags = population.table.flags_at(state.rows[closed], approach[closed])
    beyond = (flags & np.uint8(Flag.BEYOND_RADIUS)) > 0
    if yielded:
        beyond &= capped | (summits.kinds[state.rows[closed]] == SUMMIT)
    closed = closed[beyond]
    shift = _shifts(population, state, closed, punch[beyond])

    def changes(own: Index, shift: Array) -> Array:
        found = _areas(population, summits, state, own, shift, fitted)
        return np.asarray(found - area[own])

    if yielded:
        return _yielding(state, closed, shift, changes, fitted)
    weight = _rise(shift, fitted.shift)
    tilted = weight * area[closed]
    share = tilted.sum() / state.contact_area
    if share <= fitted.share[0]:
        return state
    order = np.argsort(-tilted, kind="stable")
    held = np.cumsum(tilted[order])
    most = order[: np.searchsorted(held, fitted.most * held[-1]) + 1]
    own = closed[most]
    changed = _rise(share, fitted.share) * weight[most] * changes(own, shift[most])
    return _changed(state, own, changed)


def _yielding(
    state: PopulationState,
    own: Index,
    shift: Array,
    changes: Callable[[Index, Array], Array],
    fitted: TiltedBasins,
) -> PopulationState:
    """The state with the areas of the large ones of the contacts `own` corrected.

    `changes` presses contacts under the hardness and gives the change of each area [m^2]. Changes
    of both signs that nearly cancel are the error of the elements more than that of the laws: the
    weight of all rises with their sum, so that a small change of the state makes a small one here.
    """
    area = state.contacts.area
    large = area[own] > fitted.pressed * state.contact_area
    own, shift = own[large], shift[large]
    change = changes(own, shift)
    missed = abs(change.sum()) / max(area[own].sum(), np.finfo(float).tiny)
    return _changed(state, own, _rise(missed, (0.0, fitted.confirmed)) * change)


def _changed(state: PopulationState, own: Index, change: Array) -> PopulationState:
    """The state with `change` [m^2] added to the areas of the contacts `own`."""
    area = state.contacts.area.copy()
    area[own] += change
    contacts = state.contacts._replace(area=area)
    return replace(state, contacts=contacts, contact_area=float(area.sum()))


def _shifts(population: Population, state: PopulationState, own: Index, punch: Array) -> Array:
    """Shift R |g| of the contacts `own` by the gradient g of the field, over the contact radius a,
    shape (k,).

    A paraboloid has R = a^2 / (p d) at the approach d, p = `Footprints.power` (1 for m = 0); a is
    the radius of the flat punch of the stiffness `punch` [N/m].
    """
    body, depth = population.footprints, state.contacts.approach[own]
    radius = body.radius(np.maximum(punch, 0.0))
    return np.asarray(radius * np.hypot(*state.tilt[own].T) / (body.power * depth))


def area_under(table: LawTable, force: Array) -> Array:
    """Area [m^2] of each contact of a table under a force [N], shape (n,).

    Areas follow power laws of the force between nodes, and stay constant beyond the last node. No
    area is less than the force over the hardness.
    """
    upper = np.clip(np.argmax(table.force >= force[:, None], axis=1), 1, table.nodes)
    upper[force > table.force[:, -1]] = table.nodes
    row = np.arange(len(table))
    high, low = ((table.force[row, node], table.area[row, node]) for node in (upper, upper - 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        power = np.log(high[1] / low[1]) / np.log(high[0] / low[0])
        power = np.where(upper > 1, power, 2.0 / table.exponent)
        area = high[1] * np.minimum(force / high[0], 1.0) ** power
    area = np.maximum(np.nan_to_num(area), force / table.hardness)
    return np.where(table.reach > 0, area, 0.0)


def _areas(
    population: Population,
    summits: Summits,
    state: PopulationState,
    own: Index,
    shift: Array,
    fitted: TiltedBasins,
) -> Array:
    """Areas [m^2] of the contacts `own` on their tilted basins, shape (k,); the present area of a
    contact whose tilted basin has no summit."""
    rows, contacts = state.rows[own], state.contacts
    approach, force, area = contacts.approach[own], contacts.force[own], contacts.area[own]
    gradient = state.tilt[own] / (1.0 + shift[:, None])
    tilted, body = summits.tilted(rows, gradient, fitted.passed * approach), population.material
    found = np.zeros(len(own))
    some = np.flatnonzero(tilted.valid[rows] & np.isinf(tilted.floor[rows]))
    if some.size and body.hardness < np.inf:
        found[some] = areas_under(tilted, rows[some], force[some], approach[some], body)
    elif some.size:
        table = tabulate(tilted.rows(rows[some]), body, law="ellipse")
        found[some] = area_under(table, force[some])
    return np.where(found > 0.0, found, area)


def _rise(value: Array | float, ends: tuple[float, float]) -> Array:
    """Linear rise from 0 at the first of the `ends` to 1 at the second, constant outside."""
    return np.clip((value - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)
