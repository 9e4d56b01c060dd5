"""Compiled loops over near pairs: their lists, by cells, and the tangent matrix.

The matrix diag(1/k + extra) + g_ij(v_i + v_j) of `Tangent`, and the inverse -(1 + G K)^-1 G between
the cells of `TwoLevelPreconditioner` (docs/development/interaction.md).
"""

from __future__ import annotations

import math

import numpy as np
from numba import carray, njit

from surfaces.numerics.compiled import compiled, inner

from ._pair_block_kernels import (
    BLOCK,
    BOTH,
    CAP,
    COLUMNS,
    DX,
    DY,
    FAST,
    INVERSE,
    NEGLIGIBLE,
    NEXT,
    ONE,
    ROOT,
    SKEW,
    TINY,
    VALUE,
    VARIANCE_CAP,
    ZERO,
    floats,
    long_pairs,
    look,
    places,
    set_powers,
    smooth,
    whole_lanes,
)


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


@compiled()
def active_points(active, stiffness, extra, footprint, own, scale, moments, cell, out):
    """The active points, into `out`: of all points their `rank` among these or -1, and in `narrow`
    (2, n) their variance and that times skew, zero where they are not active; their places `index`,
    their variance size (f k)^q with f, q of `footprint`, their own compliance and the diagonal of
    the matrix less its mesh part over `scale`, and their cells `near`. `moments` are size and skew
    of all points."""
    size, skew = moments
    rank, narrow, index, variance, compliance, diagonal, near = out
    factor, exponent = footprint
    f0, f1, f2 = own
    n = 0
    for i in range(active.size):
        rank[i] = -1
        narrow[0, i] = 0.0
        narrow[1, i] = 0.0
        if not active[i]:
            continue
        k = stiffness[i]
        wide = factor * k * factor * k if exponent == 2.0 else (factor * k) ** exponent
        wide *= size[i]
        held = min(wide, VARIANCE_CAP)
        rank[i] = n
        narrow[0, i] = wide
        narrow[1, i] = wide * skew[i]
        index[n] = i
        near[n] = cell[i]
        variance[n] = wide
        compliance[n] = 1.0 / k + (extra[i] if extra.size else 0.0)
        diagonal[n] = compliance[n] / scale - f0 - held * (f1 + 0.25 * held * f2)
        n += 1


@compiled(fastmath=FAST)
def tangent_list(rows, near, rank, variance, skew, form, kernel, tangent):
    """Pairs of active points (rank >= 0) of the rows and their tangent values, from the place of
    the first row on, into `tangent`: bounds, columns and values. `near`, `variance`, `skew`, `form`
    and `kernel` are as for `near_fields`."""
    ptr, col, pair = near
    table, polynomials, beads, power = kernel
    tptr, tcol, tval = tangent
    s = carray(floats(), (COLUMNS * BLOCK,))
    row = carray(places(), (BLOCK,))
    column = carray(places(), (BLOCK,))
    target = carray(places(), (BLOCK,))
    listed = carray(places(), (2, BLOCK))
    away = carray(floats(), (2, BLOCK))
    lack = carray(floats(), (4, BLOCK))
    for k in range(BLOCK):
        row[k], column[k] = 0, 0
        listed[0, k], listed[1, k] = 0, 0
        away[0, k], away[1, k] = ONE, ONE
    dy = s[DY : DY + NEXT]
    dx = s[DX : DX + NEXT]
    a = np.float32(0.5 * power)
    i = np.uint64(rows[0])
    stop = np.uint64(rows[1])
    if i >= stop:
        return
    e = np.uint64(ptr[i, 0])
    place = e
    held = np.uint64(0)
    while i < stop:
        count = np.uint64(0)
        while i < stop and count < BLOCK // 2:
            if rank[i] >= 0:
                here = np.uint64(rank[i])
                if e == np.uint64(ptr[i, 0]):
                    tptr[here, 0] = place
                end = min(np.uint64(ptr[i, 1]), e + NEXT // np.uint64(2))
                for t in range(e, end):
                    j = np.uint64(col[t])
                    tcol[place] = rank[j]
                    row[count] = np.int32(i)
                    column[count] = col[t]
                    s[count + DY] = pair[0, t]
                    s[count + DX] = pair[1, t]
                    kept = np.uint64(rank[j] >= 0)
                    count += kept
                    place += kept
                tptr[here, 1] = place
                e = end
                if e < np.uint64(ptr[i, 1]):
                    continue
            i += np.uint64(1)
            if i < stop:
                e = np.uint64(ptr[i, 0])
        first = place - count
        lanes = whole_lanes(count)
        for k in range(lanes):
            both = variance[np.uint64(row[k])] + variance[np.uint64(column[k])]
            doubt = skew[np.uint64(row[k])] + skew[np.uint64(column[k])]
            reach = dy[k] * dy[k] + dx[k] * dx[k] + both + TINY
            s[k + BOTH] = both
            s[k + ROOT] = reach
            # positive where a pair may differ from a round one by more than NEGLIGIBLE
            s[k + SKEW] = doubt - NEGLIGIBLE * reach
        set_powers(lanes, s, ROOT, power)
        for k in range(lanes):
            ci = min(variance[np.uint64(row[k])], CAP)
            cj = min(variance[np.uint64(column[k])], CAP)
            value, bend, cross, _, _ = smooth(dy[k] * dy[k] + dx[k] * dx[k], polynomials, a)
            w = s[k + BOTH] * s[k + INVERSE]
            near = look(table, 0, w) * s[k + ROOT]
            s[k + VALUE] = near - value - (ci + cj) * bend - ci * cj * cross
        k = np.uint64(0)
        while True:
            while k < count and held < BLOCK:
                tval[first + k] = s[k + VALUE]
                if s[k + SKEW] > ZERO:
                    listed[0, held] = row[k]
                    listed[1, held] = column[k]
                    away[0, held] = dy[k]
                    away[1, held] = dx[k]
                    target[held] = np.int32(first + k)
                    held += np.uint64(1)
                k += np.uint64(1)
            if held == BLOCK or i == stop:
                long_pairs(held, listed, away, variance, form, table, beads, power, lack)
                for q in range(held):
                    if lack[3, q] > NEGLIGIBLE:
                        tval[np.uint64(target[q])] += lack[0, q]
                held = np.uint64(0)
            if k == count:
                break


@compiled()
def near_tangent(rows, tptr, tcol, tval, v, out):
    """Near pairs of the tangent matrix times v, both ways."""
    out[:] = 0.0
    for i in range(np.uint64(rows[0]), np.uint64(rows[1])):
        total = 0.0
        own = v[i]
        for k in range(np.uint64(tptr[i, 0]), np.uint64(tptr[i, 1])):
            j = np.uint64(tcol[k])
            total += tval[k] * v[j]
            out[j] += tval[k] * own
        out[i] += total


@compiled()
def stiffened(coarse, total, row):
    """-(1 + G K)^-1 G of the symmetric G = -`coarse`, in its place, with K = diag(`total`), one
    spring after another; `row` is scratch."""
    count = total.size
    for c in range(count):
        weight = total[c] / (1.0 - total[c] * coarse[c, c])
        for k in range(count):
            row[k] = coarse[c, k]
        for e in range(count):
            share = weight * row[e]
            for k in range(count):
                coarse[e, k] += share * row[k]
