"""Numba kernels of the expansion of sampled profiles about a circle, eight profiles at once.

Arrays are groups of eight numbers, one per profile (`_lanes`).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.lane_functions import least, most, sine_cosine
from surfaces.numerics.lane_layout import groups, spread_rows
from surfaces.numerics.lanes import LANES, add, load, pick, splat, store, where, whole

QUANTITIES = 11
"""Numbers at every radius, see `expand_profiles`."""


@inner(fastmath=QUOTIENTS)
def _directions(phi, rays, count, cosine, sine):
    """cos n phi and sin n phi of all rays, n < count."""
    for k in range(rays):
        turn = load(phi, k)
        turn -= (2 * math.pi) * whole(turn * (0.5 / math.pi) + 0.5)
        s, c = sine_cosine(0.5 * turn)
        s, c = 2.0 * s * c, 1.0 - 2.0 * s * s
        cn, sn = splat(1.0), splat(0.0)
        for n in range(count):
            store(cosine, n * rays + k, cn)
            store(sine, n * rays + k, sn)
            cn, sn = cn * c - sn * s, sn * c + cn * s


@inner(fastmath=QUOTIENTS)
def _lengthen(q, rays, nodes, out):
    """The nodes of all rays, with one more at both ends for parabolic slopes there."""
    wide = nodes + 2
    for k in range(rays):
        for j in range(nodes):
            store(out, k * wide + 1 + j, load(q, k * nodes + j))
        o = k * wide
        before = 3.0 * (load(out, o + 1) - load(out, o + 2)) + load(out, o + 3)
        store(out, o, before)
        o += nodes
        store(out, o + 1, 3.0 * (load(out, o) - load(out, o - 1)) + load(out, o - 2))


@inner(fastmath=QUOTIENTS)
def _applied(q, first, wide, edge, a, m, nodes, radial, share, rays, k, out):
    """Radial operators of ray k at the radii a, times its share of the angle.

    Fills, `rays` groups apart, the edge operators n = 0 ... N + 1, G~ and a D'; beyond them
    operator N + 1 without the share. Beyond its end a ray goes on with its last slope and the
    curvature 2q.
    """
    orders = radial.shape[0] - 2
    cells = wide - 3.0
    ratio, square = a / edge, edge * edge
    end = load(q, first + wide - 2)
    slope = load(q, first + wide - 1) - load(q, first + wide - 3)
    slope = most(2.0 * end + (0.5 * cells) * slope, splat(0.0))
    for n in range(orders + 2):
        store(out, n * rays + k, splat(0.0))
    for j in range(nodes.size):
        s = ratio * nodes[j]
        x = s * cells
        cell = least(whole(x), splat(cells - 1.0))
        x -= cell
        cell += 1.0 * first
        v0, v1, v2, v3 = (
            pick(q, cell), pick(q, cell + 1.0), pick(q, cell + 2.0), pick(q, cell + 3.0)
        )  # fmt: skip
        c1, c2 = 0.5 * (v2 - v0), v0 - 2.5 * v1 + 2.0 * v2 - 0.5 * v3
        c3 = 0.5 * (v3 - v0) + 1.5 * (v1 - v2)
        value = v1 + x * (c1 + x * (c2 + x * c3))
        change = s * cells * (c1 + x * (2.0 * c2 + 3.0 * x * c3))
        bend = s * s * (cells * cells) * (2.0 * c2 + 6.0 * x * c3)
        over, s2 = s - 1.0, s * s
        inside = s < 1.0
        f0 = where(inside, s2 * value, end + (slope + end * over) * over)
        f1 = where(inside, s2 * (2.0 * value + change), s * (slope + 2.0 * end * over))
        f2 = where(inside, s2 * (2.0 * value + 4.0 * change + bend), 2.0 * s2 * end)
        f0, f1, f2 = square * f0, square * f1, square * f2
        both = (1 + m) * f0 + f1
        for n in range(orders):
            add(out, n * rays + k, radial[n, j] * both)
            both += f0
        add(out, orders * rays + k, radial[orders, j] * f0)
        add(out, (orders + 1) * rays + k, radial[orders + 1, j] * (f1 + f2))
    store(out, (orders + 2) * rays + k, load(out, (orders - 1) * rays + k))
    for n in range(orders + 2):
        store(out, n * rays + k, share * load(out, n * rays + k))


@inner(fastmath=QUOTIENTS)
def _sum(array, first, count):
    total = splat(0.0)
    for k in range(first, first + count):
        total += load(array, k)
    return total


@inner(fastmath=QUOTIENTS)
def _reduced(applied, rays, cosine, sine, share, harmonics, waves, row, place):
    """Angular part of `expand_profiles` for one radius; `waves` is working space."""
    count = harmonics.size - 1
    mean = _sum(applied, 2 * rays, rays)
    store(row, place, _sum(applied, 0, rays))
    store(row, place + 1, _sum(applied, (count + 2) * rays, rays))
    store(row, place + 2, _sum(applied, (count + 1) * rays, rays))
    resolved, change = splat(0.0), splat(0.0)
    for n in range(1, count):
        re, im, tail_re, tail_im = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        for k in range(rays):
            c, s = load(cosine, n * rays + k), load(sine, n * rays + k)
            own, tail = load(applied, n * rays + k), load(applied, count * rays + k)
            re += c * own
            im += s * own
            tail_re += c * tail
            tail_im += s * tail
        power = 2.0 * (re * re + im * im)
        resolved += power
        change += harmonics[n] * power
        store(waves, 2 * n, 2.0 * (re - tail_re))
        store(waves, 2 * n + 1, 2.0 * (im - tail_im))
    tail_mean = _sum(applied, count * rays, rays)
    lowest, highest = splat(math.inf), splat(-math.inf)
    smallest, largest = splat(math.inf), splat(-math.inf)
    square, published_square = splat(0.0), splat(0.0)
    for k in range(rays):
        part = load(share, k)
        published = load(applied, 2 * rays + k) / part - mean
        edge = load(applied, (count + 3) * rays + k) - tail_mean
        for n in range(1, count):
            edge += load(waves, 2 * n) * load(cosine, n * rays + k)
            edge += load(waves, 2 * n + 1) * load(sine, n * rays + k)
        published_square += part * published * published
        square += part * edge * edge
        lowest, highest = least(published, lowest), most(published, highest)
        smallest, largest = least(edge, smallest), most(edge, largest)
    store(row, place + 3, published_square)
    store(row, place + 4, square)
    store(row, place + 5, change + harmonics[count] * most(square - resolved, splat(0.0)))
    store(row, place + 6, lowest)
    store(row, place + 7, highest)
    store(row, place + 8, smallest)
    store(row, place + 9, largest)


def circle_space(rays: int, samples: int, count: int) -> tuple[Any, ...]:
    """Working groups of `expand_profiles` for `count` harmonics, the mean among them."""
    row = -(-rays // LANES) * LANES
    own = (LANES, row, row, row, -(-rays * samples // LANES) * LANES, rays * (samples + 2))
    angular = (count * rays, count * rays, (count + 4) * rays, 2 * count, 1, QUANTITIES)
    return tuple(map(groups, own)), tuple(map(groups, angular))


@compiled(fastmath=QUOTIENTS)
def expand_profiles(begin, end, profiles, fractions, nodes, radial, harmonics, m, out, space):
    """Approach, its slope, mean profile and squared edge amplitudes at a grid of radii.

    Fills, for the contacts [begin, end) and the radii ``top[i] * fractions[l]``, rows of: 0 D,
    1 a D', 2 the mean of G~, 3 mean square of the published numerator, 4 the same
    harmonic-resolved, 5 the sum of (m + (1-m) n) <e_n^2>, 6 and 7 the smallest and largest
    numerator (published), 8 and 9 (harmonic), 10 the share of angle on which the circle lies
    beyond the ray's end. `profiles` holds directions, weights, lengths and nodes of the rays, one
    profile per row of whole groups (`packed`), the numbers of rays and of their nodes, which
    profiles are valid, and `top`. `radial` holds the radial weights of the operators n = 0 ...
    N + 1, of G~ and of a D', and `harmonics` m + (1-m) n for n = 0 ... N + 1; what the harmonics up
    to N leave over is treated as harmonic N + 1.
    """
    phis, weights, edges, qs, rays, samples, valid, top = profiles
    count = harmonics.size - 1
    who = np.zeros(LANES, np.int64)
    (block, phi, share, edge, rows, q), angular = space
    cosine, sine, applied, waves, highest, row = angular
    taken = 0
    for i in range(begin, end):
        if valid[i]:
            for lane in range(taken, LANES):
                who[lane] = i
                highest[lane] = top[i]
            taken += 1
        if taken < LANES and (i + 1 < end or taken == 0):
            continue
        spread_rows(phis, who, phi, block)
        spread_rows(weights, who, share, block)
        spread_rows(edges, who, edge, block)
        spread_rows(qs, who, rows, block)
        _directions(phi, rays, count, cosine, sine)
        _lengthen(rows, rays, samples, q)
        for k in range(rays):
            store(share, k, load(share, k) * (0.5 / math.pi))
        for step in range(fractions.size):
            a = load(highest, 0) * fractions[step]
            beyond = splat(0.0)
            for k in range(rays):
                _applied(
                    q, k * (samples + 2), samples + 2, load(edge, k), a, m, nodes, radial,
                    load(share, k), rays, k, applied,
                )  # fmt: skip
                beyond += where(a > load(edge, k), load(share, k), 0.0)
            _reduced(applied, rays, cosine, sine, share, harmonics, waves, row, 0)
            store(row, 10, beyond)
            for lane in range(taken):
                for k in range(QUANTITIES):
                    out[who[lane] - begin, step, k] = row[k * LANES + lane]
        taken = 0
