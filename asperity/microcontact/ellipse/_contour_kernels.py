"""Compiled loops of the displaced contour about the best ellipse, for eight profiles at once.

On an ellipse under the approach d the pressure has the edge amplitude P(t) of the displacement
d - f, t the parameter of the ellipse, and Q(t) = -dP/d(ln size). The contour rho = 1 + x has
x = P/Q, up to the edge of the basin (docs/development/laws.md, "ellipse").

Units inside: one length and one height per profile, modulus 1. The contour has nodes on the four
mirror images of a quarter of the ellipse. Arrays are groups of eight numbers, one per profile
(`surfaces.numerics.lanes`); where each profile reads a table row of its own, a group is a quarter
of its contour.
"""

from __future__ import annotations

import numpy as np

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.lanes import (
    LANES,
    add,
    between,
    least,
    load,
    most,
    pick,
    splat,
    store,
    transpose,
)
from surfaces.numerics.vectors import absolute, root, where, whole

from ._fit_kernels import TERMS, mirrored
from .ellipse_operator import DEGREE, parity_of

NODES = DEGREE + 1
MODES = DEGREE // 2 + 1
"""Nodes on a quarter of the ellipse, and even modes: constants, so that the loops unroll."""

FORMS = 4
"""Groups that hold the second-order forms."""

QUARTERS = (TERMS + 1) * NODES
"""Numbers at the beginning of a row of `ellipse_tables` that belong to nodes of a quarter."""

WIDTH = TERMS + 2 + FORMS
"""Groups in a row of the tables: edge amplitudes of each monomial, and quadrature weights, at the
nodes of a quarter; amplitude of the displacement 1 and stiffness of the unit punch; the
second-order forms."""

FIELDS = 10
"""Groups of one profile that `amplitudes` makes from its row."""

_T = np.arange(NODES) * np.pi / (2 * DEGREE)
_COS, _SIN = np.cos(_T), np.sin(_T)
_SHARE = np.ones(NODES)
_SHARE[[0, DEGREE]] = 0.5

_SHARE /= 4 * DEGREE
"""Weight of a node in the mean over the parameter of the ellipse."""

_EVEN = 2 * np.outer(np.arange(MODES), _T)
_ODD = _EVEN + _T
_FOURIER = 2 * _SHARE * np.stack([np.cos(_EVEN), np.sin(_ODD + _T), np.cos(_ODD), np.sin(_ODD)])
_FOURIER[0, 0] *= 0.5
"""Weights of the nodes in the Fourier modes of each parity class, [class, mode, node]. Those of the
last mode are used in the even class alone."""

_CLASS = parity_of(DEGREE)
_MEMBERS = np.concatenate([np.flatnonzero(_CLASS == c) for c in range(4)])
_BEGIN = np.searchsorted(np.sort(_CLASS), np.arange(5))


@inner(fastmath=QUOTIENTS)
def amplitudes(values, rows, number, own, fields):
    """P and Q at the nodes of a quarter of the ellipse, from the row of the tables of each profile.

    `values` are f - d and its derivative with ln(size), by monomials. The groups 8 f + q of
    `fields` hold at node q: f = 0 to 3 the amplitude P in the four parity classes, 4 to 7 Q, 8 the
    quadrature weight; groups 72 and 73 hold the amplitude of the displacement 1 and the stiffness
    of the unit punch.
    """
    for n in range(LANES):
        row = int(number[n]) * WIDTH
        for c in range(4):
            P, Q = splat(0.0), splat(0.0)
            for k in range(_BEGIN[c], _BEGIN[c + 1]):
                r = _MEMBERS[k]
                e = load(rows, row + r)
                P -= values[r * LANES + n] * e
                Q += values[(TERMS + r) * LANES + n] * e
            store(own, n * FIELDS + c, P)
            store(own, n * FIELDS + 4 + c, Q)
        store(own, n * FIELDS + 8, load(rows, row + TERMS))
        store(own, n * FIELDS + 9, load(rows, row + TERMS + 1))
    for f in range(FIELDS):
        transpose(own, f, FIELDS, fields, f * LANES, 1)


@inner(fastmath=QUOTIENTS)
def limits(edge, rays, stretch, x0, y0, tc, ts, a, b, mask, limit):
    """Displacements x at which the nodes reach the edge of the basin, which is linear between the
    rays; no limit where `mask` is false."""
    for c in range(4):
        for q in range(NODES):
            px, py = a * (_COS[q] if c % 3 == 0 else -_COS[q]), b * (_SIN[q] if c < 2 else -_SIN[q])
            gx, gy = x0 + tc * px - ts * py, y0 + ts * px + tc * py
            turn = between(place(gx, stretch * gy, rays), splat(0.0), splat(1.0 * rays))
            lower = whole(turn)
            u = turn - lower
            lower = where(lower < rays, lower, 0.0)
            upper = where(lower + 1.0 < rays, lower + 1.0, 0.0)
            near, far = pick(edge, lower), pick(edge, upper)
            length = near + u * (far - near)
            displacement = length / root(gx * gx + gy * gy) - 1.0
            store(limit, c * NODES + q, where(mask, displacement, 1e300))


@inner(fastmath=QUOTIENTS)
def _displaced(P, Q, limit):
    """Displacement x = P/Q up to its limit, and 1 where the limit is not reached, else 0."""
    x = P / Q
    return least(x, limit), where(x <= limit, splat(1.0), 0.0)


@inner(fastmath=QUOTIENTS)
def displace(fields, limit, X, system, vector):
    """Displacements x of the contour, and the Newton system of the five parameters of the ellipse.

    The parameters change the contour by g = cos^2 t, sin^2 t (logarithms of the semi-axes),
    sin 2t (turn), cos t, sin t (centre). The Newton step fits x by sum_i s_i g_i:
    `system` = sum w Q g_i g_j, `vector` = sum w Q x g_i over the nodes, of quadrature weights w.

    Returns sum w (P x - Q x^2/2), which gives the force in second order; sum w x, which gives the
    stiffness in first order; sum w; sum w P; sum w over the free nodes; the largest |x|; the mean
    of (1 + x)^2, and of 1 + x over the free nodes.
    """
    average = splat(0.0)
    for q in range(NODES):
        average += load(fields, 4 * LANES + q)
    floor = average * (0.15 / NODES)
    gain, shift, total, push = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    free, widest, contour, slide = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for i in range(25):
        store(system, i, splat(0.0))
    for i in range(5):
        store(vector, i, splat(0.0))
    for q in range(NODES):
        w = 0.25 * load(fields, 8 * LANES + q)
        cq, sq = _COS[q], _SIN[q]
        cc, ss, dq = cq * cq, sq * sq, 2 * cq * sq
        e, o = load(fields, q), load(fields, LANES + q)
        x, y = load(fields, 2 * LANES + q), load(fields, 3 * LANES + q)
        p0, p3, p1, p2 = mirrored(e, o, x, y)
        e, o = load(fields, 4 * LANES + q), load(fields, 5 * LANES + q)
        x, y = load(fields, 6 * LANES + q), load(fields, 7 * LANES + q)
        q0, q3, q1, q2 = mirrored(e, o, x, y)
        q0, q1, q2, q3 = most(q0, floor), most(q1, floor), most(q2, floor), most(q3, floor)
        x0, f0 = _displaced(p0, q0, load(limit, q))
        x1, f1 = _displaced(p1, q1, load(limit, NODES + q))
        x2, f2 = _displaced(p2, q2, load(limit, 2 * NODES + q))
        x3, f3 = _displaced(p3, q3, load(limit, 3 * NODES + q))
        widest = most(most(absolute(x0), absolute(x1)), widest)
        widest = most(most(absolute(x2), absolute(x3)), widest)
        x0, x1 = most(x0, splat(-0.9)), most(x1, splat(-0.9))
        x2, x3 = most(x2, splat(-0.9)), most(x3, splat(-0.9))
        store(X, q, x0)
        store(X, NODES + q, x1)
        store(X, 2 * NODES + q, x2)
        store(X, 3 * NODES + q, x3)
        total += 4.0 * w
        push += w * (p0 + p1 + p2 + p3)
        shift += w * (x0 + x1 + x2 + x3)
        free += w * (f0 + f1 + f2 + f3)
        q0, q1, q2, q3 = w * q0, w * q1, w * q2, w * q3
        e, o, x, y = mirrored(q0, q1, q2, q3)
        add(system, 0, cc * cc * e)
        add(system, 1, cc * ss * e)
        add(system, 6, ss * ss * e)
        add(system, 12, dq * dq * e)
        add(system, 18, cc * e)
        add(system, 24, ss * e)
        add(system, 2, cc * dq * o)
        add(system, 7, ss * dq * o)
        add(system, 19, cq * sq * o)
        add(system, 3, cc * cq * x)
        add(system, 8, ss * cq * x)
        add(system, 14, dq * sq * x)
        add(system, 4, cc * sq * y)
        add(system, 9, ss * sq * y)
        add(system, 13, dq * cq * y)
        q0, q1, q2, q3 = q0 * x0, q1 * x1, q2 * x2, q3 * x3
        gain += w * (p0 * x0 + p1 * x1 + p2 * x2 + p3 * x3)
        gain -= 0.5 * (q0 * x0 + q1 * x1 + q2 * x2 + q3 * x3)
        e, o, x, y = mirrored(q0, q1, q2, q3)
        add(vector, 0, cc * e)
        add(vector, 1, ss * e)
        add(vector, 2, dq * o)
        add(vector, 3, cq * x)
        add(vector, 4, sq * y)
        x0, x1, x2, x3 = x0 + 1.0, x1 + 1.0, x2 + 1.0, x3 + 1.0
        contour += _SHARE[q] * (x0 * x0 + x1 * x1 + x2 * x2 + x3 * x3)
        slide += _SHARE[q] * (x0 * f0 + x1 * f1 + x2 * f2 + x3 * f3)
    return gain, shift, total, push, free, widest, contour, slide


@compiled(fastmath=QUOTIENTS)
def solve(matrix, vector):
    """Gaussian elimination in place of a positive system of five; upper triangle given."""
    n = 5
    for i in range(n):
        pivot = 1.0 / load(matrix, n * i + i)
        store(matrix, n * i + i, pivot)
        for r in range(i + 1, n):
            f = load(matrix, n * i + r) * pivot
            for c in range(r, n):
                store(matrix, n * r + c, load(matrix, n * r + c) - f * load(matrix, n * i + c))
            store(vector, r, load(vector, r) - f * load(vector, i))
    for i in range(n - 1, -1, -1):
        v = load(vector, i)
        for c in range(i + 1, n):
            v -= load(matrix, n * i + c) * load(vector, c)
        store(vector, i, v * load(matrix, n * i + i))


@inner(fastmath=QUOTIENTS)
def second_order(X, rows, number, own, forms):
    """Second-order stiffness sum S_ij x_i x_j of the displaced contour, over the parity classes:
    x_i are its Fourier coefficients, S the forms of `ellipse_operator`."""
    for n in range(LANES):
        for k in range(FORMS):
            store(own, n * FORMS + k, load(rows, int(number[n]) * WIDTH + TERMS + 2 + k))
    for k in range(FORMS):
        transpose(own, k, FORMS, forms, k * LANES, 1)
    for i in range(4 * MODES):
        store(own, i, splat(0.0))
    for q in range(NODES):
        x0, x1 = load(X, q), load(X, NODES + q)
        x2, x3 = load(X, 2 * NODES + q), load(X, 3 * NODES + q)
        for c, part in enumerate(mirrored(x0, x1, x2, x3)):
            for i in range(MODES):
                add(own, c * MODES + i, _FOURIER[c, i, q] * part)
    second, r = splat(0.0), 0
    for c in range(4):
        modes = MODES if c == 0 else MODES - 1
        for i in range(modes):
            for j in range(i, modes):
                second += load(forms, r) * load(own, c * MODES + i) * load(own, c * MODES + j)
                r += 1
    return second


@inner(fastmath=QUOTIENTS)
def place(x, y, rays):
    """Angle of (x, y) in steps of `rays` equispaced rays, by a polynomial for the arctangent whose
    error is 5e-5 of a quarter turn."""
    ax, ay = absolute(x), absolute(y)
    z = ay / most(ax + ay, splat(1e-300)) - 0.5
    q = z * z
    turn = 1.27223736 + q * (-1.6356908 + q * (2.97934497 - q * 3.17613357))
    turn = (0.25 * rays) * (0.5 + z * turn)
    turn = where(x < 0.0, 0.5 * rays - turn, turn)
    return where(y < 0.0, rays - turn, turn)
