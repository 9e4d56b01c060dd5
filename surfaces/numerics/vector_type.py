"""The type of vectors in compiled loops, its operators and functions, and their machine code.

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


def unary(emit: Any) -> Any:
    """An elementwise function whose code is `emit(builder, value)`."""

    @intrinsic
    def function(typing: Any, vector: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return emit(builder, args[0])

        return vector(vector), code

    return function


root = unary(lambda builder, value: elementwise(builder, "sqrt", value))
absolute = unary(lambda builder, value: elementwise(builder, "fabs", value))
whole = unary(lambda builder, value: elementwise(builder, "floor", value))
