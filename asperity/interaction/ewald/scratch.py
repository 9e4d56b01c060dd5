"""Short arrays on the stack of a compiled loop.

A loop that reads at places found in an index becomes vector instructions only if its results cannot
lie in what it reads: arrays of the caller might, an array on the stack cannot.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

__all__ = ["BLOCK", "COLUMNS", "columns", "doubles", "floats", "places"]

BLOCK = 256
"""Pairs of a block."""

COLUMNS = 9
"""Columns of numbers for each block."""

ALIGNMENT = 64


def _on_stack(kind: Any, element: Any, count: int) -> Any:
    """Pointer to `count` elements in the frame of the caller, as an intrinsic."""

    @intrinsic
    def pointer(typing_context: Any) -> Any:
        """Pointer for `numba.carray`; the caller must not return it."""

        def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            place = cgutils.alloca_once(builder, ir.ArrayType(element, count))  # type: ignore[no-untyped-call]
            place.align = ALIGNMENT
            return builder.bitcast(place, element.as_pointer())

        return types.CPointer(kind)(), codegen  # type: ignore[no-untyped-call]

    return pointer


doubles = _on_stack(types.float64, ir.DoubleType(), 2 * BLOCK)
columns = _on_stack(types.float64, ir.DoubleType(), COLUMNS * BLOCK)
floats = _on_stack(types.float32, ir.FloatType(), COLUMNS * BLOCK)
places = _on_stack(types.int32, ir.IntType(32), 2 * BLOCK)
