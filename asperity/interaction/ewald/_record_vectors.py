"""Records of points, as explicit vector instructions.

A loop that reads several arrays at the place of a neighbor spends its time on these reads. The four
numbers of a record lie side by side, so that one instruction reads or adds them all, and the two of
a table in single precision, which a loop over vectors then gathers as one word.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from surfaces.numerics import vectors as vectors

__all__ = ["NUMBERS", "add_records", "two_floats"]

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


@intrinsic
def two_floats(typing: Any, data: Any, place: Any) -> Any:
    """The numbers `place` of the data (n, 2), float32."""
    single = types.float32
    signature = types.UniTuple(single, 2)(data, types.uint64)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data, place = arguments
        start = vectors.data_of(context, builder, signature.args[0], data)
        half, whole = ir.IntType(32), ir.IntType(64)
        word = builder.gep(builder.bitcast(start, whole.as_pointer()), [place])
        both = builder.load(word, align=4, typ=whole)
        numbers = [
            builder.bitcast(builder.trunc(part, half), ir.FloatType())
            for part in (both, builder.lshr(both, ir.Constant(whole, 32)))
        ]
        return context.make_tuple(builder, signature.return_type, numbers)

    return signature, codegen
