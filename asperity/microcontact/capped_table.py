"""Law tables with a hardness, made from elastic law tables."""

from __future__ import annotations

import math
from copy import deepcopy
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from asperity.halfspace.transforms import count_below, lagrange
from surfaces.arrays import Array, Index
from surfaces.numerics import parallel

from .yielding import capped

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace

    from .law_table import LawTable

__all__ = ["capped_table"]


CONTACTS_PER_THREAD = 256
"""Contacts that a thread takes at a time: fewer do not repay it, the arrays of more leave its
cache."""

FINER_NODES = 2
"""Number of elastic contacts up to the reach from which a capped law is made, over the nodes of the
table."""

WIDER_LEVELS = 6
"""Number of elastic contacts that are larger than the one at the reach."""

LEAST_WIDENING = 1e-3
"""Increase of the root of the area of these where the basin is full at the reach."""

FURTHER_APPROACH = 0.1
"""Approach beyond the reach, over the reach, at which the stiffness of a filled basin is measured:
it is zero at the hardness."""

LEAST_YIELD = 1e-4
"""Relative loss of force below which a law stays elastic: sharp tips always yield a little."""

LEAST_RISE = 0.05
"""Least increase of a capped approach over that of the elastic one: 1/2 to 1 for a paraboloid."""

ROUNDING = 1e-9
"""Relative rounding error, by which a filled basin may exceed its largest bearing area, a node a
level, and a cubic the forces that enclose it."""


def capped_table(table: LawTable, material: HalfSpace) -> LawTable:
    """Laws of contacts whose pressure the hardness of the half-space bounds, from a table of
    elastic laws with bearing areas; the table itself without a hardness.

    Notes
    -----
    Each capped contact has the area of an elastic one (`yielding.capped`). The edge of the elastic
    contact is displaced by its approach less the depth at which the unloaded summit has this area;
    the displacement of the capped edge is derived from it. In the limit of a soft body the approach
    is the depth at which the bearing area is the contact area, whatever the law.

    Some basins are not full where their elastic laws end: those pressed alone, and those whose rays
    end at other heights. A contact that yields goes on to fill them, as the elastic law would with
    the powers of its tip, until its own approach is the reach.

    A capped force grows with the approach, but need not be convex in it: the coupled problem is one
    of forces, whose energy has the Hessian diag(dd/dF) plus the interaction of footprints, and is
    convex where every force grows (docs/development/half_space.md).
    """
    if material.hardness == math.inf:
        return table
    elastic = np.stack((np.ones(table.force.shape), table.stiffness), axis=2)
    result = replace(deepcopy(table), bearing=None, elastic=elastic, hardness=material.hardness)
    rows = np.flatnonzero((table.reach > 0) & (table.force[:, -1] > 0))
    parts = parallel.blocks(rows.size, CONTACTS_PER_THREAD, CONTACTS_PER_THREAD)
    parallel.run(lambda first, last: _cap(table, rows[first:last], material, result), parts)
    return result


def _cap(table: LawTable, rows: Index, material: HalfSpace, result: LawTable) -> None:
    """Write the capped laws of the `rows` of a table into `result`, which holds elastic laws."""
    assert table.bearing is not None
    nodes = table.nodes
    at_reach = FINER_NODES * nodes - 1
    own, elastic, force, stiffness, area = _elastic_states(table, rows)
    level = depths_of(table.bearing[rows], table.approach()[rows], area)
    found = capped(elastic, force, area, stiffness, material, level=level)
    filled = found.force[:, -1] - found.force[:, at_reach]
    filled /= FURTHER_APPROACH * table.reach[rows]
    elastic, approach, capped_force, force, stiffness, area = (
        column[:, :-1] for column in (elastic, found.approach, found.force, force, stiffness, area)
    )
    late = np.flatnonzero((capped_force < (1.0 - LEAST_YIELD) * force).any(axis=1))
    if not late.size:
        return
    rows, own, approach = rows[late], own[late], _rising(approach[late], elastic[late])
    columns = [np.maximum.accumulate(capped_force[late], axis=1), area[late], stiffness[late]]
    columns.append(columns[0] / force[late] * approach)
    if table.centre is not None:
        node = np.minimum(own.astype(np.int64), nodes - 1)
        each, share = np.arange(len(own))[:, None], own - node
        for old in np.moveaxis(table.centre[rows], 2, 0):
            columns.append(approach * (old[each, node] * (1 - share) + old[each, node + 1] * share))
    reach = np.clip(table.reach[rows], approach[:, at_reach], approach[:, -1])
    values, slope = resample(approach, np.stack(columns), nodes, reach)
    places = reach[:, None] * (np.arange(nodes + 1) / nodes) ** 2
    below = count_below(approach[:, :-1], places * (1.0 - ROUNDING))
    node = np.ceil(np.take_along_axis(own, below, 1) - ROUNDING).astype(np.int64)
    node[places == 0.0] = 0
    result.flags[rows], result.spread[rows] = (
        known[rows[:, None], node] for known in (table.flags, table.spread)
    )
    slope[:, -1] = np.minimum(slope[:, -1], filled[late])
    result.reach[rows], result.force[rows], result.stiffness[rows] = reach, values[0], slope
    result.area[rows] = np.maximum(values[1], values[0] / material.hardness)
    assert result.elastic is not None
    result.elastic[rows, 1:, 0] = values[3, :, 1:] / places[:, 1:]
    result.elastic[rows, :, 1] = values[2]
    if result.centre is not None:
        result.centre[rows, 1:] = np.moveaxis(values[4:, :, 1:] / places[:, 1:], 0, 2)


def _elastic_states(table: LawTable, rows: Index) -> tuple[Array, ...]:
    """Place among the nodes, approach, force, stiffness and area, (n, states) each, of elastic
    contacts from which the capped laws of `rows` are made: at levels up to the reach; of wider
    ones, up to the area of the basin; the last is the one at the reach pressed further, as a filled
    basin is.

    Levels are spaced by the roots of approach and of area alike, which on a paraboloid are
    proportional: where an elastic contact jumps on to the next step of a basin, one that yields
    grows on to the foot of the step before.
    """
    assert table.bearing is not None
    levels, nodes, p = FINER_NODES * table.nodes, table.nodes, table.exponent
    size = np.sqrt(np.maximum.accumulate(table.area[rows], axis=1) / table.area[rows, -1:])
    spaced = 0.5 * (np.arange(nodes + 1) / nodes + size)
    wanted = np.broadcast_to(np.arange(1, levels + 1) / levels, (len(rows), levels))
    own = _interpolated(spaced, np.broadcast_to(np.arange(nodes + 1.0), spaced.shape), wanted)
    u = np.pad(own / nodes, ((0, 0), (0, 1)), constant_values=(1.0 + FURTHER_APPROACH) ** 0.5)
    approach = table.reach[rows, None] * np.square(u)
    force, stiffness, area = table.evaluate(rows[:, None], approach)
    widening = np.maximum(np.sqrt(table.bearing[rows, -1] / area[:, -2]) - 1.0, LEAST_WIDENING)
    wider = 1.0 + widening[:, None] * (np.arange(1, WIDER_LEVELS + 1) / WIDER_LEVELS)
    states = (
        np.hstack((known[:, :-1], known[:, -2:-1] * wider**power, known[:, -1:]))
        for known, power in ((approach, 2.0), (force, p), (stiffness, p - 2.0), (area, 2.0))
    )
    return np.pad(own, ((0, 0), (0, WIDER_LEVELS)), constant_values=nodes), *states


def depths_of(bearing: Array, depth: Array, area: Array) -> Array:
    """Depths at which the unloaded summits have the areas `area`, (n, levels).

    `bearing` holds the areas of the unloaded summits above the flats at `depth`; both ascend along
    a row. Between the nodes sqrt(depth) is linear in sqrt(area), as on a cone or a paraboloid.
    """
    return np.square(_interpolated(np.sqrt(bearing), np.sqrt(depth), np.sqrt(area)))


def _interpolated(known: Array, values: Array, wanted: Array) -> Array:
    """Values at the places `wanted`, (n, l), of straight lines through `values` at the `known`
    places, (n, k), which ascend along a row; beyond the last of these its value."""
    j = np.minimum(count_below(known[:, 1:], wanted * (1.0 - ROUNDING)), known.shape[1] - 2)
    rows = np.arange(len(j))[:, None]
    (low, high), (start, end) = ((row[rows, j], row[rows, j + 1]) for row in (known, values))
    share = np.ones(wanted.shape)
    np.divide(wanted - low, high - low, out=share, where=high > low)
    return np.asarray(start + np.minimum(share, 1.0) * (end - start))


def _rising(approach: Array, elastic: Array) -> Array:
    """Approaches with an increase from level to level of at least `LEAST_RISE` of the `elastic`
    one."""
    least = LEAST_RISE * elastic
    return np.asarray(least + np.maximum.accumulate(np.maximum(approach - least, 0.0), axis=1))


def resample(x: Array, columns: Array, nodes: int, reach: Array) -> tuple[Array, Array]:
    """Interpolate columns of law tables, given at rising approaches `x`, (n, levels), to the nodes
    up to a `reach`, (n,), that the last of these are not below.

    Returns values (c, n, nodes + 1) from `columns` (c, n, levels), of which the first is the force,
    and the slope of the force (n, nodes + 1). Force over approach is a cubic in the root of the
    approach, through the four nearest levels. Between two levels that are more than a node apart,
    or whose forces do not enclose the cubic, the force is linear in the approach, as are the other
    columns.
    """
    levels, rows = x.shape[1], np.arange(len(x))[:, None]
    root = np.sqrt(x)
    u = np.sqrt(reach)[:, None] * (np.arange(1, nodes + 1) / nodes)
    before = count_below(root, u * (1.0 - ROUNDING))
    four = np.clip(before - 2, 0, levels - 4)[..., None] + np.arange(4)
    near = columns[0][rows[..., None], four] / x[rows[..., None], four]
    level, rise = (
        np.sum(weight * near, axis=-1) for weight in lagrange(root[rows[..., None], four], u)
    )
    force, slope = u * u * level, level + 0.5 * u * rise
    j = np.clip(before - 1, 0, levels - 2)
    start, low, high = x[rows, j], columns[:, rows, j], columns[:, rows, j + 1]
    rate = (high - low) / (x[rows, j + 1] - start)
    beyond = u * u - start
    wide = (root[rows, j + 1] - root[rows, j]) * nodes > u[:, -1:]
    within = np.clip(force, low[0], high[0])
    enclosed = (np.abs(force - within) <= ROUNDING * high[0]) & (slope > 0.0)
    plain = (wide | ~enclosed) & (root[rows, j] <= u)
    # up to the first level columns grow with the approach
    values = np.minimum(u * u / x[:, :1], 1.0) * (low + rate * np.maximum(beyond, 0.0))
    values[0] = np.where(plain, low[0] + rate[0] * beyond, within)
    slope = np.where(plain, rate[0], slope)
    return np.pad(values, ((0, 0), (0, 0), (1, 0))), np.pad(slope, ((0, 0), (1, 0)))
