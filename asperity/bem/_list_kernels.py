"""Compiled passes over the vectors of a contact list: one conjugate-gradient step in three."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics.compiled import SUMS, compiled

Single = NDArray[np.float32]
Double = NDArray[np.float64]
Flags = NDArray[np.bool_]


@compiled(fastmath=SUMS)
def measure(
    p: Double,
    moved: Single,
    start_gap: Double,
    change: Single,
    active: Flags,
    residual: Single,
    cap: float,
    held: bool,
) -> Any:
    """Active points, which are not held at a bound, and their residual gap - level.

    The gap is start_gap + change. Held are p = 0 with a gap above the level, and p = cap below it.

    Returns the level (mean gap where 0 < p < cap, or zero if it is `held` there), the largest error
    of the gap (duality gap over the load, penetration or lift, as in `certificate`), the number of
    active points, the energy of the move, sum moved (start_gap + change / 2), and the sum of the
    move.
    """
    n = p.size
    count = 0
    gap_sum = total = work = energy = shift = 0.0
    lowest, highest = np.inf, -np.inf
    for i in range(n):
        g = start_gap[i] + change[i]
        energy += moved[i] * (start_gap[i] + 0.5 * change[i])
        shift += moved[i]
        total += p[i]
        if p[i] >= cap:
            highest = max(highest, g)
        else:
            lowest = min(lowest, g)
            work += p[i] * g
            if p[i] > 0.0:
                count += 1
                gap_sum += g
    if lowest == np.inf:
        lowest = highest
    level = gap_sum / count if count > 0 else 0.5 * (highest + lowest)
    off = 0.0
    if held:
        off = abs(level) if count > 0 else 0.0
        level, lowest = 0.0, min(lowest, 0.0)
    inside = 0
    for i in range(n):
        above = start_gap[i] + change[i] - level
        if p[i] >= cap:
            work += p[i] * max(above + level, lowest)
        if (p[i] > 0.0 or above < 0.0) and (p[i] < cap or above > 0.0):
            active[i] = True
            residual[i] = np.float32(above)
            inside += 1
        else:
            active[i] = False
            residual[i] = np.float32(0.0)
    error = max(max(work / max(total, 1e-300), level) - lowest, highest - level, off)
    return level, error, inside, energy, shift


@compiled(fastmath=SUMS)
def turn(
    active: Flags,
    count: float,
    z: Single,
    residual: Single,
    before: Single,
    direction: Single,
    old_norm: float,
) -> float:
    """New direction z + beta * direction without mean (Polak-Ribiere); returns z . residual.

    `old_norm` zero restarts with the direction z; with an infinite `count` the mean stays.
    """
    n = z.size
    zr = zb = z_sum = r_sum = b_sum = 0.0
    for i in range(n):
        if active[i]:
            zr += z[i] * residual[i]
            zb += z[i] * before[i]
            z_sum += z[i]
            r_sum += residual[i]
            b_sum += before[i]
    mean = z_sum / count
    norm = zr - mean * r_sum
    beta = np.float32(0.0)
    if old_norm > 0.0:
        beta = np.float32(max(0.0, (norm - zb + mean * b_sum) / old_norm))
    shift = np.float32(mean)
    for i in range(n):
        if active[i]:
            direction[i] = z[i] - shift + beta * direction[i]
        else:
            direction[i] = np.float32(0.0)
    return norm


@compiled(fastmath=SUMS)
def advance(
    active: Flags,
    count: float,
    p: Double,
    start_gap: Double,
    change: Single,
    residual: Single,
    before: Single,
    direction: Single,
    response: Single,
    cap: float,
) -> int:
    """Step to the minimum along the direction; returns the number of pressures out of bounds.

    Updates p, change and residual, and keeps the last residual in `before`. The load stays, and
    the level is zero with an infinite `count`. Returns -1 and changes nothing if the direction has
    no positive curvature.
    """
    n = p.size
    slope = curvature = response_sum = direction_sum = 0.0
    for i in range(n):
        if active[i]:
            slope += residual[i] * direction[i]
            curvature += response[i] * direction[i]
            response_sum += response[i]
            direction_sum += direction[i]
    curvature -= response_sum / count * direction_sum
    if not curvature > 0.0:
        return -1
    length = slope / curvature
    short = np.float32(length)
    beyond = 0
    gap_sum = 0.0
    for i in range(n):
        change[i] -= short * response[i]
        if active[i]:
            p[i] -= length * direction[i]
            gap_sum += start_gap[i] + change[i]
            if p[i] < 0.0 or p[i] > cap:
                beyond += 1
    level = gap_sum / count
    for i in range(n):
        before[i] = residual[i]
        if active[i]:
            residual[i] = np.float32(start_gap[i] + change[i] - level)
    return beyond


@compiled(fastmath=SUMS)
def restoring(p: Double, total: float, cap: float) -> Any:
    """Factors of pressures at the cap and below it that bring them, cut at 0 and cap, to a sum.

    Only those below the cap are scaled, if they alone can make up for the rest. NaN changes none.
    """
    factor, before = 1.0, -1
    while True:
        held = 0
        free = 0.0
        for i in range(p.size):
            if p[i] >= cap or p[i] * factor >= cap:
                held += 1
            elif p[i] > 0.0:
                free += p[i]
        bound = cap * held if held > 0 else 0.0
        if bound > total * (1.0 + 1e-12):  # and not by rounding
            every = total / (bound + free * factor)
            return every, every * factor
        if held <= before or free == 0.0 or np.isnan(total):
            return 1.0, factor
        factor, before = max(total - bound, 0.0) / free, held


@compiled(fastmath=SUMS)
def leveling(p: Double, moving: Flags, total: float, cap: float) -> float:
    """What to add to the moving pressures so that all, cut at 0 and cap, have a sum."""
    shift, low, high = 0.0, 0.0, 0.0
    for i in range(p.size):
        if moving[i]:
            low, high = min(low, -p[i]), max(high, cap - p[i])
    for step in range(120):
        found = 0.0
        inside = 0
        for i in range(p.size):
            value = p[i] + (shift if moving[i] else 0.0)
            if moving[i] and value > 0.0 and value < cap:
                inside += 1
            found += min(max(value, 0.0), cap)
        if abs(found - total) <= 1e-14 * total:
            break
        if found < total:
            low = shift
        else:
            high = shift
        shift -= (found - total) / max(inside, 1)
        if inside == 0 or step % 3 == 2 or not (low < shift and shift < high):
            shift = 0.5 * (low + high)
    return shift


@compiled(fastmath=SUMS)
def cut(p: Double, base: Double, moved: Single, total: float, cap: float) -> float:
    """Cut pressures at 0 and cap, restore their sum, and form p - base; returns the largest of it.

    The sum to restore is `total`; none if NaN.
    """
    held, factor = restoring(p, total, cap)
    largest = 0.0
    for i in range(p.size):
        value = max(p[i], 0.0) * factor
        if p[i] >= cap or value >= cap * held:
            value = cap * held
        p[i] = value
        step = value - base[i]
        moved[i] = np.float32(step)
        largest = max(largest, abs(step))
    return largest
