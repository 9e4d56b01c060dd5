"""Compiled count of the groups that pairs join."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def groups(count, first, second, joined):  # type: ignore[no-untyped-def]
    """Number of groups of `count` things of which the `joined` pairs belong together."""
    parent = np.arange(count)
    left = count
    for k in range(first.size):
        if not joined[k]:
            continue
        a = first[k]
        b = second[k]
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
