"""Eight numbers at once in compiled kernels: one lane per profile, or per node of a contour.

A kernel that handles eight profiles reads like that of one: `Lanes` values know the arithmetic
operators with each other and with numbers, comparisons give a `Mask`, and `where` takes the place
of a branch. Arrays hold them as eight contiguous numbers; an index counts such groups. The
instructions are those of the processor at hand, whatever its width.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

from . import vectors as vectors

LANES = 8
"""Numbers in a vector."""

_WORD = ir.IntType(64)
_VECTOR, _BITS = ir.VectorType(ir.DoubleType(), LANES), ir.VectorType(_WORD, LANES)
_TRUTH = ir.VectorType(ir.IntType(1), LANES)


class _Vector(types.Type):
    """Numba type of eight numbers or of eight truths."""


LANE = _Vector("Lanes")
MASK = _Vector("Mask")


@register_model(_Vector)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR if kind is LANE else _TRUTH)


def _spread(context: Any, builder: Any, value: Any, kind: Any) -> Any:
    """The vector itself, or a number in every lane."""
    if kind is LANE:
        return value
    return vectors.everywhere(builder, context.cast(builder, value, kind, types.float64), LANES)


def _binary(function: Any, result: Any, emit: Any) -> None:
    """Typing and code of an operator between vectors, or a vector and a number."""

    class Typing(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            if len(args) == 2 and LANE in args and not kws:
                if all(a is LANE or isinstance(a, types.Float | types.Integer) for a in args):
                    return signature(result, *(a if a is LANE else types.float64 for a in args))
            return None

    infer_global(function)(Typing)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        a, b = (_spread(context, builder, v, t) for v, t in zip(args, sig.args, strict=True))
        return emit(builder, a, b)

    for kinds in ((LANE, LANE), (LANE, types.float64), (types.float64, LANE)):
        lower_builtin(function, *kinds)(lower)


for _functions, _name in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv, operator.itruediv), "fdiv"),
):
    for _function in _functions:
        _binary(_function, LANE, lambda builder, a, b, n=_name: getattr(builder, n)(a, b))
for _function, _sign in (
    (operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">="),
):  # fmt: skip
    _binary(_function, MASK, lambda builder, a, b, s=_sign: builder.fcmp_ordered(s, a, b))


def _logical(function: Any, emit: Any) -> None:
    class Typing(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            if not kws and all(a is MASK for a in args):
                return signature(MASK, *args)
            return None

    infer_global(function)(Typing)
    count = 1 if function is operator.invert else 2
    lower_builtin(function, *(MASK,) * count)(
        lambda context, builder, sig, args: emit(builder, *args)
    )


_logical(operator.and_, lambda builder, a, b: builder.and_(a, b))
_logical(operator.or_, lambda builder, a, b: builder.or_(a, b))
_logical(operator.invert, lambda builder, a: builder.not_(a))


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        return signature(LANE, LANE) if args == (LANE,) and not kws else None


@lower_builtin(operator.neg, LANE)
def _negative(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fsub(vectors.constant(_VECTOR, 0.0), args[0])


def _first(builder: Any, group: Any) -> Any:
    """Place of the first number of a group."""
    return builder.mul(group, ir.Constant(group.type, LANES))


@intrinsic
def load(typing: Any, array: Any, index: Any) -> Any:
    """Group `index` of a contiguous array of floats."""
    sig = LANE(array, types.intp)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = vectors.data_of(context, builder, sig.args[0], args[0])
        return vectors.load(builder, data, _first(builder, args[1]), _VECTOR)

    return sig, code


@intrinsic
def store(typing: Any, array: Any, index: Any, value: Any) -> Any:
    """Write group `index` of a contiguous array of floats."""
    sig = types.void(array, types.intp, LANE)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = vectors.data_of(context, builder, sig.args[0], args[0])
        vectors.store(builder, args[2], data, _first(builder, args[1]))
        return context.get_dummy_value()

    return sig, code


@intrinsic
def splat(typing: Any, value: Any) -> Any:
    """A number in every lane."""
    sig = LANE(types.float64)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _spread(context, builder, args[0], types.float64)

    return sig, code


@intrinsic
def where(typing: Any, mask: Any, a: Any, b: Any) -> Any:
    """Lanes of `a` where the mask holds, else of `b`."""
    sig = LANE(MASK, *(v if v is LANE else types.float64 for v in (a, b)))

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        a, b = (
            _spread(context, builder, v, t) for v, t in zip(args[1:], sig.args[1:], strict=True)
        )
        return builder.select(args[0], a, b)

    return sig, code


@intrinsic
def some(typing: Any, mask: Any) -> Any:
    """Whether a mask holds in any lane."""
    sig = types.boolean(MASK)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        byte = builder.bitcast(args[0], ir.IntType(LANES))
        return builder.icmp_unsigned("!=", byte, ir.Constant(ir.IntType(LANES), 0))

    return sig, code


@intrinsic
def total(typing: Any, value: Any) -> Any:
    """Sum of the lanes."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return vectors.sum_lanes(builder, args[0])

    return types.float64(LANE), code


def _unary(emit: Any) -> Any:
    """An elementwise function whose code is `emit(builder, value)`."""

    @intrinsic
    def function(typing: Any, value: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return emit(builder, args[0])

        return LANE(LANE), code

    return function


def _called(name: str) -> Any:
    """An elementwise function that is an LLVM intrinsic."""

    return _unary(lambda builder, value: vectors.instruction(builder, name, value))


def _words(value: int) -> Any:
    return vectors.constant(_BITS, value)


def _exponent_code(builder: Any, value: Any) -> Any:
    bits = builder.lshr(builder.bitcast(value, _BITS), _words(52))
    return builder.sitofp(builder.sub(bits, _words(1023)), _VECTOR)


def _mantissa_code(builder: Any, value: Any) -> Any:
    bits = builder.and_(builder.bitcast(value, _BITS), _words((1 << 52) - 1))
    return builder.bitcast(builder.or_(bits, _words(1023 << 52)), _VECTOR)


def _power_code(builder: Any, value: Any) -> Any:
    bits = builder.add(builder.fptosi(value, _BITS), _words(1023))
    return builder.bitcast(builder.shl(bits, _words(52)), _VECTOR)


root = _called("sqrt")
absolute = _called("fabs")
whole = _called("floor")

exponent = _unary(_exponent_code)
"""Whole part of the logarithm to base 2 of positive normal numbers."""

mantissa = _unary(_mantissa_code)
"""Number over 2 to the power of its exponent, in [1, 2)."""

power_of_two = _unary(_power_code)
"""2 to the power of whole numbers from -1022 to 1023."""


def _gathered(per_lane: bool) -> Any:
    """Function that reads an array at eight places."""

    @intrinsic
    def function(typing: Any, array: Any, places: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = vectors.data_of(context, builder, sig.args[0], args[0])
            places = builder.fptosi(args[1], _BITS)
            if per_lane:
                own = ir.Constant(_BITS, list(range(LANES)))
                places = builder.add(builder.mul(places, _words(LANES)), own)
            return vectors.gathered(builder, data, places, _VECTOR)

        return LANE(array, LANE), code

    return function


pick = _gathered(True)
"""pick(array, groups): lane l of group groups[l]."""

entries = _gathered(False)
"""entries(array, places): number places[l] of the array in lane l."""


@intrinsic
def transpose(typing: Any, array: Any, index: Any, step: Any, out: Any, place: Any) -> Any:
    """Turn the groups index + k * step of an array into the columns of the groups place + k."""
    sig = types.void(array, types.intp, types.intp, out, types.intp)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        source = vectors.data_of(context, builder, sig.args[0], args[0])
        target = vectors.data_of(context, builder, sig.args[3], args[3])
        rows, group = [], args[1]
        for _ in range(LANES):
            rows.append(vectors.load(builder, source, _first(builder, group), _VECTOR))
            group = builder.add(group, args[2])
        group = args[4]
        for row in vectors.transposed(builder, rows):
            vectors.store(builder, row, target, _first(builder, group))
            group = builder.add(group, ir.Constant(_WORD, 1))
        return context.get_dummy_value()

    return sig, code


@intrinsic
def add(typing: Any, array: Any, index: Any, value: Any) -> Any:
    """Add to group `index` of a contiguous array of floats."""
    sig = types.void(array, types.intp, LANE)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = vectors.data_of(context, builder, sig.args[0], args[0])
        place = _first(builder, args[1])
        held = vectors.load(builder, data, place, _VECTOR)
        vectors.store(builder, builder.fadd(held, args[2]), data, place)
        return context.get_dummy_value()

    return sig, code
