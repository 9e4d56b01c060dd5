"""Numba kernels of the Barber-Fabrikant functional on free rays inside a basin.

Units inside: one length and one height per profile, modulus 1.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ._lanes import FAST


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
def _march(moments, weight, edge, levels, m, rounds, out):
    """Maximise the functional over free rays a <= edge at the approaches levels**2.

    out: force, punch stiffness, area, filled share of the angle.
    """
    rays = edge.size
    a = np.empty(rays)
    d0 = levels[0] ** 2
    for p in range(rays):
        a[p] = min(math.sqrt(d0 / ((1 + m) * (3 + m) * moments[p, 0])), edge[p])
    multiplier = -1.0
    for level in range(levels.size):
        d = levels[level] ** 2
        if level > 0:
            growth = levels[level] / levels[level - 1]
            for p in range(rays):
                a[p] = min(a[p] * growth, edge[p])
            multiplier *= growth ** (3 + m)
        force = 0.0
        for _ in range(rounds):
            if multiplier > 0.0:
                for p in range(rays):
                    x = a[p]
                    for _try in range(6):
                        g, dg = moment(moments, p, x / edge[p])
                        tail = (1 - m) * multiplier * x ** (-m) if m != 0.0 else multiplier
                        h = 2 * d * x / (1 + m) - x**3 * (4 * g + dg) - tail
                        slope = 2 * d / (1 + m) - x * x * (12 * g + 7 * dg) + m * tail / x
                        # on the rising branch of h the ray has not reached its maximum yet
                        step = 0.2 * x if slope > -0.1 * d else -h / slope
                        step = min(max(step, -0.25 * x), 0.25 * x)
                        x = min(x + step, edge[p])
                        if abs(step) < 2e-3 * x:
                            break
                    a[p] = x
            load, around, area, filled = 0.0, 0.0, 0.0, 0.0
            for p in range(rays):
                x = a[p]
                g, dg = moment(moments, p, x / edge[p])
                square = weight[p] * x * x
                load += square * (d / (1 + m) - x * x * g)
                around += weight[p] * x ** (1 - m)
                area += 0.5 * square
                if x >= edge[p]:
                    filled += weight[p]
            before = multiplier
            multiplier = load / around
            force = 2 * multiplier
            change = abs(multiplier - before) / max(abs(multiplier), 1e-300)
            if change < 1e-4:
                break
        out[level, 0] = force
        out[level, 1] = 4 * area / ((1 + m) * around)
        out[level, 2] = area
        out[level, 3] = filled / (2 * math.pi)


@njit(cache=True, fastmath=FAST, nogil=True)
def march_rays(begin, end, q, weights, weight, edge, length, height, levels, m, rounds, out):
    """Profiles [begin, end): fills out (n, levels, 4)."""
    rays, nodes = q.shape[1:]
    radii = weights.shape[0]
    moments = np.empty((rays, radii))
    for i in range(begin, end):
        scale = length[i] ** 2 / height[i]
        for p in range(rays):
            for j in range(radii):
                s = 0.0
                for k in range(nodes):
                    s += weights[j, k] * q[i, p, k]
                moments[p, j] = s * scale
        _march(moments, weight[i], edge[i], levels, m, rounds, out[i])
