"""Numba kernel of the polynomial fits of one summit.

Units inside: one height per profile, and its length for the coefficients.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ._lanes import FAST
from .ellipse_tables import DEGREE

FITS = 5
"""Nested fits of a summit: a constant, so that they make a vector."""


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _sample(q, edge, reach, radii, scale, out):
    """scale * f at the falling radii `reach * radii` of rays with q = f/r**2 at equispaced nodes.

    Beyond the edge f goes on with the parabola of its last three values, up to the vertex.
    """
    last = q.shape[1] - 1
    for p in range(q.shape[0]):
        unit = reach[p] / edge[p] * last
        square = scale * reach[p] * reach[p]
        for j in range(radii.size):
            x = radii[j] * unit
            i = min(max(int(x), 1), last - 2)
            u = x - i
            v0, v1, v2, v3 = q[p, i - 1], q[p, i], q[p, i + 1], q[p, i + 2]
            c1 = v2 - v0 * (1 / 3) - 0.5 * v1 - v3 * (1 / 6)
            c2 = 0.5 * (v0 + v2) - v1
            c3 = (v3 - v0) * (1 / 6) + 0.5 * (v1 - v2)
            out[p, j] = (v1 + u * (c1 + u * (c2 + u * c3))) * (square * radii[j] * radii[j])
        if unit < last:
            continue
        square = scale * (edge[p] / last) ** 2
        f2 = q[p, last] * square * last**2
        f1 = q[p, last - 1] * square * (last - 1) ** 2
        f0 = q[p, last - 2] * square * (last - 2) ** 2
        bend = f2 - 2 * f1 + f0
        slope = max(f2 - f1 + 0.5 * bend, 0.0)
        furthest = -slope / bend if bend < 0.0 else 1e300
        for j in range(radii.size):
            u = radii[j] * unit - last
            if u < 0.0:
                break
            u = min(u, furthest)
            out[p, j] = f2 + u * (slope + 0.5 * bend * u)


@njit(cache=True, nogil=True)
def fit_space(rays, rings, monomials, points):
    """Working arrays of `fit_one`."""
    value, part = np.empty((rays, rings)), np.empty((4, points, FITS))
    return value, part, np.empty((monomials, FITS)), np.empty((2, FITS, DEGREE + 1))


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def fit_one(
    q, edge, height, reach, wide, radii, rings, image, matrices, members, count, coefs, space
):
    """Least-squares polynomials of a summit on nested ellipses.

    `reach[p]` is the length of ray p in the largest ellipse, `wide` are its semi-axes, `radii`
    those of the samples on all ellipses relative to the largest; fit s uses `radii[rings[s]]`.
    `image[b]` are the rays at (+,+), (-,+), (-,-), (+,-) of ray b in the first quadrant, so that
    the fit falls apart into four parity classes; `matrices[c]` gives the coefficients of the
    monomials `members[c, :count[c]]` from the means of class c at the points. Fills `coefs` of
    x**i y**j, shape (FITS, monomials).
    """
    value, part, found, power = space
    per = rings.shape[1]
    _sample(q, edge, reach, radii, 0.25 / height, value)
    for b in range(image.shape[0]):
        p0, p1, p2, p3 = image[b, 0], image[b, 1], image[b, 2], image[b, 3]
        for s in range(FITS):
            for j in range(per):
                r = rings[s, j]
                f0, f1, f2, f3 = value[p0, r], value[p1, r], value[p2, r], value[p3, r]
                part[0, b * per + j, s] = f0 + f1 + f2 + f3
                part[1, b * per + j, s] = f0 - f1 + f2 - f3
                part[2, b * per + j, s] = f0 - f1 - f2 + f3
                part[3, b * per + j, s] = f0 + f1 - f2 - f3
    for s in range(FITS):
        largest = radii[rings[s, 0]]
        power[:, s, 0] = 1.0
        for k in range(DEGREE):
            power[0, s, k + 1] = power[0, s, k] / (largest * wide[0])
            power[1, s, k + 1] = power[1, s, k] / (largest * wide[1])
    coefs[:, :3] = 0.0
    for c in range(4):
        np.dot(matrices[c], part[c], found)
        for k in range(count[c]):
            r, i, j = members[c, k, 0], members[c, k, 1], members[c, k, 2]
            for s in range(FITS):
                coefs[s, r] = found[k, s] * power[0, s, i] * power[1, s, j]
