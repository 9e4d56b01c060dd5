"""Numba kernels of the Barber-Fabrikant functional on free rays inside basins.

Units inside: one length and one height per profile, modulus 1. Profiles are done one by one, since
each takes a number of steps of its own; arrays are groups of eight numbers, one per ray (`_lanes`).
"""

from __future__ import annotations

import math
from typing import Any

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.lane_functions import between, exponential, least, logarithm
from surfaces.numerics.lane_layout import groups
from surfaces.numerics.lanes import (
    LANES,
    absolute,
    load,
    pick,
    root,
    some,
    splat,
    store,
    total,
    where,
    whole,
)

_TRIES, _NEAR, _STILL = 6, 2e-3, 1e-4
"""Newton steps of a ray at most, the relative step and the relative change that end a search."""


@inner(fastmath=QUOTIENTS)
def _moment(table, first, radii, x):
    """Moment h and x dh/dx at x = a/edge; equispaced table from 0, local cubics."""
    y = x * (radii - 1.0)
    i = between(whole(y), splat(1.0), splat(radii - 3.0))
    u = y - i
    i += 1.0 * first
    v0, v1, v2, v3 = (
        pick(table, i - 1.0), pick(table, i), pick(table, i + 1.0), pick(table, i + 2.0)
    )  # fmt: skip
    c1 = v2 - v0 * (1 / 3) - 0.5 * v1 - v3 * (1 / 6)
    c2 = 0.5 * (v0 + v2) - v1
    c3 = (v3 - v0) * (1 / 6) + 0.5 * (v1 - v2)
    return v1 + u * (c1 + u * (c2 + u * c3)), (c1 + u * (2.0 * c2 + 3.0 * u * c3)) * y


@inner(fastmath=QUOTIENTS)
def _power(x, exponent):
    """x to a power of which the frequent ones are known."""
    if exponent == 0.0:
        return splat(1.0)
    if exponent == 1.0:
        return x
    return exponential(exponent * logarithm(x))


@inner(fastmath=QUOTIENTS)
def _lengthen(moments, count, radii, edge, d, multiplier, m, a, moving):
    """Take the radii of all rays to their maxima, from where they are on."""
    for g in range(count):
        store(moving, g, splat(1.0))
    for _ in range(_TRIES):
        again = False
        for g in range(count):
            x, end, going = load(a, g), load(edge, g), load(moving, g) > 0.0
            h, dh = _moment(moments, g * radii, radii, x / end)
            tail = (1 - m) * multiplier * _power(x, -m)
            gain = (2 * d / (1 + m)) * x - x * x * x * (4.0 * h + dh) - tail
            slope = 2 * d / (1 + m) - x * x * (12.0 * h + 7.0 * dh)
            if m != 0.0:
                slope += m * tail / x
            # on the rising branch of the gain the ray has not reached its maximum yet
            step = where(slope > -0.1 * d, 0.2 * x, -gain / slope)
            longer = least(x + between(step, -0.25 * x, 0.25 * x), end)
            going = going & (absolute(longer - x) >= _NEAR * longer)
            store(a, g, where(load(moving, g) > 0.0, longer, x))
            store(moving, g, where(going, splat(1.0), 0.0))
            again |= some(going)
        if not again:
            break


@inner(fastmath=QUOTIENTS)
def _march(moments, count, radii, weight, edge, levels, m, rounds, a, moving, out):
    """Maximise the functional over free rays a <= edge at the approaches levels**2.

    out: force, punch stiffness, area, filled share of the angle at every level.
    """
    d = levels[0] ** 2
    for g in range(count):
        first = (1 + m) * (3 + m) * load(moments, g * radii)
        store(a, g, least(root(d / first), load(edge, g)))
    multiplier = -1.0
    for level in range(levels.size):
        d = levels[level] ** 2
        if level > 0:
            growth = levels[level] / levels[level - 1]
            for g in range(count):
                store(a, g, least(load(a, g) * growth, load(edge, g)))
            multiplier *= growth ** (3 + m)
        for _ in range(rounds):
            load_, around, area, filled = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
            if multiplier > 0.0:
                _lengthen(moments, count, radii, edge, d, multiplier, m, a, moving)
            for g in range(count):
                x, end, w = load(a, g), load(edge, g), load(weight, g)
                h, _ = _moment(moments, g * radii, radii, x / end)
                square = w * x * x
                load_ += square * (d / (1 + m) - x * x * h)
                around += w * _power(x, 1 - m)
                area += 0.5 * square
                filled += where(x >= end, w, 0.0)
            before, length = multiplier, total(around)
            multiplier = total(load_) / length
            if abs(multiplier - before) < _STILL * max(abs(multiplier), 1e-300):
                break
        out[level, 0] = 2.0 * multiplier
        out[level, 1] = 4.0 * total(area) / ((1 + m) * length)
        out[level, 2] = total(area)
        out[level, 3] = total(filled) * (0.5 / math.pi)


def ray_space(rays: int, nodes: int, radii: int) -> tuple[Any, ...]:
    """Working groups of `march_rays`: weights, lengths, q and moments of the rays, their radii and
    which of these move."""
    count = -(-rays // LANES)
    return tuple(map(groups, (count, count, nodes, count * radii, count, count)))


@compiled(fastmath=QUOTIENTS)
def march_rays(begin, end, profiles, weights, levels, m, rounds, out, space):
    """Profiles [begin, end): fills out (n, levels, 4).

    `profiles` holds q (n, rays, nodes), the weights and the lengths of the rays, and the unit of q.
    """
    q, shares, edges, scale = profiles
    rays = edges.shape[1]
    radii, nodes = weights.shape
    weight, edge, own, moments, a, moving = space
    count = weight.size // LANES
    for i in range(begin, end):
        for p in range(count * LANES):
            inside = p < rays
            weight[p] = shares[i, p] if inside else 0.0
            edge[p] = edges[i, p] if inside else 1.0
        for g in range(count):
            for k in range(nodes):
                for lane in range(LANES):
                    own[k * LANES + lane] = q[i, min(g * LANES + lane, rays - 1), k]
            for j in range(radii):
                s = splat(0.0)
                for k in range(nodes):
                    s += weights[j, k] * load(own, k)
                store(moments, g * radii + j, s * scale[i])
        _march(moments, count, radii, weight, edge, levels, m, rounds, a, moving, out[i])
