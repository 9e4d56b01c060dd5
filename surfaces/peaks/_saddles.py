"""Kernels of the segmentation: passes between touching basins, and what merges over them."""

from __future__ import annotations

import numpy as np

from surfaces.numerics.compiled import compiled, inner
from surfaces.numerics.union_find import root


@compiled()
def touching(heights, labels, periodic, counts, runs):
    """Add the pixels of each basin, and find the highest pass between touching basins, in the runs.

    Adds to the `counts` (n,); returns pairs as ``low * n + high`` and their passes. A pair may
    occur several times: those met last are held in a table where each pair has one place, and
    leave it for the list when another pair needs that place. Nothing branches on where basins
    touch, which is not known in advance: pixels on an edge are collected first, then their pairs, a
    repeated one once.
    """
    ny, nx = heights.shape
    n = counts.size
    size = 1024
    while size < 4 * nx:
        size *= 2
    held = np.zeros(size, np.int64)  # 0 marks a free place: no pair (0, 0) occurs
    tops = np.empty(size)
    used = np.int64(0)
    keys, passes = np.empty(2 * size, np.int64), np.empty(2 * size)
    mixed = np.empty(nx, np.uint8)
    mixed[0] = mixed[nx - 1] = 1
    places = np.empty(nx + 1, np.int64)
    listed = np.empty(4 * nx + 2, np.int64)
    levels = np.empty(4 * nx + 2)
    one = np.uint64(1)
    for run in range(runs.shape[0]):
        i = runs[run, 0] // nx
        first, last = runs[run, 0] - i * nx, runs[run, 1] - i * nx
        low = i + 1 if i + 1 < ny else (0 if periodic else i)
        for j in range(np.uint64(max(first, 1)), np.uint64(min(last, nx - 1))):
            a = labels[i, j]
            mixed[j] = (
                (labels[i, j + one] != a)
                | (labels[low, j - one] != a)
                | (labels[low, j] != a)
                | (labels[low, j + one] != a)
            )
        edges = 0
        for j in range(first, last):
            places[edges] = j
            edges += mixed[j]
        found = 0
        listed[0] = -1
        for edge in range(edges):
            j = places[edge]
            a = np.int64(labels[i, j])
            z = heights[i, j]
            west = j - 1 if j > 0 else (nx - 1 if periodic else j)
            east = j + 1 if j + 1 < nx else (0 if periodic else j)
            ends = (labels[i, east] != a) | (j + 1 == last)
            counts[a] += j + 1 - first if ends else 0
            first = j + 1 if ends else first
            for k in range(4):
                row = i if k == 0 else low
                col = west if k == 1 else (j if k == 2 else east)
                b = np.int64(labels[row, col])
                other = heights[row, col]
                z_pass = z if z < other else other
                key = min(a, b) * n + max(a, b)
                again = key == listed[found]
                place = found if again else found + 1
                top = levels[found] if again else -np.inf
                listed[place] = key
                levels[place] = z_pass if z_pass > top else top
                found = place if (b >= 0) & (b != a) else found
        if used + found + size > keys.size:
            keys, passes = _doubled(keys, passes, used)
        for m in range(1, found + 1):
            key, level = listed[m], levels[m]
            mixed_key = np.uint64(key) * np.uint64(0x9E3779B97F4A7C15)
            slot = np.int64(mixed_key >> np.uint64(24)) & (size - 1)
            if held[slot] == key:
                tops[slot] = level if level > tops[slot] else tops[slot]
                continue
            keys[used], passes[used] = held[slot], tops[slot]
            used += held[slot] != 0
            held[slot], tops[slot] = key, level
    for slot in range(size):
        keys[used], passes[used] = held[slot], tops[slot]
        used += held[slot] != 0
    return keys[:used], passes[:used]


@inner()
def _doubled(keys, passes, used):
    """Copies of both lists, twice as long."""
    more_keys, more_passes = np.empty(2 * keys.size, np.int64), np.empty(2 * keys.size)
    for k in range(used):
        more_keys[k], more_passes[k] = keys[k], passes[k]
    return more_keys, more_passes


@compiled()
def merge(height, low, high, passes, min_prominence, top, keeper, saddle, parent):
    """Join basins over their passes, highest first.

    Fills, but for the highest peak, `saddle` heights and the `parent` of each peak (its saddle's
    higher side), and the peak that keeps each peak's basin when those below `min_prominence` are
    pruned. At first each peak is its own `keeper`, and its own `top`, the highest of its group.
    """
    for e in range(passes.size):
        a, b = root(top, low[e]), root(top, high[e])
        if a == b:
            continue
        if a > b:
            a, b = b, a
        top[b] = a
        saddle[b] = passes[e]
        parent[b] = a
        if height[b] - passes[e] < min_prominence:
            a, b = root(keeper, low[e]), root(keeper, high[e])
            a, b = (a, b) if a < b else (b, a)
            keeper[b] = a
    for peak in range(height.size):
        keeper[peak] = keeper[keeper[peak]]
