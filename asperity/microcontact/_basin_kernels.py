"""Numba kernel that carries contours on rays to the edge of their basins.

Units inside: one length and one height per profile, modulus 1.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

FAST = {"contract", "reassoc", "nsz", "arcp"}


@njit(cache=True, fastmath=FAST, nogil=True)
def moment(table, p, x):
    """Moment h and x dh/dx at x = a/edge; equispaced table from 0, local cubics."""
    last = table.shape[1] - 1
    y = x * last
    i = min(max(int(y), 1), last - 2)
    u = y - i
    v0, v1, v2, v3 = table[p, i - 1], table[p, i], table[p, i + 1], table[p, i + 2]
    c1 = -v0 / 3 - 0.5 * v1 + v2 - v3 / 6
    c2 = 0.5 * (v0 + v2) - v1
    c3 = (v3 - v0) / 6 + 0.5 * (v1 - v2)
    return v1 + u * (c1 + u * (c2 + u * c3)), (c1 + u * (2 * c2 + 3 * u * c3)) * y


@njit(cache=True, fastmath=FAST, nogil=True)
def _operator(table, p, x, order):
    """Edge operator e / edge**2 of one ray and its slope, at x = a/edge."""
    h, dh = moment(table, p, x)
    return x * x * (order * h + dh)


@njit(cache=True, fastmath=FAST, nogil=True)
def _ray_radius(shape, nq, cx, cy):
    """Radius of the contour of the expansion in the direction (cx, cy) from the summit."""
    a, b, x0, y0, turn = shape[0], shape[1], shape[2], shape[3], shape[4]
    tc, ts = math.cos(turn), math.sin(turn)
    ox, oy = -(tc * x0 + ts * y0) / a, (ts * x0 - tc * y0) / b
    dx, dy = (tc * cx + ts * cy) / a, (-ts * cx + tc * cy) / b
    dd = dx * dx + dy * dy
    od = ox * dx + oy * dy
    rest = od * od - dd * (ox * ox + oy * oy - 1)
    if rest <= 0.0 or ox * ox + oy * oy >= 0.98:
        return -1.0
    r = (math.sqrt(rest) - od) / dd
    ex, ey = ox + r * dx, oy + r * dy
    t = math.atan2(abs(ey), abs(ex)) * 2 / math.pi * (nq - 1)
    i = min(int(t), nq - 2)
    u = t - i
    image = 0
    if ex < 0.0:
        image = 2 if ey < 0.0 else 1
    elif ey < 0.0:
        image = 3
    o = 5 + image * nq + i
    return r * (1 + shape[o] * (1 - u) + shape[o + 1] * u)


@njit(cache=True, fastmath=FAST, nogil=True)
def planform(radius, weight, direction, out):
    """Area, axis ratio from the second moments, and inertia invariant (1 for an ellipse)."""
    area, mx, my = 0.0, 0.0, 0.0
    xx, xy, yy = 0.0, 0.0, 0.0
    for p in range(radius.size):
        cx, cy = direction[p, 0], direction[p, 1]
        r2 = weight[p] * radius[p] * radius[p]
        r3 = r2 * radius[p]
        r4 = r3 * radius[p]
        area += r2
        mx += r3 * cx
        my += r3 * cy
        xx += r4 * cx * cx
        xy += r4 * cx * cy
        yy += r4 * cy * cy
    area *= 0.5
    mx /= 3 * area
    my /= 3 * area
    xx = xx / (4 * area) - mx * mx
    yy = yy / (4 * area) - my * my
    xy = xy / (4 * area) - mx * my
    half = math.sqrt(0.25 * (xx - yy) ** 2 + xy * xy)
    large, small = 0.5 * (xx + yy) + half, max(0.5 * (xx + yy) - half, 1e-12 * (xx + yy))
    out[0] = area
    out[1] = math.sqrt(small / large)
    out[2] = large * small * (4 * math.pi / area) ** 2
    out[3] = mx
    out[4] = my


@njit(cache=True, fastmath=FAST, nogil=True)
def _stiffness(form, m, punch, start, step):
    """Stiffness of a flat punch: the ellipse of equal area and second moments, and the first
    correction for its other harmonics."""
    x = (math.log(form[1]) - start) / step
    x = min(max(x, 1.0), punch.size - 2.001)
    i = int(x)
    u = x - i
    k = -u * (u - 1) * (u - 2) / 6 * punch[i - 1]
    k += (u + 1) * (u - 1) * (u - 2) / 2 * punch[i]
    k += -(u + 1) * u * (u - 2) / 2 * punch[i + 1]
    k += (u + 1) * u * (u - 1) / 6 * punch[i + 2]
    k *= (form[0] / math.pi) ** ((1 + m) / 2)
    return k * (1 + (1 - m * m) / 8 * min(max(form[2] - 1, 0.0), 1.0))


@njit(cache=True, fastmath=FAST, nogil=True)
def fill_basins(
    begin, end, q, weights, weight, direction, edge, length, height, shape, last, levels, nq, m,
    order, punch, start, step, tip, out,
):  # fmt: skip
    """Area and stiffness of the planforms of all profiles from node `last` on.

    On every ray the edge operator grows with the approach from its value at the last trusted
    contour; the ray stops at the edge. Returns (n, levels, 2).
    """
    rays, nodes = q.shape[1:]
    radii = weights.shape[0]
    table = np.empty((rays, radii))
    a, radius, target, form = np.empty(rays), np.empty(rays), np.empty(rays), np.empty(5)
    for i in range(begin, end):
        scale = length[i] ** 2 / height[i]
        first = last[i]
        d0 = levels[first] ** 2
        for p in range(rays):
            for j in range(radii):
                s = 0.0
                for k in range(nodes):
                    s += weights[j, k] * q[i, p, k]
                table[p, j] = s * scale * edge[i, p] ** 2
            r = _ray_radius(shape[i, first], nq, direction[i, p, 0], direction[i, p, 1])
            if r <= 0.0:
                r = math.sqrt(d0 * tip / (q[i, p, 0] * scale))
            a[p] = min(r / edge[i, p], 1.0)
            target[p] = _operator(table, p, a[p], order) / d0
        for level in range(first):
            out[i, level, 2] = shape[i, level, 2]
            out[i, level, 3] = shape[i, level, 3]
        for level in range(first, levels.size):
            d = levels[level] ** 2
            if level > first:
                growth = levels[level] / levels[level - 1]
                for p in range(rays):
                    if a[p] >= 1.0:
                        continue
                    want = target[p] * d
                    x = min(a[p] * growth, 1.0)
                    e = _operator(table, p, x, order)
                    for _ in range(12):
                        if e >= want or x >= 1.0:
                            break
                        x = min(x * 1.06, 1.0)
                        e = _operator(table, p, x, order)
                    if e >= want:
                        low, high = a[p], x
                        e0 = target[p] * levels[level - 1] ** 2
                        e1 = e
                        for _ in range(3):
                            u = (want - e0) / max(e1 - e0, 1e-300)
                            x = low + min(max(u, 0.05), 0.95) * (high - low)
                            e = _operator(table, p, x, order)
                            if e < want:
                                low, e0 = x, e
                            else:
                                high, e1 = x, e
                        x = low + (want - e0) / max(e1 - e0, 1e-300) * (high - low)
                    a[p] = max(a[p], min(x, 1.0))
            for p in range(rays):
                radius[p] = a[p] * edge[i, p]
            planform(radius, weight[i], direction[i], form)
            out[i, level, 0] = form[0]
            out[i, level, 1] = _stiffness(form, m, punch, start, step)
            out[i, level, 2] = form[3]
            out[i, level, 3] = form[4]
