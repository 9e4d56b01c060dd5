"""Prefetch of the pixels about summits, which lie scattered over the map."""

from __future__ import annotations

from surfaces.numerics.compiled import inner
from surfaces.numerics.vectors import prefetch

__all__ = ["prefetch_block"]

_LINE = 64
"""Bytes of a cache line."""


@inner()
def prefetch_block(array, width, row, col, rows, cols):
    """Prefetch `rows` times `cols` elements from (row, col) on of an array of that width."""
    step = _LINE // array.itemsize
    for i in range(row, row + rows):
        for j in range(0, cols + step - 1, step):
            prefetch(array, i * width + col + min(j, cols - 1))
