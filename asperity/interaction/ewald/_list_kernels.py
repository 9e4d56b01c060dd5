"""Compiled loops over cell lists: the pairs of near points.

Several points are looked at together; what is kept of them is written without gaps.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from surfaces.numerics.compiled import compiled, inner
from surfaces.numerics.vectors import compress, count, loader, multiply_add, splatter, where

LANES = 8
"""Points that are looked at together."""

_NUMBERS = np.arange(float(LANES))

_load, _splat = loader(LANES), splatter(LANES)


@inner(forceinline=True)
def _nearest(way, size):
    """A way within half of the size of a cell that repeats."""
    way = where(way > 0.5 * size, way - size, way)
    return where(way < -0.5 * size, way + size, way)


@inner(forceinline=True)
def keep_near(y, x, first, last, here, size, cut, col, dy, dx, place):
    """Points from `first` on, up to eight and before `last`, closer than sqrt(cut) to a place.

    Writes their numbers and `here` (y, x) less their places y, x, less what brings these within
    half of `size` (y, x), to `col`, `dy` and `dx` from element `place` on, and zeros behind them
    up to eight elements in all. Returns their number.
    `y` and `x` are read up to seven elements beyond the last.
    """
    way_y = _nearest(_splat(here[0]) - _load(y, first), size[0])
    way_x = _nearest(_splat(here[1]) - _load(x, first), size[1])
    numbers = _load(_NUMBERS, 0) + float(first)
    near = (multiply_add(way_y, way_y, way_x * way_x) < cut) & (numbers < float(last))
    compress(col, place, numbers, near)
    compress(dy, place, way_y, near)
    compress(dx, place, way_x, near)
    return count(near)


@njit(inline="always")
def _beside(place, step, count, wrap):
    """Neighbouring line of cells, -1 if there is none or it has been met."""
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

    Points are sorted by cell, bounded by `start`; `y` and `x` are longer by `LANES`. `size` is the
    extent (Ly, Lx) and `wrap` says whether it repeats. From place k on, fills `col` with j and
    `pair` with y_i - y_j and x_i - x_j; `ptr` (n, 2) bounds the pairs of each i. With empty `col`
    the pairs are counted only. Returns the place after the last.
    """
    ncy, ncx = cells
    fill = col.size > 0
    kept = col if fill else np.empty(LANES, np.int32)
    away = pair if fill else np.empty((2, LANES), np.float32)
    period = (size[0], size[1]) if wrap else (math.inf, math.inf)
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
                here = (y[i], x[i])
                for run in range(runs):
                    j = i + 1 if first[run] == start[home] else first[run]
                    while j < last[run]:
                        e = k if fill else 0
                        k += keep_near(
                            y, x, j, last[run], here, period, cut, kept, away[0], away[1], e
                        )
                        j += LANES
                ptr[i, 1] = k
    return k
