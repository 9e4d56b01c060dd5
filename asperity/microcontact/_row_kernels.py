"""Numba kernels that make the row of a law table from the states of one profile at its levels.

Units inside: one length and one height per profile, modulus 1.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ._directions import FAST


@njit(cache=True, nogil=True)
def row_space(levels, nodes):
    """Working arrays of `expanded_levels`, `carried_on` and `resampled`."""
    return np.empty((5, levels)), np.empty((4, nodes))


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy", inline="always")
def _second_order_area(state, stiffness):
    """See `ellipse_batch.second_order_area`."""
    uniform = (stiffness - state[1]) / max(state[2], 1e-12)
    area = state[4] + min(max(uniform, -0.3), 0.3) * state[5]
    return min(max(area, min(state[3], state[4])), max(state[3], state[4]))


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def expanded_levels(state, first, last, levels, powers, stencils, p, columns):
    """Force, stiffness and area at the trusted levels, and below them in proportion.

    `powers` are levels**p, `stencils[width - 1, start, level - start]` the weights of the slope
    at a level from `width` levels.
    """
    force, stiffness, area, scaled = columns[0], columns[1], columns[2], columns[3]
    for i in range(first, last + 1):
        scaled[i] = state[i, 0] / powers[i]
    for i in range(first, last + 1):
        width = min(5 if i < last else 2, last - first + 1)
        start = min(max(i - width // 2, first), last - width + 1)
        slope = 0.0
        for k in range(width):
            slope += stencils[width - 1, start, i - start, k] * scaled[start + k]
        u = levels[i]
        force[i] = state[i, 0]
        stiffness[i] = 0.5 * powers[i] / (u * u) * (p * scaled[i] + u * slope)
        area[i] = _second_order_area(state[i], stiffness[i])
    for i in range(first):
        square = (levels[i] / levels[first]) ** 2
        force[i] = scaled[first] * powers[i]
        stiffness[i] = 0.5 * p * force[i] / (levels[i] * levels[i])
        area[i] = area[first] * square


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy", inline="always")
def _ratio(inner, outer):
    """Ratio of the two descriptions where they meet, kept to what a mended summit can need."""
    if inner > 0.0 and outer > 0.0:
        return min(max(inner / outer, 0.5), 2.0)
    return 1.0


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def carried_on(filling, last, levels, basin, p, columns):
    """Force, stiffness and area beyond level `last`: planforms on rays.

    The ratios of stiffness and area of the two descriptions at the last trusted level fade as the
    basin fills; the force is the integral of the stiffness. Without a trusted level (-1) the
    planforms stand alone, from a paraboloid.
    """
    force, stiffness, area = columns[0], columns[1], columns[2]
    begin = max(last, 0)
    stiff, spread, room = 1.0, 1.0, 1.0
    if last >= 0:
        stiff = _ratio(stiffness[last], filling[last, 1])
        spread = _ratio(area[last], filling[last, 0])
        room = max(basin - filling[last, 0], 1e-9 * basin)
    else:
        stiffness[0], area[0] = filling[0, 1], filling[0, 0]
        force[0] = 2 / p * stiffness[0] * levels[0] ** 2
    for i in range(1, begin + 1):
        stiffness[i] = max(stiffness[i], stiffness[i - 1])
        area[i] = max(min(area[i], basin), area[i - 1])
    for i in range(begin + 1, levels.size):
        fade = min(max((basin - filling[i, 0]) / room, 0.0), 1.0)
        stiffness[i] = max(filling[i, 1] * stiff**fade, stiffness[i - 1])
        area[i] = max(min(filling[i, 0] * spread**fade, basin), area[i - 1])
        low, high = levels[i - 1], levels[i]
        # stiffness linear in the level u over d = u*u
        work = stiffness[i - 1] * (2 * low + high) + stiffness[i] * (low + 2 * high)
        force[i] = force[i - 1] + (high - low) * work / 3


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def resampled(columns, levels, powers, place, hermite, nodes, p, made):
    """Force, stiffness and area at u = nodes: Hermite of force / u**p, convex over u * u.

    Node j lies between the levels place[j] and place[j] + 1; `hermite[j]` holds the weights of
    values and slopes in the value, the same in the slope, and the share of the upper level.
    """
    force, stiffness, area = columns[0], columns[1], columns[2]
    scaled, slope = columns[3], columns[4]
    out_force, out_stiffness, out_area, secant = made[0], made[1], made[2], made[3]
    for i in range(levels.size):
        u = levels[i]
        scaled[i] = force[i] / powers[i]
        slope[i] = 2 * stiffness[i] * u / powers[i] - p * scaled[i] / u
    before, force_before, upper, widest = 0.0, 0.0, -1e300, 0.0
    for j in range(nodes.size):
        i, h, u = place[j], hermite[j], nodes[j]
        s = h[0] * scaled[i] + h[1] * slope[i] + h[2] * scaled[i + 1] + h[3] * slope[i + 1]
        g = h[4] * scaled[i] + h[5] * slope[i] + h[6] * scaled[i + 1] + h[7] * slope[i + 1]
        power = u**p
        value = s * power
        out_stiffness[j] = power / (u * u) * (p * s + u * g) / 2
        spot = (1 - h[8]) * area[i] / levels[i] ** 2 + h[8] * area[i + 1] / levels[i + 1] ** 2
        widest = max(widest, min(spot * u * u, area[i + 1]))
        out_area[j] = widest
        secant[j] = (value - force_before) / (u * u - before)
        upper = max(upper, secant[j])
        out_force[j] = upper
        before, force_before = u * u, value
    # secants that fall are replaced by the mean of their rising envelopes
    lower = 1e300
    for j in range(nodes.size - 1, -1, -1):
        lower = min(lower, secant[j])
        secant[j] = 0.5 * (out_force[j] + lower)
    before, total = 0.0, 0.0
    for j in range(nodes.size):
        square = nodes[j] * nodes[j]
        total += secant[j] * (square - before)
        out_force[j] = total
        out_stiffness[j] = max(out_stiffness[j], secant[j])
        if j + 1 < nodes.size:
            out_stiffness[j] = min(out_stiffness[j], secant[j + 1])
        before = square
