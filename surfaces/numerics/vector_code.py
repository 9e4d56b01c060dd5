"""The type of vectors in compiled loops, its operators, and the machine code of both.

What loops are written with is in `vectors`. A `builder` is that of llvmlite, a vector one of its
values of `ir.VectorType`.
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
    "BYTES",
    "INDEX",
    "WORD",
    "Vector",
    "as_vector",
    "call",
    "constant",
    "data_of",
    "elementwise",
    "fitted",
    "gathered",
    "halves",
    "on_stack",
    "place_of",
    "read",
    "shuffled",
    "spread",
    "vector_among",
    "vector_of",
    "write",
]


INDEX, WORD = ir.IntType(32), ir.IntType(64)
CODE = {
    types.float32: ir.FloatType(),
    types.float64: ir.DoubleType(),
    types.boolean: ir.IntType(1),
}
BYTES = {"float": 4, "double": 8, "i32": 4, "i64": 8}


class Vector(types.Type):
    """Numba type of `width` numbers, or truths, of the numba type `element`; see `vector_of`."""

    def __init__(self, element: Any, width: int) -> None:
        self.element, self.width = element, width
        super().__init__(name=f"Vector({element}, {width})")

    @property
    def code(self) -> Any:
        """Type of the vector in machine code."""
        return ir.VectorType(CODE[self.element], self.width)


@functools.cache
def vector_of(element: Any, width: int) -> Vector:
    """The type of vectors of so many elements; made once, the compiler asks for it often."""
    return Vector(element, width)


@register_model(Vector)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, kind.code)


def constant(kind: Any, value: float) -> Any:
    return ir.Constant(kind, [value] * kind.count)


def spread(builder: Any, scalar: Any, width: int) -> Any:
    """A scalar in every lane."""
    kind = ir.VectorType(scalar.type, width)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), scalar, INDEX(0))
    return shuffled(builder, first, first, [0] * width)


def shuffled(builder: Any, a: Any, b: Any, order: Any) -> Any:
    """Lanes of two vectors, those of the second counted on from the first, in a new order."""
    mask = ir.Constant(ir.VectorType(INDEX, len(order)), list(order))
    return builder.shuffle_vector(a, b, mask)


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


def elementwise(builder: Any, name: str, *values: Any) -> Any:
    """LLVM intrinsic of equal vectors."""
    kind = values[0].type
    full = f"{name}.v{kind.count}f{8 * BYTES[str(kind.element)]}"
    return call(builder, full, ir.FunctionType(kind, [kind] * len(values)), *values)


def call(builder: Any, name: str, kind: Any, *values: Any) -> Any:
    return builder.call(
        cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}"), values
    )


def halves(builder: Any, pair: Any, step: int) -> Any:
    """Of two vectors, the lanes whose number has the bit `step` clear, and those that have it set.

    Those of the first vector come to lanes with the bit clear, those of the second to the others.
    """
    lanes = range(pair[0].type.count)
    low = [lane if not lane & step else len(lanes) + lane - step for lane in lanes]
    high = [lane + step if not lane & step else len(lanes) + lane for lane in lanes]
    return shuffled(builder, *pair, low), shuffled(builder, *pair, high)


def place_of(builder: Any, index: Any, width: int, grouped: bool) -> Any:
    """Element at which a vector starts: the index, or the start of that group of `width`."""
    return builder.mul(index, ir.Constant(index.type, width)) if grouped else index


def vector_among(*kinds: Any) -> Any:
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


def as_vector(builder: Any, value: Any, width: int) -> Any:
    return value if isinstance(value.type, ir.VectorType) else spread(builder, value, width)


def _binary(function: Any, truth: bool, emit: Any) -> None:
    """Typing and code of an operator between vectors, or a vector and a number."""

    class Typing(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            one = vector_among(*args) if len(args) == 2 and not kws else None
            if one is None or one.element is types.boolean:
                return None
            result = vector_of(types.boolean, one.width) if truth else one
            return signature(result, *(a if a == one else one.element for a in args))

    infer_global(function)(Typing)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        width = vector_among(*sig.args).width
        return emit(builder, *(as_vector(builder, value, width) for value in args))

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
_unary_operator(operator.neg, False, 1, lambda builder, a: builder.fsub(constant(a.type, 0.0), a))


ALIGNMENT = 64
"""Bytes of a cache line."""


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
