"""Compiled loops over the rays of sampled profiles, one profile at a time.

Laws "paper" and "harmonic": the expansion about a circle (`single.circle`; Popov, Li & Willert
2023, equations 22-25, 49, 50; docs/development/laws.md, "harmonic"). Radial integrals are taken by
a Gauss-Jacobi rule, angular ones by sums over rays. Law "ritz": the Barber-Fabrikant functional
(`single.ritz`), stationary over rays a <= edge; units of its loops are one length and one height
per profile, modulus 1.
"""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner

_RAY_STEPS, _SMALL_STEP, _SMALL_CHANGE = 6, 2e-3, 1e-4
"""Newton steps of a ray at most, the relative step and the relative change that end a search."""

QUANTITIES = 11
"""Numbers at every radius, see `expand_profiles`."""


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
    for _ in range(_RAY_STEPS):
        h, dh = _moment(table, x / edge)
        tail = (1.0 - m) * multiplier * (x**-m if m != 0.0 else 1.0)
        gain = (2 * d / (1 + m)) * x - x * x * x * (4.0 * h + dh) - tail
        slope = 2 * d / (1 + m) - x * x * (12.0 * h + 7.0 * dh) + m * tail / x
        # while the gain rises the ray has not reached its maximum yet
        step = 0.2 * x if slope > -0.1 * d else -gain / slope
        before, x = x, min(x + min(max(step, -0.25 * x), 0.25 * x), edge)
        if abs(x - before) < _SMALL_STEP * x:
            break
    return x


@inner(fastmath=QUOTIENTS)
def _march(moments, weight, edge, levels, m, rounds, a, out):
    """Stationary value of the functional over free rays a <= edge at the approaches levels**2.

    out: force, punch stiffness, area, filled share of the angle at every level.
    """
    rays = edge.size
    for p in range(rays):
        first = (3 + m) * moments[p, 0]  # that of a paraboloid, a^2 = (1 + m) d R
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
            if abs(multiplier - before) < _SMALL_CHANGE * max(abs(multiplier), 1e-300):
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


@inner(fastmath=QUOTIENTS)
def _lengthen(q, line):
    """The nodes of a ray, with one more at both ends for parabolic slopes there."""
    last = q.size + 1
    line[1:last] = q
    line[0] = 3.0 * (line[1] - line[2]) + line[3]
    line[last] = 3.0 * (line[last - 1] - line[last - 2]) + line[last - 3]


@inner(fastmath=QUOTIENTS)
def _apply(line, edge, a, m, nodes, radial, share, out):
    """Radial operators n = 0 ... N + 1, G~ and a D' of a ray at the radius a, times its share of
    the angle.

    Between its nodes f/r^2 is a cubic (Catmull-Rom); beyond its end the ray goes on with its last
    slope and the curvature 2q.
    """
    orders, cells = radial.shape[0] - 2, line.size - 3
    end = line[cells + 1]
    slope = max(2.0 * end + 0.5 * cells * (line[cells + 2] - line[cells]), 0.0)
    unit = share * edge * edge
    out[:] = 0.0
    for j in range(nodes.size):
        s = a / edge * nodes[j]
        if s < 1.0:
            cell = min(int(s * cells), cells - 1)
            x = s * cells - cell
            v0, v1, v2, v3 = line[cell], line[cell + 1], line[cell + 2], line[cell + 3]
            c1, c2 = 0.5 * (v2 - v0), v0 - 2.5 * v1 + 2.0 * v2 - 0.5 * v3
            c3 = 0.5 * (v3 - v0) + 1.5 * (v1 - v2)
            value = v1 + x * (c1 + x * (c2 + x * c3))
            change = s * cells * (c1 + x * (2.0 * c2 + 3.0 * x * c3))
            bend = s * s * cells * cells * (2.0 * c2 + 6.0 * x * c3)
            f0 = s * s * value
            f1 = s * s * (2.0 * value + change)
            f2 = s * s * (2.0 * value + 4.0 * change + bend)
        else:
            over = s - 1.0
            f0 = end + (slope + end * over) * over
            f1 = s * (slope + 2.0 * end * over)
            f2 = 2.0 * s * s * end
        f0, f1, f2 = unit * f0, unit * f1, unit * f2
        for n in range(orders):
            out[n] += radial[n, j] * ((1.0 + m + n) * f0 + f1)
        out[orders] += radial[orders, j] * f0
        out[orders + 1] += radial[orders + 1, j] * (f1 + f2)


@inner(fastmath=QUOTIENTS)
def _reduce(applied, turns, share, harmonics, row):
    """Angular part of `expand_profiles` for one radius, from the operators of all rays
    `applied` (rays, N + 4) and the `turns` exp(i n phi), shape (N + 1, rays)."""
    count = harmonics.size - 1
    means = applied.sum(axis=0)
    row[0], row[1], row[2] = means[0], means[count + 2], means[count + 1]
    waves = np.zeros(count, np.complex128)
    resolved, change = 0.0, 0.0
    for n in range(1, count):
        own, tail = 0j, 0j
        for k in range(share.size):
            own += turns[n, k] * applied[k, n]
            tail += turns[n, k] * applied[k, count]
        power = 2.0 * (own.real * own.real + own.imag * own.imag)
        resolved += power
        change += harmonics[n] * power
        waves[n] = 2.0 * (own - tail)
    square, published_square = 0.0, 0.0
    row[6], row[7], row[8], row[9] = math.inf, -math.inf, math.inf, -math.inf
    for k in range(share.size):
        published = applied[k, 2] / share[k] - means[2]
        edge = applied[k, count] / share[k] - means[count]
        for n in range(1, count):
            edge += waves[n].real * turns[n, k].real + waves[n].imag * turns[n, k].imag
        published_square += share[k] * published * published
        square += share[k] * edge * edge
        row[6], row[7] = min(row[6], published), max(row[7], published)
        row[8], row[9] = min(row[8], edge), max(row[9], edge)
    row[3], row[4] = published_square, square
    row[5] = change + harmonics[count] * max(square - resolved, 0.0)


@compiled(fastmath=QUOTIENTS)
def expand_profiles(begin, end, profiles, fractions, nodes, radial, harmonics, m, out):
    """Approach, its slope, mean profile and squared edge amplitudes at a grid of radii.

    Fills, for the contacts [begin, end) and the radii ``top[i] * fractions[l]``, rows of: 0 D,
    1 a D', 2 the mean of G~, 3 mean square of the published numerator, 4 the same
    harmonic-resolved, 5 the sum of (m + (1-m) n) <e_n^2>, 6 and 7 the smallest and largest
    numerator (published), 8 and 9 (harmonic), 10 the share of angle on which the circle lies
    beyond the ray's end. `profiles` holds directions, weights, lengths (n, rays) and nodes
    (n, rays, nodes) of the rays, which profiles are usable, and `top`. `radial` holds the radial
    weights of the operators n = 0 ... N + 1, of G~ and of a D', and `harmonics` m + (1-m) n for
    n = 0 ... N + 1; what the harmonics up to N leave over is treated as harmonic N + 1.
    """
    phi, weight, edge, q, usable, top = profiles
    rays, samples = q.shape[1], q.shape[2]
    line = np.empty((rays, samples + 2))
    applied = np.empty((rays, radial.shape[0]))
    turns = np.ones((harmonics.size - 1, rays), np.complex128)
    for i in range(begin, end):
        if not usable[i]:
            continue
        share = weight[i] * (0.5 / math.pi)
        for k in range(rays):
            _lengthen(q[i, k], line[k])
            turn = complex(math.cos(phi[i, k]), math.sin(phi[i, k]))
            for n in range(1, len(turns)):
                turns[n, k] = turns[n - 1, k] * turn
        for step in range(fractions.size):
            a, row = top[i] * fractions[step], out[i - begin, step]
            row[10] = 0.0
            for k in range(rays):
                _apply(line[k], edge[i, k], a, m, nodes, radial, share[k], applied[k])
                if a > edge[i, k]:
                    row[10] += share[k]
            _reduce(applied, turns, share, harmonics, row)
