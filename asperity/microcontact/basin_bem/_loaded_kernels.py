"""Few elements that carry a force with pressures that a hardness bounds."""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import compiled, inner

from ._closing_kernels import LONGEST, relieve
from ._element_kernels import elements
from ._outline_kernels import contact_size

__all__ = ["area_under_load"]

TRIES = 6
"""Grids tried for one contact."""

SPARE = 1.1
"""Depth of the part of a basin that is looked at, over the approach of the contact."""

SLACK = 0.35
"""Part of that depth which the flat may stay short of: beyond, elements are too large."""

SHIFTS = 4
"""Times that the force is restored by a shift of all pressures between their bounds."""


@inner(fastmath=True)
def _restore(count, load, bound, pressure):
    """Bring the sum of pressures between 0 and `bound` to the load by a shift of those between."""
    for _ in range(SHIFTS):
        total, between = 0.0, 0
        for i in range(count):
            total += pressure[i]
            if 0.0 < pressure[i] < bound:
                between += 1
        if between == 0 or abs(total - load) <= 1e-6 * load:
            break
        shift = np.float32((load - total) / between)
        for i in range(count):
            if 0.0 < pressure[i] < bound:
                pressure[i] = min(max(pressure[i] + shift, np.float32(0.0)), bound)


@inner(fastmath=True)
def _level(count, bound, pressure, left):
    """Overlap that remains under the flat: the mean between the bounds, or halfway between what
    remains at the bound and off contact."""
    total, between, low, high = 0.0, 0, 1e30, -1e30
    for i in range(count):
        if pressure[i] <= 0.0:
            high = max(high, left[i])
        elif pressure[i] >= bound:
            low = min(low, left[i])
        else:
            total += left[i]
            between += 1
    if between:
        return np.float32(total / between)
    if high < -1e29:
        high = low
    if low > 1e29:
        low = high
    return np.float32(0.5 * (low + high))


@inner(fastmath=True)
def bear(count, row, col, gap, kernel, load, bound, tolerance, system, pressure, work):
    """Pressures 0 <= p <= bound of this sum: the minimum of p G p / 2 - p gap.

    Conjugate gradients on the elements between the bounds and on those that leave one (Polonsky &
    Keer 1999). Leaves the overlap that remains, over its level, in the first row of `work` and
    returns this level. `system` is scratch.
    """
    made, ends = system[1], system[2]
    first = 0
    for i in range(1, count + 1):
        if i == count or row[i] != row[first] or col[i] - col[first] != i - first:
            ends[first] = i
            first = i
    left, way, change, beside = work[0], work[1], work[2], work[3]
    low, high = 0.0, 2.0 * max(bound, load)
    for i in range(count):
        made[i], way[i] = False, 0.0
    for _ in range(40):  # pressures of a paraboloid, cut at the bound
        scale, total = 0.5 * (low + high), 0.0
        for i in range(count):
            total += min(scale * math.sqrt(max(gap[i], 0.0)), bound)
        if total < load:
            low = scale
        else:
            high = scale
    for i in range(count):
        pressure[i] = min(high * math.sqrt(max(gap[i], 0.0)), bound)
        left[i] = gap[i]
    relieve(count, pressure, row, col, kernel, system, left)
    before, fresh = np.float32(1.0), True
    level = np.float32(0.0)
    for _ in range(LONGEST):
        level = _level(count, bound, pressure, left)
        error, total, square, mean, free = 0.0, 0.0, 0.0, 0.0, 0
        for i in range(count):
            over = left[i] - level
            total += pressure[i] * gap[i]
            error += (bound - pressure[i]) * over if over > 0.0 else -pressure[i] * over
            if (pressure[i] > 0.0 or over > 0.0) and (pressure[i] < bound or over < 0.0):
                square += over * over
                free += 1
        if error <= tolerance * total or free == 0:
            break
        share = np.float32(0.0 if fresh else square / before)
        before = np.float32(square)
        for i in range(count):
            over = left[i] - level
            way[i] = (
                over + share * way[i]
                if (pressure[i] > 0.0 or over > 0.0) and (pressure[i] < bound or over < 0.0)
                else np.float32(0.0)
            )
            mean += way[i]
        mean /= free
        above, below = 0.0, 0.0
        for i in range(count):
            over = left[i] - level
            if (pressure[i] > 0.0 or over > 0.0) and (pressure[i] < bound or over < 0.0):
                way[i] -= np.float32(mean)
                above += over * way[i]
            change[i] = 0.0
        relieve(count, way, row, col, kernel, system, change)
        for i in range(count):
            below -= change[i] * way[i]
        if not below > 0.0:
            if fresh:
                break
            fresh = True
            continue
        step, fresh = np.float32(above / below), False
        for i in range(count):
            beside[i] = pressure[i]
            wanted = pressure[i] + step * way[i]
            pressure[i] = min(max(wanted, np.float32(0.0)), bound)
            if pressure[i] != wanted or (beside[i] <= 0.0 and pressure[i] > 0.0):
                fresh = True
            beside[i] += step * way[i]
            left[i] += step * change[i]
        if fresh:
            _restore(count, load, bound, pressure)
            for i in range(count):
                beside[i] = pressure[i] - beside[i]
            relieve(count, beside, row, col, kernel, system, left)
    for i in range(count):
        left[i] -= level
    return level


@compiled()
def area_under_load(
    slot, peak, force, depth, surface, summits, unit, m, hardness, kernels, points, tolerance, out,
    space,
):  # fmt: skip
    """Contact area [m^2] of a peak that carries a force [N] under a hardness [Pa], into `out`.

    `depth` is about the approach [m]; the other arguments are those of `press_levels`. The area is
    zero where the basin reaches too far or does not bear the force.
    """
    number, scratch, mark = space[1][3], space[2], space[0][0]
    system, closed, overlap, work, row, col = scratch
    edge = math.gamma(0.5 * (3.0 + m)) / math.gamma(0.5 * (5.0 - m))
    mark[:] = 0
    out[slot] = 0.0
    depth *= SPARE
    for attempt in range(TRIES):
        total, nv, nu, hv, hu, kind, _, _, _, _ = elements(
            peak, depth, surface, summits, points, attempt + 1, space
        )
        if total < 0:
            return
        side = hu * hv
        load = force * unit / (depth * side ** (0.5 * (1.0 + m)))
        bound = np.float32(hardness * unit / (depth * side ** (0.5 * (m - 1.0))))
        if total < 4 or load > 0.99 * total * bound:
            depth *= 1.5
            continue
        level = bear(
            total, row, col, overlap, kernels[kind], np.float32(load), bound, tolerance, system,
            closed, work,
        )  # fmt: skip
        if level < 0.0 or (level > SLACK and attempt < TRIES - 1):
            depth *= SPARE * (1.0 - level)
            continue
        size = contact_size(
            number, nv, nu, math.sqrt(hv / hu), math.sqrt(hu / hv), closed, work[0], m, edge
        )
        out[slot] = max(side * size, force / hardness)
        return
