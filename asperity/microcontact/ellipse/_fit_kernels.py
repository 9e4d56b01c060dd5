"""Compiled loops of the polynomials of summits, eight at once: fitted, moved, and the small systems
of Newton steps.

Units inside: one height per profile, and its length for the coefficients. Arrays are groups of
eight numbers, one per profile (`surfaces.numerics.lanes`). Coefficients run over the monomials
x**i y**j of `ellipse_operator.monomials`.
"""

from __future__ import annotations

from typing import Any

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.lane_functions import between, least, most
from surfaces.numerics.lane_layout import groups
from surfaces.numerics.lanes import load, pick, splat, store
from surfaces.numerics.vectors import some, where, whole

from .ellipse_operator import DEGREE

TERMS = (DEGREE + 1) * (DEGREE + 2) // 2
"""Number of monomials: a constant, so that the loops unroll."""

FITS = 5
"""Nested fits of a summit."""


@inner(fastmath=QUOTIENTS)
def move(x0, y0, sine, tangent, out):
    """Coefficients about (x0, y0) in turned axes, by Taylor shifts and three shears.

    Given are the sine of the turn and the tangent of half of it.
    """
    for j in range(DEGREE):
        top = DEGREE - j
        for p in range(top):
            for i in range(top - 1, p - 1, -1):
                k = i + j
                low, high = k * (k + 1) // 2 + j, (k + 1) * (k + 2) // 2 + j
                store(out, low, load(out, low) + x0 * load(out, high))
    for i in range(DEGREE):
        top = DEGREE - i
        for p in range(top):
            for j in range(top - 1, p - 1, -1):
                k = i + j
                low, high = k * (k + 1) // 2 + j, (k + 1) * (k + 2) // 2 + j + 1
                store(out, low, load(out, low) + y0 * load(out, high))
    for k in range(1, DEGREE + 1):
        o = k * (k + 1) // 2
        for shear in range(3):
            for p in range(k):
                for j in range(k - 1, p - 1, -1):
                    if shear == 1:
                        store(out, o + j, load(out, o + j) + sine * load(out, o + j + 1))
                    else:
                        above = tangent * load(out, o + k - j - 1)
                        store(out, o + k - j, load(out, o + k - j) - above)


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
def _sample(q, rays, nodes, edge, reach, radii, scale, out):
    """scale * f at the falling radii `reach * radii` of rays with q = f/r**2 at equispaced nodes.

    Beyond the edge f goes on with the parabola of its last three values, up to the vertex.
    """
    last = nodes - 1.0
    for p in range(rays):
        length, first = load(edge, p), p * nodes
        unit = load(reach, p) / length * last
        square = scale * load(reach, p) * load(reach, p)
        for j in range(radii.size):
            x = radii[j] * unit
            i = between(whole(x), splat(1.0), splat(last - 2.0))
            u = x - i
            i += 1.0 * first
            v0, v1, v2, v3 = pick(q, i - 1.0), pick(q, i), pick(q, i + 1.0), pick(q, i + 2.0)
            c1 = v2 - v0 * (1 / 3) - 0.5 * v1 - v3 * (1 / 6)
            c2 = 0.5 * (v0 + v2) - v1
            c3 = (v3 - v0) * (1 / 6) + 0.5 * (v1 - v2)
            value = (v1 + u * (c1 + u * (c2 + u * c3))) * (square * radii[j] ** 2)
            store(out, p * radii.size + j, value)
        if not some(unit >= last):
            continue
        square = scale * length * length * (1 / last**2)
        f2 = load(q, first + nodes - 1) * square * last**2
        f1 = load(q, first + nodes - 2) * square * (last - 1) ** 2
        f0 = load(q, first + nodes - 3) * square * (last - 2) ** 2
        bend = f2 - 2.0 * f1 + f0
        slope = most(f2 - f1 + 0.5 * bend, splat(0.0))
        furthest = where(bend < 0.0, -slope / bend, 1e300)
        for j in range(radii.size):
            u = radii[j] * unit - last
            inside = u < 0.0
            u = least(u, furthest)
            value = f2 + u * (slope + 0.5 * bend * u)
            at = p * radii.size + j
            store(out, at, where(inside, load(out, at), value))


def fit_space(rays: int, radii: int, points: int) -> tuple[Any, ...]:
    """Working groups of `fit`: samples, their parity classes and powers of the semi-axes."""
    return groups(rays * radii), groups(4 * points * FITS), groups(2 * (DEGREE + 1))


@inner(fastmath=QUOTIENTS)
def fit(q, nodes, edge, scale, reach, wide, rules, number, coefs, space):
    """Least-squares polynomials of summits on nested ellipses.

    `reach[p]` is the length of ray p in the largest ellipse, `wide` are the inverse semi-axes of
    these, `radii` the radii of the samples on all ellipses relative to the largest; fit s uses
    `radii[rings[s]]`. `image[b]` are the rays at (+,+), (-,+), (-,-), (+,-) of ray b in
    the first quadrant, so that the fit falls apart into four parity classes; `matrices[number, c]`
    gives the coefficients of the monomials `members[c, :count[c]]` from the means of class c at the
    points. Fills the groups `coefs` of x**i y**j, (FITS, monomials).
    """
    radii, rings, image, matrices, members, count = rules
    value, part, power = space
    per, samples = rings.shape[1], radii.size
    points = image.shape[0] * per
    _sample(q, 4 * (image.shape[0] - 1), nodes, edge, reach, radii, scale, value)
    for b in range(image.shape[0]):
        p0, p1, p2, p3 = image[b, 0], image[b, 1], image[b, 2], image[b, 3]
        for s in range(FITS):
            for j in range(per):
                r = rings[s, j]
                f0, f1 = load(value, p0 * samples + r), load(value, p1 * samples + r)
                f2, f3 = load(value, p2 * samples + r), load(value, p3 * samples + r)
                at, step = (b * per + j) * FITS + s, points * FITS
                store(part, at, f0 + f1 + f2 + f3)
                store(part, at + step, f0 - f1 + f2 - f3)
                store(part, at + 2 * step, f0 - f1 - f2 + f3)
                store(part, at + 3 * step, f0 + f1 - f2 - f3)
    for axis in range(2):
        outer = splat(1.0)
        for k in range(DEGREE + 1):
            store(power, axis * (DEGREE + 1) + k, outer)
            outer *= load(wide, axis)
    for i in range(FITS * TERMS):
        store(coefs, i, splat(0.0))
    for c in range(4):
        for k in range(count[c]):
            s0, s1, s2, s3, s4 = splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
            for n in range(points):
                weight, at = matrices[number, c, k, n], (c * points + n) * FITS
                s0 += weight * load(part, at)
                s1 += weight * load(part, at + 1)
                s2 += weight * load(part, at + 2)
                s3 += weight * load(part, at + 3)
                s4 += weight * load(part, at + 4)
            r, i, j = members[c, k, 0], members[c, k, 1], members[c, k, 2]
            unit = load(power, i) * load(power, DEGREE + 1 + j)
            for s, found in enumerate((s0, s1, s2, s3, s4)):
                store(coefs, s * TERMS + r, found * unit * (1 / radii[rings[s, 0]] ** (i + j)))


@inner(fastmath=QUOTIENTS)
def usable(coefs):
    """1 where the fits are finite and the smallest ellipse rises across the ridge, else 0."""
    fine = load(coefs, (FITS - 1) * TERMS + 5) > 0.0
    for i in range(FITS * TERMS):
        fine = fine & (load(coefs, i) < 1e300) & (load(coefs, i) > -1e300)
    return where(fine, splat(1.0), 0.0)
