"""Symmetric stencils on a padded grid (docs/development/half_space.md), 16 points at once.

Written with vectors because the automatic vectorizer does not find them. A tile is 16 neighbors of
a row: rows at equal distance above and below are added first, then weighted, and the weighted sums
are shifted last, so that a tile costs as much as four to five points on their own.
"""

from __future__ import annotations

from numba import carray, types

from surfaces.numerics.compiled import inner
from surfaces.numerics.vectors import loader, multiply_add, on_stack, repeater, store

RADIUS = 7
SHORT_RADIUS = 4
LANES = 16
_HALF = LANES // 2
_ROWS = 2 * LANES * (RADIUS + 1)

_load, _repeat = loader(LANES), repeater(LANES)
_rows = on_stack(types.float32, _ROWS)


@inner(forceinline=True)
def tile(radius, grid, place, stride, weights, sums):
    """Stencil sums of the 16 points from a flat offset of the grid on, into `sums`.

    grid, weights and sums are flat float32 arrays; weights hold the quadrant of the stencil,
    (radius + 1)**2 values from its centre on.
    """
    folded = carray(_rows(), (_ROWS,))
    weighted = carray(_rows(), (_ROWS,))
    begin = place - _HALF
    store(folded, 0, _load(grid, begin))
    store(folded, LANES, _load(grid, begin + LANES))
    for row in range(1, radius + 1):
        above, below = begin + row * stride, begin - row * stride
        store(folded, 2 * LANES * row, _load(grid, above) + _load(grid, below))
        right = _load(grid, above + LANES) + _load(grid, below + LANES)
        store(folded, 2 * LANES * row + LANES, right)
    for distance in range(radius + 1):
        weight = _repeat(weights, distance)
        left, right = weight * _load(folded, 0), weight * _load(folded, LANES)
        for row in range(1, radius + 1):
            weight = _repeat(weights, row * (radius + 1) + distance)
            left = multiply_add(_load(folded, 2 * LANES * row), weight, left)
            right = multiply_add(_load(folded, 2 * LANES * row + LANES), weight, right)
        store(weighted, 2 * LANES * distance, left)
        store(weighted, 2 * LANES * distance + LANES, right)
    found = _load(weighted, _HALF)
    for distance in range(1, radius + 1):
        middle = 2 * LANES * distance + _HALF
        found = found + _load(weighted, middle - distance) + _load(weighted, middle + distance)
    store(sums, 0, found)
