"""Compiled passes over the pixels of basins whose contacts have joined.

`slot` are the places of the contacts that are closed, of the peaks whose basins hold the pixels:
-1 for all others, and at its end, where the label -1 of what no basin holds leads. Both take the
rows [first, last) of a map.
"""

from __future__ import annotations

import math

from surfaces.numerics.compiled import compiled, inner


@compiled()
def tally(heights, labels, slot, periodic, spacing, first, last, top, depth, count, slope):
    """Pixels of closed basins, and the sums of their slopes, by the depth under the summit.

    Basins have the summit `top` (n,) and are counted down to `depth` (n,), into the bins of `count`
    and `slope` (n, bins).
    """
    ny, nx = heights.shape
    bins = count.shape[1]
    for i in range(first, last):
        inside = 0 < i < ny - 1
        up = i - 1 if i > 0 else (ny - 1 if periodic else 0)
        down = i + 1 if i < ny - 1 else (0 if periodic else i)
        dy = spacing[0] * (2 if periodic or inside else 1)
        for j in range(nx):
            own = slot[labels[i, j]]
            if own < 0:
                continue
            fall = top[own] - heights[i, j]
            if fall >= depth[own]:
                continue
            inside = 0 < j < nx - 1
            left = j - 1 if j > 0 else (nx - 1 if periodic else 0)
            right = j + 1 if j < nx - 1 else (0 if periodic else j)
            dx = spacing[1] * (2 if periodic or inside else 1)
            y = (heights[down, j] - heights[up, j]) / dy
            x = (heights[i, right] - heights[i, left]) / dx
            place = max(int(fall / depth[own] * bins), 0)
            count[own, place] += 1
            slope[own, place] += math.sqrt(y * y + x * x)


@inner()
def _add(one, other, length, common, free):
    """Add the side between two pixels to the outlines of the contacts that they lie in, if any."""
    lengths = free if one < 0 or other < 0 else common
    if one >= 0:
        lengths[one] += length
    if other >= 0:
        lengths[other] += length


@compiled()
def outlines(heights, labels, slot, periodic, spacing, first, last, level, lines, common, free):
    """Lengths of the outlines of contacts that reach down to `level`, where they border on other
    contacts and where they do not; added to `common` and `free`, all (n,).

    Of each row its sides to the one before and within are looked at; `lines` is scratch, (2, nx).
    """
    nx = heights.shape[1]
    for i in range(first if first == 0 and not periodic else first - 1, last):
        before, here = lines[i % 2], lines[(i + 1) % 2]
        for j in range(nx):
            own = slot[labels[i, j]]
            here[j] = own if own >= 0 and heights[i, j] > level[own] else -1
        if i < first:
            continue
        for j in range(nx):
            if before[j] != here[j] and (i > 0 or periodic):
                _add(before[j], here[j], spacing[1], common, free)
        for j in range(0 if periodic else 1, nx):
            if here[j - 1] != here[j]:
                _add(here[j - 1], here[j], spacing[0], common, free)
