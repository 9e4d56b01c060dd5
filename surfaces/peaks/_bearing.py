"""Kernel of the bearing areas of profiles."""

from __future__ import annotations

import math

from surfaces.numerics.compiled import compiled

__all__ = ["bearing_areas"]


@compiled()
def bearing_areas(q, t, edge, weight, depths, area):
    """Add the areas above the flats at `depths` (n, levels), rising, to `area`.

    Each ray, of which `weight` is the angle, adds half its squared length up to f = depth; the root
    of f is linear between its nodes.
    """
    last = t.size - 1
    for i in range(depths.shape[0]):
        for k in range(edge.shape[1]):
            end, share = edge[i, k], 0.5 * weight[i, k]
            j, below, above = 0, 0.0, math.sqrt(max(q[i, k, 1], 0.0)) * t[1] * end
            for level in range(depths.shape[1]):
                root = math.sqrt(depths[i, level])
                while j < last and above < root:
                    j, below = j + 1, above
                    if j < last:
                        above = math.sqrt(max(q[i, k, j + 1], 0.0)) * t[j + 1] * end
                r = end
                if j < last:
                    r *= t[j] + (t[j + 1] - t[j]) * (root - below) / max(above - below, 1e-300)
                area[i, level] += share * r * r
