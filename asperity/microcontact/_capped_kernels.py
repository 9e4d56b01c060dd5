"""Kernels of capped laws: from values at the nodes of an elastic law to those of the capped one."""

from __future__ import annotations

import math

from surfaces.numerics.compiled import compiled

__all__ = ["depths_of", "resample"]

LEAST_RISE = 1e-6
"""Rise of an approach over the last, relative, where a capped law would stand still."""

_TINY = 1e-300


@compiled()
def depths_of(bearing, depth, area):
    """Replace the areas of each row, rising, by the depths at which the unloaded summit has them.

    `bearing` holds the areas of the unloaded summits above the flats at `depth`, both rising along
    a row; depth over area is linear in the area between them.
    """
    last = depth.shape[1] - 1
    for i in range(area.shape[0]):
        j = 0
        for k in range(area.shape[1]):
            wanted = area[i, k]
            while j < last - 1 and bearing[i, j + 1] < wanted:
                j += 1
            low, high = bearing[i, j], max(bearing[i, j + 1], _TINY)
            above = depth[i, j + 1] / high
            below = depth[i, j] / low if low > 0.0 else above
            share = (wanted - low) / (high - low) if high > low else 1.0
            area[i, k] = wanted * (below + min(max(share, 0.0), 1.0) * (above - below))


@compiled()
def resample(approach, columns, reach, values, stiffness):
    """Columns of law tables from their values at the approaches of each row, which rise.

    Fills `values` (c, n, nodes + 1) from `columns` (c, n, levels), of which the first is the force,
    `reach` (n,) with the last approaches and `stiffness` (n, nodes + 1) with the slope of the
    force. Between the levels a column over the approach is linear in the root of the approach, and
    the stiffness follows from the forces of four levels.
    """
    levels, nodes = approach.shape[1], values.shape[2] - 1
    for i in range(approach.shape[0]):
        x, force = approach[i], columns[0, i]
        for k in range(1, levels):
            x[k] = max(x[k], x[k - 1] * (1.0 + LEAST_RISE))
        reach[i] = x[levels - 1]
        j = 0
        for node in range(1, nodes + 1):
            at = reach[i] * (node / nodes) ** 2
            while j < levels - 2 and x[j + 1] < at:
                j += 1
            start = math.sqrt(x[j])
            share = max((math.sqrt(at) - start) / (math.sqrt(x[j + 1]) - start), 0.0)
            for c in range(columns.shape[0]):
                low, high = columns[c, i, j] / x[j], columns[c, i, j + 1] / x[j + 1]
                values[c, i, node] = at * (low + share * (high - low))
            first, last = max(j - 1, 0), min(j + 2, levels - 1)
            before = (force[j + 1] - force[first]) / (x[j + 1] - x[first])
            after = (force[last] - force[j]) / (x[last] - x[j])
            stiffness[i, node] = before + share * (after - before)
