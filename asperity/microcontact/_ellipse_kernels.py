"""Numba kernels of the contact law about the optimal ellipse.

Units inside: one length and one height per profile, modulus 1. Coefficient vectors run over the
monomials x**i y**j of `ellipse_tables.monomials`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from .ellipse_tables import DEGREE

TERMS = (DEGREE + 1) * (DEGREE + 2) // 2
NODES = DEGREE + 1
"""Monomials, and nodes on a quarter of the ellipse: constants, so that the loops unroll."""

FAST = {"contract", "reassoc", "nsz", "arcp"}

WIDEST, SHARE, CONFINED = 0.5, 0.05, 0.5
"""Limits of trust: displacement of the contour, share of F2, confined share of the contour."""

STATES = 10
"""Numbers kept per level: force, stiffness of the first-order contour and its change with a
uniform displacement, areas of the ellipse and of the contour and the change of the latter,
largest displacement, share of F2, confined share, trust (1 or 0)."""


@njit(cache=True, fastmath=FAST, nogil=True)
def move(source, x0, y0, turn, out):
    """Coefficients about (x0, y0) in axes turned by `turn`, by Taylor shifts and three shears."""
    degree = DEGREE
    for r in range(TERMS):
        out[r] = source[r]
    if x0 != 0.0:
        for j in range(degree + 1):
            top = degree - j
            for p in range(top):
                for i in range(top - 1, p - 1, -1):
                    k = i + j
                    out[k * (k + 1) // 2 + j] += x0 * out[(k + 1) * (k + 2) // 2 + j]
    if y0 != 0.0:
        for i in range(degree + 1):
            top = degree - i
            for p in range(top):
                for j in range(top - 1, p - 1, -1):
                    k = i + j
                    out[k * (k + 1) // 2 + j] += y0 * out[(k + 1) * (k + 2) // 2 + j + 1]
    if turn == 0.0:
        return
    s, t = math.sin(turn), -math.tan(0.5 * turn)
    for k in range(1, degree + 1):
        o = k * (k + 1) // 2
        for shear in range(3):
            if shear == 1:
                for p in range(k):
                    for j in range(k - 1, p - 1, -1):
                        out[o + j] += s * out[o + j + 1]
            else:
                for p in range(k):
                    for i in range(k - 1, p - 1, -1):
                        out[o + k - i] += t * out[o + k - i - 1]


@njit(cache=True, fastmath=FAST, nogil=True)
def _row(rows, start, step, position, out):
    """Row of the tables at a logarithm of the axis ratio, by local cubics."""
    x = (position - start) / step
    x = min(max(x, 1.0), rows.shape[0] - 2.001)
    i = int(x)
    u = x - i
    w0 = -u * (u - 1) * (u - 2) / 6
    w1 = (u + 1) * (u - 1) * (u - 2) / 2
    w2 = -(u + 1) * u * (u - 2) / 2
    w3 = (u + 1) * u * (u - 1) / 6
    for n in range(out.size):
        out[n] = w0 * rows[i - 1, n] + w1 * rows[i, n] + w2 * rows[i + 1, n] + w3 * rows[i + 2, n]


@njit(cache=True, fastmath=FAST, nogil=True)
def _solve(matrix, vector):
    """Gaussian elimination in place of a small positive system."""
    n = 5
    for i in range(n):
        pivot = 1.0 / matrix[i, i]
        for r in range(i + 1, n):
            f = matrix[r, i] * pivot
            for c in range(i, n):
                matrix[r, c] -= f * matrix[i, c]
            vector[r] -= f * vector[i]
    for i in range(n - 1, -1, -1):
        v = vector[i]
        for c in range(i + 1, n):
            v -= matrix[i, c] * vector[c]
        vector[i] = v / matrix[i, i]


@njit(cache=True, fastmath=FAST, nogil=True)
def _edge_radius(edge, stretch, offset, x, y):
    """Ray length to the basin edge towards (x, y), linear in the stretched angle.

    The arctangent is a polynomial, right to 1e-4 of a step between rays.
    """
    n = edge.size
    y *= stretch
    ax, ay = abs(x), abs(y)
    t = min(ax, ay) / max(max(ax, ay), 1e-300)
    q = t * t
    turn = 0.99997726 + q * (-0.33262347 + q * (0.19354346 + q * (-0.11643287 + q * 0.05265332)))
    turn = t * (turn - 0.01172120 * q * q * q * q * q)
    if ay > ax:
        turn = 0.5 * math.pi - turn
    if x < 0.0:
        turn = math.pi - turn
    if y < 0.0:
        turn = 2 * math.pi - turn
    position = turn * (n / (2 * math.pi)) - offset
    lower = math.floor(position)
    u = position - lower
    i = int(lower) % n
    return edge[i] + u * (edge[(i + 1) % n] - edge[i])


@njit(cache=True, fastmath=FAST, nogil=True, inline="always")
def _mirrored(a, b, c, d):
    """Sums over the mirror images: even, odd in both, odd in x, odd in y."""
    return a + b + c + d, a - b + c - d, a - b - c + d, a + b - c - d


@njit(cache=True, fastmath=FAST, nogil=True)
def march(
    begin, end, all_coefs, all_sizes, all_edges, all_stretches, offset, levels, most, stop, m,
    rows, start, step, moments, parity, nodes, all_states, all_shapes,
):  # fmt: skip
    """Follow the profiles [begin, end) through the approaches levels**2.

    Fills states (n, levels, STATES) and shapes (n, levels, 5 + 4 nodes): semi-axes, centre, turn
    and displacements of the contour. `most` Newton steps at most before the first trusted level;
    `stop` ends a profile after the last;
    without it every level is iterated to rest.
    """
    n, nq, degree = TERMS, NODES, DEGREE
    around = 4.0 * (nq - 1)
    ct, st, s2 = np.cos(nodes), np.sin(nodes), np.sin(2 * nodes)
    modes = degree // 2 + 1
    cosine = np.empty((degree + 1, nq))
    sine = np.empty((degree + 1, nq))
    for k in range(degree + 1):
        for q in range(nq):
            cosine[k, q] = math.cos(k * nodes[q])
            sine[k, q] = math.sin(k * nodes[q])
    local = np.empty(n)
    mixed = np.empty(n)
    row = np.empty(rows.shape[1])
    o_w, o_k = n * nq, n * nq + nq
    P, Q, X = np.empty((4, nq)), np.empty((4, nq)), np.empty((4, nq))
    free = np.empty((4, nq))
    fourier = np.zeros((4, modes))
    H, g = np.empty((5, 5)), np.empty(5)
    pa, pb = np.empty(degree + 1), np.empty(degree + 1)
    before, slope = np.zeros(5), np.zeros(5)
    sx = np.array([1.0, -1.0, -1.0, 1.0])
    sy = np.array([1.0, 1.0, -1.0, -1.0])
    for profile in range(begin, end):
        fit, sizes, edge = all_coefs[profile], all_sizes[profile], all_edges[profile]
        state, shape, stretch = all_states[profile], all_shapes[profile], all_stretches[profile]
        still = 1e-3 if stop else 1e-10
        smallest = 1e300
        for p in range(edge.size):
            smallest = min(smallest, edge[p])
        fits = sizes.size

        a2, b2 = fit[fits - 1, 3], fit[fits - 1, 5]
        ratio = (max(a2, 0.0) / b2) ** 0.63
        if ratio < 1.0 / 40:
            ratio = 1.0 / 40
        b2 = max(b2, 1e-30)
        a2 = b2 * ratio ** (1 / 0.63)
        d = levels[0] ** 2
        size = math.sqrt(d * (1 + m) / (2 * math.sqrt(a2 * b2)))
        la = math.log(size) - 0.5 * math.log(ratio)
        lb = math.log(size) + 0.5 * math.log(ratio)
        x0, y0, turn = 0.0, 0.0, 0.0
        before[:] = 0.0
        begun = False
        slope[:] = 0.0
        slope[:2] = 0.5
        for level in range(levels.size):
            d = levels[level] ** 2
            if level > 0:
                growth = 2 * math.log(levels[level] / levels[level - 1])
                la += slope[0] * growth
                lb += slope[1] * growth
                turn += slope[2] * growth
                x0 += slope[3] * growth
                y0 += slope[4] * growth
            repeats = 1 if begun else most
            for _ in range(repeats):
                a, b = math.exp(la), math.exp(lb)
                s = math.sqrt(a * b)
                f = 0
                while f < fits - 1 and sizes[f + 1] >= s:
                    f += 1
                if f == 0 or fits == 1:
                    move(fit[f], x0, y0, turn, local)
                else:
                    # between two fits that both reach beyond the contact
                    lower = sizes[f + 1] if f < fits - 1 else sizes[f] * sizes[f] / sizes[f - 1]
                    u = min(math.log(sizes[f] / s) / math.log(sizes[f] / lower), 1.0)
                    for r in range(n):
                        mixed[r] = (1 - u) * fit[f - 1, r] + u * fit[f, r]
                    move(mixed, x0, y0, turn, local)
                pa[0] = 1.0
                pb[0] = 1.0
                for k in range(degree):
                    pa[k + 1] = pa[k] * a
                    pb[k + 1] = pb[k] * b
                _row(rows, start, step, lb - la, row)
                for c in range(4):
                    for q in range(nq):
                        P[c, q] = 0.0
                        Q[c, q] = 0.0
                mean = 0.0
                r = 0
                for k in range(degree + 1):
                    for j in range(k + 1):
                        v = local[r] * pa[k - j] * pb[j]
                        if r == 0:
                            v -= d
                        mean += v * moments[r]
                        kv = k * v
                        c = parity[r]
                        for q in range(nq):
                            e = row[r * nq + q]
                            P[c, q] -= v * e
                            Q[c, q] += kv * e
                        r += 1
                average = 0.0
                for q in range(nq):
                    e, o, x, y = P[0, q], P[1, q], P[2, q], P[3, q]
                    P[0, q] = e + o + x + y
                    P[1, q] = e - o - x + y
                    P[2, q] = e + o - x - y
                    P[3, q] = e - o + x - y
                    e, o, x, y = Q[0, q], Q[1, q], Q[2, q], Q[3, q]
                    Q[0, q] = e + o + x + y
                    Q[1, q] = e - o - x + y
                    Q[2, q] = e + o - x - y
                    Q[3, q] = e - o + x - y
                    average += 4 * e
                average /= 4 * nq
                punch = row[o_k] * s ** (1 + m)
                scale = math.pi * s ** (1 + m) * row[0]
                confined = max(a, b) * 1.6 + abs(x0) + abs(y0) > smallest
                for i in range(5):
                    g[i] = 0.0
                    for j in range(5):
                        H[i, j] = 0.0
                gain, shift, total, push = 0.0, 0.0, 0.0, 0.0
                widest, open_weight, filled = 0.0, 0.0, 0.0
                tc, ts = math.cos(turn), math.sin(turn)
                for c in range(4):
                    for q in range(nq):
                        w = row[o_w + q] * 0.25
                        Qv = max(Q[c, q], 0.15 * average)
                        Pv = P[c, q]
                        x = Pv / Qv
                        free[c, q] = 1.0
                        if confined:
                            px, py = a * ct[q] * sx[c], b * st[q] * sy[c]
                            gx, gy = x0 + tc * px - ts * py, y0 + ts * px + tc * py
                            limit = (
                                _edge_radius(edge, stretch, offset, gx, gy)
                                / math.sqrt(gx * gx + gy * gy)
                                - 1
                            )
                            if x > limit:
                                x = limit
                                free[c, q] = 0.0
                                filled += w
                        widest = max(widest, abs(x))
                        x = max(x, -0.9)
                        X[c, q] = x
                        Q[c, q] = Qv
                        gain += w * (Pv * x - 0.5 * Qv * x * x)
                        shift += w * x
                        total += w
                        push += w * Pv
                        open_weight += w * free[c, q]
                for q in range(nq):
                    w = row[o_w + q] * 0.25
                    cq, sq, dq = ct[q], st[q], s2[q]
                    cc, ss = cq * cq, sq * sq
                    e, o, ox, oy = _mirrored(w * Q[0, q], w * Q[1, q], w * Q[2, q], w * Q[3, q])
                    H[0, 0] += cc * cc * e
                    H[0, 1] += cc * ss * e
                    H[1, 1] += ss * ss * e
                    H[2, 2] += dq * dq * e
                    H[3, 3] += cc * e
                    H[4, 4] += ss * e
                    H[0, 2] += cc * dq * o
                    H[1, 2] += ss * dq * o
                    H[3, 4] += cq * sq * o
                    H[0, 3] += cc * cq * ox
                    H[1, 3] += ss * cq * ox
                    H[2, 4] += dq * sq * ox
                    H[0, 4] += cc * sq * oy
                    H[1, 4] += ss * sq * oy
                    H[2, 3] += dq * cq * oy
                    e, o, ox, oy = _mirrored(
                        w * Q[0, q] * X[0, q],
                        w * Q[1, q] * X[1, q],
                        w * Q[2, q] * X[2, q],
                        w * Q[3, q] * X[3, q],
                    )
                    g[0] += cc * e
                    g[1] += ss * e
                    g[2] += dq * o
                    g[3] += cq * ox
                    g[4] += sq * oy
                for i in range(5):
                    for j in range(i):
                        H[i, j] = H[j, i]
                _solve(H, g)
                for i in range(5):
                    g[i] = min(max(g[i], -0.4), 0.4)
                force = -punch * mean
                oldx, oldy, oldt = x0, y0, turn
                la += g[0]
                lb += g[1]
                arm = 0.5 * (a / b - b / a)
                twist = 0.0
                if abs(arm) >= 0.15:
                    twist = min(max(g[2] / arm, -0.3), 0.3)
                x0 += tc * g[3] * a - ts * g[4] * b
                y0 += ts * g[3] * a + tc * g[4] * b
                turn += twist
                if abs(g[0]) + abs(g[1]) + abs(twist) + abs(g[3]) + abs(g[4]) < still:
                    break
            # second-order stiffness of the displaced contour, from the Fourier coefficients of X
            for c in range(4):
                for k in range(modes):
                    fourier[c, k] = 0.0
            contour = 0.0
            for q in range(nq):
                half = 1.0
                if q == 0 or q == nq - 1:
                    half = 0.5
                xa, xb, xc, xd = X[0, q], X[1, q], X[2, q], X[3, q]
                contour += half * ((1 + xa) ** 2 + (1 + xb) ** 2 + (1 + xc) ** 2 + (1 + xd) ** 2)
                half *= 2.0 / around
                e = (xa + xb + xc + xd) * half
                o = (xa - xb + xc - xd) * half
                ox = (xa - xb - xc + xd) * half
                oy = (xa + xb - xc - xd) * half
                for k in range(modes):
                    fourier[0, k] += e * cosine[2 * k, q]
                for k in range(modes - 1):
                    fourier[1, k] += o * sine[2 * k + 2, q]
                    fourier[2, k] += ox * cosine[2 * k + 1, q]
                    fourier[3, k] += oy * sine[2 * k + 1, q]
            fourier[0, 0] *= 0.5
            second = 0.0
            r = o_k + 1
            for c in range(4):
                count = modes if c == 0 else modes - 1
                for i in range(count):
                    for j in range(i, count):
                        second += row[r] * fourier[c, i] * fourier[c, j]
                        r += 1
            gain += push / total * second
            pstar = row[0]
            state[level, 0] = force + scale * gain
            state[level, 1] = punch + scale * pstar * (shift + second)
            state[level, 2] = scale * pstar * open_weight
            state[level, 3] = math.pi * a * b
            state[level, 4] = math.pi * a * b * contour / around
            # d(area)/d(uniform displacement of the free part)
            slide = 0.0
            for q in range(nq):
                half = 0.5 if q == 0 or q == nq - 1 else 1.0
                for c in range(4):
                    slide += half * free[c, q] * (1 + X[c, q])
            state[level, 5] = 2 * math.pi * a * b * slide / around
            state[level, 6] = widest
            state[level, 7] = scale * gain / force
            state[level, 8] = filled / total
            shape[level, 0] = a
            shape[level, 1] = b
            shape[level, 2] = oldx
            shape[level, 3] = oldy
            shape[level, 4] = oldt
            for c in range(4):
                for q in range(nq):
                    shape[level, 5 + c * nq + q] = X[c, q]
            if level > 0:
                slope[0] = (la - before[0]) / growth
                slope[1] = (lb - before[1]) / growth
                slope[2] = (turn - before[2]) / growth
                slope[3] = (x0 - before[3]) / growth
                slope[4] = (y0 - before[4]) / growth
            before[0] = la
            before[1] = lb
            before[2] = turn
            before[3] = x0
            before[4] = y0
            state[level, 9] = 1.0
            untrusted = widest > WIDEST or abs(state[level, 7]) > SHARE
            untrusted = untrusted or state[level, 8] > CONFINED
            if untrusted or not (force > 0.0):
                state[level, 9] = 0.0
                if stop and (begun or level > levels.size // 2):
                    break
            elif stop:
                begun = True
