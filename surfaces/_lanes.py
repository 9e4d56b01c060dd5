"""Sum over the lanes of a vector, in code written as explicit vector instructions."""

from __future__ import annotations

from typing import Any

from llvmlite import ir

__all__ = ["sum_lanes"]


def sum_lanes(builder: Any, values: Any) -> Any:
    """Sum of the lanes of one vector, pairwise; their number is a power of two."""
    lanes, index = values.type.count, ir.IntType(32)
    while lanes > 1:
        lanes //= 2
        nothing = ir.Constant(values.type, ir.Undefined)
        low, high = (
            ir.Constant(ir.VectorType(index, lanes), list(range(start, start + lanes)))
            for start in (0, lanes)
        )
        values = builder.fadd(
            builder.shuffle_vector(values, nothing, low),
            builder.shuffle_vector(values, nothing, high),
        )
    return builder.extract_element(values, ir.Constant(index, 0))
