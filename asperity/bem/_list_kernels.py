"""Compiled passes over the vectors of a contact list: one conjugate-gradient step in three."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import prange
from numpy.typing import NDArray

from surfaces.numerics.compiled import SUMS, compiled

Single = NDArray[np.float32]
Double = NDArray[np.float64]
Flags = NDArray[np.bool_]


@compiled(parallel=True, fastmath=SUMS)
def measure(
    p: Double,
    moved: Single,
    start_gap: Double,
    change: Single,
    active: Flags,
    residual: Single,
) -> Any:
    """Active points {p > 0} U {gap < level} and their residual gap - level.

    The gap is start_gap + change.

    Returns the level (mean gap of the contact), the lowest gap, the load-weighted mean gap, the
    number of active points, the energy of the move, sum moved (start_gap + change / 2), and the
    sum of the move.
    """
    n = p.size
    count = 0
    gap_sum = total = work = energy = shift = 0.0
    lowest = np.inf
    for i in prange(n):
        g = start_gap[i] + change[i]
        lowest = min(lowest, g)
        energy += moved[i] * (start_gap[i] + 0.5 * change[i])
        shift += moved[i]
        if p[i] > 0.0:
            count += 1
            gap_sum += g
            total += p[i]
            work += p[i] * g
    level = gap_sum / count
    inside = 0
    for i in prange(n):
        above = start_gap[i] + change[i] - level
        if p[i] > 0.0 or above < 0.0:
            active[i] = True
            residual[i] = np.float32(above)
            inside += 1
        else:
            active[i] = False
            residual[i] = np.float32(0.0)
    return level, lowest, work / total, inside, energy, shift


@compiled(parallel=True, fastmath=SUMS)
def turn(
    active: Flags,
    count: int,
    z: Single,
    residual: Single,
    before: Single,
    direction: Single,
    old_norm: float,
) -> float:
    """New direction z + beta * direction without mean (Polak-Ribiere); returns z . residual.

    `old_norm` zero restarts with the direction z.
    """
    n = z.size
    zr = zb = z_sum = r_sum = b_sum = 0.0
    for i in prange(n):
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
    for i in prange(n):
        if active[i]:
            direction[i] = z[i] - shift + beta * direction[i]
        else:
            direction[i] = np.float32(0.0)
    return norm


@compiled(parallel=True, fastmath=SUMS)
def advance(
    active: Flags,
    count: int,
    p: Double,
    start_gap: Double,
    change: Single,
    residual: Single,
    before: Single,
    direction: Single,
    response: Single,
) -> int:
    """Step to the minimum along the direction; returns the number of negative pressures.

    Updates p, change and residual, and keeps the last residual in `before`. Returns -1 and
    changes nothing if the direction has no positive curvature.
    """
    n = p.size
    slope = curvature = response_sum = direction_sum = 0.0
    for i in prange(n):
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
    negative = 0
    gap_sum = 0.0
    for i in prange(n):
        change[i] -= short * response[i]
        if active[i]:
            p[i] -= length * direction[i]
            gap_sum += start_gap[i] + change[i]
            if p[i] < 0.0:
                negative += 1
    level = gap_sum / count
    for i in prange(n):
        before[i] = residual[i]
        if active[i]:
            residual[i] = np.float32(start_gap[i] + change[i] - level)
    return negative


@compiled(parallel=True, fastmath=SUMS)
def cut(p: Double, base: Double, moved: Single, total: float) -> float:
    """Cut negative pressures, scale to the load, and form p - base; returns the largest |p - base|.

    The load is `total`, the sum of the pressures.
    """
    positive = 0.0
    for i in prange(p.size):
        positive += max(p[i], 0.0)
    factor = total / positive
    largest = 0.0
    for i in prange(p.size):
        value = max(p[i], 0.0) * factor
        p[i] = value
        step = value - base[i]
        moved[i] = np.float32(step)
        largest = max(largest, abs(step))
    return largest
