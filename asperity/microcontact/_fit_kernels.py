"""Numba kernel of the polynomial fits of a batch of summits."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

FAST = {"contract", "reassoc", "nsz", "arcp"}


@njit(cache=True, fastmath=FAST, nogil=True)
def _sample(q, p, edge, r):
    """f at radius r of a ray with q = f/r**2 at equispaced nodes.

    Beyond the edge f goes on with the parabola of its last three values, up to the vertex.
    """
    last = q.shape[1] - 1
    if r >= edge:
        step = edge / last
        f2 = q[p, last] * edge * edge
        f1 = q[p, last - 1] * (edge - step) ** 2
        f0 = q[p, last - 2] * (edge - 2 * step) ** 2
        bend = f2 - 2 * f1 + f0
        slope = max(f2 - f1 + 0.5 * bend, 0.0)
        u = (r - edge) / step
        if bend < 0.0:
            u = min(u, -slope / bend)
        return f2 + u * (slope + 0.5 * bend * u)
    x = r / edge * last
    i = min(max(int(x), 1), last - 2)
    u = x - i
    w0 = -u * (u - 1) * (u - 2) / 6
    w1 = (u + 1) * (u - 1) * (u - 2) / 2
    w2 = -(u + 1) * u * (u - 2) / 2
    w3 = (u + 1) * u * (u - 1) / 6
    return (w0 * q[p, i - 1] + w1 * q[p, i] + w2 * q[p, i + 1] + w3 * q[p, i + 2]) * r * r


@njit(cache=True, fastmath=FAST, nogil=True)
def _factor(a, n):
    """Cholesky factor in the lower triangle of a[:n, :n], in place."""
    for i in range(n):
        for j in range(i + 1):
            s = a[i, j]
            for k in range(j):
                s -= a[i, k] * a[j, k]
            if i == j:
                a[i, i] = math.sqrt(max(s, 1e-14))
            else:
                a[i, j] = s / a[j, j]


@njit(cache=True, fastmath=FAST, nogil=True)
def _substitute(a, n, v):
    """Solve with the Cholesky factor, in place."""
    for i in range(n):
        s = v[i]
        for k in range(i):
            s -= a[i, k] * v[k]
        v[i] = s / a[i, i]
    for i in range(n - 1, -1, -1):
        s = v[i]
        for k in range(i + 1, n):
            s -= a[k, i] * v[k]
        v[i] = s / a[i, i]


@njit(cache=True, fastmath=FAST, nogil=True)
def fit_rays(
    begin, end, direction, edge, q, ratio, length, height, fractions, radii, weights, base, image,
    share, members, count, power_x, power_y,
    coefs, rest,
):  # fmt: skip
    """Least-squares polynomials of all summits on nested ellipses.

    The rays are mirror images of the `base` rays: `image[b]` are the rays at (+,+), (-,+),
    (-,-), (+,-) of base ray b. The normal equations then fall apart into four parity classes.
    `members[c, :count[c]]` are the monomials of class c. Fills, for the summits [begin, end),
    the coefficients of (x/length)**i (y/length)**j in units of `height`, and the rms residuals
    relative to the largest value on each ellipse.
    """
    fits = fractions.size
    terms, rings = power_x.size, radii.size
    quarter = base.size
    widest = 0
    for c in range(4):
        widest = max(widest, count[c])
    degree = 0
    for r in range(terms):
        degree = max(degree, power_x[r])
    normal = np.zeros((4, widest, widest))
    values = np.zeros((4, quarter, rings, widest))
    unit = np.empty(direction.shape[1])
    px, py = np.empty(degree + 1), np.empty(degree + 1)
    right, copy = np.empty((4, widest)), np.empty(widest)
    for i in range(begin, end):
        own = q[i]
        normal[:] = 0.0
        b0 = math.sqrt(ratio[i])
        a0 = 1.0 / b0
        for p in range(unit.size):
            cx, cy = direction[i, p, 0], direction[i, p, 1]
            unit[p] = 1.0 / math.sqrt(cx * cx / (a0 * a0) + cy * cy / (b0 * b0))
        for b in range(quarter):
            p = base[b]
            cx = abs(direction[i, p, 0]) * unit[p] / a0
            cy = abs(direction[i, p, 1]) * unit[p] / b0
            for j in range(rings):
                px[0] = 1.0
                py[0] = 1.0
                for k in range(degree):
                    px[k + 1] = px[k] * cx * radii[j]
                    py[k + 1] = py[k] * cy * radii[j]
                w = share[b] * weights[j]
                for c in range(4):
                    v = values[c, b, j]
                    for k in range(count[c]):
                        r = members[c, k]
                        v[k] = px[power_x[r]] * py[power_y[r]]
                    for k in range(count[c]):
                        for h in range(k + 1):
                            normal[c, k, h] += w * v[k] * v[h]
        for c in range(4):
            _factor(normal[c], count[c])
        for s in range(fits):
            size = fractions[s] * length[i]
            for c in range(4):
                for k in range(widest):
                    right[c, k] = 0.0
            square, top, total = 0.0, 0.0, 0.0
            for b in range(quarter):
                for j in range(rings):
                    r = radii[j] * size * unit[base[b]]
                    f0 = _sample(own, image[b, 0], edge[i, image[b, 0]], r)
                    f1 = _sample(own, image[b, 1], edge[i, image[b, 1]], r)
                    f2 = _sample(own, image[b, 2], edge[i, image[b, 2]], r)
                    f3 = _sample(own, image[b, 3], edge[i, image[b, 3]], r)
                    w = share[b] * weights[j]
                    square += w * (f0 * f0 + f1 * f1 + f2 * f2 + f3 * f3)
                    total += 4 * w
                    top = max(top, max(max(f0, f1), max(f2, f3)))
                    e = 0.25 * w * (f0 + f1 + f2 + f3)
                    o = 0.25 * w * (f0 - f1 + f2 - f3)
                    ox = 0.25 * w * (f0 - f1 - f2 + f3)
                    oy = 0.25 * w * (f0 + f1 - f2 - f3)
                    for k in range(count[0]):
                        right[0, k] += e * values[0, b, j, k]
                    for k in range(count[1]):
                        right[1, k] += o * values[1, b, j, k]
                    for k in range(count[2]):
                        right[2, k] += ox * values[2, b, j, k]
                    for k in range(count[3]):
                        right[3, k] += oy * values[3, b, j, k]
            explained = 0.0
            px[0], py[0] = 1.0 / height[i], 1.0
            for k in range(degree):
                px[k + 1] = px[k] / (fractions[s] * a0)
                py[k + 1] = py[k] / (fractions[s] * b0)
            for c in range(4):
                m = count[c]
                for k in range(m):
                    copy[k] = right[c, k]
                _substitute(normal[c], m, right[c])
                for k in range(m):
                    explained += 4 * copy[k] * right[c, k]
                    r = members[c, k]
                    coefs[i, s, r] = right[c, k] / (
                        (fractions[s] * a0) ** power_x[r]
                        * (fractions[s] * b0) ** power_y[r]
                        * height[i]
                    )
            rest[i, s] = math.sqrt(max(square - explained, 0.0) / total) / max(top, 1e-300)
