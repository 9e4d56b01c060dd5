"""Law tables of contacts whose pressure a hardness bounds."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ._capped_kernels import depths_of, resample
from .yielding import capped

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace

    from .law_table import LawTable

__all__ = ["capped_table"]

Array = NDArray[np.float64]

FINER = 2
"""Elastic approaches, over the nodes of a table, of which the capped contacts are found first."""

BEYOND = 0.1
"""Further approach, over the reach, that tells how a filled basin bears more: at the hardness it
bears none."""

LEAST_YIELD = 1e-4
"""Loss of force, relative, from which on a law is changed: sharp tips always yield a little."""


def capped_table(table: LawTable, material: HalfSpace) -> LawTable:
    """The laws of contacts whose pressure the hardness of a half-space bounds, from elastic ones.

    Parameters
    ----------
    table
        Elastic laws, with their bearing areas.
    material
        Half-space; without a hardness the table is returned as it is.

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
    assert table.bearing is not None
    centre = None if table.centre is None else table.centre.copy()
    result = replace(
        table,
        reach=table.reach.copy(),
        force=table.force.copy(),
        stiffness=table.stiffness.copy(),
        area=table.area.copy(),
        centre=centre,
        bearing=None,
        elastic=np.stack((np.ones(table.force.shape), table.stiffness), axis=2),
        hardness=material.hardness,
    )
    rows, nodes = np.flatnonzero((table.reach > 0) & (table.force[:, -1] > 0)), table.nodes
    u = np.arange(1, FINER * nodes + 1) / (FINER * nodes)
    elastic = table.reach[rows, None] * np.square(u)
    force, stiffness, area = table.evaluate(rows[:, None], elastic)
    level = area.copy()
    depths_of(table.bearing[rows], table.approach()[rows], level)
    found = capped(elastic, force, area, stiffness, material, level=level)
    late = np.flatnonzero((found.force < (1.0 - LEAST_YIELD) * force).any(axis=1))
    if not late.size:
        return result
    rows, approach = rows[late], found.approach[late]
    columns = [np.maximum.accumulate(found.force[late], axis=1), area[late], stiffness[late]]
    columns.append(columns[0] / force[late] * approach)
    if centre is not None:
        node = np.arange(FINER * nodes) // FINER
        share = u * nodes - node
        for old in np.moveaxis(centre[rows], 2, 0):
            columns.append(approach * (old[:, node] * (1 - share) + old[:, node + 1] * share))
    values = np.zeros((len(columns), len(rows), nodes + 1))
    reach, slope = np.zeros(len(rows)), np.zeros((len(rows), nodes + 1))
    resample(elastic[late], approach, np.stack(columns), reach, values, slope)
    over = BEYOND * table.reach[rows]
    deeper = table.reach[rows] + over
    force, stiffness, area = table.evaluate(rows, deeper)
    filled = capped(deeper, force, area, stiffness, material, level=level[late, -1])
    slope[:, -1] = np.minimum(slope[:, -1], (filled.force - found.force[late, -1]) / over)
    result.reach[rows], result.force[rows], result.stiffness[rows] = reach, values[0], slope
    result.area[rows] = np.maximum(values[1], values[0] / material.hardness)
    places = reach[:, None] * (np.arange(1, nodes + 1) / nodes) ** 2
    assert result.elastic is not None
    result.elastic[rows, 1:, 0] = values[3, :, 1:] / places
    result.elastic[rows, :, 1] = values[2]
    if centre is not None:
        centre[rows, 1:] = np.moveaxis(values[4:, :, 1:] / places, 0, 2)
    return result
