"""Compiled loops over near pairs: cell lists, fields and the tangent matrix."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from .footprint import PAIR_NODES

BEADS, SHARES = np.polynomial.hermite_e.hermegauss(4)
SHARES = SHARES / SHARES.sum()
ROUNDEST = 0.1
NEGLIGIBLE = 0.02


@njit(inline="always")
def _beside(place, step, count, wrap):  # type: ignore[no-untyped-def]
    """Neighbouring line of cells, -1 if there is none or it has been met."""
    if count == 1:
        return 0 if step == 0 else -1
    other = place + step
    if other < 0 or other >= count:
        return (other + count) % count if wrap else -1
    return other


@njit(cache=True, nogil=True)
def most_pairs(start, cells, wrap, rows):  # type: ignore[no-untyped-def]
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
def half_list(y, x, start, cells, size, wrap, cut, rows, k, far, far_scale, ptr, col, pair):  # type: ignore[no-untyped-def]
    """Pairs of points i < j closer than sqrt(cut) for the rows [rows[0], rows[1]) of cells.

    Points are sorted by cell, bounded by `start`; `size` is the extent (Ly, Lx) and `wrap` says
    whether it repeats. From place k on, fills `col` with j and `pair` with y_i - y_j, x_i - x_j and
    the columns of `far` at r^2; `ptr` (n, 2) bounds the pairs of each i. With empty `col` the pairs
    are counted only. Returns the place after the last.
    """
    ncy, ncx = cells
    fill = col.size > 0
    last = far.shape[0] - 2
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
                            r2 = dy * dy + dx * dx
                            if r2 >= cut:
                                continue
                            k += 1
                            if not fill:
                                continue
                            e = np.uint64(k - 1)
                            col[e] = j
                            pair[e, 0] = dy
                            pair[e, 1] = dx
                            place = r2 * far_scale
                            c = np.uint64(min(int(place), last))
                            t = place - c
                            for q in range(5):
                                low = far[c, q]
                                pair[e, q + 2] = low + t * (far[c + np.uint64(1), q] - low)
                ptr[i, 1] = k
    return k


@njit(nogil=True)
def _round(r2, both, shape, power):  # type: ignore[no-untyped-def]
    """Kernel of two round footprints, and its slope over the distance by the distance."""
    inverse = 1.0 / (r2 + both)
    w = both * inverse * PAIR_NODES
    c = min(int(w), PAIR_NODES - 1)
    t = w - c
    root = math.sqrt(inverse) if power == 1.0 else inverse ** (0.5 * power)
    value = (shape[c, 0] + t * (shape[c + 1, 0] - shape[c, 0])) * root
    pull = (shape[c, 2] + t * (shape[c + 1, 2] - shape[c, 2])) * root * inverse
    return value, pull


@njit(nogil=True)
def _long(dy, dx, yy, xx, xy, shape, power):  # type: ignore[no-untyped-def]
    """Kernel of two footprints with the sum of moments yy, xx, xy, and its gradient.

    A Gaussian of moments l1 > l2 is taken as round ones of variance max(l2, `ROUNDEST` l1) at the
    four Gauss nodes of the rest along its long axis: within 1 % of the kernel for two contacts of
    2:1 that touch, 8 % for two of 4:1 side by side.
    """
    skew = 0.5 * (xx - yy)
    half = math.sqrt(skew * skew + xy * xy)
    large = 0.5 * (xx + yy) + half
    width = max(large - 2.0 * half, ROUNDEST * large)
    reach = math.sqrt(large - width)
    turn = skew / half
    ex = math.sqrt(max(0.5 * (1.0 + turn), 0.0)) * reach
    ey = math.copysign(math.sqrt(max(0.5 * (1.0 - turn), 0.0)), xy) * reach
    value, gy, gx = 0.0, 0.0, 0.0
    for b in range(BEADS.size):
        by = dy + BEADS[b] * ey
        bx = dx + BEADS[b] * ex
        part, pull = _round(by * by + bx * bx, width, shape, power)
        value += SHARES[b] * part
        gy += SHARES[b] * pull * by
        gx += SHARES[b] * pull * bx
    return value, gy, gx


@njit(nogil=True)
def _differs(yy, xx, xy, reach):  # type: ignore[no-untyped-def]
    """Whether moments differ from round ones by more than a share of r^2 + S^2."""
    limit = NEGLIGIBLE * reach
    return 0.25 * (xx - yy) * (xx - yy) + xy * xy > limit * limit


@njit(cache=True, nogil=True)
def near_fields(  # type: ignore[no-untyped-def]
    rows, force, variance, growth, form, dipole, moves, cap, ptr, col, pair, shape, power, out
):
    """Near pairs of the rows, both ways, into `out` (n, 6): v0, v1, gradient, field of shifts, and
    what v0 lacks for footprints that are not round.

    The energy of the pair (i, j) is F_i F_j N(r; m_i, m_j); v0_i = sum F_j N and
    v1_i = sum F_j dN/dm_i. The smooth part that is subtracted takes variances up to `cap` only,
    as the mesh does. Gradients are those of footprints wider by half the `growth` of both contacts,
    the mean of receiver and source, of moments `form` (n, 3), yy, xx, xy, over their variance.
    They, the field of forces times shifts `dipole` (n, 2) and the last column are made only if
    `moves`.
    """
    nodes = float(shape.shape[0] - 1)
    out[:] = 0.0
    one = np.uint64(1)
    for i in range(np.uint64(rows[0]), np.uint64(rows[1])):
        a0 = 0.0
        a1 = 0.0
        a2 = 0.0
        a3 = 0.0
        a4 = 0.0
        a5 = 0.0
        fi = force[i]
        loaded = fi != 0.0
        mi = variance[i]
        vi = min(mi, cap)
        wi = 1.0 if mi < cap else 0.0
        for k in range(np.uint64(ptr[i, 0]), np.uint64(ptr[i, 1])):
            j = np.uint64(col[k])
            fj = force[j]
            if not loaded and fj == 0.0:
                continue
            mj = variance[j]
            vj = min(mj, cap)
            wj = 1.0 if mj < cap else 0.0
            dy = pair[k, 0]
            dx = pair[k, 1]
            r2 = dy * dy + dx * dx
            both = mi + mj
            inverse = 1.0 / (r2 + both)
            w = both * inverse * nodes
            c = np.uint64(min(int(w), PAIR_NODES - 1))
            t = w - c
            root = math.sqrt(inverse) if power == 1.0 else inverse ** (0.5 * power)
            bend = 0.5 * pair[k, 3]
            cross = 0.25 * pair[k, 4]
            value = (
                (shape[c, 0] + t * (shape[c + one, 0] - shape[c, 0])) * root
                - pair[k, 2]
                - (vi + vj) * bend
                - vi * vj * cross
            )
            slope = (shape[c, 1] + t * (shape[c + one, 1] - shape[c, 1])) * root * inverse
            a0 += fj * value
            a1 += fj * (slope - wi * (bend + vj * cross))
            out[j, 0] += fi * value
            out[j, 1] += fi * (slope - wj * (bend + vi * cross))
            if moves:
                here = mi + 0.5 * growth[i]
                there = mj + 0.5 * growth[j]
                both = here + there
                inverse = 1.0 / (r2 + both)
                w = both * inverse * nodes
                c = np.uint64(min(int(w), PAIR_NODES - 1))
                t = w - c
                root = math.sqrt(inverse) if power == 1.0 else inverse ** (0.5 * power)
                pull = (shape[c, 2] + t * (shape[c + one, 2] - shape[c, 2])) * root * inverse
                gy = pull * dy
                gx = pull * dx
                yy = here * form[i, 0] + there * form[j, 0]
                xx = here * form[i, 1] + there * form[j, 1]
                xy = here * form[i, 2] + there * form[j, 2]
                if _differs(yy, xx, xy, r2 + both):
                    full, gy, gx = _long(dy, dx, yy, xx, xy, shape, power)
                    full -= (shape[c, 0] + t * (shape[c + one, 0] - shape[c, 0])) * root
                    a5 += fj * full
                    out[j, 5] += fi * full
                gy -= pair[k, 5] * dy
                gx -= pair[k, 5] * dx
                bend = 0.5 * pair[k, 6]
                a2 += fj * (gy - vj * bend * dy)
                a3 += fj * (gx - vj * bend * dx)
                a4 -= dipole[j, 0] * gy + dipole[j, 1] * gx
                out[j, 2] -= fi * (gy - vi * bend * dy)
                out[j, 3] -= fi * (gx - vi * bend * dx)
                out[j, 4] += dipole[i, 0] * gy + dipole[i, 1] * gx
        out[i, 0] += a0
        out[i, 1] += a1
        out[i, 2] += a2
        out[i, 3] += a3
        out[i, 4] += a4
        out[i, 5] += a5


@njit(cache=True, nogil=True)
def tangent_list(rows, ptr, col, pair, rank, variance, form, cap, shape, power, tptr, tcol, tval):  # type: ignore[no-untyped-def]
    """Pairs of active points (rank >= 0) of the rows and their tangent values, from the place of
    the first row on; `variance` and the moments `form` (n, 3) run over the active points."""
    nodes = float(shape.shape[0] - 1)
    one = np.uint64(1)
    place = np.uint64(ptr[rows[0], 0]) if rows[1] > rows[0] else np.uint64(0)
    for i in range(np.uint64(rows[0]), np.uint64(rows[1])):
        if rank[i] < 0:
            continue
        here = np.uint64(rank[i])
        mi = variance[here]
        vi = min(mi, cap)
        tptr[here, 0] = place
        for e in range(np.uint64(ptr[i, 0]), np.uint64(ptr[i, 1])):
            other = rank[np.uint64(col[e])]
            if other < 0:
                continue
            there = np.uint64(other)
            mj = variance[there]
            vj = min(mj, cap)
            spread = mi + mj
            reach = pair[e, 0] * pair[e, 0] + pair[e, 1] * pair[e, 1] + spread
            inverse = 1.0 / reach
            w = spread * inverse * nodes
            c = np.uint64(min(int(w), PAIR_NODES - 1))
            root = math.sqrt(inverse) if power == 1.0 else inverse ** (0.5 * power)
            value = (shape[c, 0] + (w - c) * (shape[c + one, 0] - shape[c, 0])) * root
            yy = form[here, 0] + form[there, 0]
            xx = form[here, 1] + form[there, 1]
            xy = form[here, 2] + form[there, 2]
            if _differs(yy, xx, xy, reach):
                value = _long(pair[e, 0], pair[e, 1], yy, xx, xy, shape, power)[0]
            tcol[place] = there
            tval[place] = (
                value - pair[e, 2] - 0.5 * (vi + vj) * pair[e, 3] - 0.25 * vi * vj * pair[e, 4]
            )
            place += one
        tptr[here, 1] = place


@njit(cache=True, nogil=True)
def near_tangent(rows, tptr, tcol, tval, v, out):  # type: ignore[no-untyped-def]
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
