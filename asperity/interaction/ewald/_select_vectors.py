"""Selection of pairs, several at a time, as explicit vector instructions.

What is kept is written without gaps, which the automatic vectorizer cannot do.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from surfaces.numerics import vectors as vectors

__all__ = ["LANES", "keep_near"]

LANES = 8
"""Points that are looked at together."""

_INDEX, _WORD, _FLOAT, _DOUBLE = ir.IntType(32), ir.IntType(64), ir.FloatType(), ir.DoubleType()
_TRUTH = ir.VectorType(ir.IntType(1), LANES)
_INDICES, _FLOATS = ir.VectorType(_INDEX, LANES), ir.VectorType(_FLOAT, LANES)


def _compress(builder: Any, vector: Any, data: Any, place: Any, mask: Any) -> None:
    """Write the lanes in the mask from an element of the data on, without gaps, and zeros behind
    them up to all lanes: to leave these out takes some processors ten times as long."""
    # as integers: where processors lack the instruction, LLVM cannot expand that of floats
    name = f"llvm.experimental.vector.compress.v{LANES}i32"
    takes = ir.FunctionType(_INDICES, [_INDICES, _TRUTH, _INDICES])
    function = cgutils.get_or_insert_function(builder.module, takes, name)
    whole = builder.bitcast(vector, _INDICES)
    close = builder.call(function, [whole, mask, vectors.constant(_INDICES, 0)])
    vectors.store(builder, builder.bitcast(close, vector.type), data, place)


def _count(builder: Any, mask: Any) -> Any:
    """Lanes in the mask."""
    byte = ir.IntType(LANES)
    return builder.zext(builder.ctpop(builder.bitcast(mask, byte)), _WORD)


def _lanes_from(builder: Any, first: Any) -> Any:
    """Whole numbers from the first on."""
    steps = ir.Constant(ir.VectorType(first.type, LANES), list(range(LANES)))
    return builder.add(vectors.everywhere(builder, first, LANES), steps)


@intrinsic
def keep_near(
    typing: Any,
    y: Any,
    x: Any,
    first: Any,
    last: Any,
    here: Any,
    size: Any,
    cut: Any,
    col: Any,
    dy: Any,
    dx: Any,
    place: Any,
) -> Any:
    """Points from `first` on, up to eight and before `last`, closer than sqrt(cut) to a place.

    Writes their numbers and `here` (y, x) less their places y, x, less what brings these within
    half of `size` (y, x), to `col`, `dy` and `dx` from element `place` on, and zeros behind them
    up to eight elements in all. Returns their number.
    `y` and `x` are read up to seven elements beyond the last.
    """
    pair = types.UniTuple(types.float64, 2)
    word = types.int64
    signature = word(y, x, word, word, pair, pair, types.float64, col, dy, dx, word)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        y, x, first, last, here, size, cut, col, dy, dx, place = arguments
        kinds = signature.args
        doubles = ir.VectorType(_DOUBLE, LANES)
        ways = []
        for axis, array in enumerate((y, x)):
            data = vectors.data_of(context, builder, kinds[axis], array)
            there = vectors.load(builder, data, first, doubles)
            at = vectors.everywhere(builder, builder.extract_value(here, axis), LANES)
            period = vectors.everywhere(builder, builder.extract_value(size, axis), LANES)
            way = builder.fsub(at, there)
            half = builder.fmul(period, vectors.constant(doubles, 0.5))
            least = builder.fneg(half)
            above, below = (
                builder.fcmp_ordered(sign, way, bound)
                for sign, bound in ((">", half), ("<", least))
            )
            way = builder.select(above, builder.fsub(way, period), way)
            ways.append(builder.select(below, builder.fadd(way, period), way))
        square = vectors.multiply_add(builder, ways[0], ways[0], builder.fmul(ways[1], ways[1]))
        near = builder.fcmp_ordered("<", square, vectors.everywhere(builder, cut, LANES))
        numbers = _lanes_from(builder, first)
        end = vectors.everywhere(builder, last, LANES)
        near = builder.and_(near, builder.icmp_signed("<", numbers, end))
        parts = [builder.trunc(numbers, _INDICES)]
        parts += [builder.fptrunc(way, _FLOATS) for way in ways]
        for part, kind, array in zip(parts, kinds[7:10], (col, dy, dx), strict=True):
            data = vectors.data_of(context, builder, kind, array)
            _compress(builder, part, data, place, near)
        return _count(builder, near)

    return signature, codegen
