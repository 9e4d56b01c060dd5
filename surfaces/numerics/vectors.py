"""The vector type of hand-vectorized loops: several numbers of one precision, handled at once.

The automatic vectorizer misses loops of few terms, table look-ups and shuffles. Such a loop is
written with vectors: they know the arithmetic operators with each other and with numbers,
comparisons give a mask, and `where` takes the place of a branch. The instructions are those of the
processor at hand, whatever its width.

    load = loader(8)                       # eight elements from a place of an array on

    @njit
    def weighted(a, b, weight, out):
        store(out, 0, where(load(a, 0) > load(b, 0), weight * load(a, 0), 0.0))

Width and precision are those of what is loaded: every function below takes vectors of any. All of
the machine-near code of the project is here and in `vector_type`.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .vector_type import (
    BYTES,
    CODE,
    INDEX,
    WORD,
    absolute,
    call,
    constant,
    halves,
    lane,
    multiply_add,
    root,
    some,
    splatter,
    spread,
    sums,
    total,
    vector_of,
    where,
    whole,
)

__all__ = [
    "absolute",
    "add",
    "entries",
    "lane",
    "loader",
    "multiply_add",
    "on_stack",
    "pick",
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


ALIGNMENT = 64
"""Bytes of a cache line."""


def loader(width: int, grouped: bool = False) -> Any:
    """load(array, place): vector of `width` elements of a contiguous array from a place on.

    If `grouped`, places count groups of `width` elements; so for the functions below.
    """

    @intrinsic
    def load(typing: Any, array: Any, place: Any) -> Any:
        kind = vector_of(array.dtype, width)

        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = data_of(context, builder, sig.args[0], args[0])
            return read(builder, data, place_of(builder, args[1], width, grouped), kind.code)

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


@intrinsic
def add(typing: Any, array: Any, group: Any, vector: Any) -> Any:
    """Add a vector to a group of elements of its width."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = data_of(context, builder, sig.args[0], args[0])
        start = place_of(builder, args[1], sig.args[2].width, True)
        change = fitted(builder, args[2], array.dtype)
        held = read(builder, data, start, change.type)
        write(builder, builder.fadd(held, change), data, start)
        return context.get_dummy_value()

    return types.void(array, types.intp, vector), code


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


@intrinsic
def pick(typing: Any, array: Any, groups: Any) -> Any:
    """In lane l that lane of group groups[l] of the array."""
    kind = vector_of(array.dtype, groups.width)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = data_of(context, builder, sig.args[0], args[0])
        words = ir.VectorType(WORD, kind.width)
        groups = builder.mul(builder.fptosi(args[1], words), constant(words, kind.width))
        own = ir.Constant(words, list(range(kind.width)))
        return gathered(builder, data, builder.add(groups, own), kind.code)

    return kind(array, groups), code


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


def on_stack(kind: Any, count: int) -> Any:
    """pointer(): `count` elements of a numba type in the frame of the calling function, for
    `numba.carray`; the caller must not return it.

    A loop that reads at places found in an index becomes vector instructions only if its results
    cannot lie in what it reads: arrays of the caller might, an array on the stack cannot.
    """

    @intrinsic
    def pointer(typing: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            element = context.get_data_type(kind)
            place = cgutils.alloca_once(builder, element, count)
            place.align = ALIGNMENT
            return place

        return types.CPointer(kind)(), code

    return pointer


def data_of(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    """Pointer to the first element of an array of the numba type `kind`."""
    return context.make_array(kind)(context, builder, array).data


def fitted(builder: Any, vector: Any, element: Any) -> Any:
    """A vector in the precision of an array's elements; whole numbers are cut off."""
    if element in CODE:
        code = ir.VectorType(CODE[element], vector.type.count)
        if code == vector.type:
            return vector
        return (builder.fpext if element == types.float64 else builder.fptrunc)(vector, code)
    return builder.fptosi(vector, ir.VectorType(ir.IntType(element.bitwidth), vector.type.count))


def read(builder: Any, data: Any, place: Any, kind: Any) -> Any:
    pointer = builder.bitcast(builder.gep(data, [place]), kind.as_pointer())
    return builder.load(pointer, align=BYTES[str(kind.element)], typ=kind)


def write(builder: Any, vector: Any, data: Any, place: Any) -> None:
    pointer = builder.bitcast(builder.gep(data, [place]), vector.type.as_pointer())
    builder.store(vector, pointer, align=BYTES[str(vector.type.element)])


def gathered(builder: Any, data: Any, places: Any, kind: Any) -> Any:
    """Elements of the data at a vector of 64-bit places."""
    width, size = kind.count, BYTES[str(kind.element)]
    start = spread(builder, builder.ptrtoint(data, WORD), width)
    pointers = ir.VectorType(kind.element.as_pointer(), width)
    at = builder.add(start, builder.mul(places, constant(places.type, size)))
    at = builder.inttoptr(at, pointers)
    truth = ir.VectorType(ir.IntType(1), width)
    takes = ir.FunctionType(kind, [pointers, INDEX, truth, kind])
    name = f"masked.gather.v{width}f{8 * size}.v{width}p0"
    rest = ir.Constant(kind, ir.Undefined)
    return call(builder, name, takes, at, INDEX(size), constant(truth, 1), rest)


def place_of(builder: Any, index: Any, width: int, grouped: bool) -> Any:
    """Element at which a vector starts: the index, or the start of that group of `width`."""
    return builder.mul(index, ir.Constant(index.type, width)) if grouped else index
