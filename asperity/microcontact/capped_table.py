"""Law tables of contacts whose pressure a hardness bounds."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics import parallel
from surfaces.numerics.compiled import compiled

from ._ray_kernels import lagrange
from .yielding import capped

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace

    from .law_table import LawTable

__all__ = ["capped_table"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

CONTACTS_PER_THREAD = 256
"""Contacts that repay a thread, which takes no more at a time: their arrays stay in its cache."""

FINER_NODES = 2
"""Elastic approaches, over the nodes of a table, of which the capped contacts are found first."""

FURTHER_APPROACH = 0.1
"""Further approach, over the reach, that tells how a filled basin bears more: at the hardness it
bears none."""

LEAST_YIELD = 1e-4
"""Loss of force, relative, from which on a law is changed: sharp tips always yield a little."""

LEAST_RISE = 0.05
"""Least growth of a capped approach over that of the elastic one: a paraboloid has 1/2 to 1."""

AREA_ROUNDING = 1e-9
"""Relative error of areas: a summit that has filled its basin has none deeper down."""


def capped_table(table: LawTable, material: HalfSpace) -> LawTable:
    """The laws of contacts whose pressure the hardness of a half-space bounds, from elastic ones
    with their bearing areas; without a hardness these.

    Notes
    -----
    Each capped contact has the area of an elastic one (`yielding.capped`). How far its edge is
    displaced goes on from that of the elastic one, its approach less the depth at which the
    unloaded summit has the area. A soft body is therefore pressed as far as its bearing area tells,
    whatever the law.

    A capped force grows with the approach, but need not be convex in it: the coupled problem is one
    of forces, whose energy has the Hessian diag(dd/dF) plus the interaction of footprints, and is
    convex where every force grows (docs/development/half_space.md).
    """
    if material.hardness == math.inf:
        return table
    result = replace(
        table,
        reach=table.reach.copy(),
        force=table.force.copy(),
        stiffness=table.stiffness.copy(),
        area=table.area.copy(),
        centre=None if table.centre is None else table.centre.copy(),
        bearing=None,
        elastic=np.stack((np.ones(table.force.shape), table.stiffness), axis=2),
        hardness=material.hardness,
    )
    rows = np.flatnonzero((table.reach > 0) & (table.force[:, -1] > 0))
    parts = parallel.blocks(rows.size, CONTACTS_PER_THREAD, CONTACTS_PER_THREAD)
    parallel.run(lambda first, last: _cap(table, rows[first:last], material, result), parts)
    return result


def _cap(table: LawTable, rows: Rows, material: HalfSpace, result: LawTable) -> None:
    """Put the capped laws of some rows of a table into `result`, which holds the elastic ones."""
    assert table.bearing is not None
    nodes = table.nodes
    levels = FINER_NODES * nodes
    u = np.append(np.arange(1, levels + 1) / levels, (1.0 + FURTHER_APPROACH) ** 0.5)
    elastic = table.reach[rows, None] * np.square(u)
    force, stiffness, area = table.evaluate(rows[:, None], elastic)
    level = area.copy()
    depths_of(table.bearing[rows], table.approach()[rows], level)
    found = capped(elastic, force, area, stiffness, material, level=level)
    filled = (found.force[:, -1] - found.force[:, -2]) / (FURTHER_APPROACH * table.reach[rows])
    elastic, approach, capped_force, force, stiffness, area = (
        column[:, :-1] for column in (elastic, found.approach, found.force, force, stiffness, area)
    )
    late = np.flatnonzero((capped_force < (1.0 - LEAST_YIELD) * force).any(axis=1))
    if not late.size:
        return
    rows, approach = rows[late], approach[late]
    columns = [np.maximum.accumulate(capped_force[late], axis=1), area[late], stiffness[late]]
    columns.append(columns[0] / force[late] * approach)
    if table.centre is not None:
        node = np.arange(levels) // FINER_NODES
        share = u[:-1] * nodes - node
        for old in np.moveaxis(table.centre[rows], 2, 0):
            columns.append(approach * (old[:, node] * (1 - share) + old[:, node + 1] * share))
    values = np.zeros((len(columns), len(rows), nodes + 1))
    reach, slope = np.zeros(len(rows)), np.zeros((len(rows), nodes + 1))
    resample(elastic[late], approach, np.stack(columns), reach, values, slope)
    slope[:, -1] = np.minimum(slope[:, -1], filled[late])
    result.reach[rows], result.force[rows], result.stiffness[rows] = reach, values[0], slope
    result.area[rows] = np.maximum(values[1], values[0] / material.hardness)
    places = reach[:, None] * (np.arange(1, nodes + 1) / nodes) ** 2
    assert result.elastic is not None
    result.elastic[rows, 1:, 0] = values[3, :, 1:] / places
    result.elastic[rows, :, 1] = values[2]
    if result.centre is not None:
        result.centre[rows, 1:] = np.moveaxis(values[4:, :, 1:] / places, 0, 2)


@compiled()
def depths_of(bearing: Array, depth: Array, area: Array) -> None:
    """Replace the areas of each row, rising, by the depths at which the unloaded summit has them.

    `bearing` holds the areas of the unloaded summits above the flats at `depth`, both rising along
    a row; the root of the depth is linear in that of the area between them.
    """
    last = depth.shape[1] - 1
    for i in range(area.shape[0]):
        j = 0
        for k in range(area.shape[1]):
            wanted = area[i, k] * (1.0 - AREA_ROUNDING)
            while j < last - 1 and bearing[i, j + 1] < wanted:
                j += 1
            low, high = math.sqrt(bearing[i, j]), math.sqrt(bearing[i, j + 1])
            share = (math.sqrt(wanted) - low) / (high - low) if high > low else 1.0
            start, end = math.sqrt(depth[i, j]), math.sqrt(depth[i, j + 1])
            area[i, k] = (start + min(share, 1.0) * (end - start)) ** 2


@compiled()
def resample(
    elastic: Array, approach: Array, columns: Array, reach: Array, values: Array, stiffness: Array
) -> None:
    """Columns of law tables from their values at the approaches of each row.

    Fills `values` (c, n, nodes + 1) from `columns` (c, n, levels), of which the first is the force,
    `reach` (n,) with the last approaches and `stiffness` (n, nodes + 1) with the slope of the
    force. Over the approach the force is a cubic in the root of the approach through the four
    nearest levels, or linear in it where that does not lie between two or these are more than a
    node apart, as are the other columns. An approach is made to grow by `LEAST_RISE` of the
    `elastic` one at least.
    """
    levels, nodes = approach.shape[1], values.shape[2] - 1
    weight, slope, root = np.empty(4), np.empty(4), np.empty(levels)
    for i in range(approach.shape[0]):
        x = approach[i]
        lower, under = 0.0, 0.0
        for k in range(levels):
            x[k] = max(x[k], under + LEAST_RISE * (elastic[i, k] - lower))
            lower, under, root[k] = elastic[i, k], x[k], math.sqrt(x[k])
        reach[i] = x[levels - 1]
        base, j = 0, 0
        for node in range(1, nodes + 1):
            u = root[levels - 1] * node / nodes
            while base + 4 < levels and root[base + 2] < u:
                base += 1
            while j < levels - 2 and root[j + 1] < u:
                j += 1
            lagrange(root, base, u, weight, slope)
            level, rise = 0.0, 0.0
            for k in range(base, base + 4):
                ratio = columns[0, i, k] / x[k]
                level += weight[k - base] * ratio
                rise += slope[k - base] * ratio
            force, grown = u * u * level, level + 0.5 * u * rise
            low, high = columns[0, i, j], columns[0, i, j + 1]
            wide = (root[j + 1] - root[j]) * nodes > root[levels - 1]
            if (wide or not (low <= force <= high and grown > 0.0)) and root[j] <= u:
                grown = (high - low) / (x[j + 1] - x[j])
                force = low + grown * (u * u - x[j])
            values[0, i, node], stiffness[i, node] = force, grown
            share = min(max((u * u - x[j]) / (x[j + 1] - x[j]), 0.0), 1.0)
            small = min(u * u / x[0], 1.0)  # before the first level columns grow with the approach
            for c in range(1, columns.shape[0]):
                low, high = columns[c, i, j], columns[c, i, j + 1]
                values[c, i, node] = small * (low + share * (high - low))
