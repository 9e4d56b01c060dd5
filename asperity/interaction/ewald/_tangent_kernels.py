"""Compiled loops over near pairs: the tangent matrix.

The matrix diag(1/k + extra) + g_ij(v_i + v_j) of `Tangent`, and the inverse -(1 + G K)^-1 G between
the cells of `TwoLevelPreconditioner` (docs/development/interaction.md).
"""

from __future__ import annotations

import numpy as np
from numba import carray

from surfaces.numerics.compiled import compiled

from ._pair_block_kernels import (
    BLOCK,
    BOTH,
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
    ZERO,
    floats,
    long_pairs,
    look,
    places,
    set_powers,
    smooth,
    whole_lanes,
)


@compiled()
def active_points(
    active,
    stiffness,
    extra,
    footprint,
    own,
    cap,
    scale,
    size,
    skew,
    cell,
    rank,
    narrow,
    index,
    variance,
    compliance,
    diagonal,
    near,
):
    """The active points: their places `index`, their variance size (f k)^q with f, q of
    `footprint`, their own compliance and the diagonal of the matrix less its mesh part over
    `scale`, and their cells `near`. Of all points their `rank` among these or -1, and in `narrow`
    (2, n) their variance and that times `skew`, zero where they are not active."""
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
        held = min(wide, cap)
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
def tangent_list(
    rows,
    ptr,
    col,
    pair,
    rank,
    variance,
    skew,
    form,
    cap,
    shape,
    far,
    beads,
    power,
    tptr,
    tcol,
    tval,
):
    """Pairs of active points (rank >= 0) of the rows and their tangent values, from the place of
    the first row on; `variance`, `skew` and `form` as for `near_fields`."""
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
    cap = np.float32(cap)
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
            ci = min(variance[np.uint64(row[k])], cap)
            cj = min(variance[np.uint64(column[k])], cap)
            value, bend, cross, _, _ = smooth(dy[k] * dy[k] + dx[k] * dx[k], far, a)
            w = s[k + BOTH] * s[k + INVERSE]
            near = look(shape, 0, w) * s[k + ROOT]
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
                long_pairs(held, listed, away, variance, form, shape, beads, power, lack)
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
def stiffened(far, total, row):
    """-(1 + G K)^-1 G of the symmetric G = -`far`, in its place, with K = diag(`total`), one spring
    after another; `row` is scratch."""
    count = total.size
    for c in range(count):
        weight = total[c] / (1.0 - total[c] * far[c, c])
        for k in range(count):
            row[k] = far[c, k]
        for e in range(count):
            share = weight * row[e]
            for k in range(count):
                far[e, k] += share * row[k]
