"""Compiled loops that make rows of a law table from profiles followed about their ellipses.

Units inside: one length and one height per profile, modulus 1. Arrays are groups of eight numbers,
one per profile (`surfaces.numerics.lanes`): first the force at every level, then the stiffness, the
area and two of working space.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.lanes import (
    LANES,
    between,
    exponential,
    groups,
    least,
    load,
    logarithm,
    most,
    ordered,
    pick,
    splat,
    spread_rows,
    store,
)
from surfaces.numerics.vectors import absolute, entries, where

from ._basin_kernels import basin_space, fill
from ._ellipse_kernels import SHAPE_ROW, STATES

WIDTH = 5
"""Levels from which a slope is taken at most."""

MADE = 7
"""Columns of a row: force, stiffness, area, flags, spread and the centre."""

_BEYOND, _FILLED = 64.0, 128.0
_UNTRUSTED = 0.05
"""Spread beyond the trusted levels."""


def row_space(levels: int, nodes: int) -> tuple[Any, ...]:
    """Groups of the columns over the levels, and of the finished rows."""
    return groups(5 * levels), groups(MADE * nodes)


@inner(fastmath=QUOTIENTS)
def _second_order_area(state, level, stiffness):
    """Contact area whose contour has the stiffness dF/dd to second order.

    The unknown second-order displacement is taken uniform along the contour; the result stays
    between the ellipse and the first-order contour.
    """
    o = level * STATES
    ellipse, contour = load(state, o + 3), load(state, o + 4)
    uniform = (stiffness - load(state, o + 1)) / most(load(state, o + 2), splat(1e-12))
    area = contour + between(uniform, splat(-0.3), splat(0.3)) * load(state, o + 5)
    return between(area, least(ellipse, contour), most(ellipse, contour))


@inner(fastmath=QUOTIENTS)
def expanded_levels(state, first, last, levels, powers, stencils, p, columns):
    """Force, stiffness and area at the trusted levels, and below them in proportion.

    `powers` are levels**p, `stencils[width - 1, start, level - start]` the weights of the slope
    at a level from `width` levels.
    """
    count = levels.size
    flat = stencils.ravel()
    for i in range(count):
        inside = (first <= 1.0 * i) & (last >= 1.0 * i)
        force = where(inside, load(state, i * STATES), 0.0)
        store(columns, i, force)
        store(columns, 3 * count + i, force * (1 / powers[i]))
    for i in range(count):
        inside = (first <= 1.0 * i) & (last >= 1.0 * i)
        width = least(where(last > 1.0 * i, splat(1.0 * WIDTH), 2.0), last - first + 1.0)
        half = where(width > 3.0, splat(2.0), 1.0)
        start = least(most(i - half, first), last - width + 1.0)
        start = between(start, splat(0.0), splat(count - 1.0))
        row = between((width - 1.0) * count + start, splat(0.0), splat(WIDTH * count - 1.0))
        row = (row * WIDTH + between(i - start, splat(0.0), splat(WIDTH - 1.0))) * WIDTH
        slope = splat(0.0)
        for k in range(WIDTH):
            scaled = pick(columns, 3 * count + least(start + k, splat(count - 1.0)))
            slope += entries(flat, row + k) * scaled
        u = levels[i]
        slope = p * load(columns, 3 * count + i) + u * slope
        stiffness = (0.5 * powers[i] / (u * u)) * slope
        store(columns, count + i, where(inside, stiffness, 0.0))
        area = _second_order_area(state, i, stiffness)
        store(columns, 2 * count + i, where(inside, area, 0.0))
    begin = most(first, splat(0.0))
    scaled, area = pick(columns, 3 * count + begin), pick(columns, 2 * count + begin)
    unit = 1.0 / entries(levels, begin)
    for i in range(count):
        below, u = first > 1.0 * i, levels[i]
        force = scaled * powers[i]
        share = u * unit
        store(columns, i, where(below, force, load(columns, i)))
        stiffness = force * (0.5 * p / (u * u))
        store(columns, count + i, where(below, stiffness, load(columns, count + i)))
        spot = area * share * share
        store(columns, 2 * count + i, where(below, spot, load(columns, 2 * count + i)))


@inner(fastmath=QUOTIENTS)
def _log_ratio(inner, outer):
    """Log ratio of the two descriptions where they meet, kept to what a mended summit can need."""
    both = (inner > 0.0) & (outer > 0.0)
    ratio = between(where(both, inner, 1.0) / where(both, outer, 1.0), splat(0.5), splat(2.0))
    return logarithm(ratio)


@inner(fastmath=QUOTIENTS)
def carried_on(filling, last, levels, basin, p, columns):
    """Force, stiffness and area beyond the levels `last`: planforms on rays.

    The ratio of the areas of the two descriptions at the last trusted level fades as the basin
    fills; the stiffness is that of the planforms at once, and the force its integral. Without a
    trusted level (-1) the planforms stand alone, from a paraboloid.
    """
    count = levels.size
    known = last >= 0.0
    begin = most(last, splat(0.0))
    at = pick(filling, 4.0 * begin)
    spread = where(known, _log_ratio(pick(columns, 2 * count + begin), at), 0.0)
    room = where(known, most(basin - at, 1e-9 * basin), 1.0)
    stiffness = where(known, load(columns, count), load(filling, 1))
    area = where(known, load(columns, 2 * count), load(filling, 0))
    force = where(known, load(columns, 0), stiffness * (2 / p * levels[0] ** 2))
    store(columns, 0, force)
    store(columns, count, stiffness)
    store(columns, 2 * count, area)
    for i in range(1, count):
        beyond = begin < 1.0 * i
        full, punch = load(filling, 4 * i), load(filling, 4 * i + 1)
        fade = between((basin - full) / room, splat(0.0), splat(1.0))
        spot = full * exponential(spread * fade)
        before = stiffness
        stiffness = most(where(beyond, punch, load(columns, count + i)), stiffness)
        area = most(least(where(beyond, spot, load(columns, 2 * count + i)), basin), area)
        low, high = levels[i - 1], levels[i]
        # stiffness linear in the level u over d = u*u
        work = before * (2 * low + high) + stiffness * (low + 2 * high)
        force = where(beyond, force + work * ((high - low) / 3), load(columns, i))
        store(columns, i, force)
        store(columns, count + i, stiffness)
        store(columns, 2 * count + i, area)


@compiled(fastmath=QUOTIENTS)
def resampled(columns, levels, powers, resampling, p, made):
    """Force, stiffness and area at u = nodes: Hermite of force / u**p, convex over u * u.

    Node j lies between the levels place[j] and place[j] + 1; `hermite[j]` holds the weights of
    values and slopes in the value, the same in the slope, and the share of the upper level.
    """
    nodes, node_powers, place, hermite = resampling
    count, size = levels.size, nodes.size
    for i in range(count):
        u = levels[i]
        scaled = load(columns, i) * (1 / powers[i])
        store(columns, 3 * count + i, scaled)
        slope = load(columns, count + i) * (2 * u / powers[i]) - scaled * (p / u)
        store(columns, 4 * count + i, slope)
    force_before, upper, widest, before = splat(0.0), splat(-1e300), splat(0.0), 0.0
    for j in range(size):
        i, h, u = place[j], hermite[j], nodes[j]
        s0, s1 = load(columns, 3 * count + i), load(columns, 3 * count + i + 1)
        g0, g1 = load(columns, 4 * count + i), load(columns, 4 * count + i + 1)
        s = h[0] * s0 + h[1] * g0 + h[2] * s1 + h[3] * g1
        g = h[4] * s0 + h[5] * g0 + h[6] * s1 + h[7] * g1
        value = s * node_powers[j]
        store(made, size + j, (p * s + u * g) * (0.5 * node_powers[j] / (u * u)))
        next_area = load(columns, 2 * count + i + 1)
        spot = load(columns, 2 * count + i) * ((1 - h[8]) / levels[i] ** 2)
        spot += next_area * (h[8] / levels[i + 1] ** 2)
        widest = most(least(spot * (u * u), next_area), widest)
        store(made, 2 * size + j, widest)
        secant = (value - force_before) * (1 / (u * u - before))
        upper = most(secant, upper)
        store(made, j, upper)
        # the secants wait where the flags will be
        store(made, 3 * size + j, secant)
        before, force_before = u * u, value
    # secants that fall are replaced by the mean of their rising envelopes
    lower = splat(1e300)
    for j in range(size - 1, -1, -1):
        lower = least(load(made, 3 * size + j), lower)
        store(made, 3 * size + j, 0.5 * (load(made, j) + lower))
    before, total = 0.0, splat(0.0)
    for j in range(size):
        square = nodes[j] * nodes[j]
        secant = load(made, 3 * size + j)
        total += secant * (square - before)
        store(made, j, total)
        stiffness = most(load(made, size + j), secant)
        if j + 1 < size:
            stiffness = least(stiffness, load(made, 3 * size + j + 1))
        store(made, size + j, stiffness)
        before = square


@inner(fastmath=QUOTIENTS)
def marked(state, filling, first, last, basin, resampling, made):
    """Flags, spread and centre of the rows."""
    nodes, _, place, hermite = resampling
    size = nodes.size
    for j in range(size):
        i, share = place[j], hermite[j, 8]
        low = (first <= 1.0 * i) & (last >= 1.0 * i)
        high = (first <= 1.0 * (i + 1)) & (last >= 1.0 * (i + 1))
        beyond = splat(0.0)
        if share <= 0.999:
            beyond = where(low, beyond, _BEYOND)
        if share >= 0.001:
            beyond = where(high, beyond, _BEYOND)
        filled = where(load(made, 2 * size + j) > 0.999 * basin, splat(_FILLED), 0.0)
        store(made, 3 * size + j, beyond + filled)
        below = where(low, absolute(load(state, i * STATES + 6)), _UNTRUSTED)
        above = where(high, absolute(load(state, (i + 1) * STATES + 6)), _UNTRUSTED)
        store(made, 4 * size + j, (1 - share) * below + share * above)
        for k in range(2):
            near, far = load(filling, 4 * i + 2 + k), load(filling, 4 * i + 6 + k)
            store(made, (5 + k) * size + j, (1 - share) * near + share * far)


@inner()
def _write(made, nodes, lane, length, angle, units, n, out):
    """Row n of the table from a lane of the finished rows, in `units`."""
    _, force, stiffness, area, flags, spread, centre = out
    c, s = math.cos(angle) * length, math.sin(angle) * length
    for j in range(nodes):
        k, step = j * LANES + lane, nodes * LANES
        force[n, j + 1] = made[k] * units[0]
        stiffness[n, j + 1] = made[k + step] * units[1]
        area[n, j + 1] = made[k + 2 * step] * length * length
        flags[n, j + 1] = int(made[k + 3 * step])
        spread[n, j + 1] = made[k + 4 * step]
        x, y = made[k + 5 * step], made[k + 6 * step]
        centre[n, j + 1, 0], centre[n, j + 1, 1] = c * x - s * y, s * x + c * y


def table_space(rays: int, samples: int, levels: int, nodes: int) -> tuple[Any, ...]:
    """Working groups of `tabulate_rows`.

    A block; nodes and weights of the rays, frames, scales, states, contours and trusted levels; the
    planforms and what they are made with; the columns and the rows.
    """
    row = -(-rays // LANES) * LANES
    counts = (-(-rays * samples // LANES) * LANES, row, 4 * rays, LANES)
    states = (-(-levels * STATES // LANES) * LANES, SHAPE_ROW, LANES)
    return (
        groups(LANES),
        tuple(map(groups, counts)),
        tuple(map(groups, states)),
        (groups(4 * levels), basin_space(rays, levels)),
        row_space(levels, nodes),
    )


@compiled()
def tabulate_rows(
    begin, profiles, frames, scales, found, levels, m, modulus, weights, punch, resampling, out,
    space,
):  # fmt: skip
    """Table rows of the profiles from `begin` on, of which `frames`, `scales` and `found` tell.

    Profiles of which the trust ends at the same level go together; those whose last scale is zero
    keep rows of zeros.
    """
    _, angles, all_weights, _, _, qs, _, rays, samples = profiles
    u, powers, stencils = levels
    states, shapes, ends = found
    n, p, nodes = len(scales), 3 + m, resampling[0].size
    who, own = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    block, (q, weight, frame, scale), (state, shape, end), (filling, filling_in), lines = space
    columns, made = lines
    keys = np.zeros(n, np.int64)
    for k in range(n):
        keys[k] = 1 + int(ends[k, 1]) if scales[k, LANES - 1] > 0.0 else u.size + 1
    order = ordered(keys, u.size + 1)
    count = 0
    while count < n and keys[order[count]] <= u.size:
        count += 1
    for i in range(0, count, LANES):
        for lane in range(LANES):
            own[lane] = order[min(i + lane, count - 1)]
            who[lane] = begin + own[lane]
        for source, at, target in (
            (qs, who, q), (all_weights, who, weight), (frames, own, frame), (scales, own, scale),
            (states, own, state), (shapes, own, shape), (ends, own, end),
        ):  # fmt: skip
            spread_rows(source, at, target, block)
        first, last = load(end, 0), load(end, 1)
        lengths, basins = load(scale, 0), load(scale, 2)
        fill(
            q, samples, weights, weight, frame, frame[2 * rays * LANES :], rays,
            lengths * lengths / load(scale, 1), shape, state, last, u, m, punch, filling,
            filling_in,
        )  # fmt: skip
        expanded_levels(state, first, last, u, powers, stencils, p, columns)
        carried_on(filling, last, u, basins, p, columns)
        resampled(columns, u, powers, resampling, p, made)
        marked(state, filling, first, last, basins, resampling, made)
        for lane in range(min(LANES, count - i)):
            k = who[lane]
            length, height = scale[lane], scale[LANES + lane]
            out[0][k] = height
            unit = modulus * length ** (1 + m)
            _write(made, nodes, lane, length, angles[k], (unit * height, unit), k, out)
