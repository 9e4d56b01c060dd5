"""Contacts on basins that the field of the others tilts: they get the area of the tilted basin."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.errors import Flag
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
    if population.material.hardness < np.inf and MODE:
        return _exp(population, summits, state, fitted, closed)
    beyond = population.table.flags_at(state.rows[closed], approach[closed])
    closed = closed[(beyond & np.uint8(Flag.BEYOND_RADIUS)) > 0]
    body, depth, punch = population.footprints, approach[closed], stiffness[closed]
    if population.material.hardness < np.inf:
        punch = population.table.elastic_at(state.rows[closed], depth)[1]
    radius = (body.power * punch / (2.0 * body.modulus)) ** (1.0 / body.power)
    shift = radius * np.hypot(*state.tilt[closed].T) / (body.power * depth)
    weight = _rise(shift, fitted.shift)
    tilted = weight * area[closed]
    share = tilted.sum() / state.contact_area
    if share <= fitted.share[0]:
        return state
    order = np.argsort(-tilted, kind="stable")
    held = np.cumsum(tilted[order])
    most = order[: np.searchsorted(held, fitted.most * held[-1]) + 1]
    own, weight = closed[most], weight[most]
    gradient = state.tilt[own] / (1.0 + shift[most, None])
    rows, deepest = state.rows[own], fitted.passed * approach[own]
    found = _areas(summits.tilted(rows, gradient, deepest), rows, force[own], population.material)
    found = np.where(found > 0.0, found, area[own])
    listed = state.listed.copy()
    listed[3, own] += _rise(share, fitted.share) * weight * (found - area[own])
    return replace(state, listed=listed, contact_area=float(listed[3].sum()))


import os, time
MODE = os.environ.get("EXP", "")
STAT = [0, 0.0]


def _exp(population, summits, state, fitted, closed):
    from asperity.microcontact.basin_bem.press import areas_under
    approach, force, stiffness, area = state.listed
    t0 = time.perf_counter()
    if "b" in MODE:
        flags = population.table.flags_at(state.rows[closed], approach[closed])
        closed = closed[(flags & np.uint8(Flag.BEYOND_RADIUS)) > 0]
    body, depth = population.footprints, approach[closed]
    punch = population.table.elastic_at(state.rows[closed], depth)[1]
    radius = (body.power * punch / (2.0 * body.modulus)) ** (1.0 / body.power)
    shift = radius * np.hypot(*state.tilt[closed].T) / (body.power * depth)
    big = area[closed] > float(os.environ.get("SHARE", "0.003")) * state.contact_area
    own, shift = closed[big], shift[big]
    if not own.size:
        return state
    gradient = state.tilt[own] / (1.0 + shift[:, None])
    if "0" in MODE:
        gradient *= 0.0
    rows = state.rows[own]
    tilted = summits.tilted(rows, gradient, fitted.passed * approach[own])
    ok = tilted.valid[rows]
    if "j" not in MODE:
        ok &= np.isinf(summits.floor[rows])
    found = np.zeros(len(rows))
    found[ok] = areas_under(tilted, rows[ok], force[own][ok], approach[own][ok], population.material)
    n0 = int((found == 0).sum())
    found = np.where(found > 0.0, found, area[own])
    listed = state.listed.copy()
    listed[3, own] = found
    STAT[0] += len(own); STAT[1] += time.perf_counter() - t0
    if "v" in MODE:
        print("share %.4f" % (state.contact_area/population.nominal_area), "n", len(own), "lost", n0, "held %.2f" % (area[own].sum()/state.contact_area), "ratio %.3f" % (found.sum()/area[own].sum()), "ms %.1f" % (1e3*(time.perf_counter()-t0)))
    return replace(state, listed=listed, contact_area=float(listed[3].sum()))


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


def _areas(summits: Summits, rows: Rows, force: Array, material: HalfSpace) -> Array:
    """Areas [m^2] of contacts on their tilted basins, shape (k,); zero where there is no summit."""
    area = np.zeros(len(rows))
    alone = np.flatnonzero(summits.valid[rows] & np.isinf(summits.floor[rows]))
    if alone.size:
        profiles = summits.rows(rows[alone])
        table = tabulate(profiles, material, law="ellipse")
        area[alone] = area_under(table, force[alone])
    return area


def _rise(value: Array | float, ends: tuple[float, float]) -> Array:
    """From 0 to 1 between two values."""
    return np.clip((value - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)
