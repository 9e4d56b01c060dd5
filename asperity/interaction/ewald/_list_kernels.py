"""Compiled loops over cell lists: the pairs of near points."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from surfaces.numerics.compiled import compiled, inner


@inner()
def _nearest(way, size):
    """A way within half of the size of a cell that repeats."""
    way = way - size if way > 0.5 * size else way
    return way + size if way < -0.5 * size else way


@njit(inline="always")
def _beside(place, step, count, wrap):
    """Neighboring line of cells, -1 if there is none or it has been met."""
    if count == 1:
        return 0 if step == 0 else -1
    other = place + step
    if other < 0 or other >= count:
        return (other + count) % count if wrap else -1
    return other


@compiled()
def by_cell(y, x, size, cells, order, start):
    """Points in the order of their cells, row by row, into `order`; `start` bounds each cell."""
    ncy, ncx = cells
    cell = np.empty(y.size, np.int32)
    start[:] = 0
    for i in range(y.size):
        cy = min(int(y[i] / size[0] * ncy), ncy - 1)
        cx = min(int(x[i] / size[1] * ncx), ncx - 1)
        cell[i] = cy * ncx + cx
        start[cell[i] + 1] += 1
    for c in range(1, start.size):
        start[c] += start[c - 1]
    next_in = start[:-1].copy()
    for i in range(y.size):
        order[next_in[cell[i]]] = i
        next_in[cell[i]] += 1


@compiled()
def half_list(y, x, start, cells, size, wrap, cut, rows, k, ptr, col, pair):
    """Pairs of points i < j closer than sqrt(cut) for the rows [rows[0], rows[1]) of cells.

    Points are sorted by cell, bounded by `start`. `size` is the extent (Ly, Lx) and `wrap` says
    whether it repeats; beyond half of it pairs of further images are listed too, and those of a
    point with its own, of which j = i. From place k on, fills `col` with j, `pair` with y_i - y_j
    and x_i - x_j, and one place more; `ptr` (n, 2) bounds the pairs of each i. With empty `col` the
    pairs are counted only. Returns the place after the last.
    """
    ncy, ncx = cells
    fill = col.size > 0
    high, wide = (size[0], size[1]) if wrap else (math.inf, math.inf)
    far = math.sqrt(cut)
    rows_away = int(far / high + 0.5) if ncy == 1 else 0
    columns_away = int(far / wide + 0.5) if ncx == 1 else 0
    first = np.empty(9, np.int64)
    last = np.empty(9, np.int64)
    for cy in range(rows[0], rows[1]):
        for cx in range(ncx):
            home = cy * ncx + cx
            # points of cells beside each other follow one another
            runs = 0
            for oy in range(-1, 2):
                by = _beside(cy, oy, ncy, wrap)
                for ox in range(-1, 2):
                    bx = _beside(cx, ox, ncx, wrap)
                    other = by * ncx + bx
                    if by < 0 or bx < 0 or other < home or start[other] == start[other + 1]:
                        continue
                    if runs == 0 or last[runs - 1] != start[other]:
                        first[runs] = start[other]
                        runs += 1
                    last[runs - 1] = start[other + 1]
            for i in range(start[home], start[home + 1]):
                ptr[i, 0] = k
                for run in range(runs):
                    for j in range(i + 1 if first[run] == start[home] else first[run], last[run]):
                        dy, dx = _nearest(y[i] - y[j], high), _nearest(x[i] - x[j], wide)
                        if fill:  # the next pair is written over one that is not near
                            col[k], pair[0, k], pair[1, k] = j, dy, dx
                        k += 1 if dy * dy + dx * dx < cut else 0
                    if rows_away + columns_away == 0:
                        continue
                    for j in range(i if first[run] == start[home] else first[run], last[run]):
                        for a in range(-rows_away, rows_away + 1):
                            for b in range(-columns_away, columns_away + 1):
                                # the nearest image is listed, and a point has each image twice
                                if (a == 0 and b == 0) or (i == j and (a, b) < (0, 0)):
                                    continue
                                dy = _nearest(y[i] - y[j], high) + a * size[0]
                                dx = _nearest(x[i] - x[j], wide) + b * size[1]
                                if fill:
                                    col[k], pair[0, k], pair[1, k] = j, dy, dx
                                k += 1 if dy * dy + dx * dx < cut else 0
                ptr[i, 1] = k
    return k
