"""Compiled loops over near pairs: displacements and gradients.

Near part of the sum in `Interaction`: g(r; m_i + m_j) less the smooth part and its Laplacians, with
the slopes by the moments and by the distance (docs/development/interaction.md, "Sum over pairs").
"""

from __future__ import annotations

import numpy as np
from numba import carray, njit

from asperity.halfspace.footprint import PAIR_NODES
from surfaces.numerics.compiled import compiled
from surfaces.numerics.vectors import loader, store

from ._pair_block_kernels import (
    BEND,
    BLOCK,
    BOTH,
    CAP,
    COLUMNS,
    CROSS,
    FAST,
    FLAT,
    INVERSE,
    NEGLIGIBLE,
    ONE,
    PULL,
    PULL_COLUMN,
    PULL_ROW,
    ROOT,
    SKEW,
    STEEP,
    TINY,
    TO_COLUMN,
    TO_ROW,
    WIDE,
    ZERO,
    columns,
    doubles,
    floats,
    long_pairs,
    look,
    places,
    set_powers,
    smooth,
    whole_lanes,
    within,
)

PAIRS = BLOCK // 2
"""Pairs of a block."""

# columns of the scratch in double precision
SUM, NEAR, OVER, OWN, OTHER, PART = (np.uint64(column * PAIRS) for column in range(6))
TWO, FOUR = np.uint64(2), np.uint64(4)

# the four numbers of a point lie side by side, so that one instruction reads them all
_record = loader(4)


@njit(inline="always")
def _exact(count, s, d, dy, dx, power):
    """R^(-p/2) and 1/R in double precision, into the columns `NEAR` and `OVER` of `d`: energies are
    compared over steps that single precision does not resolve."""
    if power == 1.0:
        for k in range(count):
            reach = np.float64(dy[k]) * dy[k] + np.float64(dx[k]) * dx[k] + TINY + d[k + SUM]
            root = np.float64(s[k + ROOT])
            root = root * (1.5 - 0.5 * reach * root * root)
            d[k + NEAR] = root
            d[k + OVER] = root * root
    else:
        for k in range(count):
            reach = np.float64(dy[k]) * dy[k] + np.float64(dx[k]) * dx[k] + TINY + d[k + SUM]
            d[k + NEAR] = reach ** (-0.5 * power)
            d[k + OVER] = 1.0 / reach


@njit(inline="always")
def _add_long(count, listed, lack, force, dipole, out):
    """Add what listed pairs lack to both of their points."""
    for k in range(count):
        if lack[3, k] <= NEGLIGIBLE:
            continue
        i = np.uint64(listed[0, k])
        j = np.uint64(listed[1, k])
        fi = force[i]
        fj = force[j]
        full = np.float64(lack[0, k])
        gy = np.float64(lack[1, k])
        gx = np.float64(lack[2, k])
        out[i, 2] += fj * gy
        out[i, 3] += fj * gx
        out[i, 4] -= dipole[j, 0] * gy + dipole[j, 1] * gx
        out[i, 5] += fj * full
        out[j, 2] -= fi * gy
        out[j, 3] -= fi * gx
        out[j, 4] += dipole[i, 0] * gy + dipole[i, 1] * gx
        out[j, 5] += fi * full


@njit(inline="always")
def _fill(i, k, stop, ptr, col, record, row, both, d):
    """Write what the pairs of the block that starts at pair k of row i read of their points: the
    row into `row`, sums of records into `both`, the variances that the mesh knows into the columns
    `OWN` and `OTHER` of `d`. Returns the number of pairs, and the row and pair after the last. A
    block ends before a gap."""
    count = np.uint64(0)
    size = np.uint64(PAIRS)
    while True:
        end = np.uint64(ptr[i, 1])
        take = min(end - k, size - count)
        own = record[i, 3]
        for t in range(count, count + take):
            j = np.uint64(col[k + t - count])
            store(both, FOUR * t, _record(record, FOUR * i) + _record(record, FOUR * j))
            row[t] = np.int32(i)
            d[t + OWN] = own
            d[t + OTHER] = record[j, 3]
        count += take
        k += take
        if k < end:
            return count, i, k
        i += np.uint64(1)
        if i == stop:
            return count, i, k
        k = np.uint64(ptr[i, 0])
        if k != end or count == size:
            return count, i, k


@njit(inline="always")
def _set_sums(count, s, d, both, dy, dx):
    """Sums of two records as columns: variances `SUM` of `d` and `BOTH`, with `ROOT` for R; `WIDE`
    with `STEEP` for R; and `SKEW`, positive where a pair may differ from a round one by more than
    `NEGLIGIBLE`."""
    for k in range(count):
        total = both[FOUR * k]
        d[k + SUM] = total
        s[k + BOTH] = total
        s[k + ROOT] = dy[k] * dy[k] + dx[k] * dx[k] + np.float32(total) + TINY
    for k in range(count):
        wide = np.float32(both[FOUR * k + np.uint64(1)])
        reach = dy[k] * dy[k] + dx[k] * dx[k] + wide + TINY
        s[k + WIDE] = wide
        s[k + STEEP] = reach
        s[k + SKEW] = np.float32(both[FOUR * k + TWO]) - NEGLIGIBLE * reach


@compiled(fastmath=FAST)
def near_fields(rows, force, record, wide, form, dipole, near, kernel, value_table, out):
    """Near pairs of the rows, both ways, into `out` (n, 6): v0, v1, gradient, field of shifts, and
    what v0 lacks for footprints that are not round.

    The energy of the pair (i, j) is F_i F_j N(r; m_i, m_j); v0_i = sum F_j N and
    v1_i = sum F_j dN/dm_i. The smooth part that is subtracted takes variances up to `VARIANCE_CAP`
    only, as the mesh does. `record` (n, 4) holds the variance; that of the footprints of the
    gradients, `wide` in single precision, the mean of receiver and source; by how much these differ
    from round ones; and what the mesh takes of the variance. Moments of the footprints over their
    variance are `form` (3, n), yy, xx, xy; `dipole` (n, 2) are forces times shifts. `near` are
    `NearPairs`, `kernel` is `Interaction.kernel`, its first table in double precision the
    `value_table`.
    """
    ptr, col, pair = near
    table, polynomials, beads, power = kernel
    out[:] = 0.0
    s = carray(floats(), (COLUMNS * BLOCK,))
    d = carray(columns(), (COLUMNS * BLOCK,))
    both = carray(doubles(), (2 * BLOCK,))
    row = carray(places(), (BLOCK,))
    listed = carray(places(), (2, BLOCK))
    away = carray(floats(), (2, BLOCK))
    lack = carray(floats(), (4, BLOCK))
    both[:] = 0.0
    d[:] = 0.0
    for k in range(BLOCK):
        listed[0, k], listed[1, k] = 0, 0
        away[0, k], away[1, k] = ONE, ONE
    a = np.float32(0.5 * power)
    i = np.uint64(rows[0])
    stop = np.uint64(rows[1])
    if i >= stop:
        return
    e = np.uint64(ptr[i, 0])
    held = np.uint64(0)
    while i < stop:
        begin = e
        count, i, e = _fill(i, e, stop, ptr, col, record, row, both, d)
        lanes = whole_lanes(count)
        column = col[begin : begin + lanes]
        dy = pair[0][begin : begin + lanes]
        dx = pair[1][begin : begin + lanes]
        _set_sums(lanes, s, d, both, dy, dx)
        set_powers(lanes, s, ROOT, power)
        _exact(lanes, s, d, dy, dx, power)
        for k in range(lanes):
            ci = np.float32(d[k + OWN])
            cj = np.float32(d[k + OTHER])
            value, bend, cross, pull, turn = smooth(dy[k] * dy[k] + dx[k] * dx[k], polynomials, a)
            inverse = s[k + INVERSE]
            slope = look(table, 1, s[k + BOTH] * inverse) * s[k + ROOT] * inverse
            s[k + TO_ROW] = slope - (bend + cj * cross if ci < CAP else ZERO)
            s[k + TO_COLUMN] = slope - (bend + ci * cross if cj < CAP else ZERO)
            d[k + PART] = value + (d[k + OWN] + d[k + OTHER]) * bend
            d[k + PART] += d[k + OWN] * d[k + OTHER] * cross
            s[k + BEND] = pull
            s[k + CROSS] = turn
        for k in range(lanes):
            place = within(d[k + SUM] * d[k + OVER] * PAIR_NODES, 1.0 * PAIR_NODES)
            c = np.uint64(np.int32(place))
            value = value_table[0, c] + (place - c) * value_table[1, c]
            d[k + NEAR] = value * d[k + NEAR] - d[k + PART]
        set_powers(lanes, s, STEEP, power)
        for k in range(lanes):
            inverse = s[k + FLAT]
            pull = look(table, 2, s[k + WIDE] * inverse) * s[k + STEEP] * inverse - s[k + BEND]
            turn = s[k + CROSS]
            s[k + PULL] = pull
            s[k + PULL_ROW] = pull - np.float32(d[k + OTHER]) * turn
            s[k + PULL_COLUMN] = pull - np.float32(d[k + OWN]) * turn
        k = np.uint64(0)
        while k < count:
            h = np.uint64(row[k])
            last = min(count, np.uint64(ptr[h, 1]) - begin)
            fi = force[h]
            a0, a1, a2, a3, a4 = 0.0, 0.0, 0.0, 0.0, 0.0
            py = dipole[h, 0]
            px = dipole[h, 1]
            for t in range(k, last):
                j = np.uint64(column[t])
                fj = force[j]
                value = d[t + NEAR]
                by = np.float64(dy[t])
                bx = np.float64(dx[t])
                pull = np.float64(s[t + PULL])
                to_row = fj * s[t + PULL_ROW]
                to_column = fi * s[t + PULL_COLUMN]
                a0 += fj * value
                a1 += fj * s[t + TO_ROW]
                a2 += to_row * by
                a3 += to_row * bx
                a4 -= (dipole[j, 0] * by + dipole[j, 1] * bx) * pull
                out[j, 0] += fi * value
                out[j, 1] += fi * s[t + TO_COLUMN]
                out[j, 2] -= to_column * by
                out[j, 3] -= to_column * bx
                out[j, 4] += (py * by + px * bx) * pull
            out[h, 0] += a0
            out[h, 1] += a1
            out[h, 2] += a2
            out[h, 3] += a3
            out[h, 4] += a4
            k = last
        for k in range(count):
            if s[k + SKEW] > ZERO:
                listed[0, held] = row[k]
                listed[1, held] = column[k]
                away[0, held] = dy[k]
                away[1, held] = dx[k]
                held += np.uint64(1)
        if held > BLOCK // 2 or i == stop:
            long_pairs(held, listed, away, wide, form, table, beads, power, lack)
            _add_long(held, listed, lack, force, dipole, out)
            held = np.uint64(0)
