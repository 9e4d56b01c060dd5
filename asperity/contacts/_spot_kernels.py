"""Compiled count of separate contact spots."""

from __future__ import annotations

import numpy as np

from surfaces.numerics.compiled import compiled
from surfaces.numerics.union_find import root


@compiled()
def spots(pairs, depth, approach, area):
    """Number of separate spots of the contacts with an `area`; two that have joined are one.

    A pair (n, 2) has joined where the sum of its `approach` is above its `depth` (n,).
    """
    parent = np.empty(area.size, np.int64)
    left = 0
    for i in range(area.size):
        parent[i] = i
        left += area[i] > 0.0
    for k in range(pairs.shape[0]):
        a = pairs[k, 0]
        b = pairs[k, 1]
        if area[a] <= 0.0 or area[b] <= 0.0 or approach[a] + approach[b] <= depth[k]:
            continue
        a, b = root(parent, a), root(parent, b)
        if a != b:
            parent[max(a, b)] = min(a, b)
            left -= 1
    return left
