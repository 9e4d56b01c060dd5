"""Numba kernels of the Barber-Fabrikant functional on free rays inside basins.

Units inside: one length and one height per profile, modulus 1. Eight profiles are done at once:
arrays are groups of eight numbers, one per profile (`_lanes`).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from ._lane_functions import between, exponential, least, logarithm, most
from ._lane_layout import groups, spread_rows
from ._lanes import FAST, LANES, absolute, load, pick, root, some, splat, store, where, whole

_TRIES, _NEAR, _STILL = 6, 2e-3, 1e-4
"""Newton steps of a ray at most, the relative step and the relative change that end a search."""


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
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


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _power(x, exponent):
    """x to a power of which the frequent ones are known."""
    if exponent == 0.0:
        return splat(1.0)
    if exponent == 1.0:
        return x
    return exponential(exponent * logarithm(x))


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _longest(moments, first, radii, start, edge, d, multiplier, m, going):
    """Radius of a ray at its maximum, from `start` on, where the mask holds."""
    x = start
    for _ in range(_TRIES):
        g, dg = _moment(moments, first, radii, x / edge)
        tail = (1 - m) * multiplier * _power(x, -m)
        h = (2 * d / (1 + m)) * x - x * x * x * (4.0 * g + dg) - tail
        slope = 2 * d / (1 + m) - x * x * (12.0 * g + 7.0 * dg)
        if m != 0.0:
            slope += m * tail / x
        # on the rising branch of h the ray has not reached its maximum yet
        step = where(slope > -0.1 * d, 0.2 * x, -h / slope)
        step = between(step, -0.25 * x, 0.25 * x)
        x = where(going, least(x + step, edge), x)
        going = going & (absolute(step) >= _NEAR * x)
        if not some(going):
            break
    return x


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _march(moments, rays, radii, weight, edge, levels, m, rounds, a, out):
    """Maximise the functional over free rays a <= edge at the approaches levels**2.

    out: force, punch stiffness, area, filled share of the angle at every level.
    """
    d0 = levels[0] ** 2
    for p in range(rays):
        first = (1 + m) * (3 + m) * load(moments, p * radii)
        store(a, p, least(root(d0 / first), load(edge, p)))
    multiplier = splat(-1.0)
    for level in range(levels.size):
        d = levels[level] ** 2
        if level > 0:
            growth = levels[level] / levels[level - 1]
            for p in range(rays):
                store(a, p, least(load(a, p) * growth, load(edge, p)))
            multiplier *= growth ** (3 + m)
        going = splat(0.0) < 1.0
        for _ in range(rounds):
            load_, around, area, filled = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
            moving = going & (multiplier > 0.0)
            for p in range(rays):
                x, end, w = load(a, p), load(edge, p), load(weight, p)
                if some(moving):
                    x = _longest(moments, p * radii, radii, x, end, d, multiplier, m, moving)
                    store(a, p, x)
                g, _ = _moment(moments, p * radii, radii, x / end)
                square = w * x * x
                load_ += square * (d / (1 + m) - x * x * g)
                around += w * _power(x, 1 - m)
                area += 0.5 * square
                filled += where(x >= end, w, 0.0)
            before = multiplier
            multiplier = load_ / around
            change = absolute(multiplier - before)
            going = going & (change >= _STILL * most(absolute(multiplier), splat(1e-300)))
            if not some(going):
                break
        store(out, 4 * level, 2.0 * multiplier)
        store(out, 4 * level + 1, 4.0 * area / ((1 + m) * around))
        store(out, 4 * level + 2, area)
        store(out, 4 * level + 3, filled * (0.5 / math.pi))


def ray_space(rays: int, nodes: int, radii: int, levels: int) -> tuple[Any, ...]:
    """Working groups of `march_rays`: a block and units, q, weights and lengths of the rays, their
    moments, radii and results."""
    row = -(-rays // LANES) * LANES
    own = (-(-rays * nodes // LANES) * LANES, row, row)
    return tuple(map(groups, (LANES, 1, *own, rays * radii, rays, 4 * levels)))


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def march_rays(begin, end, profiles, weights, levels, m, rounds, out, space):
    """Profiles [begin, end): fills out (n, levels, 4).

    `profiles` holds, one profile per row of whole groups (`packed`), q, the weights and the
    lengths of the rays; and how many rays there are, and the unit of q.
    """
    q, weight, edge, rays, scale = profiles
    radii, nodes = weights.shape
    block, unit, own, own_weight, own_edge, moments, a, found = space
    who = np.empty(LANES, np.int64)
    for i in range(begin, end, LANES):
        for lane in range(LANES):
            who[lane] = min(i + lane, end - 1)
            unit[lane] = scale[who[lane]]
        spread_rows(q, who, own, block)
        spread_rows(weight, who, own_weight, block)
        spread_rows(edge, who, own_edge, block)
        for p in range(rays):
            for j in range(radii):
                s = splat(0.0)
                for k in range(nodes):
                    s += weights[j, k] * load(own, p * nodes + k)
                store(moments, p * radii + j, s * load(unit, 0))
        _march(moments, rays, radii, own_weight, own_edge, levels, m, rounds, a, found)
        for lane in range(min(LANES, end - i)):
            for level in range(levels.size):
                for k in range(4):
                    out[i + lane, level, k] = found[(4 * level + k) * LANES + lane]
