"""Short arrays on the stack of a compiled loop.

A loop that reads at places found in an index becomes vector instructions only if its results cannot
lie in what it reads: arrays of the caller might, an array on the stack cannot.
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

__all__ = ["on_stack"]

ALIGNMENT = 64
"""Bytes of a cache line."""


def on_stack(kind: Any, count: int) -> Any:
    """pointer(): `count` elements of a numba type in the frame of the calling function, for
    `numba.carray`; the caller must not return it."""

    @intrinsic
    def pointer(typing: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            element = context.get_data_type(kind)
            place = cgutils.alloca_once(builder, element, count)
            place.align = ALIGNMENT
            return place

        return types.CPointer(kind)(), code

    return pointer
