"""Compiled count of the spots that contacts make."""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(inline="always")
def _share(dy, dx, angle, area, aspect):
    """Radius of an ellipse over the distance, in the direction of a point."""
    c = math.cos(angle)
    s = math.sin(angle)
    along = c * dx + s * dy
    across = c * dy - s * dx
    return math.sqrt(area / (math.pi * (along * along * aspect + across * across / aspect)))


@njit(cache=True, nogil=True)
def spots(pairs, offset, area, angle, aspect):
    """Number of separate spots of the contacts with an `area`; two of a pair that meet are one.

    `offset` (n, 2) is the way y, x from the first to the second of each pair, `angle` the direction
    of the long axis of each contact and `aspect` the ratio of its short axis to the long one.
    """
    parent = np.arange(area.size)
    left = 0
    for i in range(area.size):
        left += area[i] > 0.0
    for k in range(pairs.shape[0]):
        a = pairs[k, 0]
        b = pairs[k, 1]
        if area[a] <= 0.0 or area[b] <= 0.0:
            continue
        dy = offset[k, 0]
        dx = offset[k, 1]
        reach = _share(dy, dx, angle[a], area[a], aspect[a])
        if reach + _share(dy, dx, angle[b], area[b], aspect[b]) < 1.0:
            continue
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        while parent[b] != b:
            parent[b] = parent[parent[b]]
            b = parent[b]
        if a != b:
            parent[max(a, b)] = min(a, b)
            left -= 1
    return left
