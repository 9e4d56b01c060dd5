"""Vectors read from arrays and written to them; `vectors` explains their use."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .vector_code import (
    BYTES,
    INDEX,
    WORD,
    call,
    constant,
    data_of,
    fitted,
    gathered,
    halves,
    place_of,
    read,
    spread,
    vector_of,
    write,
)

__all__ = [
    "adder",
    "compress",
    "entries",
    "loader",
    "picker",
    "prefetch",
    "repeater",
    "store",
    "storer",
    "transposer",
    "two_floats",
]


def loader(width: int, grouped: bool = False, element: Any = None) -> Any:
    """load(array, place): vector of `width` elements of a contiguous array from a place on.

    If `grouped`, places count groups of `width` elements; so for the functions below. In the
    precision of the array, or that of the numba type `element`.
    """

    @intrinsic
    def load(typing: Any, array: Any, place: Any) -> Any:
        held, kind = vector_of(array.dtype, width), vector_of(element or array.dtype, width)

        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = data_of(context, builder, sig.args[0], args[0])
            found = read(builder, data, place_of(builder, args[1], width, grouped), held.code)
            return fitted(builder, found, kind.element)

        return kind(array, types.intp), code

    return load


def storer(grouped: bool = False) -> Any:
    """store(array, place, vector): write a vector from a place on, in the precision of the array;
    of an array of whole numbers, their whole part."""

    @intrinsic
    def store(typing: Any, array: Any, place: Any, vector: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = data_of(context, builder, sig.args[0], args[0])
            start = place_of(builder, args[1], sig.args[2].width, grouped)
            write(builder, fitted(builder, args[2], array.dtype), data, start)
            return context.get_dummy_value()

        return types.void(array, types.intp, vector), code

    return store


store = storer()


def adder(grouped: bool = False) -> Any:
    """add(array, place, vector): add a vector to what is there."""

    @intrinsic
    def add(typing: Any, array: Any, place: Any, vector: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = data_of(context, builder, sig.args[0], args[0])
            start = place_of(builder, args[1], sig.args[2].width, grouped)
            change = fitted(builder, args[2], array.dtype)
            held = read(builder, data, start, change.type)
            write(builder, builder.fadd(held, change), data, start)
            return context.get_dummy_value()

        return types.void(array, types.intp, vector), code

    return add


def repeater(width: int) -> Any:
    """repeat(array, place): an element in every lane of a vector of `width`."""

    @intrinsic
    def repeat(typing: Any, array: Any, place: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = data_of(context, builder, sig.args[0], args[0])
            return spread(builder, builder.load(builder.gep(data, [args[1]])), width)

        return vector_of(array.dtype, width)(array, types.intp), code

    return repeat


@intrinsic
def compress(typing: Any, array: Any, place: Any, vector: Any, mask: Any) -> Any:
    """Write the lanes of a vector that are in the mask from a place on, without gaps, and zeros
    behind them up to all lanes: to leave these out takes some processors ten times as long."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = data_of(context, builder, sig.args[0], args[0])
        value = fitted(builder, args[2], array.dtype)
        # as integers: where processors lack the instruction, LLVM cannot expand that of floats
        size = 8 * BYTES[str(value.type.element)]
        words = ir.VectorType(ir.IntType(size), vector.width)
        takes = ir.FunctionType(words, [words, args[3].type, words])
        name = f"experimental.vector.compress.v{vector.width}i{size}"
        held = builder.bitcast(value, words)
        found = call(builder, name, takes, held, args[3], constant(words, 0))
        write(builder, builder.bitcast(found, value.type), data, args[1])
        return context.get_dummy_value()

    return types.void(array, types.intp, vector, mask), code


@intrinsic
def two_floats(typing: Any, array: Any, place: Any) -> Any:
    """The two numbers `place` of an array (n, 2) in single precision, read as one word: a loop over
    vectors then gathers them at once."""
    single = types.float32

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = builder.bitcast(data_of(context, builder, sig.args[0], args[0]), WORD.as_pointer())
        both = builder.load(builder.gep(data, [args[1]]), align=4, typ=WORD)
        numbers = [
            builder.bitcast(builder.trunc(part, INDEX), ir.FloatType())
            for part in (both, builder.lshr(both, WORD(32)))
        ]
        return context.make_tuple(builder, sig.return_type, numbers)

    return types.UniTuple(single, 2)(array, types.uint64), code


@intrinsic
def entries(typing: Any, array: Any, places: Any) -> Any:
    """Elements of an array at a vector of whole numbers."""
    kind = vector_of(array.dtype, places.width)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = data_of(context, builder, sig.args[0], args[0])
        places = builder.fptosi(args[1], ir.VectorType(WORD, kind.width))
        return gathered(builder, data, places, kind.code)

    return kind(array, places), code


def picker() -> Any:
    """pick(array, groups): in lane l that lane of group groups[l] of the array."""

    @intrinsic
    def pick(typing: Any, array: Any, groups: Any) -> Any:
        kind = vector_of(array.dtype, groups.width)

        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = data_of(context, builder, sig.args[0], args[0])
            words = ir.VectorType(WORD, kind.width)
            groups = builder.mul(builder.fptosi(args[1], words), constant(words, kind.width))
            own = ir.Constant(words, list(range(kind.width)))
            return gathered(builder, data, builder.add(groups, own), kind.code)

        return kind(array, groups), code

    return pick


def transposer(width: int, grouped: bool = False) -> Any:
    """transpose(array, place, step, out, to, along): turn the `width` vectors of an array from a
    place on, a `step` apart, into columns, `along` apart in `out`."""

    @intrinsic
    def transpose(
        typing: Any, array: Any, place: Any, step: Any, out: Any, to: Any, along: Any
    ) -> Any:
        kind = vector_of(array.dtype, width).code

        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            source = data_of(context, builder, sig.args[0], args[0])
            target = data_of(context, builder, sig.args[3], args[3])
            place, step, to, along = (
                place_of(builder, args[k], width, grouped) for k in (1, 2, 4, 5)
            )
            rows = []
            for _ in range(width):
                rows.append(read(builder, source, place, kind))
                place = builder.add(place, step)
            half = width // 2
            while half:
                for i in (i for i in range(width) if not i & half):
                    rows[i], rows[i + half] = halves(builder, (rows[i], rows[i + half]), half)
                half //= 2
            for row in rows:
                write(builder, row, target, to)
                to = builder.add(to, along)
            return context.get_dummy_value()

        place = types.intp
        return types.void(array, place, place, out, place, place), code

    return transpose


@intrinsic
def prefetch(typing: Any, array: Any, place: Any) -> Any:
    """Ask for the cache line of an element that will be read soon; it need not exist."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = data_of(context, builder, sig.args[0], args[0])
        pointer = builder.bitcast(builder.gep(data, [args[1]]), ir.IntType(8).as_pointer())
        takes = ir.FunctionType(ir.VoidType(), [pointer.type, INDEX, INDEX, INDEX])
        call(builder, "prefetch.p0", takes, pointer, *(INDEX(n) for n in (0, 3, 1)))
        return context.get_dummy_value()

    return types.void(array, types.intp), code
