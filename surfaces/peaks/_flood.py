"""Kernels of the segmentation: steepest ascent, plateaus, basins, and passes between basins.

The pointer map ``link`` (int32, flat) holds one number per pixel:

====================  ==========================================================
-1                    not flooded
-2 - j                the steepest way up leads to pixel j
``FLAT``              no way up, but a neighbor of the same height
0, 1, ...             label of the basin
====================  ==========================================================
"""

from __future__ import annotations

import numpy as np

from surfaces.numerics.compiled import compiled, inner
from surfaces.patches import root

FLAT = np.int32(-(2**31))
_ROWS = np.array([-1, -1, -1, 0, 0, 1, 1, 1])  # of the eight neighbors
_COLS = np.array([-1, 0, 1, -1, 1, -1, 0, 1])


@compiled()
def ascend(heights, periodic, above, distances, link, start, stop):
    """Link each flooded pixel of the rows [start, stop) to its steepest higher neighbor.

    `distances` are those to the neighbors above, beside and diagonal. Returns the pixels without a
    higher neighbor, strict peaks and members of plateaus, and of each flooded run of a row the
    first pixel and the end, (runs, 2).
    """
    ny, nx = heights.shape
    inv_y, inv_x, inv_d = 1.0 / distances[0], 1.0 / distances[1], 1.0 / distances[2]
    peaks, flats = np.empty((stop - start) * nx, np.int32), np.empty((stop - start) * nx, np.int32)
    runs = np.empty(((stop - start) * (nx // 2 + 1), 2), np.int32)
    window, way = np.empty((3, nx + 2)), np.empty(nx, np.int32)
    one, two, side, top = np.uint64(1), np.uint64(2), np.int32(1), FLAT + np.int32(1)
    n_peaks = 0
    n_flats = 0
    n_runs = 0
    for i in range(start, stop):
        for k in range(0 if i == start else 2, 3):
            row = i + k - 1
            if periodic:
                row = row + ny if row < 0 else (row - ny if row >= ny else row)
            line = window[(i + k) % 3]
            if 0 <= row < ny:
                for j in range(nx):
                    line[j + 1] = heights[row, j]
                line[0] = heights[row, nx - 1] if periodic else -np.inf
                line[nx + 1] = heights[row, 0] if periodic else -np.inf
            else:
                for j in range(nx + 2):
                    line[j] = -np.inf
        up, down = np.int32(((i - 1) % ny - i) * nx), np.int32(((i + 1) % ny - i) * nx)
        north, here, south = window[i % 3], window[(i + 1) % 3], window[(i + 2) % 3]
        base = i * nx
        j = 0
        while j < nx:
            if not here[j + 1] >= above:
                link[base + j] = -1
                j += 1
                continue
            first = j
            while j < nx and here[j + 1] >= above:
                j += 1
            runs[n_runs, 0] = base + first
            runs[n_runs, 1] = base + j
            n_runs += 1
            for c in range(np.uint64(first), np.uint64(j)):
                z = here[c + one]
                best = (north[c] - z) * inv_d
                on = up - side
                s = (north[c + one] - z) * inv_y
                on = up if s > best else on
                best = s if s > best else best
                s = (north[c + two] - z) * inv_d
                on = up + side if s > best else on
                best = s if s > best else best
                s = (here[c] - z) * inv_x
                on = -side if s > best else on
                best = s if s > best else best
                s = (here[c + two] - z) * inv_x
                on = side if s > best else on
                best = s if s > best else best
                s = (south[c] - z) * inv_d
                on = down - side if s > best else on
                best = s if s > best else best
                s = (south[c + one] - z) * inv_y
                on = down if s > best else on
                best = s if s > best else best
                s = (south[c + two] - z) * inv_d
                on = down + side if s > best else on
                best = s if s > best else best
                on = on if best >= 0.0 else top
                way[c] = on if best != 0.0 else FLAT
            for c in range(first, j):
                link[base + c] = -2 - base - c - way[c]
            if first == 0 and (way[0] + 1) % nx == 0:
                link[base] -= nx
            if j == nx and (way[nx - 1] - 1) % nx == 0:
                link[base + nx - 1] += nx
            for c in range(first, j):
                if way[c] == top:
                    link[base + c] = -2 - base - c
                    peaks[n_peaks] = base + c
                    n_peaks += 1
                elif way[c] == FLAT:
                    link[base + c] = FLAT
                    flats[n_flats] = base + c
                    n_flats += 1
    return peaks[:n_peaks], flats[:n_flats], runs[:n_runs]


@inner()
def beside(p, k, shape, periodic):
    """Neighbor k of pixel p; -1 beyond the border."""
    ny, nx = shape
    row, col = p // nx + _ROWS[k], p % nx + _COLS[k]
    if periodic:
        row, col = row % ny, col % nx
    elif not (0 <= row < ny and 0 <= col < nx):
        return -1
    return row * nx + col


@compiled()
def spread(flat, shape, periodic, link, queue, at, tail):
    """Link the plateau around the `tail` pixels in the queue towards them, nearest first.

    `at` holds their row and column without wrapping. Returns the pixels in the queue.
    """
    head = 0
    while head < tail:
        p = queue[head]
        for k in range(8):
            q = beside(p, k, shape, periodic)
            if q >= 0 and flat[q] == flat[p] and link[q] == FLAT:
                link[q] = -2 - p
                at[tail, 0] = at[head, 0] + _ROWS[k]
                at[tail, 1] = at[head, 1] + _COLS[k]
                queue[tail] = q
                tail += 1
        head += 1
    return tail


@compiled()
def drain_plateaus(flat, shape, periodic, link, flats):
    """Link the pixels of plateaus; return the pixels that stand for plateaus that are peaks.

    A plateau with a way out drains through it, nearest exit first. A plateau without one is one
    peak, at its member nearest to its centroid, of several the one with the highest neighbors.
    """
    queue = np.empty(flats.size, np.int64)
    at = np.zeros((flats.size, 2), np.int64)
    found = np.empty(flats.size, np.int64)
    tail = 0
    for p in flats:
        for k in range(8):
            q = beside(p, k, shape, periodic)
            if q >= 0 and flat[q] == flat[p] and link[q] != FLAT:
                queue[tail] = p
                found[tail] = q
                tail += 1
                break
    for exit_ in range(tail):
        link[queue[exit_]] = -2 - found[exit_]
    spread(flat, shape, periodic, link, queue, at, tail)
    n_peaks = 0
    for p in flats:
        if link[p] != FLAT:
            continue
        queue[0] = p
        at[0, 0], at[0, 1] = 0, 0
        link[p] = -2 - p
        size = spread(flat, shape, periodic, link, queue, at, 1)
        row, col = 0.0, 0.0
        for member in range(size):
            row += at[member, 0] / size
            col += at[member, 1] / size
        best, least, highest = 0, np.inf, -np.inf
        for member in range(size):
            link[queue[member]] = FLAT
            away = (at[member, 0] - row) ** 2 + (at[member, 1] - col) ** 2
            if away > least + 1e-6:
                continue
            around = 0.0
            for k in range(8):
                q = beside(queue[member], k, shape, periodic)
                around += flat[q] if q >= 0 else -np.inf
            if away < least - 1e-6 or around > highest:
                best, least, highest = member, away, around
        queue[0] = queue[best]
        link[queue[0]] = -2 - queue[0]
        found[n_peaks] = queue[0]
        n_peaks += 1
        spread(flat, shape, periodic, link, queue, at, 1)
    return found[:n_peaks]


@compiled()
def follow(link, runs):
    """Replace the links of all pixels of the runs by the label of the peak that they lead to.

    Each pixel copies what its target holds, in one sweep forwards and one backwards through the
    runs: paths that change direction at most once have reached their peak then. The few others are
    followed pixel by pixel.
    """
    count = runs.shape[0]
    for sweep in range(3):
        for k in range(count):
            run = count - 1 - k if sweep == 1 else k
            first, last = runs[run, 0], runs[run, 1]
            for step in range(last - first):
                p = last - 1 - step if sweep == 1 else first + step
                q = link[p]
                if sweep < 2:
                    link[p] = link[-2 - q if q < 0 else p]
                    continue
                while q < 0:
                    q = link[-2 - q]
                link[p] = q


@compiled()
def touching(heights, labels, periodic, counts, runs):
    """Add the pixels of each basin, and find the highest pass between touching basins, in the runs.

    Adds to the `counts` (n,); returns pairs as ``low * n + high`` and their passes. A hash table
    holds the pairs met last; a pair is moved to the list when another needs its place, so that it
    may occur several times. Pixels that may lie on an edge are first marked row by row, without a
    branch.
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
    mixed = np.ones(nx, np.bool_)
    one = np.uint64(1)
    for run in range(runs.shape[0]):
        i = runs[run, 0] // nx
        first, last = runs[run, 0] - i * nx, runs[run, 1] - i * nx
        low = i + 1 if i + 1 < ny else (0 if periodic else i)
        if used + 4 * nx + size > keys.size:
            keys, passes = _doubled(keys, passes, used)
        for j in range(np.uint64(max(first, 1)), np.uint64(min(last, nx - 1))):
            a = labels[i, j]
            mixed[j] = (
                (labels[i, j + one] != a)
                | (labels[low, j - one] != a)
                | (labels[low, j] != a)
                | (labels[low, j + one] != a)
            )
        for j in range(first, last):
            if not mixed[j]:
                continue
            a, z = np.int64(labels[i, j]), heights[i, j]
            west = j - 1 if j > 0 else (nx - 1 if periodic else j)
            east = j + 1 if j + 1 < nx else (0 if periodic else j)
            if labels[i, east] != a or j + 1 == last:
                counts[a] += j + 1 - first
                first = j + 1
            for k in range(4):
                row = i if k == 0 else low
                col = west if k == 1 else (j if k == 2 else east)
                b = np.int64(labels[row, col])
                if b < 0 or b == a:
                    continue
                level = min(z, heights[row, col])
                key = min(a, b) * n + max(a, b)
                mixed_key = np.uint64(key) * np.uint64(0x9E3779B97F4A7C15)
                slot = np.int64(mixed_key >> np.uint64(24)) & (size - 1)
                if held[slot] == key:
                    tops[slot] = max(tops[slot], level)
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
    """Copies of both lists with twice the room."""
    more_keys, more_passes = np.empty(2 * keys.size, np.int64), np.empty(2 * keys.size)
    for k in range(used):
        more_keys[k], more_passes[k] = keys[k], passes[k]
    return more_keys, more_passes


@compiled()
def merge(height, low, high, passes, lowest, min_prominence):
    """Join basins over their passes, highest first.

    Kruskal's maximum spanning tree by union-find. Returns for each peak the height of its saddle
    (the `lowest` if it has none), its parent (the highest peak across the saddle; -1 if none), and
    its keeper, the peak that gets its basin when peaks below `min_prominence` are pruned.
    """
    saddle, parent = np.full(height.size, lowest), np.full(height.size, -1)
    top, keeper = np.arange(height.size), np.arange(height.size)  # the highest of each group first
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
    return saddle, parent, keeper
