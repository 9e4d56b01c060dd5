"""Compiled loops over cell lists: the pairs of near points."""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(inline="always")
def _beside(place, step, count, wrap):
    """Neighbouring line of cells, -1 if there is none or it has been met."""
    if count == 1:
        return 0 if step == 0 else -1
    other = place + step
    if other < 0 or other >= count:
        return (other + count) % count if wrap else -1
    return other


@njit(cache=True, nogil=True)
def most_pairs(start, cells, wrap, rows):
    """Pairs of points in the same or neighbouring cells, for the rows of cells."""
    ncy, ncx = cells
    total = 0
    for cy in range(rows[0], rows[1]):
        for cx in range(ncx):
            home = cy * ncx + cx
            own = start[home + 1] - start[home]
            total += own * (own - 1) // 2
            for oy in range(-1, 2):
                by = _beside(cy, oy, ncy, wrap)
                for ox in range(-1, 2):
                    bx = _beside(cx, ox, ncx, wrap)
                    other = by * ncx + bx
                    if by >= 0 and bx >= 0 and other > home:
                        total += own * (start[other + 1] - start[other])
    return total


@njit(cache=True, nogil=True)
def half_list(y, x, start, cells, size, wrap, cut, rows, k, ptr, col, pair):
    """Pairs of points i < j closer than sqrt(cut) for the rows [rows[0], rows[1]) of cells.

    Points are sorted by cell, bounded by `start`; `size` is the extent (Ly, Lx) and `wrap` says
    whether it repeats. From place k on, fills `col` with j and `pair` with y_i - y_j, x_i - x_j and
    the columns of `far` at r^2; `ptr` (n, 2) bounds the pairs of each i. With empty `col` the pairs
    are counted only. Returns the place after the last.
    """
    ncy, ncx = cells
    fill = col.size > 0
    half_y = 0.5 * size[0] if wrap else math.inf
    half_x = 0.5 * size[1] if wrap else math.inf
    for cy in range(rows[0], rows[1]):
        for cx in range(ncx):
            home = cy * ncx + cx
            for i in range(np.uint64(start[home]), np.uint64(start[home + 1])):
                ptr[i, 0] = k
                for oy in range(-1, 2):
                    by = _beside(cy, oy, ncy, wrap)
                    for ox in range(-1, 2):
                        bx = _beside(cx, ox, ncx, wrap)
                        other = by * ncx + bx
                        if by < 0 or bx < 0 or other < home:
                            continue
                        first = i + np.uint64(1) if other == home else np.uint64(start[other])
                        for j in range(first, np.uint64(start[other + 1])):
                            dy = y[i] - y[j]
                            dx = x[i] - x[j]
                            if abs(dy) > half_y:
                                dy -= math.copysign(size[0], dy)
                            if abs(dx) > half_x:
                                dx -= math.copysign(size[1], dx)
                            if dy * dy + dx * dx >= cut:
                                continue
                            k += 1
                            if not fill:
                                continue
                            e = np.uint64(k - 1)
                            col[e] = j
                            pair[0, e] = dy
                            pair[1, e] = dx
                ptr[i, 1] = k
    return k
