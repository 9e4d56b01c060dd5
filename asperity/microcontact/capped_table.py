"""Law tables with a hardness, made from elastic law tables."""

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
"""Contacts that a thread takes at a time: fewer do not repay it, the arrays of more leave its
cache."""

FINER_NODES = 2
"""Number of elastic approaches from which a capped law is made, over the nodes of the table."""

FURTHER_APPROACH = 0.1
"""Approach beyond the reach, over the reach, at which the stiffness of a filled basin is measured:
it is zero at the hardness."""

LEAST_YIELD = 1e-4
"""Relative loss of force below which a law stays elastic: sharp tips always yield a little."""

LEAST_RISE = 0.05
"""Least increase of a capped approach over that of the elastic one: 1/2 to 1 for a paraboloid."""

AREA_ROUNDING = 1e-9
"""Relative rounding error of areas, by which a filled basin may exceed its largest bearing area."""


def capped_table(table: LawTable, material: HalfSpace) -> LawTable:
    """Laws of contacts whose pressure the hardness of the half-space bounds, from a table of
    elastic laws with bearing areas; the table itself without a hardness.

    Notes
    -----
    Each capped contact has the area of an elastic one (`yielding.capped`). The edge of the elastic
    contact is displaced by its approach less the depth at which the unloaded summit has this area;
    the displacement of the capped edge is derived from it. In the limit of a soft body the approach
    is the depth at which the bearing area is the contact area, whatever the law.

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
    """Write the capped laws of the `rows` of a table into `result`, which holds elastic laws."""
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
    """Replace each `area` by the depth at which the unloaded summit has this area; rows ascend.

    `bearing` holds the areas of the unloaded summits above the flats at `depth`; both ascend along
    a row. Between the nodes sqrt(depth) is linear in sqrt(area), as on a cone or a paraboloid.
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
    """Interpolate columns of law tables, given at the approaches of each row, to the nodes.

    Fills `values` (c, n, nodes + 1) from `columns` (c, n, levels), of which the first is the force,
    `reach` (n,) with the last approaches, and `stiffness` (n, nodes + 1) with the slope of the
    force. Force over approach is a cubic in the root of the approach, through the four nearest
    levels. Between two levels that are more than a node apart, or whose forces do not enclose the
    cubic, the force is linear in the approach, as are the other columns. Approaches first get an
    increase of at least `LEAST_RISE` of the `elastic` one.
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
