"""What compiled loops over near pairs share.

Pairs are taken in blocks: what vector instructions can do is done for a whole block, in single
precision, into the columns of a scratch array; sums for rows and columns follow in double
precision.
"""

from __future__ import annotations

import math

import numpy as np
from numba import carray, njit, types

from asperity.halfspace.footprint import PAIR_NODES, SMOOTH_DEGREE
from surfaces.numerics.compiled import QUOTIENTS, inner
from surfaces.numerics.vectors import on_stack, two_floats

BLOCK = 256
"""Pairs of a block."""

COLUMNS = 9
"""Columns of numbers for each block."""

doubles = on_stack(types.float64, 2 * BLOCK)
columns = on_stack(types.float64, COLUMNS * BLOCK)
floats = on_stack(types.float32, COLUMNS * BLOCK)
places = on_stack(types.int32, 2 * BLOCK)

VARIANCE_CAP = 0.35
"""Largest variance over the squared split length that the expansion takes; wider footprints keep
this second moment beyond the cut-off."""
CAP = np.float32(VARIANCE_CAP)

ROUNDEST = np.float32(0.06)
"""Least variance of the round parts of a long footprint over that along it."""
NEGLIGIBLE = np.float32(0.02)
FAST = QUOTIENTS | {"afn"}
ZERO, ONE, HALF = np.float32(0.0), np.float32(1.0), np.float32(0.5)
TINY = np.float32(1e-12)
"""Least R [eta^2]: two summits may lie at one place."""

# columns of the scratch; the last line: for listed pairs
NEXT = np.uint64(BLOCK)
_AT = [np.uint64(column * BLOCK) for column in range(COLUMNS)]
BOTH, ROOT, INVERSE, WIDE, STEEP, FLAT, SKEW, BEND, CROSS = _AT
VALUE, TO_ROW, TO_COLUMN, PULL, PULL_ROW, PULL_COLUMN = _AT[:6]
DY, DX = _AT[3:5]
WIDTH, EY, EX, LONG, OVER, FULL, GY, GX, DIFFERS = _AT


@njit(inline="always")
def whole_lanes(count):
    """Whole vectors of `count` elements; what lies beyond in them is made and not used."""
    return (count + np.uint64(7)) // np.uint64(8) * np.uint64(8)


@njit(inline="always")
def within(place, end):
    """A place in a table; its end for what is no number."""
    place = place if place < end else end
    return place if place > 0 * end else 0 * end


@njit(inline="always")
def look(table, column, w):
    """Column of the table at w in [0, 1], linear between nodes."""
    place = within(w * np.float32(PAIR_NODES), np.float32(PAIR_NODES))
    c = np.int32(place)
    value, rise = two_floats(table, np.uint64(column * (PAIR_NODES + 1) + c))
    return value + (place - np.float32(c)) * rise


@njit(inline="always")
def smooth(r2, polynomials, a):
    """Columns of `smooth_part`, the Laplacians by their shares in the expansion: f, 1/2 and 1/4 of
    the first two Laplacians, f'/r, and 1/2 of the slope of the first over r."""
    u = r2 - polynomials[2, 0]
    edge = polynomials[0, SMOOTH_DEGREE]
    g2 = polynomials[1, SMOOTH_DEGREE]
    for q in range(1, SMOOTH_DEGREE + 1):
        edge = edge * u + polynomials[0, SMOOTH_DEGREE - q]
        g2 = g2 * u + polynomials[1, SMOOTH_DEGREE - q]
    two = np.float32(2.0)
    four = np.float32(4.0)
    g1 = -(r2 * g2 + edge) * (ONE / (a + ONE))
    g0 = (edge - r2 * g1) * (ONE / a)
    bend = -two * (a * g1 + edge)
    cross = four * (a * (a + ONE) * g2 + (ONE - a - r2) * edge)
    return g0, bend, cross, two * g1, -four * (a * g2 - edge)


@inner()
def _graded_powers(count, s, at, power):
    """`set_powers` on graded half-spaces."""
    half = -0.5 * power
    for k in range(at, at + count):
        reach = s[k]
        s[k] = reach**half
        s[k + NEXT] = 1.0 / reach


@njit(inline="always")
def set_powers(count, s, at, power):
    """Replace R in the column `at` of the scratch by R^(-p/2), and the next column by 1/R."""
    if power != 1.0:
        _graded_powers(count, s, at, power)
        return
    for k in range(at, at + count):
        root = ONE / math.sqrt(s[k])
        s[k] = root
        s[k + NEXT] = root * root


@inner(fastmath=FAST)
def long_pairs(count, listed, away, wide, form, table, beads, power, lack):
    """What listed pairs of footprints i, j (2, n), `away` (2, n) from each other, lack for not
    being round, into `lack` (4, n): value, gradient by y and x, and by how much their moments
    differ from round ones over R.

    A Gaussian of moments l1 > l2 is taken as round ones of variance max(l2, `ROUNDEST` l1) at the
    four Gauss nodes of the rest along its long axis, `beads` with their weights: within 3 % of two
    elliptic contacts of 2:1 that touch, 8 % of two of 4:1. Inside each other, where true contacts
    cannot be, long footprints act 10 to 20 % less on each other than ellipses would.
    """
    s = carray(floats(), (COLUMNS * BLOCK,))
    lanes = whole_lanes(count)
    for k in range(lanes):
        both = wide[np.uint64(listed[0, k])] + wide[np.uint64(listed[1, k])]
        s[k + WIDTH] = both
        s[k + LONG] = away[0, k] * away[0, k] + away[1, k] * away[1, k] + both
    set_powers(lanes, s, LONG, power)
    for k in range(lanes):
        i = np.uint64(listed[0, k])
        j = np.uint64(listed[1, k])
        root = s[k + LONG]
        inverse = s[k + OVER]
        w = s[k + WIDTH] * inverse
        pull = look(table, 2, w) * root * inverse
        s[k + FULL] = -look(table, 0, w) * root
        s[k + GY] = -pull * away[0, k]
        s[k + GX] = -pull * away[1, k]
        yy = wide[i] * form[0, i] + wide[j] * form[0, j]
        xx = wide[i] * form[1, i] + wide[j] * form[1, j]
        xy = wide[i] * form[2, i] + wide[j] * form[2, j]
        skew = HALF * (xx - yy)
        turn = math.sqrt(skew * skew + xy * xy)
        large = HALF * (xx + yy) + turn
        width = max(large - turn - turn, ROUNDEST * large)
        reach = math.sqrt(large - width)
        share = HALF * skew / (turn + TINY)
        across = math.sqrt(max(HALF - share, ZERO)) * reach
        s[k + WIDTH] = width
        s[k + EY] = across if xy > ZERO else -across
        s[k + EX] = math.sqrt(max(HALF + share, ZERO)) * reach
        s[k + DIFFERS] = turn * inverse
    for b in range(beads.shape[1]):
        for k in range(lanes):
            by = away[0, k] + beads[0, b] * s[k + EY]
            bx = away[1, k] + beads[0, b] * s[k + EX]
            s[k + LONG] = by * by + bx * bx + s[k + WIDTH]
        set_powers(lanes, s, LONG, power)
        for k in range(lanes):
            root = s[k + LONG]
            inverse = s[k + OVER]
            w = s[k + WIDTH] * inverse
            pull = beads[1, b] * look(table, 2, w) * root * inverse
            s[k + FULL] += beads[1, b] * look(table, 0, w) * root
            s[k + GY] += pull * (away[0, k] + beads[0, b] * s[k + EY])
            s[k + GX] += pull * (away[1, k] + beads[0, b] * s[k + EX])
    for k in range(count):
        lack[0, k] = s[k + FULL]
        lack[1, k] = s[k + GY]
        lack[2, k] = s[k + GX]
        lack[3, k] = s[k + DIFFERS]
