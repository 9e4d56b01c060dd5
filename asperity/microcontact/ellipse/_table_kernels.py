"""Compiled loops that make the rows of a law table from the states that `march_rows` found.

Units inside: one length and one height per profile, modulus 1. The columns of a profile over the
levels are force, stiffness, area, and two for working. Planforms on rays are computed for eight
profiles at once (`surfaces.numerics.lanes`), the rest for one after the other.
"""

from __future__ import annotations

import math

import numpy as np

from asperity.errors import Flag
from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.lanes import LANES, groups, in_groups, load, ordered, spread_rows

from ._basin_kernels import fill
from ._ellipse_kernels import SHAPE_ROW, STATES

WIDTH = 5
"""Largest number of levels in the stencil of a slope."""

_BEYOND, _FILLED = int(Flag.BEYOND_RADIUS), int(Flag.FILLED)
_UNTRUSTED = 0.05
"""Expected relative error of the force (`LawTable.spread`) beyond the trusted levels."""


@inner(fastmath=QUOTIENTS)
def _second_order_area(state, stiffness):
    """Contact area to second order, from the stiffness dF/dd of the second-order force.

    The first-order contour is displaced uniformly until its stiffness is dF/dd. The area is kept
    between those of the ellipse and of the first-order contour.
    """
    ellipse, contour = state[3], state[4]
    uniform = (stiffness - state[1]) / max(state[2], 1e-12)
    area = contour + min(max(uniform, -0.3), 0.3) * state[5]
    return min(max(area, min(ellipse, contour)), max(ellipse, contour))


@inner(fastmath=QUOTIENTS)
def expanded_levels(state, first, last, levels, powers, stencils, p, columns):
    """Force, stiffness and area at the trusted levels, and below them by the law of a paraboloid.

    `powers` are levels**p, `stencils[width - 1, start, level - start]` the weights of the slope
    at a level from `width` levels.
    """
    force, stiffness, area, scaled, _ = columns
    for i in range(first, last + 1):
        force[i] = state[i, 0]
        scaled[i] = force[i] / powers[i]
    for i in range(first, last + 1):
        width = min(WIDTH if i < last else 2, last - first + 1)
        start = min(max(i - (2 if width > 3 else 1), first), last - width + 1)
        slope, u = 0.0, levels[i]
        for k in range(width):
            slope += stencils[width - 1, start, i - start, k] * scaled[start + k]
        stiffness[i] = 0.5 * powers[i] / (u * u) * (p * scaled[i] + u * slope)
        area[i] = _second_order_area(state[i], stiffness[i])
    for i in range(first):
        force[i] = scaled[first] * powers[i]
        stiffness[i] = force[i] * (0.5 * p / levels[i] ** 2)
        area[i] = area[first] * (levels[i] / levels[first]) ** 2


@inner(fastmath=QUOTIENTS)
def carried_on(filling, last, levels, basin, p, columns):
    """Force, stiffness and area beyond the level `last`, from planforms on rays (`filling`).

    The area of the planform is multiplied by its ratio to the area of the expansion at the last
    trusted level, between 1/2 and 2; this factor fades to 1 as the basin fills. The stiffness is
    that of the planform, and the force its integral. Without a trusted level (-1) the law begins
    as that of a paraboloid.
    """
    force, stiffness, area, _, _ = columns
    spread, room = 0.0, 1.0
    if last < 0:
        area[0], stiffness[0] = filling[0, 0], filling[0, 1]
        force[0] = stiffness[0] * (2 / p * levels[0] ** 2)
    else:
        full = filling[last, 0]
        room = max(basin - full, 1e-9 * basin)
        if area[last] > 0.0 and full > 0.0:
            spread = math.log(min(max(area[last] / full, 0.5), 2.0))
    for i in range(1, levels.size):
        if i > last:
            full = filling[i, 0]
            fade = min(max((basin - full) / room, 0.0), 1.0)
            stiffness[i], area[i] = filling[i, 1], full * math.exp(spread * fade)
        stiffness[i] = max(stiffness[i], stiffness[i - 1])
        area[i] = max(min(area[i], basin), area[i - 1])
        if i > last:
            low, high = levels[i - 1], levels[i]
            # stiffness linear in the level u over d = u*u
            work = stiffness[i - 1] * (2 * low + high) + stiffness[i] * (low + 2 * high)
            force[i] = force[i - 1] + work * ((high - low) / 3)


@compiled(fastmath=QUOTIENTS)
def resampled(columns, levels, powers, resampling, p, made):
    """Force, stiffness and area at u = nodes: Hermite polynomials of force / u**p, made convex over
    the approach u * u.

    Node j lies between the levels place[j] and place[j] + 1. `hermite[j]` holds the weights of
    values and slopes in the value, then in the slope, then the share of the upper level. The last
    row of `made` (4, nodes) is for working.
    """
    nodes, node_powers, place, hermite = resampling
    force, stiffness, area, scaled, slope = columns
    for i in range(levels.size):
        u = levels[i]
        scaled[i] = force[i] / powers[i]
        slope[i] = stiffness[i] * (2 * u / powers[i]) - scaled[i] * (p / u)
    value, square, widest, upper, secants = 0.0, 0.0, 0.0, -1e300, made[3]
    for j in range(nodes.size):
        i, h, u = place[j], hermite[j], nodes[j]
        s0, s1, g0, g1 = scaled[i], scaled[i + 1], slope[i], slope[i + 1]
        s = h[0] * s0 + h[1] * g0 + h[2] * s1 + h[3] * g1
        g = h[4] * s0 + h[5] * g0 + h[6] * s1 + h[7] * g1
        before, value = value, s * node_powers[j]
        made[1, j] = (p * s + u * g) * (0.5 * node_powers[j] / (u * u))
        spot = area[i] * ((1 - h[8]) / levels[i] ** 2) + area[i + 1] * (h[8] / levels[i + 1] ** 2)
        widest = max(min(spot * (u * u), area[i + 1]), widest)
        made[2, j] = widest
        below, square = square, u * u
        secants[j] = (value - before) / (square - below)
        upper = max(secants[j], upper)
        made[0, j] = upper
    # secants that fall are replaced by the mean of their rising envelopes
    lower = 1e300
    for j in range(nodes.size - 1, -1, -1):
        lower = min(secants[j], lower)
        secants[j] = 0.5 * (made[0, j] + lower)
    value, square = 0.0, 0.0
    for j in range(nodes.size):
        below, square = square, nodes[j] * nodes[j]
        value += secants[j] * (square - below)
        made[0, j], made[1, j] = value, max(made[1, j], secants[j])
        if j + 1 < nodes.size:
            made[1, j] = min(made[1, j], secants[j + 1])


@inner()
def _write(made, state, filling, trusted, basin, resampling, length, angle, units, n, out):
    """Row n of the table, in `units` of force and stiffness, with its flags, spread and centre."""
    _, force, stiffness, area, flags, spread, centre = out
    nodes, _, place, hermite = resampling
    first, last = trusted
    c, s = math.cos(angle) * length, math.sin(angle) * length
    for j in range(nodes.size):
        i, share = place[j], hermite[j, 8]
        low, high = first <= i <= last, first <= i + 1 <= last
        force[n, j + 1] = made[0, j] * units[0]
        stiffness[n, j + 1] = made[1, j] * units[1]
        area[n, j + 1] = made[2, j] * length * length
        beyond = (share <= 0.999 and not low) or (share >= 0.001 and not high)
        flags[n, j + 1] = _BEYOND if beyond else 0
        if made[2, j] > 0.999 * basin:
            flags[n, j + 1] |= _FILLED
        below = abs(state[i, 6]) if low else _UNTRUSTED
        above = abs(state[i + 1, 6]) if high else _UNTRUSTED
        spread[n, j + 1] = (1 - share) * below + share * above
        x = (1 - share) * filling[i, 2] + share * filling[i + 1, 2]
        y = (1 - share) * filling[i, 3] + share * filling[i + 1, 3]
        centre[n, j + 1, 0], centre[n, j + 1, 1] = c * x - s * y, s * x + c * y


@compiled()
def tabulate_rows(
    begin, profiles, frames, scales, found, levels, m, modulus, weights, punch, resampling, out
):  # fmt: skip
    """Table rows of the profiles from `begin` on, from their `frames`, `scales` and states `found`.

    Profiles with the same last trusted level are computed together. Profiles without a fit keep
    rows of zeros.
    """
    _, angles, all_weights, _, _, qs, _, rays, samples = profiles
    u, powers, stencils = levels
    states, shapes, ends = found
    n, p, size = len(scales), 3 + m, u.size
    who, own = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    block, q, weight = groups(LANES), groups(in_groups(rays * samples)), groups(in_groups(rays))
    frame, scale, shape, end = groups(4 * rays), groups(LANES), groups(SHAPE_ROW), groups(LANES)
    planforms = groups(4 * size)
    columns, made = np.zeros((5, size)), np.zeros((4, resampling[0].size))
    keys = np.zeros(n, np.int64)
    for k in range(n):
        keys[k] = 1 + int(ends[k, 1]) if scales[k, LANES - 1] > 0.0 else size + 1
    order = ordered(keys, size + 1)
    count = 0
    while count < n and keys[order[count]] <= size:
        count += 1
    for i in range(0, count, LANES):
        for lane in range(LANES):
            own[lane] = order[min(i + lane, count - 1)]
            who[lane] = begin + own[lane]
        for source, at, target in (
            (qs, who, q), (all_weights, who, weight), (frames, own, frame), (scales, own, scale),
            (shapes, own, shape), (ends, own, end),
        ):  # fmt: skip
            spread_rows(source, at, target, block)
        lengths = load(scale, 0)
        fill(
            q, samples, weights, weight, frame, frame[2 * rays * LANES :], rays,
            lengths * lengths / load(scale, 1), shape, load(end, 1), u, m, punch, planforms,
        )  # fmt: skip
        for lane in range(min(LANES, count - i)):
            k, row = own[lane], who[lane]
            length, height, basin = scales[k, 0], scales[k, 1], scales[k, 2]
            first, last = int(ends[k, 0]), int(ends[k, 1])
            state = states[k, : size * STATES].reshape(size, STATES)
            filling = planforms.reshape(size, 4, LANES)[:, :, lane]
            for j in range(last):
                filling[j, 2], filling[j, 3] = state[j, 7], state[j, 8]
            if last >= 0:
                expanded_levels(state, first, last, u, powers, stencils, p, columns)
            carried_on(filling, last, u, basin, p, columns)
            resampled(columns, u, powers, resampling, p, made)
            out[0][row] = height
            unit = modulus * length ** (1 + m)
            _write(
                made, state, filling, (first, last), basin, resampling, length, angles[row],
                (unit * height, unit), row, out,
            )  # fmt: skip
