"""Area within the contour of a contact of few elements."""

from __future__ import annotations

import numpy as np

from surfaces.numerics.compiled import inner

__all__ = ["NONE", "contact_size"]

NONE = -1
"""Number of elements of other basins and of those that the flat does not reach."""


@inner()
def _way(inside, outside, side, closed, left, m, edge):
    """Way from a closed element towards an open one, over their distance, to the edge of contact.

    Next to the edge of a smooth contact the pressure is c s^((1+m)/2) and the gap
    c edge s^((3-m)/2), both at the distance s and as lengths in units of the element: c follows
    from the distance `side` of the two elements.
    """
    if outside < 0:
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
def contact_size(number, nv, nu, hv, hu, closed, left, m, edge):
    """Area over that of an element within the contour of a contact.

    `number` is the element at each point of the grid, or `NONE`. The contour crosses the lines
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
                corners[k] = NONE
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
                    share = _way(here, there, side, closed, left, m, edge)
                else:
                    share = 1.0 - _way(there, here, side, closed, left, m, edge)
                ways[count, 0], ways[count, 1] = y + share * step_y, x + share * step_x
                count += 1
            twice = 0.0
            for k in range(count):
                n = (k + 1) % count
                twice += ways[k, 0] * ways[n, 1] - ways[n, 0] * ways[k, 1]
            total += 0.5 * abs(twice)
    return total
