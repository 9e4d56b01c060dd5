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
    rows, nodes = np.flatnonzero((table.reach > 0) & (table.force[:, -1] > 0)), table.nodes
    u = np.arange(1, FINER * nodes + 1) / (FINER * nodes)
    elastic = table.reach[rows, None] * np.square(u)
    force, stiffness, area = table.evaluate(rows[:, None], elastic)
    level = area.copy()
    depths_of(table.bearing[rows], table.approach()[rows], level)
    found = capped(elastic, force, area, stiffness, material, level=level)
    columns = [np.maximum.accumulate(found.force, axis=1), area, force]
    if table.centre is not None:
        node = np.arange(FINER * nodes) // FINER
        share = u * nodes - node
        for old in np.moveaxis(table.centre[rows], 2, 0):
            columns.append(found.approach * (old[:, node] * (1 - share) + old[:, node + 1] * share))
    values = np.zeros((len(columns), len(rows), nodes + 1))
    reach, slope = np.zeros(len(rows)), np.zeros((len(rows), nodes + 1))
    resample(elastic, found.approach, np.stack(columns), reach, values, slope)
    places = reach[:, None] * (np.arange(1, nodes + 1) / nodes) ** 2
    result = replace(
        table,
        reach=np.zeros(len(table)),
        bearing=None,
        hardness=material.hardness,
        elastic_force=np.zeros(table.force.shape),
        **{name: np.zeros(table.force.shape) for name in ("force", "stiffness", "area")},
        centre=None if table.centre is None else np.zeros(table.centre.shape),
    )
    assert result.elastic_force is not None
    result.reach[rows], result.stiffness[rows] = reach, slope
    result.force[rows], result.elastic_force[rows] = values[0], values[2]
    result.area[rows] = np.maximum(values[1], values[0] / material.hardness)
    if result.centre is not None:
        result.centre[rows, 1:] = np.moveaxis(values[3:, :, 1:] / places, 0, 2)
    return result
