"""Compiled loops that fit polynomials to summits, and move them to other axes.

Eight profiles at once, in groups of eight numbers (`surfaces.numerics.lanes`), in units of one
height and one length of each. Coefficients run over the monomials of `ellipse_operator.monomials`.
"""

from __future__ import annotations

import math

import numpy as np

from asperity.microcontact.hertz import ASPECT_EXPONENT
from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.lanes import (
    LANES,
    between,
    collect_rows,
    exponential,
    groups,
    in_groups,
    least,
    load,
    logarithm,
    most,
    ordered,
    pick,
    sine_cosine,
    splat,
    spread_rows,
    store,
)
from surfaces.numerics.vectors import root, some, where, whole

from .ellipse_operator import DEGREE

TERMS = (DEGREE + 1) * (DEGREE + 2) // 2
"""Number of monomials: a constant, so that the loops unroll."""

NESTED_FITS = 5
"""Nested fits of a summit."""

SMALLEST_RATIO = 1 / 40
"""Least axis ratio of the ellipses on which a summit is fitted."""

SCALES = LANES
"""Numbers of a profile: units of length and height, area of the basin over squared length, ratio of
the rays, logarithms of the semi-axes of the first ellipse, shortest ray, 1 if the fit is usable."""


@inner(fastmath=QUOTIENTS)
def move(x0, y0, sine, tangent, out):
    """Coefficients about (x0, y0) in axes turned by an angle, in place: Taylor shifts, then three
    shears, for the `sine` of the angle and the `tangent` of half of it.
    """
    for axis, shift in enumerate((x0, y0)):
        for other in range(DEGREE):
            top = DEGREE - other
            for p in range(top):
                for power in range(top - 1, p - 1, -1):
                    k = power + other
                    low = k * (k + 1) // 2 + (power if axis == 1 else other)
                    high = low + k + 1 + axis
                    store(out, low, load(out, low) + shift * load(out, high))
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


@inner(fastmath=QUOTIENTS, inline="always")
def mirrored(a, b, c, d):
    """Parity sums over the four mirror images: even, odd in x and y, odd in x, odd in y.

    Of four such parts it makes the values at the images 0, 3, 1, 2.
    """
    return a + b + c + d, a - b + c - d, a - b - c + d, a + b - c - d


@inner(fastmath=QUOTIENTS)
def _sample(q, rays, nodes, edge, reach, radii, scale, out):
    """scale * f at the falling radii `reach * radii` of rays with q = f/r**2 at equispaced nodes.

    Beyond the edge f continues as the parabola through its last three values, up to its vertex.
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


@inner(fastmath=QUOTIENTS)
def fit(q, nodes, edge, scale, reach, wide, rules, number, coefs):
    """Least-squares polynomials of summits on nested ellipses.

    `reach[p]` is the length of ray p in the largest ellipse, `wide` holds its inverse semi-axes.
    `rules` are those of `batch._fit_rules`: fit s uses the samples `radii[rings[s]]`; `image[b]`
    are the mirror images of ray b, by which the fit separates into four parity classes;
    `matrices[number, c]` gives the coefficients of the monomials `members[c, :count[c]]` from the
    means of class c at the points.
    Fills the groups `coefs` of x**i y**j, (NESTED_FITS, monomials).
    """
    radii, rings, image, matrices, members, count = rules
    per, samples, rays = rings.shape[1], radii.size, 4 * (image.shape[0] - 1)
    points = image.shape[0] * per
    value, part = groups(rays * samples), groups(4 * points * NESTED_FITS)
    power = groups(2 * (DEGREE + 1))
    _sample(q, rays, nodes, edge, reach, radii, scale, value)
    for b in range(image.shape[0]):
        p0, p1, p2, p3 = image[b, 0], image[b, 1], image[b, 2], image[b, 3]
        for s in range(NESTED_FITS):
            for j in range(per):
                r = rings[s, j]
                f0, f1 = load(value, p0 * samples + r), load(value, p1 * samples + r)
                f2, f3 = load(value, p2 * samples + r), load(value, p3 * samples + r)
                at, step = (b * per + j) * NESTED_FITS + s, points * NESTED_FITS
                for c, total in enumerate(mirrored(f0, f1, f2, f3)):
                    store(part, at + c * step, total)
    for axis in range(2):
        outer = splat(1.0)
        for k in range(DEGREE + 1):
            store(power, axis * (DEGREE + 1) + k, outer)
            outer *= load(wide, axis)
    for i in range(NESTED_FITS * TERMS):
        store(coefs, i, splat(0.0))
    for c in range(4):
        for k in range(count[c]):
            r, i, j = members[c, k, 0], members[c, k, 1], members[c, k, 2]
            unit = load(power, i) * load(power, DEGREE + 1 + j)
            for s in range(NESTED_FITS):
                found = splat(0.0)
                for n in range(points):
                    at = (c * points + n) * NESTED_FITS + s
                    found += matrices[number, c, k, n] * load(part, at)
                store(coefs, s * TERMS + r, found * unit * (1 / radii[rings[s, 0]] ** (i + j)))


@inner(fastmath=QUOTIENTS)
def usable(coefs):
    """1 where all fits are finite and the smallest one is convex across the ridge, else 0."""
    fine = load(coefs, (NESTED_FITS - 1) * TERMS + 5) > 0.0
    for i in range(NESTED_FITS * TERMS):
        fine = fine & (load(coefs, i) < 1e300) & (load(coefs, i) > -1e300)
    return where(fine, splat(1.0), 0.0)


@inner(fastmath=QUOTIENTS)
def _frame(phi, angle, weight, large, small, edge, q, nodes, skews, rays, m, scales, frame, wide):
    """Length, height, ratio of the rays and number of the base ellipse of profiles.

    Fills, in groups, `frame` with the directions of the rays in the axes of the summit, their
    lengths, and their lengths in the ellipse of semi-axes 1/`wide`; and all `scales` but the
    semi-axes and the last. Returns the numbers. The ellipse has about the axis ratio of the
    Hertzian contact; the largest fit reaches 1.1 times the rms distance of the basin edge in units
    of it. Tables end at the height: the approach 2/(1 + m) f at which a paraboloid fills.
    """
    ray = rays // 8
    for p in range(rays):
        turn = load(phi, p) - angle
        turn -= (2 * math.pi) * whole(turn * (0.5 / math.pi) + 0.5)
        s, c = sine_cosine(0.5 * turn)
        store(frame, p, 1.0 - 2.0 * s * s)
        store(frame, rays + p, 2.0 * s * c)
    stretch = math.tan(2 * math.pi * ray / rays) * load(frame, ray) / load(frame, rays + ray)
    ratio = between(small / large, splat(0.0), splat(1.0))
    ratio = most(
        ASPECT_EXPONENT * logarithm(most(ratio, splat(1e-300))), splat(math.log(SMALLEST_RATIO))
    )
    ratio = where(large > 0.0, ratio, 0.0)
    step = math.log(skews[1] / skews[0])
    number = whole(-(ratio + logarithm(stretch) + math.log(skews[0])) * (1 / step) + 0.5)
    number = between(number, splat(0.0), splat(skews.size - 1.0))
    across = root(skews[0] * exponential(step * number) * stretch)
    along = 1.0 / across
    square, top = splat(0.0), splat(0.0)
    for p in range(rays):
        cx, cy, length = load(frame, p) * along, load(frame, rays + p) * across, load(edge, p)
        unit = cx * cx + cy * cy
        square += length * length * unit
        store(frame, 3 * rays + p, 1.0 / root(unit))
        top = most(load(q, p * nodes + nodes - 1) * length * length, top)
    length = 1.1 * root(square * (1 / rays))
    inverse = 1.0 / length
    basin, smallest = splat(0.0), splat(1e300)
    for p in range(rays):
        own = load(edge, p) * inverse
        store(frame, 2 * rays + p, own)
        store(frame, 3 * rays + p, load(frame, 3 * rays + p) * length)
        basin += 0.5 * load(weight, p) * own * own
        smallest = least(own, smallest)
    store(scales, 0, length)
    store(scales, 1, 2.0 / (1.0 + m) * top)
    store(scales, 2, basin)
    store(scales, 3, stretch)
    store(scales, 6, smallest)
    store(wide, 0, along)
    store(wide, 1, across)
    return number


@inner(fastmath=QUOTIENTS)
def _first_ellipse(coefs, depth, m, scales):
    """Logarithms of the semi-axes of the Hertz contacts of the paraboloids in the smallest fits."""
    o = (NESTED_FITS - 1) * TERMS
    along, across = most(load(coefs, o + 3), splat(1e-300)), most(load(coefs, o + 5), splat(1e-30))
    ratio = most(ASPECT_EXPONENT * logarithm(along / across), splat(math.log(SMALLEST_RATIO)))
    mean = logarithm(across) + (0.5 / ASPECT_EXPONENT) * ratio
    size = 0.5 * (math.log(0.5 * depth * (1 + m)) - mean)
    store(scales, 4, size - 0.5 * ratio)
    store(scales, 5, size + 0.5 * ratio)


@compiled()
def fit_rows(begin, end, profiles, rules, depth, m, frames, coefs, scales):
    """Frames (rows of directions, lengths and reaches of the rays), fits and scales of profiles.

    Row 0 of the results belongs to the profile `begin`; the last of the `scales` is zero where a
    profile has no usable fit. `depth` is the smallest approach.
    """
    phis, angles, weights, curvatures, edges, qs, valid, rays, nodes = profiles
    skews, fitting = rules
    n = end - begin
    row = in_groups(rays)
    block, phi, weight, edge = groups(LANES), groups(row), groups(row), groups(row)
    q, fits = groups(in_groups(rays * nodes)), groups(in_groups(NESTED_FITS * TERMS))
    frame, own, wide = groups(4 * rays), groups(SCALES), groups(2)
    numbers, single = groups(1), groups(3)
    who, chosen = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    axes, number = np.zeros((n, 2)), np.zeros(n, np.int64)
    for i in range(0, n, LANES):
        count = min(LANES, n - i)
        for lane in range(LANES):
            k = begin + i + min(lane, count - 1)
            who[lane] = k
            single[lane], single[LANES + lane] = angles[k], curvatures[k, 0]
            single[2 * LANES + lane] = curvatures[k, 1]
        for source, target in ((phis, phi), (weights, weight), (edges, edge), (qs, q)):
            spread_rows(source, who, target, block)
        found = _frame(
            phi, load(single, 0), weight, load(single, 1), load(single, 2), edge, q, nodes, skews,
            rays, m, own, frame, wide,
        )  # fmt: skip
        store(numbers, 0, found)
        for lane in range(LANES):
            who[lane] = i + lane
        for source, rows in ((frame, frames), (own, scales)):
            collect_rows(source, rows, who, count, block)
        for lane in range(count):
            k = i + lane
            axes[k, 0], axes[k, 1] = wide[lane], wide[LANES + lane]
            fine = valid[begin + k] and scales[k, 0] > 0.0 and scales[k, 1] > 0.0
            number[k] = int(numbers[lane]) if fine else skews.size
            scales[k, LANES - 1] = 0.0
    order = ordered(number, skews.size)
    taken = 0
    for i in range(n):
        k = order[i]
        if number[k] == skews.size:
            break
        for lane in range(taken, LANES):
            who[lane] = k
        taken += 1
        if taken < LANES and i + 1 < n and number[order[i + 1]] == number[k]:
            continue
        for lane in range(LANES):
            wide[lane], wide[LANES + lane] = axes[who[lane], 0], axes[who[lane], 1]
            chosen[lane] = begin + who[lane]
        for source, at, target in (
            (frames, who, frame), (scales, who, own), (edges, chosen, edge), (qs, chosen, q)
        ):  # fmt: skip
            spread_rows(source, at, target, block)
        fit(
            q, nodes, edge, 0.25 / load(own, 1), frame[3 * rays * LANES :], wide, fitting,
            number[k], fits,
        )  # fmt: skip
        _first_ellipse(fits, depth, m, own)
        store(own, SCALES - 1, usable(fits))
        for source, rows in ((fits, coefs), (own, scales)):
            collect_rows(source, rows, who, taken, block)
        taken = 0
