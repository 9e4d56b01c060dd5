"""Numba kernels of the contact law about the optimal ellipse.

Units inside: one length and one height per profile, modulus 1. The contour has nodes on the four
mirror images of a quarter of the ellipse; each quarter is padded to a vector by its last node
once more, with no weight.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ._directions import FAST, place
from ._polynomial_kernels import TERMS, move, solve, table_row
from .ellipse_tables import DEGREE, LANES

NODES = DEGREE + 1
MODES = DEGREE // 2 + 1
"""Nodes on a quarter of the ellipse, and even modes: constants, so that the loops unroll."""

WIDEST, SHARE, CONFINED = 0.5, 0.05, 0.5
"""Limits of trust: displacement of the contour, share of F2, confined share of the contour."""

_AGAIN = 2
"""Newton steps at most at a level after the first trusted one: a single one where it is trusted."""

_STILL = 1e-3
"""Newton step, in logarithms and angles, that ends the search at a level."""

STATES = 10
"""Numbers kept per level: force, stiffness of the first-order contour and its change with a
uniform displacement, areas of the ellipse and of the contour and the change of the latter,
largest displacement, share of F2, confined share, trust (1 or 0)."""

SHAPE = 5 + 4 * NODES
"""Numbers of a contour: semi-axes, centre, turn and displacements at the nodes."""

_T = np.minimum(np.arange(LANES), DEGREE) * np.pi / (2 * DEGREE)
_COS, _SIN = np.cos(_T), np.sin(_T)
_XI = np.stack([_COS, -_COS, -_COS, _COS])
_ETA = np.stack([_SIN, _SIN, -_SIN, -_SIN])
_SHARE = np.where(np.arange(LANES) < NODES, 1.0, 0.0)
_SHARE[[0, DEGREE]] = 0.5
_SHARE /= 4 * DEGREE
"""Share of a node in the mean over the parameter of the ellipse."""
_EVEN = np.cos(np.outer(2 * np.arange(MODES), _T)) * _SHARE * 2
_EVEN[0] *= 0.5
_BOTH = np.sin(np.outer(2 * np.arange(MODES - 1) + 2, _T)) * _SHARE * 2
_ALONG = np.cos(np.outer(2 * np.arange(MODES - 1) + 1, _T)) * _SHARE * 2
_ACROSS = np.sin(np.outer(2 * np.arange(MODES - 1) + 1, _T)) * _SHARE * 2
_CLASS = np.array(
    [(0, 2, 3, 1)[(k - j) % 2 + 2 * (j % 2)] for k in range(DEGREE + 1) for j in range(k + 1)]
)
_ORDER = np.array([k for k in range(DEGREE + 1) for j in range(k + 1)])
_WEIGHTS = TERMS * LANES
_PUNCH = _WEIGHTS + LANES


@njit(cache=True, nogil=True)
def march_space(width):
    """Working arrays of `march_one` for tables of `width` numbers in a row."""
    return (
        np.empty(TERMS),
        np.empty(width),
        np.empty((6, 4, LANES)),
        np.empty((4, MODES)),
        np.empty((5, 5)),
        np.empty((6, 5)),
        np.empty((2, DEGREE + 1)),
    )


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy", inline="always")
def _mirrored(a, b, c, d):
    """Sums over the mirror images: even, odd in both, odd in x, odd in y."""
    return a + b + c + d, a - b + c - d, a - b - c + d, a + b - c - d


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _amplitudes(coefs, powers, row, moments, depth, P, Q):
    """Amplitude P and its growth Q around the ellipse, and the mean of the displacement."""
    P[:] = 0.0
    Q[:] = 0.0
    mean = 0.0
    r = 0
    for k in range(DEGREE + 1):
        for j in range(k + 1):
            v = coefs[r] * powers[0, k - j] * powers[1, j]
            if r == 0:
                v -= depth
            mean += v * moments[r]
            kv = k * v
            c = _CLASS[r]
            for q in range(LANES):
                e = row[r * LANES + q]
                P[c, q] -= v * e
                Q[c, q] += kv * e
            r += 1
    average = 0.0
    for q in range(NODES):
        average += Q[0, q]
    for field in (P, Q):
        for q in range(LANES):
            e, o, x, y = field[0, q], field[1, q], field[2, q], field[3, q]
            field[0, q] = e + o + x + y
            field[1, q] = e - o - x + y
            field[2, q] = e + o - x - y
            field[3, q] = e - o + x - y
    return mean, average / NODES


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _limits(edge, stretch, pose, a, b, turns, limit):
    """Displacement at which each node of the contour meets the edge, linear between the rays."""
    rays = edge.size
    x0, y0 = pose[3], pose[4]
    tc, ts = math.cos(pose[2]), math.sin(pose[2])
    for c in range(4):
        for q in range(LANES):
            px, py = a * _XI[c, q], b * _ETA[c, q]
            gx, gy = x0 + tc * px - ts * py, y0 + ts * px + tc * py
            turns[c, q] = place(gx, stretch * gy, rays)
            limit[c, q] = 1.0 / math.sqrt(gx * gx + gy * gy)
    for c in range(4):
        for q in range(LANES):
            lower = int(turns[c, q])
            u = turns[c, q] - lower
            lower = lower if lower < rays else 0
            upper = lower + 1 if lower + 1 < rays else 0
            limit[c, q] *= edge[lower] + u * (edge[upper] - edge[lower])
            limit[c, q] -= 1.0


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _step(Q, X, row, H, g):
    """Newton step of the five parameters of the ellipse from the displacements X."""
    for i in range(5):
        g[i] = 0.0
        for j in range(5):
            H[i, j] = 0.0
    for q in range(LANES):
        w = row[_WEIGHTS + q] * 0.25
        cq, sq = _COS[q], _SIN[q]
        dq = 2 * cq * sq
        cc, ss = cq * cq, sq * sq
        qa, qb, qc, qd = w * Q[0, q], w * Q[1, q], w * Q[2, q], w * Q[3, q]
        e, o, ox, oy = _mirrored(qa, qb, qc, qd)
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
        e, o, ox, oy = _mirrored(qa * X[0, q], qb * X[1, q], qc * X[2, q], qd * X[3, q])
        g[0] += cc * e
        g[1] += ss * e
        g[2] += dq * o
        g[3] += cq * ox
        g[4] += sq * oy
    solve(H, g)
    for i in range(5):
        g[i] = min(max(g[i], -0.4), 0.4)


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _second_order(X, row, fourier):
    """Second-order stiffness of the displaced contour, from its Fourier coefficients."""
    for c in range(4):
        for k in range(MODES):
            fourier[c, k] = 0.0
    for q in range(LANES):
        e, o, ox, oy = _mirrored(X[0, q], X[1, q], X[2, q], X[3, q])
        for k in range(MODES):
            fourier[0, k] += e * _EVEN[k, q]
        for k in range(MODES - 1):
            fourier[1, k] += o * _BOTH[k, q]
            fourier[2, k] += ox * _ALONG[k, q]
            fourier[3, k] += oy * _ACROSS[k, q]
    second = 0.0
    r = _PUNCH + 1
    for c in range(4):
        count = MODES if c == 0 else MODES - 1
        for i in range(count):
            for j in range(i, count):
                second += row[r] * fourier[c, i] * fourier[c, j]
                r += 1
    return second


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _start(fit, depth, m, pose):
    """Ellipse of the paraboloid in a fit."""
    a2, b2 = max(fit[3], 0.0), max(fit[5], 1e-30)
    ratio = max((a2 / b2) ** 0.63, 1.0 / 40)
    a2 = b2 * ratio ** (1 / 0.63)
    size = 0.5 * math.log(depth * (1 + m) / (2 * math.sqrt(a2 * b2)))
    pose[0] = size - 0.5 * math.log(ratio)
    pose[1] = size + 0.5 * math.log(ratio)
    pose[2:] = 0.0


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _mixed(fit, logs, size, out):
    """Polynomial for a contact of the log size: between the two fits that just reach beyond it."""
    fits = logs.size
    f = 0
    while f < fits - 1 and logs[f + 1] >= size:
        f += 1
    if f == 0:
        for r in range(TERMS):
            out[r] = fit[0, r]
        return
    lower = logs[f + 1] if f < fits - 1 else 2 * logs[f] - logs[f - 1]
    u = min((logs[f] - size) / (logs[f] - lower), 1.0)
    for r in range(TERMS):
        out[r] = (1 - u) * fit[f - 1, r] + u * fit[f, r]


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def march_one(
    fit, logs, edge, stretch, levels, most, m, rows, start, inverse, moments, state, shape,
    space,
):  # fmt: skip
    """Follow a profile through the approaches levels**2.

    Fills state (levels, STATES) and shape (levels, SHAPE). `most` Newton steps at most before the
    first trusted level; ends at the first level after it that is not trusted. Returns the first and
    the last trusted level, or -1 for both.
    """
    local, row, fields, fourier, H, poses, powers = space
    P, Q, X, limit, free = fields[0], fields[1], fields[2], fields[3], fields[4]
    turns = fields[5]
    g, pose, slope, before, used = poses[0], poses[1], poses[2], poses[3], poses[4]
    smallest = 1e300
    for p in range(edge.size):
        smallest = min(smallest, edge[p])
    _start(fit[logs.size - 1], levels[0] ** 2, m, pose)
    slope[:] = 0.0
    slope[:2] = 0.5
    first, last = -1, -1
    for level in range(levels.size):
        d = levels[level] ** 2
        growth = 1.0
        if level > 0:
            growth = 2 * math.log(levels[level] / levels[level - 1])
            for i in range(5):
                pose[i] += slope[i] * growth
        state[level, 9] = 0.0
        force, punch, scale, gain, shift, second = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        total, push, open_weight, widest, filled, a, b = 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0
        for _ in range(_AGAIN if first >= 0 else most):
            for i in range(5):
                used[i] = pose[i]
            size = 0.5 * (pose[0] + pose[1])
            a, b, power = math.exp(pose[0]), math.exp(pose[1]), math.exp((1 + m) * size)
            _mixed(fit, logs, size, local)
            move(pose[3], pose[4], pose[2], local)
            powers[:, 0] = 1.0
            for k in range(DEGREE):
                powers[0, k + 1] = powers[0, k] * a
                powers[1, k + 1] = powers[1, k] * b
            table_row(rows, start, inverse, pose[1] - pose[0], row)
            mean, average = _amplitudes(local, powers, row, moments, d, P, Q)
            punch = row[_PUNCH] * power
            scale = math.pi * power * row[0]
            confined = max(a, b) * 1.6 + abs(pose[3]) + abs(pose[4]) > smallest
            if confined:
                _limits(edge, stretch, pose, a, b, turns, limit)
            else:
                limit[:] = 1e300
            gain, shift, total, push = 0.0, 0.0, 0.0, 0.0
            widest, open_weight = 0.0, 0.0
            floor = 0.15 * average
            for c in range(4):
                for q in range(LANES):
                    w = row[_WEIGHTS + q] * 0.25
                    Pv, Qv, edge_x = P[c, q], max(Q[c, q], floor), limit[c, q]
                    x = Pv / Qv
                    open_ = 1.0 if x <= edge_x else 0.0
                    x = min(x, edge_x)
                    widest = max(widest, abs(x))
                    x = max(x, -0.9)
                    X[c, q] = x
                    Q[c, q] = Qv
                    free[c, q] = open_
                    gain += w * (Pv * x - 0.5 * Qv * x * x)
                    shift += w * x
                    total += w
                    push += w * Pv
                    open_weight += w * open_
            filled = total - open_weight
            force = -punch * mean
            small = widest <= WIDEST and abs(scale * gain) <= SHARE * force
            small = small and total - open_weight <= CONFINED * total
            _step(Q, X, row, H, g)
            arm = 0.5 * (a / b - b / a)
            twist = 0.0
            if abs(arm) >= 0.15:
                twist = min(max(g[2] / arm, -0.3), 0.3)
            tc, ts = math.cos(pose[2]), math.sin(pose[2])
            pose[0] += g[0]
            pose[1] += g[1]
            pose[2] += twist
            pose[3] += tc * g[3] * a - ts * g[4] * b
            pose[4] += ts * g[3] * a + tc * g[4] * b
            if abs(g[0]) + abs(g[1]) + abs(twist) + abs(g[3]) + abs(g[4]) < _STILL:
                break
            if first >= 0 and small:
                break
        second = _second_order(X, row, fourier)
        gain += push / total * second
        contour, slide = 0.0, 0.0
        for c in range(4):
            for q in range(LANES):
                grown = _SHARE[q] * (1 + X[c, q])
                contour += grown * (1 + X[c, q])
                slide += grown * free[c, q]
        disk = math.pi * a * b
        share = scale * gain / force
        state[level, 0] = force + scale * gain
        state[level, 1] = punch + scale * row[0] * (shift + second)
        state[level, 2] = scale * row[0] * open_weight
        state[level, 3] = disk
        state[level, 4] = disk * contour
        # change of the area with a uniform displacement of the free part
        state[level, 5] = 2 * disk * slide
        state[level, 6] = widest
        state[level, 7] = share
        state[level, 8] = filled / total
        shape[level, 0] = a
        shape[level, 1] = b
        shape[level, 2] = used[3]
        shape[level, 3] = used[4]
        shape[level, 4] = used[2]
        for c in range(4):
            for q in range(NODES):
                shape[level, 5 + c * NODES + q] = X[c, q]
        for i in range(5):
            if level > 0:
                slope[i] = (pose[i] - before[i]) / growth
            before[i] = pose[i]
        trusted = widest <= WIDEST and abs(share) <= SHARE and filled <= CONFINED * total
        if trusted and force > 0.0:
            state[level, 9] = 1.0
            first = level if first < 0 else first
            last = level
        elif first >= 0 or level > levels.size // 2:
            break
    return first, last
