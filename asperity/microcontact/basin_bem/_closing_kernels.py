"""Pressures of few elements under a flat, at an approach or under a load, and their contour."""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import inner

__all__ = [
    "COPY_CHUNK",
    "MOST_ELEMENTS",
    "MOST_SIDE_ELEMENTS",
    "OUTSIDE",
    "bear",
    "contact_size",
    "solve",
]

MOST_SIDE_ELEMENTS = 64
"""Largest number of elements along a side of the grid of one contact."""

MOST_ELEMENTS = 700
"""Largest number of elements of one contact."""

COPY_CHUNK = 16
"""Influences copied at a time: what follows is overwritten, and rows are as much longer."""

MAX_GRADIENT_STEPS = 200
"""Steps of conjugate gradients."""

FORCE_SHIFTS = 4
"""Times that the force is restored by a shift of all pressures between their bounds."""

OUTSIDE = -1
"""Number of elements of other basins and of those that the flat does not reach."""


@inner(fastmath=True)
def _forget(count, row, col, system):
    """Begin with no row of the matrix made; note where elements that follow each other end."""
    _, made, ends = system
    first = 0
    for i in range(count):
        made[i] = False
        if i + 1 == count or row[i + 1] != row[first] or col[i + 1] - col[first] != i + 1 - first:
            ends[first] = i + 1
            first = i + 1


@inner(fastmath=True)
def _relieve(count, amounts, row, col, kernel, system, out):
    """Take the displacements of all elements by the pressures `amounts` off `out`.

    Rows of the matrix are made when they are first needed: elements that stay open need none.
    """
    matrix, made, ends = system
    for i in range(count):
        amount = amounts[i]
        if amount == 0.0:
            continue
        line = matrix[i]
        if not made[i]:
            made[i], last = True, 0
            while last < count:  # elements that follow each other in a row of the grid
                first, last = last, ends[last]
                begin, offsets = (
                    MOST_SIDE_ELEMENTS + col[first] - col[i],
                    kernel[abs(row[first] - row[i])],
                )
                for at in range(0, last - first, COPY_CHUNK):
                    to, some = line[first + at :], offsets[begin + at :]
                    for k in range(COPY_CHUNK):
                        to[k] = some[k]
        for k in range(count):
            out[k] -= amount * line[k]


@inner(fastmath=True)
def solve(count, row, col, gap, kernel, tolerance, system, pressure, work):
    """Pressures p >= 0 that close the overlaps: the minimum of p G p / 2 - p gap.

    Conjugate gradients that are restricted to the closed elements (Polonsky & Keer 1999), from the
    pressures of a paraboloid of this depth. `gap` is the overlap over its largest value. Leaves the
    overlap that remains in the first row of `work`; `system` is scratch (`elements`).
    """
    _forget(count, row, col, system)
    left, way, change, beside = work[0], work[1], work[2], work[3]
    scale = 4.0 / math.pi * math.sqrt(2.0 * math.pi / count)
    for i in range(count):
        pressure[i] = scale * math.sqrt(max(2.0 * gap[i] - 1.0, 0.0))
        left[i], way[i] = gap[i], 0.0
    _relieve(count, pressure, row, col, kernel, system, left)
    before, fresh = 1.0, True
    for _ in range(MAX_GRADIENT_STEPS):
        total, error, square = 0.0, 0.0, 0.0
        for i in range(count):
            total += pressure[i] * gap[i]
            if pressure[i] > 0.0:
                square += left[i] * left[i]
                error += abs(left[i]) * pressure[i]
        if error <= tolerance * total:
            break
        share = np.float32(0.0 if fresh else square / before)
        before = square
        for i in range(count):
            way[i] = left[i] + share * way[i] if pressure[i] > 0.0 else np.float32(0.0)
            change[i] = 0.0
        _relieve(count, way, row, col, kernel, system, change)
        above, below = 0.0, 0.0
        for i in range(count):
            below -= change[i] * way[i]
            above += left[i] * way[i]
        step, fresh = np.float32(above / below), False
        for i in range(count):
            beside[i] = 0.0  # what the pressure changes by beyond a step along the way
            if pressure[i] > 0.0:
                pressure[i] += step * way[i]
                if pressure[i] < 0.0:
                    beside[i], pressure[i] = -pressure[i], np.float32(0.0)
            elif left[i] > 0.0:
                pressure[i] = beside[i] = step * left[i]
                fresh = True
        for i in range(count):
            left[i] += step * change[i]
        _relieve(count, beside, row, col, kernel, system, left)


@inner(fastmath=True)
def _restore(count, load, bound, pressure):
    """Bring the sum of pressures between 0 and `bound` to the load by a shift of those between."""
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
    _forget(count, row, col, system)
    left, way, change, beside = work[0], work[1], work[2], work[3]
    low, high = 0.0, 2.0 * max(bound, load)
    for i in range(count):
        way[i] = 0.0
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
    _relieve(count, pressure, row, col, kernel, system, left)
    before, fresh = np.float32(1.0), True
    level = np.float32(0.0)
    for _ in range(MAX_GRADIENT_STEPS):
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
        _relieve(count, way, row, col, kernel, system, change)
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
            _relieve(count, beside, row, col, kernel, system, left)
    for i in range(count):
        left[i] -= level
    return level


@inner()
def _way(inside, outside, side, closed, left, m, edge, bound):
    """Way from a closed element towards an open one, over their distance, to the edge of contact.

    Next to the edge of a smooth contact the pressure is c s^((1+m)/2) and the gap
    c edge s^((3-m)/2), both at the distance s and as lengths in units of the element: c follows
    from the distance `side` of the two elements.
    """
    if outside < 0 or closed[inside] >= bound:
        return 0.5
    power, ratio = 2.0 / (3.0 - m), (3.0 - m) / (1.0 + m)
    a, b = float(closed[inside]), (max(-left[outside], 0.0) / edge) ** power
    a = a * a if m == 0.0 else a ** (2.0 / (1.0 + m))
    w = (side / a) ** (1.0 / ratio)  # c^-power, at which both distances add up to `side`
    if b * w > side:
        w = side / b
    for _ in range(4):
        near = a * (w * w * w if m == 0.0 else w**ratio)
        w -= (near + b * w - side) / (ratio * near + b * w) * w
    return 1.0 - b * w / side


@inner()
def contact_size(number, nv, nu, hv, hu, closed, left, m, edge, bound):
    """Area over that of an element within the contour of a contact.

    `number` is the element at each point of the grid, or `OUTSIDE`. The contour crosses the lines
    between neighbors as `_way` says and is straight from one line to the next; where the next point
    is none, it runs along the elements.
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
                    share = _way(here, there, side, closed, left, m, edge, bound)
                else:
                    share = 1.0 - _way(there, here, side, closed, left, m, edge, bound)
                ways[count, 0], ways[count, 1] = y + share * step_y, x + share * step_x
                count += 1
            twice = 0.0
            for k in range(count):
                n = (k + 1) % count
                twice += ways[k, 0] * ways[n, 1] - ways[n, 0] * ways[k, 1]
            total += 0.5 * abs(twice)
    return total
