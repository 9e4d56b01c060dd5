"""Compiled solvers of a small contact: pressures at an approach or under a load, and contact area.

The units are the largest overlap, and this over `halfspace.influence.compliance` for pressures. G
is the matrix of influences of rectangular elements (`halfspace.influence.near_influence`).
"""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import inner

MOST_SIDE_ELEMENTS = 64
"""Largest number of elements along a side of the grid of one contact."""

MOST_ELEMENTS = 700
"""Largest number of elements of one contact."""

MAX_GRADIENT_STEPS = 200
"""Most steps of conjugate gradients."""

FORCE_SHIFTS = 4
"""Most shifts of the pressures between their bounds that restore the force."""

OUTSIDE = -1
"""Mark of grid points that are no elements: of other basins, or not reached by the flat."""


@inner(fastmath=True)
def _subtract_displacement(count, amounts, row, col, kernel, system, out):
    """Subtract G `amounts`, the displacements by these pressures, from `out`.

    Rows of G are made when they are first needed: elements that stay open need none.
    """
    matrix, made = system
    for i in range(count):
        amount = amounts[i]
        if amount == 0.0:
            continue
        line = matrix[i]
        if not made[i]:
            made[i] = True
            for k in range(count):
                line[k] = kernel[abs(row[k] - row[i]), MOST_SIDE_ELEMENTS + col[k] - col[i]]
        for k in range(count):
            out[k] -= amount * line[k]


@inner(fastmath=True)
def _restore(count, load, bound, pressure):
    """Bring the sum of the pressures to the load by a shift of those between 0 and `bound`."""
    for _ in range(FORCE_SHIFTS):
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
def _level(count, bound, pressure, residual):
    """Residual that all elements between the bounds should share: how much the flat stands above
    the assumed depth. Their mean; if there are none, the mean of the least residual at the bound
    and the largest off contact."""
    total, between, low, high = 0.0, 0, 1e30, -1e30
    for i in range(count):
        if pressure[i] <= 0.0:
            high = max(high, residual[i])
        elif pressure[i] >= bound:
            low = min(low, residual[i])
        else:
            total += residual[i]
            between += 1
    if between:
        return np.float32(total / between)
    if high < -1e29:
        high = low
    if low > 1e29:
        low = high
    return np.float32(0.5 * (low + high))


@inner(fastmath=True)
def _start(count, overlap, load, bound, pressure):
    """Pressures of a paraboloid; under a load cut at the bound, and scaled to the load."""
    if load <= 0.0:
        scale = 4.0 / math.pi * math.sqrt(2.0 * math.pi / count)
        for i in range(count):
            pressure[i] = scale * math.sqrt(max(2.0 * overlap[i] - 1.0, 0.0))
        return
    low, high = 0.0, 2.0 * max(bound, load)
    for _ in range(40):
        scale, total = 0.5 * (low + high), 0.0
        for i in range(count):
            total += min(scale * math.sqrt(max(overlap[i], 0.0)), bound)
        if total < load:
            low = scale
        else:
            high = scale
    for i in range(count):
        pressure[i] = min(high * math.sqrt(max(overlap[i], 0.0)), bound)


@inner(fastmath=True)
def solve(count, row, col, overlap, kernel, load, bound, tolerance, system, pressure, work):
    """Pressures 0 <= p <= bound under overlaps h: the minimum of p.G p / 2 - p.h, at the sum `load`
    of the pressures or, if that is zero, whatever their sum.

    Conjugate gradients on the elements between the bounds (Polonsky & Keer 1999; upper bound: Tian
    & Bhushan 1996), from the pressures of a paraboloid. Returns the `_level` of the residual h - G
    p under a load, else 0, and leaves the residual less this level in the first row of `work`.
    `system` is scratch.
    """
    system[1][:count] = False
    residual, direction, change, correction = work[0], work[1], work[2], work[3]
    _start(count, overlap, load, bound, pressure)
    for i in range(count):
        residual[i], direction[i] = overlap[i], 0.0
    _subtract_displacement(count, pressure, row, col, kernel, system, residual)
    before, fresh, level = 1.0, True, np.float32(0.0)
    for _ in range(MAX_GRADIENT_STEPS):
        if load > 0.0:
            level = _level(count, bound, pressure, residual)
        total, error, square, mean, free = 0.0, 0.0, 0.0, 0.0, 0
        for i in range(count):
            over = residual[i] - level
            total += pressure[i] * overlap[i]
            if 0.0 < pressure[i] < bound:
                square += over * over
                free += 1
            if over < 0.0 or load <= 0.0:
                error += abs(over) * pressure[i]
            else:
                error += (bound - pressure[i]) * over
        if error <= tolerance * total:
            break
        share = np.float32(0.0 if fresh else square / before)
        before = square
        for i in range(count):
            inside = 0.0 < pressure[i] < bound
            over = residual[i] - level
            direction[i] = over + share * direction[i] if inside else np.float32(0.0)
            mean += direction[i]
            change[i] = 0.0
        mean = np.float32(mean / max(free, 1) if load > 0.0 else 0.0)
        above, below = 0.0, 0.0
        for i in range(count):
            if 0.0 < pressure[i] < bound:
                direction[i] -= mean
                above += (residual[i] - level) * direction[i]
        _subtract_displacement(count, direction, row, col, kernel, system, change)
        for i in range(count):
            below -= change[i] * direction[i]
        step = np.float32(above / below) if below > 0.0 else np.float32(1.0)
        fresh = not below > 0.0
        for i in range(count):
            correction[i] = pressure[i]
            over = residual[i] - level
            inside = 0.0 < pressure[i] < bound
            leaves = (pressure[i] <= 0.0 and over > 0.0) or (pressure[i] >= bound and over < 0.0)
            wanted = pressure[i] + step * (over if leaves else direction[i])
            pressure[i] = min(max(wanted, np.float32(0.0)), bound)
            correction[i] += step * direction[i]
            fresh = fresh or leaves
            residual[i] += step * change[i]
        if load > 0.0:
            _restore(count, load, bound, pressure)
        for i in range(count):
            correction[i] = pressure[i] - correction[i]
        _subtract_displacement(count, correction, row, col, kernel, system, residual)
    for i in range(count):
        residual[i] -= level
    return level


@inner()
def _edge_share(inside, outside, side, closed, residual, m, edge, bound):
    """Distance of the edge of contact from a closed element, over that of an open neighbor.

    At the distance s from the edge of a smooth contact the pressure is c s^((1+m)/2), and the gap c
    `edge` s^((3-m)/2), with `edge` = Gamma((3+m)/2)/Gamma((5-m)/2), in the units of this module and
    with the side of a square element as length. c follows from the distance `side` of both.
    """
    if outside < 0 or closed[inside] >= bound:
        return 0.5
    power, ratio = 2.0 / (3.0 - m), (3.0 - m) / (1.0 + m)
    a, b = float(closed[inside]), (max(-residual[outside], 0.0) / edge) ** power
    a = a * a if m == 0.0 else a ** (2.0 / (1.0 + m))
    w = (side / a) ** (1.0 / ratio)  # c^-power, at which both distances add up to `side`
    if b * w > side:
        w = side / b
    for _ in range(4):
        near = a * (w * w * w if m == 0.0 else w**ratio)
        w -= (near + b * w - side) / (ratio * near + b * w) * w
    return 1.0 - b * w / side


@inner()
def contact_size(number, nv, nu, hv, hu, closed, residual, m, edge, bound):
    """Contact area over the area of an element.

    `number` is the element at each point of the grid, or `OUTSIDE`. The contour crosses the line
    between a closed and an open neighbor at the point of `_edge_share`, halfway if the neighbor is
    `OUTSIDE`, and is straight from one crossing to the next (marching squares).
    """
    corners, ways = np.empty(4, np.int64), np.empty((8, 2))
    total = 0.0
    for i in range(-1, nv):
        for j in range(-1, nu):
            count = 0
            for k in range(4):
                row, col = i + (1 if k == 1 or k == 2 else 0), j + k // 2
                corners[k] = OUTSIDE
                if 0 <= row < nv and 0 <= col < nu:
                    corners[k] = number[row * nu + col]
                if corners[k] >= 0 and closed[corners[k]] > 0.0:
                    count += 1
            if count == 0 or count == 4:
                total += 0.25 * count
                continue
            count = 0
            for k in range(4):
                here, there = corners[k], corners[(k + 1) % 4]
                y, x = 1.0 if k == 1 or k == 2 else 0.0, float(k // 2)
                step_y = 1.0 if k == 0 else -1.0 if k == 2 else 0.0
                step_x = 1.0 if k == 1 else -1.0 if k == 3 else 0.0
                own = here >= 0 and closed[here] > 0.0
                if own:
                    ways[count, 0], ways[count, 1] = y, x
                    count += 1
                other = there >= 0 and closed[there] > 0.0
                if own == other:
                    continue
                side = hv if step_y != 0.0 else hu
                if own:
                    share = _edge_share(here, there, side, closed, residual, m, edge, bound)
                else:
                    share = 1.0 - _edge_share(there, here, side, closed, residual, m, edge, bound)
                ways[count, 0], ways[count, 1] = y + share * step_y, x + share * step_x
                count += 1
            twice = 0.0
            for k in range(count):
                n = (k + 1) % count
                twice += ways[k, 0] * ways[n, 1] - ways[n, 0] * ways[k, 1]
            total += 0.5 * abs(twice)
    return total
