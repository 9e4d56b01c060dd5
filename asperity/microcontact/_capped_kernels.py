"""Kernels of capped laws: from values at the nodes of an elastic law to those of the capped one."""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import compiled

from ._ray_kernels import lagrange

__all__ = ["depths_of", "resample"]

LEAST_RISE = 0.05
"""Least growth of a capped approach over that of the elastic one: a paraboloid has 1/2 to 1."""

ROUNDING = 1e-9
"""Relative error of areas: a summit that has filled its basin has none deeper down."""


@compiled()
def depths_of(bearing, depth, area):
    """Replace the areas of each row, rising, by the depths at which the unloaded summit has them.

    `bearing` holds the areas of the unloaded summits above the flats at `depth`, both rising along
    a row; the root of the depth is linear in that of the area between them.
    """
    last = depth.shape[1] - 1
    for i in range(area.shape[0]):
        j = 0
        for k in range(area.shape[1]):
            wanted = area[i, k] * (1.0 - ROUNDING)
            while j < last - 1 and bearing[i, j + 1] < wanted:
                j += 1
            low, high = math.sqrt(bearing[i, j]), math.sqrt(bearing[i, j + 1])
            share = (math.sqrt(wanted) - low) / (high - low) if high > low else 1.0
            start, end = math.sqrt(depth[i, j]), math.sqrt(depth[i, j + 1])
            area[i, k] = (start + min(share, 1.0) * (end - start)) ** 2


@compiled()
def resample(elastic, approach, columns, reach, values, stiffness):
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
