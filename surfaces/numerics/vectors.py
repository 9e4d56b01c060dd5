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
the machine-near code of the project is here and in `stack`.
"""

from __future__ import annotations

import functools
import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

__all__ = [
    "Vector",
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

_INDEX, _WORD = ir.IntType(32), ir.IntType(64)
_CODE = {
    types.float32: ir.FloatType(),
    types.float64: ir.DoubleType(),
    types.boolean: ir.IntType(1),
}
_BYTES = {"float": 4, "double": 8, "i32": 4, "i64": 8}


class Vector(types.Type):
    """Numba type of `width` numbers, or truths, of the numba type `element`; see `vector_of`."""

    def __init__(self, element: Any, width: int) -> None:
        self.element, self.width = element, width
        super().__init__(name=f"Vector({element}, {width})")

    @property
    def code(self) -> Any:
        """Type of the vector in machine code."""
        return ir.VectorType(_CODE[self.element], self.width)


@functools.cache
def vector_of(element: Any, width: int) -> Vector:
    """The type of vectors of so many elements; made once, the compiler asks for it often."""
    return Vector(element, width)


@register_model(Vector)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, kind.code)


# --- emission: a builder is that of llvmlite, a vector one of its values of `ir.VectorType` ---


def _constant(kind: Any, value: float) -> Any:
    return ir.Constant(kind, [value] * kind.count)


def _spread(builder: Any, scalar: Any, width: int) -> Any:
    """A scalar in every lane."""
    kind = ir.VectorType(scalar.type, width)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), scalar, _INDEX(0))
    return _shuffled(builder, first, first, [0] * width)


def _shuffled(builder: Any, a: Any, b: Any, order: Any) -> Any:
    """Lanes of two vectors, those of the second counted on from the first, in a new order."""
    mask = ir.Constant(ir.VectorType(_INDEX, len(order)), list(order))
    return builder.shuffle_vector(a, b, mask)


def _data(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    """Pointer to the first element of an array of the numba type `kind`."""
    return context.make_array(kind)(context, builder, array).data


def _fitted(builder: Any, vector: Any, element: Any) -> Any:
    """A vector in the precision of an array's elements; whole numbers are cut off."""
    if element in _CODE:
        code = ir.VectorType(_CODE[element], vector.type.count)
        if code == vector.type:
            return vector
        return (builder.fpext if element == types.float64 else builder.fptrunc)(vector, code)
    return builder.fptosi(vector, ir.VectorType(ir.IntType(element.bitwidth), vector.type.count))


def _read(builder: Any, data: Any, place: Any, kind: Any) -> Any:
    pointer = builder.bitcast(builder.gep(data, [place]), kind.as_pointer())
    return builder.load(pointer, align=_BYTES[str(kind.element)], typ=kind)


def _write(builder: Any, vector: Any, data: Any, place: Any) -> None:
    pointer = builder.bitcast(builder.gep(data, [place]), vector.type.as_pointer())
    builder.store(vector, pointer, align=_BYTES[str(vector.type.element)])


def _gathered(builder: Any, data: Any, places: Any, kind: Any) -> Any:
    """Elements of the data at a vector of 64-bit places."""
    width, size = kind.count, _BYTES[str(kind.element)]
    start = _spread(builder, builder.ptrtoint(data, _WORD), width)
    pointers = ir.VectorType(kind.element.as_pointer(), width)
    at = builder.add(start, builder.mul(places, _constant(places.type, size)))
    at = builder.inttoptr(at, pointers)
    truth = ir.VectorType(ir.IntType(1), width)
    takes = ir.FunctionType(kind, [pointers, _INDEX, truth, kind])
    name = f"masked.gather.v{width}f{8 * size}.v{width}p0"
    rest = ir.Constant(kind, ir.Undefined)
    return _call(builder, name, takes, at, _INDEX(size), _constant(truth, 1), rest)


def _elementwise(builder: Any, name: str, *values: Any) -> Any:
    """LLVM intrinsic of equal vectors."""
    kind = values[0].type
    full = f"{name}.v{kind.count}f{8 * _BYTES[str(kind.element)]}"
    return _call(builder, full, ir.FunctionType(kind, [kind] * len(values)), *values)


def _call(builder: Any, name: str, kind: Any, *values: Any) -> Any:
    return builder.call(
        cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}"), values
    )


def _halves(builder: Any, pair: Any, step: int) -> Any:
    """Of two vectors, the lanes whose number has the bit `step` clear, and those that have it set.

    Those of the first vector come to lanes with the bit clear, those of the second to the others.
    """
    lanes = range(pair[0].type.count)
    low = [lane if not lane & step else len(lanes) + lane - step for lane in lanes]
    high = [lane + step if not lane & step else len(lanes) + lane for lane in lanes]
    return _shuffled(builder, *pair, low), _shuffled(builder, *pair, high)


def _place(builder: Any, index: Any, width: int, grouped: bool) -> Any:
    """Element at which a vector starts: the index, or the start of that group of `width`."""
    return builder.mul(index, ir.Constant(index.type, width)) if grouped else index


def _vectors(*kinds: Any) -> Any:
    """The one vector type among arguments of which the others are numbers, or None."""
    found = None
    for kind in kinds:
        if isinstance(kind, Vector):
            if found not in (None, kind):
                return None
            found = kind
        elif not isinstance(kind, types.Float | types.Integer):
            return None
    return found


def _as_vector(builder: Any, value: Any, width: int) -> Any:
    return value if isinstance(value.type, ir.VectorType) else _spread(builder, value, width)


# --- operators ---


def _binary(function: Any, truth: bool, emit: Any) -> None:
    """Typing and code of an operator between vectors, or a vector and a number."""

    class Typing(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            one = _vectors(*args) if len(args) == 2 and not kws else None
            if one is None or one.element is types.boolean:
                return None
            result = vector_of(types.boolean, one.width) if truth else one
            return signature(result, *(a if a == one else one.element for a in args))

    infer_global(function)(Typing)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        width = _vectors(*sig.args).width
        return emit(builder, *(_as_vector(builder, value, width) for value in args))

    for kinds in ((Vector, Vector), (Vector, types.Float), (types.Float, Vector)):
        lower_builtin(function, *kinds)(lower)


for _functions, _name in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv, operator.itruediv), "fdiv"),
):
    for _function in _functions:
        _binary(_function, False, lambda builder, a, b, n=_name: getattr(builder, n)(a, b))
for _function, _sign in (
    (operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">="),
):  # fmt: skip
    _binary(_function, True, lambda builder, a, b, s=_sign: builder.fcmp_ordered(s, a, b))


def _unary_operator(function: Any, truth: bool, count: int, emit: Any) -> None:
    """Typing and code of an operator of `count` equal masks, or vectors of numbers."""

    class Typing(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            one = args[0]
            if kws or len(args) != count or not isinstance(one, Vector) or len(set(args)) > 1:
                return None
            return signature(one, *args) if (one.element is types.boolean) == truth else None

    infer_global(function)(Typing)
    lower_builtin(function, *(Vector,) * count)(
        lambda context, builder, sig, args: emit(builder, *args)
    )


_unary_operator(operator.and_, True, 2, lambda builder, a, b: builder.and_(a, b))
_unary_operator(operator.or_, True, 2, lambda builder, a, b: builder.or_(a, b))
_unary_operator(operator.invert, True, 1, lambda builder, a: builder.not_(a))
_unary_operator(operator.neg, False, 1, lambda builder, a: builder.fsub(_constant(a.type, 0.0), a))


# --- arrays ---


def loader(width: int, grouped: bool = False, element: Any = None) -> Any:
    """load(array, place): vector of `width` elements of a contiguous array from a place on.

    If `grouped`, places count groups of `width` elements; so for the functions below. In the
    precision of the array, or that of the numba type `element`.
    """

    @intrinsic
    def load(typing: Any, array: Any, place: Any) -> Any:
        held, kind = vector_of(array.dtype, width), vector_of(element or array.dtype, width)

        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = _data(context, builder, sig.args[0], args[0])
            found = _read(builder, data, _place(builder, args[1], width, grouped), held.code)
            return _fitted(builder, found, kind.element)

        return kind(array, types.intp), code

    return load


def storer(grouped: bool = False) -> Any:
    """store(array, place, vector): write a vector from a place on, in the precision of the array;
    of an array of whole numbers, their whole part."""

    @intrinsic
    def store(typing: Any, array: Any, place: Any, vector: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = _data(context, builder, sig.args[0], args[0])
            start = _place(builder, args[1], sig.args[2].width, grouped)
            _write(builder, _fitted(builder, args[2], array.dtype), data, start)
            return context.get_dummy_value()

        return types.void(array, types.intp, vector), code

    return store


store = storer()


def adder(grouped: bool = False) -> Any:
    """add(array, place, vector): add a vector to what is there."""

    @intrinsic
    def add(typing: Any, array: Any, place: Any, vector: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = _data(context, builder, sig.args[0], args[0])
            start = _place(builder, args[1], sig.args[2].width, grouped)
            change = _fitted(builder, args[2], array.dtype)
            held = _read(builder, data, start, change.type)
            _write(builder, builder.fadd(held, change), data, start)
            return context.get_dummy_value()

        return types.void(array, types.intp, vector), code

    return add


def repeater(width: int) -> Any:
    """repeat(array, place): an element in every lane of a vector of `width`."""

    @intrinsic
    def repeat(typing: Any, array: Any, place: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = _data(context, builder, sig.args[0], args[0])
            return _spread(builder, builder.load(builder.gep(data, [args[1]])), width)

        return vector_of(array.dtype, width)(array, types.intp), code

    return repeat


@intrinsic
def compress(typing: Any, array: Any, place: Any, vector: Any, mask: Any) -> Any:
    """Write the lanes of a vector that are in the mask from a place on, without gaps, and zeros
    behind them up to all lanes: to leave these out takes some processors ten times as long."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = _data(context, builder, sig.args[0], args[0])
        value = _fitted(builder, args[2], array.dtype)
        # as integers: where processors lack the instruction, LLVM cannot expand that of floats
        size = 8 * _BYTES[str(value.type.element)]
        words = ir.VectorType(ir.IntType(size), vector.width)
        takes = ir.FunctionType(words, [words, args[3].type, words])
        name = f"experimental.vector.compress.v{vector.width}i{size}"
        held = builder.bitcast(value, words)
        found = _call(builder, name, takes, held, args[3], _constant(words, 0))
        _write(builder, builder.bitcast(found, value.type), data, args[1])
        return context.get_dummy_value()

    return types.void(array, types.intp, vector, mask), code


@intrinsic
def two_floats(typing: Any, array: Any, place: Any) -> Any:
    """The two numbers `place` of an array (n, 2) in single precision, read as one word: a loop over
    vectors then gathers them at once."""
    single = types.float32

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = builder.bitcast(_data(context, builder, sig.args[0], args[0]), _WORD.as_pointer())
        both = builder.load(builder.gep(data, [args[1]]), align=4, typ=_WORD)
        numbers = [
            builder.bitcast(builder.trunc(part, _INDEX), ir.FloatType())
            for part in (both, builder.lshr(both, _WORD(32)))
        ]
        return context.make_tuple(builder, sig.return_type, numbers)

    return types.UniTuple(single, 2)(array, types.uint64), code


@intrinsic
def entries(typing: Any, array: Any, places: Any) -> Any:
    """Elements of an array at a vector of whole numbers."""
    kind = vector_of(array.dtype, places.width)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = _data(context, builder, sig.args[0], args[0])
        places = builder.fptosi(args[1], ir.VectorType(_WORD, kind.width))
        return _gathered(builder, data, places, kind.code)

    return kind(array, places), code


def picker() -> Any:
    """pick(array, groups): in lane l that lane of group groups[l] of the array."""

    @intrinsic
    def pick(typing: Any, array: Any, groups: Any) -> Any:
        kind = vector_of(array.dtype, groups.width)

        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = _data(context, builder, sig.args[0], args[0])
            words = ir.VectorType(_WORD, kind.width)
            groups = builder.mul(builder.fptosi(args[1], words), _constant(words, kind.width))
            own = ir.Constant(words, list(range(kind.width)))
            return _gathered(builder, data, builder.add(groups, own), kind.code)

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
            source = _data(context, builder, sig.args[0], args[0])
            target = _data(context, builder, sig.args[3], args[3])
            place, step, to, along = (
                _place(builder, args[k], width, grouped) for k in (1, 2, 4, 5)
            )
            rows = []
            for _ in range(width):
                rows.append(_read(builder, source, place, kind))
                place = builder.add(place, step)
            half = width // 2
            while half:
                for i in (i for i in range(width) if not i & half):
                    rows[i], rows[i + half] = _halves(builder, (rows[i], rows[i + half]), half)
                half //= 2
            for row in rows:
                _write(builder, row, target, to)
                to = builder.add(to, along)
            return context.get_dummy_value()

        place = types.intp
        return types.void(array, place, place, out, place, place), code

    return transpose


@intrinsic
def prefetch(typing: Any, array: Any, place: Any) -> Any:
    """Ask for the cache line of an element that will be read soon; it need not exist."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = _data(context, builder, sig.args[0], args[0])
        pointer = builder.bitcast(builder.gep(data, [args[1]]), ir.IntType(8).as_pointer())
        takes = ir.FunctionType(ir.VoidType(), [pointer.type, _INDEX, _INDEX, _INDEX])
        _call(builder, "prefetch.p0", takes, pointer, *(_INDEX(n) for n in (0, 3, 1)))
        return context.get_dummy_value()

    return types.void(array, types.intp), code


# --- functions of vectors ---


def splatter(width: int) -> Any:
    """splat(value): a number in every lane of a vector of `width`."""

    @intrinsic
    def splat(typing: Any, value: Any) -> Any:
        element = value if isinstance(value, types.Float) else types.float64

        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return _spread(builder, args[0], width)

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
    one = _vectors(a, b) or vector_of(types.float64, mask.width)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(args[0], *(_as_vector(builder, v, one.width) for v in args[1:]))

    return one(mask, *(v if v == one else one.element for v in (a, b))), code


@intrinsic
def count(typing: Any, mask: Any) -> Any:
    """Number of lanes in a mask."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        word = builder.bitcast(args[0], ir.IntType(mask.width))
        return builder.zext(builder.ctpop(word), _WORD)

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
                _shuffled(builder, value, value, range(start, start + width))
                for start in (0, width)
            )
            value = builder.fadd(low, high)
        return builder.extract_element(value, _INDEX(0))

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
            rows = [builder.fadd(*_halves(builder, pair, step)) for pair in pairs]
            step //= 2
        return rows[0]

    return kind(vectors), code


@intrinsic
def multiply_add(typing: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c, rounded once where the processor can; numbers stand in every lane."""
    one = _vectors(a, b, c)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _elementwise(
            builder, "fmuladd", *(_as_vector(builder, value, one.width) for value in args)
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


root = _unary(lambda builder, value: _elementwise(builder, "sqrt", value))
absolute = _unary(lambda builder, value: _elementwise(builder, "fabs", value))
whole = _unary(lambda builder, value: _elementwise(builder, "floor", value))


def _words(value: Any, number: int) -> Any:
    return _constant(ir.VectorType(_WORD, value.type.count), number)


def _exponent(builder: Any, value: Any) -> Any:
    word = builder.bitcast(value, ir.VectorType(_WORD, value.type.count))
    word = builder.lshr(word, _words(value, 52))
    return builder.sitofp(builder.sub(word, _words(value, 1023)), value.type)


def _mantissa(builder: Any, value: Any) -> Any:
    word = builder.bitcast(value, ir.VectorType(_WORD, value.type.count))
    word = builder.and_(word, _words(value, (1 << 52) - 1))
    return builder.bitcast(builder.or_(word, _words(value, 1023 << 52)), value.type)


def _power_of_two(builder: Any, value: Any) -> Any:
    word = builder.fptosi(value, ir.VectorType(_WORD, value.type.count))
    word = builder.shl(builder.add(word, _words(value, 1023)), _words(value, 52))
    return builder.bitcast(word, value.type)


exponent = _unary(_exponent)
"""Whole part of the logarithm to base 2 of positive normal numbers (double precision)."""

mantissa = _unary(_mantissa)
"""Number over 2 to the power of its exponent, in [1, 2) (double precision)."""

power_of_two = _unary(_power_of_two)
"""2 to the power of whole numbers from -1022 to 1023 (double precision)."""
