"""The vector type of hand-vectorised loops: several numbers of one precision, handled at once.

The automatic vectorizer misses loops of few terms, table look-ups and shuffles. Such a loop is
written with vectors: they know the arithmetic operators with each other and with numbers,
comparisons give a mask, and `where` takes the place of a branch. The instructions are those of the
processor at hand, whatever its width.

    load = loader(8)                       # eight elements from a place of an array on

    @njit
    def weighted(a, b, weight, out):
        store(out, 0, where(load(a, 0) > load(b, 0), weight * load(a, 0), 0.0))

Width and precision are those of what is loaded: every function below takes vectors of any. All of
the machine-near code of the project is here, in `vector_arrays`, `vector_code` and `stack`.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .vector_arrays import (
    adder,
    compress,
    entries,
    loader,
    picker,
    prefetch,
    repeater,
    store,
    storer,
    transposer,
    two_floats,
)
from .vector_code import (
    INDEX,
    WORD,
    as_vector,
    constant,
    elementwise,
    halves,
    shuffled,
    spread,
    vector_among,
    vector_of,
)

__all__ = [
    "absolute",
    "adder",
    "compress",
    "count",
    "entries",
    "exponent",
    "lane",
    "loader",
    "mantissa",
    "multiply_add",
    "picker",
    "power_of_two",
    "prefetch",
    "repeater",
    "root",
    "some",
    "splatter",
    "store",
    "storer",
    "sums",
    "total",
    "transposer",
    "two_floats",
    "where",
    "whole",
]


def splatter(width: int) -> Any:
    """splat(value): a number in every lane of a vector of `width`."""

    @intrinsic
    def splat(typing: Any, value: Any) -> Any:
        element = value if isinstance(value, types.Float) else types.float64

        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return spread(builder, args[0], width)

        return vector_of(element, width)(element), code

    return splat


@intrinsic
def lane(typing: Any, vector: Any, number: Any) -> Any:
    """The number in a lane."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.extract_element(args[0], args[1])

    return vector.element(vector, types.intp), code


@intrinsic
def where(typing: Any, mask: Any, a: Any, b: Any) -> Any:
    """Lanes of `a` where the mask holds, else of `b`; one of them may be a number."""
    one = vector_among(a, b) or vector_of(types.float64, mask.width)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(args[0], *(as_vector(builder, v, one.width) for v in args[1:]))

    return one(mask, *(v if v == one else one.element for v in (a, b))), code


@intrinsic
def count(typing: Any, mask: Any) -> Any:
    """Number of lanes in a mask."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        word = builder.bitcast(args[0], ir.IntType(mask.width))
        return builder.zext(builder.ctpop(word), WORD)

    return types.int64(mask), code


@intrinsic
def some(typing: Any, mask: Any) -> Any:
    """Whether a mask holds in any lane."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        word = ir.IntType(mask.width)
        return builder.icmp_unsigned("!=", builder.bitcast(args[0], word), word(0))

    return types.boolean(mask), code


@intrinsic
def total(typing: Any, vector: Any) -> Any:
    """Sum of the lanes, pairwise; their number is a power of two."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value, width = args[0], vector.width
        while width > 1:
            width //= 2
            low, high = (
                shuffled(builder, value, value, range(start, start + width)) for start in (0, width)
            )
            value = builder.fadd(low, high)
        return builder.extract_element(value, INDEX(0))

    return vector.element(vector), code


@intrinsic
def sums(typing: Any, vectors: Any) -> Any:
    """Vector of the `total` of each vector of a tuple of as many as there are lanes."""
    kind = vectors.dtype

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        rows, step = cgutils.unpack_tuple(builder, args[0]), kind.width // 2
        while step:
            half = len(rows) // 2
            pairs = zip(rows[:half], rows[half:], strict=True)
            rows = [builder.fadd(*halves(builder, pair, step)) for pair in pairs]
            step //= 2
        return rows[0]

    return kind(vectors), code


@intrinsic
def multiply_add(typing: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c, rounded once where the processor can; numbers stand in every lane."""
    one = vector_among(a, b, c)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return elementwise(
            builder, "fmuladd", *(as_vector(builder, value, one.width) for value in args)
        )

    return one(*(value if value == one else one.element for value in (a, b, c))), code


def _unary(emit: Any) -> Any:
    """An elementwise function whose code is `emit(builder, value)`."""

    @intrinsic
    def function(typing: Any, vector: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return emit(builder, args[0])

        return vector(vector), code

    return function


root = _unary(lambda builder, value: elementwise(builder, "sqrt", value))
absolute = _unary(lambda builder, value: elementwise(builder, "fabs", value))
whole = _unary(lambda builder, value: elementwise(builder, "floor", value))


def _words(value: Any, number: int) -> Any:
    return constant(ir.VectorType(WORD, value.type.count), number)


def _exponent(builder: Any, value: Any) -> Any:
    word = builder.bitcast(value, ir.VectorType(WORD, value.type.count))
    word = builder.lshr(word, _words(value, 52))
    return builder.sitofp(builder.sub(word, _words(value, 1023)), value.type)


def _mantissa(builder: Any, value: Any) -> Any:
    word = builder.bitcast(value, ir.VectorType(WORD, value.type.count))
    word = builder.and_(word, _words(value, (1 << 52) - 1))
    return builder.bitcast(builder.or_(word, _words(value, 1023 << 52)), value.type)


def _power_of_two(builder: Any, value: Any) -> Any:
    word = builder.fptosi(value, ir.VectorType(WORD, value.type.count))
    word = builder.shl(builder.add(word, _words(value, 1023)), _words(value, 52))
    return builder.bitcast(word, value.type)


exponent = _unary(_exponent)
"""Whole part of the logarithm to base 2 of positive normal numbers (double precision)."""

mantissa = _unary(_mantissa)
"""Number over 2 to the power of its exponent, in [1, 2) (double precision)."""

power_of_two = _unary(_power_of_two)
"""2 to the power of whole numbers from -1022 to 1023 (double precision)."""
