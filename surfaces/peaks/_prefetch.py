"""Prefetch of the pixels about summits, which lie scattered over the map."""

from __future__ import annotations

from typing import Any

from numba import njit, types
from numba.extending import intrinsic

from .._vectors import data_of, prefetch

__all__ = ["prefetch_block"]

_LINE = 64
"""Bytes of a cache line."""


@intrinsic
def _prefetch_element(typing: Any, array: Any, place: Any) -> Any:
    """Prefetch one element of an array."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        prefetch(builder, data_of(context, builder, signature.args[0], arguments[0]), arguments[1])
        return context.get_dummy_value()

    return types.void(array, types.intp), code


@njit(cache=True, nogil=True)
def prefetch_block(flat, width, row, col, rows, cols):
    """Prefetch `rows` times `cols` elements from (row, col) on of an array of that width."""
    step = _LINE // flat.itemsize
    for i in range(rows):
        first = (row + i) * width + col
        for j in range(0, cols + step - 1, step):
            _prefetch_element(flat, first + min(j, cols - 1))
