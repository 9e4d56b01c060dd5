"""Records of points, as explicit vector instructions.

A loop that reads several arrays at the place of a neighbor spends its time on these reads. The four
numbers of a record lie side by side, so that one instruction reads or adds them all.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from surfaces import _vectors as vectors

__all__ = ["NUMBERS", "add_records"]

NUMBERS = 4
"""Numbers of a record."""


def _kind(array: Any) -> Any:
    """Vector of the elements of an array that a record takes."""
    return ir.VectorType(
        ir.FloatType() if array.dtype == types.float32 else ir.DoubleType(), NUMBERS
    )


@intrinsic
def add_records(typing: Any, data: Any, one: Any, other: Any, sums: Any, place: Any) -> Any:
    """Write the sum of the records `one` and `other` of the data (n, 4) as record `place` of
    `sums`, flat."""
    word = types.uint64
    signature = types.void(data, word, word, sums, word)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data, one, other, sums, place = arguments
        kind = _kind(signature.args[0])
        source = vectors.data_of(context, builder, signature.args[0], data)
        target = vectors.data_of(context, builder, signature.args[3], sums)
        size = ir.Constant(place.type, NUMBERS)
        left, right = (
            vectors.load(builder, source, builder.mul(k, size), kind) for k in (one, other)
        )
        total = builder.fadd(left, right)
        vectors.store(builder, total, target, builder.mul(place, size))
        return context.get_dummy_value()

    return signature, codegen
