"""Contacts on basins that the field of the others tilts: they get the area of the tilted basin."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.errors import Flag
from asperity.microcontact.basin_bem.press import areas_under
from asperity.microcontact.laws import tabulate

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.interaction.population import Population, PopulationState
    from asperity.microcontact.law_table import LawTable
    from asperity.parameters.constants import TiltedBasins
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
    (docs/development/interaction.md). With a hardness the contact radius is that of the elastic
    contact of the same area: how far a basin is tilted is no matter of what has yielded.
    """
    if not (population.contact_shift and state.contact_area > 0.0):
        return state
    approach, force, stiffness, area = state.listed
    closed = np.flatnonzero(force > 0.0)
    if population.material.hardness < np.inf:
        own = closed[area[closed] > fitted.pressed * state.contact_area]
        punch = population.table.elastic_at(state.rows[own], approach[own])[1]
        shift, share = _shifts(population, state, own, punch), np.ones(len(own))
    else:
        beyond = population.table.flags_at(state.rows[closed], approach[closed])
        closed = closed[(beyond & np.uint8(Flag.BEYOND_RADIUS)) > 0]
        shift = _shifts(population, state, closed, stiffness[closed])
        weight = _rise(shift, fitted.shift)
        tilted = weight * area[closed]
        held = float(tilted.sum() / state.contact_area)
        if held <= fitted.share[0]:
            return state
        order = np.argsort(-tilted, kind="stable")
        first = np.cumsum(tilted[order])
        most = order[: np.searchsorted(first, fitted.most * first[-1]) + 1]
        own, shift, share = closed[most], shift[most], _rise(held, fitted.share) * weight[most]
    gradient = state.tilt[own] / (1.0 + shift[:, None])
    rows, deepest = state.rows[own], fitted.passed * approach[own]
    tilted_summits = summits.tilted(rows, gradient, deepest)
    found = _areas(tilted_summits, rows, force[own], approach[own], population.material)
    found = np.where(found > 0.0, found, area[own])
    listed = state.listed.copy()
    listed[3, own] += share * (found - area[own])
    return replace(state, listed=listed, contact_area=float(listed[3].sum()))


def _shifts(population: Population, state: PopulationState, own: Rows, punch: Array) -> Array:
    """Shift of some contacts by the gradient of the field over their radius, which the stiffness
    `punch` [N/m] tells, shape (k,)."""
    body, depth = population.footprints, state.listed[0, own]
    radius = (body.power * punch / (2.0 * body.modulus)) ** (1.0 / body.power)
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
    summits: Summits, rows: Rows, force: Array, approach: Array, material: HalfSpace
) -> Array:
    """Areas [m^2] of contacts on their tilted basins, shape (k,); zero where there is no summit."""
    area = np.zeros(len(rows))
    some = np.flatnonzero(summits.valid[rows] & np.isinf(summits.floor[rows]))
    if not some.size:
        return area
    if material.hardness < np.inf:
        area[some] = areas_under(summits, rows[some], force[some], approach[some], material)
    else:
        table = tabulate(summits.rows(rows[some]), material, law="ellipse")
        area[some] = area_under(table, force[some])
    return area


def _rise(value: Array | float, ends: tuple[float, float]) -> Array:
    """From 0 to 1 between two values."""
    return np.clip((value - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)
