"""Compiled loops of the expansion of sampled profiles about a circle, one profile at a time.

The equations are those of `single.circle` (published: 22-25, 49, 50; harmonic by harmonic: theory,
section 5), with the radial integrals by a Gauss-Jacobi rule and the angular ones by sums over rays;
`resample` turns values over radii into the columns of a law table.
"""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner

QUANTITIES = 11
"""Numbers at every radius, see `expand_profiles`."""


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


@compiled()
def resample(u, ratios, flags, good, basin, intervals, p):
    """Columns of the law table from values over rising ``u = sqrt(approach)``.

    `ratios` holds force/u^p, area/u^2 and spread, shape (3, peaks, radii); between the radii they
    are cubic through the four nearest. The table of a contact ends where the area reaches
    `basin`, else at its last `good` value.
    """
    peaks = good.size
    reach = np.zeros(peaks)
    values = np.zeros((4, peaks, intervals + 1))
    marks = np.zeros((peaks, intervals + 1), dtype=np.uint8)
    for i in range(peaks):
        last = good[i] - 1
        if last < 3:
            continue
        w, dw = np.empty(4), np.empty(4)
        end, filled = u[i, last], False
        for k in range(last + 1):
            area = ratios[1, i, k] * u[i, k] ** 2
            if area >= basin[i]:
                before = ratios[1, i, k - 1] * u[i, k - 1] ** 2 if k else 0.0
                square = u[i, k - 1] ** 2 if k else 0.0
                share = (basin[i] - before) / (area - before)
                end = math.sqrt(square + share * (u[i, k] ** 2 - square))
                filled = True
                break
        reach[i] = end * end
        base, near = 0, 0
        for j in range(1, intervals + 1):
            x = end * j / intervals
            while base + 4 < good[i] and u[i, base + 2] < x:
                base += 1
            while near < last and u[i, near] < x:
                near += 1
            _lagrange(u[i], base, x, w, dw)
            s, ds, b = 0.0, 0.0, 0.0
            for k in range(4):
                s += w[k] * ratios[0, i, base + k]
                ds += dw[k] * ratios[0, i, base + k]
                b += w[k] * ratios[1, i, base + k]
            power = x ** (p - 2.0)
            values[0, i, j] = max(power * x * x * s, values[0, i, j - 1])
            values[1, i, j] = max(0.5 * power * (p * s + x * ds), 0.5 * values[0, i, j] / (x * x))
            area = min(b * x * x, basin[i]) if filled else b * x * x
            values[2, i, j] = max(area, values[2, i, j - 1])
            values[3, i, j] = ratios[2, i, near]
            marks[i, j] = flags[i, near]
        if filled:
            values[2, i, intervals] = basin[i]
            marks[i, intervals] |= 128
    return reach, values[0], values[1], values[2], marks, values[3]


@inner()
def _lagrange(u, base, x, w, dw):
    """Weights of the value and of the slope at x of the cubic through four nodes."""
    for k in range(4):
        below, product, slope = 1.0, 1.0, 0.0
        for j in range(4):
            if j == k:
                continue
            below *= u[base + k] - u[base + j]
            slope = slope * (x - u[base + j]) + product
            product *= x - u[base + j]
        w[k] = product / below
        dw[k] = slope / below
