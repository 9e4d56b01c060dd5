"""Numba kernel of what a profile adds to the paraboloid of its summit under a Hertzian contact."""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import QUOTIENTS, compiled


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
