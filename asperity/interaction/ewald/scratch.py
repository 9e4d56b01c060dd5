"""Working space of the loops over blocks of pairs."""

from __future__ import annotations

from numba import types

from surfaces.numerics.vectors import on_stack

__all__ = ["BLOCK", "COLUMNS", "columns", "doubles", "floats", "places"]

BLOCK = 256
"""Pairs of a block."""

COLUMNS = 9
"""Columns of numbers for each block."""

doubles = on_stack(types.float64, 2 * BLOCK)
columns = on_stack(types.float64, COLUMNS * BLOCK)
floats = on_stack(types.float32, COLUMNS * BLOCK)
places = on_stack(types.int32, 2 * BLOCK)
