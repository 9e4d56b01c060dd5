"""Contacts on basins that the field of the others tilts, or that have yielded: they get the area of
the tilted basin under their force.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.errors import Flag
from asperity.microcontact.basin_bem.press import areas_under
from asperity.microcontact.capped_table import LEAST_YIELD
from asperity.microcontact.laws import tabulate

if TYPE_CHECKING:
    from asperity.interaction.population import Population, PopulationState
    from asperity.microcontact.law_table import LawTable
    from asperity.parameters import TiltedBasins
    from surfaces.peaks.summits import Summits

__all__ = ["area_under", "correct"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]


def correct(
    population: Population,
    summits: Summits,
    state: PopulationState,
    fitted: TiltedBasins,
) -> PopulationState:
    """State of which the contacts on tilted basins have the areas of these; forces do not change.

    Notes
    -----
    A contact counts as on a tilted basin where the shift of a paraboloid by the gradient of the
    field, R |g| over the contact radius, is large and the contact reaches beyond the paraboloid of
    its summit. If such contacts hold much of the area, each is pressed anew with its force on the
    next summit uphill of its basin, which the gradient has tilted
    (docs/development/interaction.md).

    The elastic contact of the same area, from which the law of a yielded contact is made, may have
    another shape. Where contacts have yielded, those of large area that reach beyond the paraboloid
    of their summit are therefore pressed by elements under the hardness, the largest first, until
    their laws are confirmed (docs/development/hardness.md); none where the area of all is about the
    load over the hardness.
    Their contact radius is that of the elastic contact of the same area: how far a basin is tilted
    is no matter of what has yielded.
    """
    if not (population.contact_shift and state.contact_area > 0.0):
        return state
    approach, force, stiffness, area = state.listed
    closed = np.flatnonzero(force > 0.0)
    punch, yielded = stiffness[closed], False
    if population.material.hardness < np.inf:
        least = float(force.sum()) / population.material.hardness
        if state.contact_area <= (1.0 + fitted.confirmed) * least:
            return state
        elastic = population.table.elastic_at(state.rows[closed], approach[closed])
        yielded = bool((elastic[0] < 1.0 - LEAST_YIELD).any())
        punch = elastic[1] if yielded else punch
    flags = population.table.flags_at(state.rows[closed], approach[closed])
    beyond = (flags & np.uint8(Flag.BEYOND_RADIUS)) > 0
    closed = closed[beyond]
    shift = _shifts(population, state, closed, punch[beyond])

    def changes(own: Rows, shift: Array) -> Array:
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
    own: Rows,
    shift: Array,
    changes: Callable[[Rows, Array], Array],
    fitted: TiltedBasins,
) -> PopulationState:
    """State of which those of the contacts `own` that have a large area are pressed under the
    hardness, the largest first, those on tilted basins as if twice as large, until their laws are
    confirmed: these stay. By how much the areas of some change is told by `changes`."""
    area = state.listed[3]
    large = area[own] > fitted.pressed * state.contact_area
    own, shift = own[large], shift[large]
    order = np.argsort(-area[own] * (1.0 + _rise(shift, fitted.shift)), kind="stable")
    own, shift = own[order], shift[order]
    first, last, changed = 0, fitted.probe, np.empty(0)
    while first < len(own):
        some = own[first:last]
        change = changes(some, shift[first:last])
        if abs(change.sum()) <= fitted.confirmed * area[some].sum():
            break
        changed = np.append(changed, change)
        first, last = last, 2 * last
    return _changed(state, own[: len(changed)], changed)


def _changed(state: PopulationState, own: Rows, change: Array) -> PopulationState:
    """State with other areas [m^2] of some contacts."""
    listed = state.listed.copy()
    listed[3, own] += change
    return replace(state, listed=listed, contact_area=float(listed[3].sum()))


def _shifts(population: Population, state: PopulationState, own: Rows, punch: Array) -> Array:
    """Shift of some contacts by the gradient of the field over their radius, which the stiffness
    `punch` [N/m] tells, shape (k,)."""
    body, depth = population.footprints, state.listed[0, own]
    radius = body.radius(np.maximum(punch, 0.0))
    return np.asarray(radius * np.hypot(*state.tilt[own].T) / (body.power * depth))


def area_under(table: LawTable, force: Array) -> Array:
    """Area [m^2] of each contact of a table under a force [N], shape (n,).

    Power laws between the nodes; beyond the force of the last node its area, or what that force
    takes at the hardness.
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
    own: Rows,
    shift: Array,
    fitted: TiltedBasins,
) -> Array:
    """Areas [m^2] of contacts on their tilted basins, shape (k,); their own ones where there is no
    summit."""
    rows, approach, force, area = state.rows[own], *state.listed[:, own][[0, 1, 3]]
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
    """From 0 to 1 between two values."""
    return np.clip((value - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)
