"""Compiled loops over the rays of sampled profiles, one profile at a time: what a profile adds to
the paraboloid of its summit under a Hertzian contact, and the Barber-Fabrikant functional on free
rays inside basins.

The functional is stationary over rays a <= edge (`single.ritz`). Units of its loops: one length and
one height per profile, modulus 1.
"""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner

_TRIES, _NEAR, _STILL = 6, 2e-3, 1e-4
"""Newton steps of a ray at most, the relative step and the relative change that end a search."""


@inner(fastmath=QUOTIENTS)
def _moment(table, x):
    """Moment h and x dh/dx at x = a/edge; equispaced table from 0, local cubics."""
    y = x * (table.size - 1)
    i = min(max(int(y), 1), table.size - 3)
    u = y - i
    v0, v1, v2, v3 = table[i - 1], table[i], table[i + 1], table[i + 2]
    c1 = v2 - v0 * (1 / 3) - 0.5 * v1 - v3 * (1 / 6)
    c2 = 0.5 * (v0 + v2) - v1
    c3 = (v3 - v0) * (1 / 6) + 0.5 * (v1 - v2)
    return v1 + u * (c1 + u * (c2 + u * c3)), (c1 + u * (2.0 * c2 + 3.0 * u * c3)) * y


@inner(fastmath=QUOTIENTS)
def _longest(table, edge, d, multiplier, m, x):
    """Radius at which the gain of a ray is largest, from the radius x on."""
    for _ in range(_TRIES):
        h, dh = _moment(table, x / edge)
        tail = (1.0 - m) * multiplier * (x**-m if m != 0.0 else 1.0)
        gain = (2 * d / (1 + m)) * x - x * x * x * (4.0 * h + dh) - tail
        slope = 2 * d / (1 + m) - x * x * (12.0 * h + 7.0 * dh) + m * tail / x
        # while the gain rises the ray has not reached its maximum yet
        step = 0.2 * x if slope > -0.1 * d else -gain / slope
        before, x = x, min(x + min(max(step, -0.25 * x), 0.25 * x), edge)
        if abs(x - before) < _NEAR * x:
            break
    return x


@inner(fastmath=QUOTIENTS)
def _march(moments, weight, edge, levels, m, rounds, a, out):
    """Stationary value of the functional over free rays a <= edge at the approaches levels**2.

    out: force, punch stiffness, area, filled share of the angle at every level.
    """
    rays = edge.size
    for p in range(rays):
        first = (1 + m) * (3 + m) * moments[p, 0]
        a[p] = min(levels[0] / math.sqrt(first), edge[p]) if first > 0.0 else edge[p]
    multiplier = -1.0
    for level in range(levels.size):
        d = levels[level] ** 2
        if level > 0:
            growth = levels[level] / levels[level - 1]
            for p in range(rays):
                a[p] = min(a[p] * growth, edge[p])
            multiplier *= growth ** (3 + m)
        for _ in range(rounds):
            work, around, area, filled = 0.0, 0.0, 0.0, 0.0
            for p in range(rays):
                if multiplier > 0.0:
                    a[p] = _longest(moments[p], edge[p], d, multiplier, m, a[p])
                x = a[p]
                h, _ = _moment(moments[p], x / edge[p])
                square = weight[p] * x * x
                work += square * (d / (1 + m) - x * x * h)
                around += weight[p] * (x ** (1.0 - m) if m != 0.0 else x)
                area += 0.5 * square
                filled += weight[p] if x >= edge[p] else 0.0
            before, multiplier = multiplier, work / around
            if abs(multiplier - before) < _STILL * max(abs(multiplier), 1e-300):
                break
        out[level, 0] = 2.0 * multiplier
        out[level, 1] = 4.0 * area / ((1 + m) * around)
        out[level, 2] = area
        out[level, 3] = filled * (0.5 / math.pi)


@compiled(fastmath=QUOTIENTS)
def march_rays(begin, end, profiles, weights, levels, m, rounds, out):
    """Profiles [begin, end): fills out (n, levels, 4).

    `profiles` holds q (n, rays, nodes), the weights and the lengths of the rays, and the unit of q;
    `weights` (radii, nodes) turn q into the moments of a ray.
    """
    q, shares, edges, unit = profiles
    rays, (radii, nodes) = edges.shape[1], weights.shape
    moments, a = np.empty((rays, radii)), np.empty(rays)
    for i in range(begin, end):
        for p in range(rays):
            for j in range(radii):
                total = 0.0
                for k in range(nodes):
                    total += weights[j, k] * q[i, p, k]
                moments[p, j] = total * unit[i]
        _march(moments, shares[i], edges[i], levels, m, rounds, a, out[i])


@compiled(fastmath=QUOTIENTS)
def mean_excess(begin, end, q, edge, weight, curvature, axes, valid, weights, m, u, out):
    """Mean of f minus the paraboloid over the elliptic punch of semi-axes `axes` times u.

    `weights` are those of the moments h of a ray at equispaced fractions of it
    (`ray_moments.moment_weights`), transposed: the mean is (1 + m) sum w a^4 h / sum w a^2.
    Beyond its edge a ray keeps its last moment. Fills out (n, u) for the profiles [begin, end).
    """
    rays, radii = q.shape[1], weights.shape[1]
    moment = np.empty((rays, radii))
    for i in range(begin, end):
        if not valid[i]:
            continue
        np.dot(q[i], weights, moment)
        bend = curvature[i, 0] - curvature[i, 1]
        total = 0.0
        for p in range(rays):
            along = 0.5
            if bend > 1e-9 * curvature[i, 0]:
                along = min(max((curvature[i, 0] - 2 * q[i, p, 0]) / bend, 0.0), 1.0)
            square = 1 / (along / axes[i, 1] ** 2 + (1 - along) / axes[i, 0] ** 2)
            total += weight[i, p] * square
            scale = (1 + m) * weight[i, p] * square * square
            unit = math.sqrt(square) / edge[i, p] * (radii - 1)
            for j in range(u.size):
                x = min(u[j] * unit, radii - 1.0)
                k = min(int(x), radii - 2)
                h = moment[p, k] + (x - k) * (moment[p, k + 1] - moment[p, k])
                out[i, j] += scale * u[j] ** 4 * (h - moment[p, 0])
        for j in range(u.size):
            if u[j] > 0.0:
                out[i, j] /= total * u[j] * u[j]
