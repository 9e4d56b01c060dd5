"""Compiled passes over the pixels of basins whose contacts have joined.

`slot` are the places of the contacts that are closed, of the peaks whose basins hold the pixels:
-1 for all others, and at its end, where the label -1 of what no basin holds leads.
"""

from __future__ import annotations

import math

from surfaces._compiled import compiled


@compiled(error_model="numpy")
def tally(heights, labels, slot, periodic, spacing, first, last, top, depth, count, slope, found):
    """Pixels of closed basins in the rows [first, last), and the sums of their slopes, by the depth
    under the summit.

    Basins have the summit `top` (n,) and are counted down to `depth` (n,), into the bins of `count`
    and `slope` (n, bins). Returns how many pixels that are; `found` begins with them.
    """
    ny, nx = heights.shape
    bins = count.shape[1]
    number = 0
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
            found[number] = i * nx + j
            number += 1
            inside = 0 < j < nx - 1
            left = j - 1 if j > 0 else (nx - 1 if periodic else 0)
            right = j + 1 if j < nx - 1 else (0 if periodic else j)
            dx = spacing[1] * (2 if periodic or inside else 1)
            y = (heights[down, j] - heights[up, j]) / dy
            x = (heights[i, right] - heights[i, left]) / dx
            place = max(int(fall / depth[own] * bins), 0)
            count[own, place] += 1
            slope[own, place] += math.sqrt(y * y + x * x)
    return number


@compiled()
def outlines(heights, labels, slot, periodic, spacing, level, found, common, free):
    """Lengths of the outlines of contacts that reach down to `level`, where they border on other
    contacts and where they do not; added to `common` and `free`, (n + 1,) as `level`.

    Their pixels are among those `found`. The last place is that of all that is open, whose level is
    infinite.
    """
    ny, nx = heights.shape
    for pixel in found:
        i, j = pixel // nx, pixel % nx
        own = slot[labels[i, j]]
        if heights[i, j] <= level[own]:
            continue
        for k in range(4):
            a, b = i, j
            if k < 2:
                a += 2 * k - 1
            else:
                b += 2 * k - 5
            if not (0 <= a < ny and 0 <= b < nx):
                if not periodic:
                    continue
                a, b = a % ny, b % nx
            other = slot[labels[a, b]]
            length = spacing[1] if k < 2 else spacing[0]
            if heights[a, b] <= level[other]:
                free[own] += length
            elif other != own:
                common[own] += length
