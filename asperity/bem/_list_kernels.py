"""Compiled passes over the vectors of a contact list. `measure`, `turn` and `advance` make one
step of conjugate gradients (Polonsky & Keer 1999, with the factor of Polak & Ribiere).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Array, Mask
from surfaces.numerics.compiled import EXTREMES, SUMS, compiled

_NEWTON_STEPS = 10
"""Most Newton steps for the sum of bounded pressures before bisection; three are usually enough."""

_ROUNDING = 1e-6
"""Squared norm of a residual over that of the next one, below which the last direction is rounding.
"""

Single = NDArray[np.float32]


@compiled(fastmath=EXTREMES)
def measure(
    p: Array,
    moved: Single,
    start_gap: Array,
    change: Single,
    active: Mask,
    residual: Single,
    cap: float,
    held: bool,
) -> Any:
    """Mark the active points, and compute their residual gap - level.

    The gap is start_gap + change. A point is held at a bound, and not active, if p = 0 and its gap
    is above the level, or if p = cap and its gap is below the level.

    Returns the level (the mean gap where 0 < p < cap; zero if `held`), the largest error of the gap
    (duality gap over the load, penetration or lift, as in `certificate`), the number of active
    points, the energy of the move, sum moved (start_gap + change / 2), and the sum of the move.
    """
    n = p.size
    count = inside = 0
    gap_sum = total = work = energy = shift = 0.0
    lowest, highest = np.inf, -np.inf
    for i in range(n):
        g = start_gap[i] + change[i]
        below = p[i] < cap
        touching = (p[i] > 0.0) & below
        energy += moved[i] * (start_gap[i] + 0.5 * change[i])
        shift += moved[i]
        total += p[i]
        high, low = -np.inf if below else g, g if below else np.inf
        highest = high if high > highest else highest
        lowest = low if low < lowest else lowest
        work += p[i] * g if below else 0.0
        count += touching
        gap_sum += g if touching else 0.0
    if lowest == np.inf:
        lowest = highest
    level = gap_sum / count if count > 0 else 0.5 * (highest + lowest)
    off = 0.0
    if held:
        off = abs(level) if count > 0 else 0.0
        level, lowest = 0.0, min(lowest, 0.0)
    held_work = 0.0
    for i in range(n):
        above = start_gap[i] + change[i] - level
        held_work += p[i] * max(above + level, lowest) if p[i] >= cap else 0.0
        free = ((p[i] > 0.0) | (above < 0.0)) & ((p[i] < cap) | (above > 0.0))
        active[i] = free
        residual[i] = np.float32(above if free else 0.0)
        inside += free
    work += held_work
    error = max(max(work / max(total, 1e-300), level) - lowest, highest - level, off)
    return level, error, inside, energy, shift


@compiled(fastmath=SUMS)
def turn(
    active: Mask,
    count: float,
    z: Single,
    residual: Single,
    before: Single,
    direction: Single,
    old_norm: float,
) -> float:
    """New direction z + beta * direction less its mean (Polak-Ribiere); returns z . residual.

    The last direction may belong to other active points. It is left out if `old_norm` is zero, or
    so much below the new norm that it was rounding. With an infinite `count` no mean is subtracted.
    """
    n = z.size
    zr = zb = z_sum = r_sum = b_sum = d_sum = 0.0
    for i in range(n):
        if active[i]:
            zr += z[i] * residual[i]
            zb += z[i] * before[i]
            z_sum += z[i]
            r_sum += residual[i]
            b_sum += before[i]
            d_sum += direction[i]
    mean = z_sum / count
    norm = zr - mean * r_sum
    beta = np.float32(0.0)
    if old_norm > _ROUNDING * max(norm, 0.0):
        beta = np.float32(max(0.0, (norm - zb + mean * b_sum) / old_norm))
    shift = np.float32(mean + beta * d_sum / count)
    for i in range(n):
        if active[i]:
            direction[i] = z[i] - shift + beta * direction[i]
        else:
            direction[i] = np.float32(0.0)
    return norm


@compiled(fastmath=SUMS)
def advance(
    active: Mask,
    count: float,
    p: Array,
    change: Single,
    residual: Single,
    direction: Single,
    response: Single,
    cap: float,
) -> int:
    """Step to the minimum along the direction; returns the number of pressures out of bounds.

    Updates p and change. The sum of p does not change if `count` is finite; with an infinite one
    the level is zero and the sum is free. Returns -1 and changes nothing if the direction has no
    positive curvature.
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
    for i in range(n):
        change[i] -= short * response[i]
        if active[i]:
            p[i] -= length * direction[i]
            if p[i] < 0.0 or p[i] > cap:
                beyond += 1
    return beyond


@compiled(fastmath=EXTREMES)
def leveling(p: Array, total: float, cap: float) -> Any:
    """Shift of the pressures between the bounds after which all, cut at 0 and cap, sum to `total`.

    Pressures p <= 0 and p = cap are not shifted. The shift is found by Newton steps on the sum;
    without a cap the sum is convex in the shift, and they converge. With a cap a step is replaced
    by a bisection if it leaves the bracket, and after `_NEWTON_STEPS`.

    Returns the shift, and a factor on the shifted pressures: 1, unless rounding leaves no shift of
    this sum.
    """
    low, high, shift, over = -np.inf, min(cap, total), 0.0, total
    if cap < np.inf:
        low = 0.0
        for i in range(p.size):
            low = min(low, -p[i])
    for step in range(120):
        found = 0.0
        inside = 0
        for i in range(p.size):
            value = p[i] + shift if (p[i] > 0.0) & (p[i] != cap) else p[i]
            found += min(max(value, 0.0), cap)
            inside += (value > 0.0) & (value < cap)
        excess = found - total
        if abs(excess) <= 1e-12 * total:
            return shift - excess / max(inside, 1), 1.0
        if excess < 0.0:
            low = shift
        else:
            high, over = shift, found
        shift -= excess / max(inside, 1)
        newton = inside > 0 and low < shift and shift < high and step < _NEWTON_STEPS
        if not newton and low > -np.inf:
            shift = 0.5 * (low + high)
        if shift == low or shift == high:
            break
    return high, total / over


@compiled(fastmath=EXTREMES)
def cut(p: Array, base: Array, moved: Single, leveled: tuple[float, float], cap: float) -> float:
    """Apply the result of `leveling` to p, cut p at 0 and cap, and set `moved` to p - base; returns
    the largest |p - base|."""
    shift, factor = leveled
    largest = 0.0
    for i in range(p.size):
        value = (p[i] + shift) * factor if (p[i] > 0.0) & (p[i] != cap) else p[i]
        p[i] = min(max(value, 0.0), cap)
        step = p[i] - base[i]
        moved[i] = np.float32(step)
        largest = max(largest, abs(step))
    return largest
