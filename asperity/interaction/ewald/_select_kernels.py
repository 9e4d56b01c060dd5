"""Selection of pairs, several at a time; what is kept is written without gaps."""

from __future__ import annotations

import numpy as np

from surfaces.numerics.compiled import inner
from surfaces.numerics.vectors import compress, count, loader, multiply_add, splatter, where

__all__ = ["LANES", "keep_near"]

LANES = 8
"""Points that are looked at together."""

_NUMBERS = np.arange(float(LANES))

_load, _splat = loader(LANES), splatter(LANES)


@inner(forceinline=True)
def _nearest(way, size):
    """A way within half of the size of a cell that repeats."""
    way = where(way > 0.5 * size, way - size, way)
    return where(way < -0.5 * size, way + size, way)


@inner(forceinline=True)
def keep_near(y, x, first, last, here, size, cut, col, dy, dx, place):
    """Points from `first` on, up to eight and before `last`, closer than sqrt(cut) to a place.

    Writes their numbers and `here` (y, x) less their places y, x, less what brings these within
    half of `size` (y, x), to `col`, `dy` and `dx` from element `place` on, and zeros behind them
    up to eight elements in all. Returns their number.
    `y` and `x` are read up to seven elements beyond the last.
    """
    way_y = _nearest(_splat(here[0]) - _load(y, first), size[0])
    way_x = _nearest(_splat(here[1]) - _load(x, first), size[1])
    numbers = _load(_NUMBERS, 0) + float(first)
    near = (multiply_add(way_y, way_y, way_x * way_x) < cut) & (numbers < float(last))
    compress(col, place, numbers, near)
    compress(dy, place, way_y, near)
    compress(dx, place, way_x, near)
    return count(near)
