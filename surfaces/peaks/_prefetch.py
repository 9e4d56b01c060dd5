"""Prefetch of the pixels about summits, which lie scattered over the map."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core.cgutils import for_range
from numba.extending import intrinsic

from surfaces.numerics.vectors import data_of, prefetch

__all__ = ["prefetch_block"]

_LINE = 64
"""Bytes of a cache line."""


@intrinsic
def prefetch_block(
    typing: Any, array: Any, width: Any, row: Any, col: Any, rows: Any, cols: Any
) -> Any:
    """Prefetch `rows` times `cols` elements from (row, col) on of an array of that width."""
    step = 8 * _LINE // array.dtype.bitwidth

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        width, row, col, rows, cols = arguments[1:]
        data = data_of(context, builder, signature.args[0], arguments[0])
        last = builder.sub(cols, ir.Constant(cols.type, 1))
        lines = builder.sdiv(
            builder.add(cols, ir.Constant(cols.type, 2 * step - 2)), ir.Constant(cols.type, step)
        )
        with for_range(builder, rows) as down:
            first = builder.add(builder.mul(builder.add(row, down.index), width), col)
            with for_range(builder, lines) as across:
                place = builder.mul(across.index, ir.Constant(cols.type, step))
                place = builder.select(builder.icmp_signed("<", place, last), place, last)
                prefetch(builder, data, builder.add(first, place))
        return context.get_dummy_value()

    return types.void(array, *(types.intp,) * 5), code
