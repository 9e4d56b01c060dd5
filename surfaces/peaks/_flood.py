"""Kernels of the segmentation: steepest ascent, plateaus, basins.

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

FLAT = np.int32(-(2**31))
_ROWS = np.array([-1, -1, -1, 0, 0, 1, 1, 1])  # of the eight neighbors
_COLS = np.array([-1, 0, 1, -1, 1, -1, 0, 1])


@compiled()
def ascend(
    heights, periodic, above, inverse, link, peaks, flats, runs, start, stop, window, way, lows
):
    """Link each flooded pixel of the rows [start, stop) to its steepest higher neighbor.

    `inverse` holds 1/distance to the neighbors above, beside and diagonal. Pixels without a higher
    neighbor are collected: strict peaks in `peaks`, members of plateaus in `flats`. `runs` gets the
    first pixel and the end of each flooded run of a row. The lowest flooded height of each column
    lowers `lows`; `window` (3, nx + 2) and `way` (nx,) are scratch. Returns the three counts.
    """
    ny, nx = heights.shape
    inv_y, inv_x, inv_d = inverse
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
                lows[c] = z if z < lows[c] else lows[c]
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
    return n_peaks, n_flats, n_runs


@inner()
def _beside(p, k, shape, periodic):
    """Neighbor k of pixel p; -1 beyond the border."""
    ny, nx = shape
    row, col = p // nx + _ROWS[k], p % nx + _COLS[k]
    if periodic:
        row, col = row % ny, col % nx
    elif not (0 <= row < ny and 0 <= col < nx):
        return -1
    return row * nx + col


@compiled()
def _spread(flat, shape, periodic, link, queue, at, tail):
    """Link the plateau around the `tail` pixels in the queue towards them, nearest first.

    `at` holds their row and column without wrapping. Returns the pixels in the queue.
    """
    head = 0
    while head < tail:
        p = queue[head]
        for k in range(8):
            q = _beside(p, k, shape, periodic)
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
    peak, at its member nearest to its centroid.
    """
    queue = np.empty(flats.size, np.int64)
    at = np.zeros((flats.size, 2), np.int64)
    found = np.empty(flats.size, np.int64)
    tail = 0
    for p in flats:
        for k in range(8):
            q = _beside(p, k, shape, periodic)
            if q >= 0 and flat[q] == flat[p] and link[q] != FLAT:
                queue[tail] = p
                found[tail] = q
                tail += 1
                break
    for exit_ in range(tail):
        link[queue[exit_]] = -2 - found[exit_]
    _spread(flat, shape, periodic, link, queue, at, tail)
    n_peaks = 0
    for p in flats:
        if link[p] != FLAT:
            continue
        queue[0] = p
        at[0, 0], at[0, 1] = 0, 0
        link[p] = -2 - p
        size = _spread(flat, shape, periodic, link, queue, at, 1)
        row, col = 0.0, 0.0
        for member in range(size):
            row += at[member, 0] / size
            col += at[member, 1] / size
        best, least = 0, np.inf
        for member in range(size):
            link[queue[member]] = FLAT
            away = (at[member, 0] - row) ** 2 + (at[member, 1] - col) ** 2
            if away < least:
                best, least = member, away
        queue[0] = queue[best]
        link[queue[0]] = -2 - queue[0]
        found[n_peaks] = queue[0]
        n_peaks += 1
        _spread(flat, shape, periodic, link, queue, at, 1)
    return found[:n_peaks]


@compiled()
def follow(link, runs):
    """Replace the links of the pixels of all runs by the label at the end of their way up.

    Each pixel takes over what its target holds, forwards and then backwards through the runs: a way
    that turns back at most once is at its end then. The few others are followed pixel by pixel.
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
