"""The 4 by 4 mesh nodes about a point, as explicit vector instructions.

Four nodes of a mesh line lie side by side. `lines` are the places of the first node of each of the
four lines in a flat mesh, `at` the shares (y, x) of a step by which the point lies behind the
second nodes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from surfaces.numerics import vectors as vectors

__all__ = ["add_moved", "add_spread", "add_stored", "read", "read_stored", "set_stored"]

NODES = 4
_SINGLE, _DOUBLE = (ir.VectorType(kind, NODES) for kind in (ir.FloatType(), ir.DoubleType()))
_CUBIC = (
    (-1.0, 3.0, -3.0, 1.0),
    (3.0, -6.0, 3.0, 0.0),
    (-3.0, 0.0, 3.0, 0.0),
    (1.0, 4.0, 1.0, 0.0),
)
"""Six times the cubic B-spline at the four nodes, by falling powers of the share of a step."""

_real, _word = types.float64, types.uint64
_lines, _pair = types.UniTuple(_word, NODES), types.UniTuple(_real, 2)


def _weights(builder: Any, at: Any, axis: int) -> list[Any]:
    """B-spline weights of the four nodes along an axis, their first and second slopes."""
    t = vectors.everywhere(builder, builder.extract_value(at, axis), NODES)
    found = []
    for order in range(3):
        total = None
        for power, numbers in zip((3, 2, 1, 0), _CUBIC, strict=True):
            if power < order:
                break
            factor = (1, power, power * (power - 1))[order] / 6
            part = ir.Constant(_DOUBLE, [factor * number for number in numbers])
            total = part if total is None else vectors.multiply_add(builder, total, t, part)
        found.append(total)
    return found


def _each(builder: Any, vector: Any) -> list[Any]:
    """For every lane, a vector of its number."""
    return [vectors.shuffled(builder, vector, vector, [lane] * NODES) for lane in range(NODES)]


def _kind(mesh: Any) -> Any:
    """Vector of four nodes of a mesh of this numba type."""
    return _SINGLE if mesh.dtype == types.float32 else _DOUBLE


def _add(builder: Any, data: Any, lines: Any, changes: Iterable[Any]) -> None:
    """Add a vector to each line."""
    for a, change in enumerate(changes):
        place = builder.extract_value(lines, a)
        held = vectors.load(builder, data, place, change.type)
        vectors.store(builder, builder.fadd(held, change), data, place)


def _stored(builder: Any, data: Any, place: Any) -> Iterator[Any]:
    """Lines of the 16 weights from element `place` on."""
    for _ in range(NODES):
        yield vectors.load(builder, data, place, _SINGLE)
        place = builder.add(place, ir.Constant(place.type, NODES))


def _spread(builder: Any, at: Any, half: Any) -> list[Any]:
    """Lines of the weights of a unit force with `half` its variance by y and x [steps^2]."""
    along, _, bent = _weights(builder, at, 0)
    across, _, curved = _weights(builder, at, 1)
    high, wide = (
        vectors.everywhere(builder, builder.extract_value(half, axis), NODES) for axis in (0, 1)
    )
    value = vectors.multiply_add(builder, high, bent, along)
    other = builder.fmul(wide, along)
    return [
        vectors.multiply_add(builder, p, across, builder.fmul(q, curved))
        for p, q in zip(_each(builder, value), _each(builder, other), strict=True)
    ]


@intrinsic
def add_spread(typing: Any, mesh: Any, lines: Any, at: Any, half: Any, force: Any) -> Any:
    """Add a force that is spread with `half` its variance by y and x [steps^2]."""
    signature = types.void(mesh, _lines, _pair, _pair, _real)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        mesh, lines, at, half, force = arguments
        data = vectors.data_of(context, builder, signature.args[0], mesh)
        force = vectors.everywhere(builder, force, NODES)
        _add(builder, data, lines, (builder.fmul(force, w) for w in _spread(builder, at, half)))
        return context.get_dummy_value()

    return signature, codegen


@intrinsic
def add_moved(typing: Any, mesh: Any, lines: Any, at: Any, moment: Any) -> Any:
    """Add a force times its shift (y, x) [steps]."""
    signature = types.void(mesh, _lines, _pair, _pair)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        mesh, lines, at, moment = arguments
        data = vectors.data_of(context, builder, signature.args[0], mesh)
        along, steep, _ = _weights(builder, at, 0)
        across, slope, _ = _weights(builder, at, 1)
        by, bx = (
            vectors.everywhere(builder, builder.extract_value(moment, axis), NODES)
            for axis in (0, 1)
        )
        parts = (_each(builder, builder.fmul(*pair)) for pair in ((by, steep), (bx, along)))
        changes = (
            vectors.multiply_add(builder, p, across, builder.fmul(q, slope))
            for p, q in zip(*parts, strict=True)
        )
        if _kind(signature.args[0]) is _SINGLE:
            changes = (builder.fptrunc(change, _SINGLE) for change in changes)
        _add(builder, data, lines, changes)
        return context.get_dummy_value()

    return signature, codegen


@intrinsic
def read(typing: Any, mesh: Any, lines: Any, at: Any) -> Any:
    """Value of the spline at the point, its slopes by y and x, and its second slopes [1/steps]."""
    signature = types.UniTuple(_real, 5)(mesh, _lines, _pair)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        mesh, lines, at = arguments
        data = vectors.data_of(context, builder, signature.args[0], mesh)
        along = [_each(builder, part) for part in _weights(builder, at, 0)]
        across = _weights(builder, at, 1)
        sums: list[Any] = [None] * 3
        kind = _kind(signature.args[0])
        for a in range(NODES):
            line = vectors.load(builder, data, builder.extract_value(lines, a), kind)
            line = line if kind is _DOUBLE else builder.fpext(line, _DOUBLE)
            for order, part in enumerate(along):
                sums[order] = (
                    builder.fmul(part[a], line)
                    if a == 0
                    else vectors.multiply_add(builder, part[a], line, sums[order])
                )
        terms = ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2))
        found = [vectors.sum_lanes(builder, builder.fmul(sums[y], across[x])) for y, x in terms]
        return context.make_tuple(builder, signature.return_type, found)

    return signature, codegen


@intrinsic
def set_stored(typing: Any, weight: Any, place: Any, at: Any, half: Any) -> Any:
    """Write the 16 weights of a force that is spread with `half` its variance by y and x [steps^2]
    from element `place` of `weight` on, flat."""
    signature = types.void(weight, _word, _pair, _pair)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        weight, place, at, half = arguments
        data = vectors.data_of(context, builder, signature.args[0], weight)
        for line in _spread(builder, at, half):
            vectors.store(builder, builder.fptrunc(line, _SINGLE), data, place)
            place = builder.add(place, ir.Constant(place.type, NODES))
        return context.get_dummy_value()

    return signature, codegen


@intrinsic
def add_stored(typing: Any, mesh: Any, lines: Any, weight: Any, place: Any, force: Any) -> Any:
    """Add a force by the 16 weights from element `place` on."""
    signature = types.void(mesh, _lines, weight, _word, types.float32)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        mesh, lines, weight, place, force = arguments
        data = vectors.data_of(context, builder, signature.args[0], mesh)
        stored = vectors.data_of(context, builder, signature.args[2], weight)
        force = vectors.everywhere(builder, force, NODES)
        changes = (builder.fmul(force, part) for part in _stored(builder, stored, place))
        _add(builder, data, lines, changes)
        return context.get_dummy_value()

    return signature, codegen


@intrinsic
def read_stored(typing: Any, mesh: Any, lines: Any, weight: Any, place: Any) -> Any:
    """Sum of the nodes by the 16 weights from element `place` on."""
    signature = types.float32(mesh, _lines, weight, _word)

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        mesh, lines, weight, place = arguments
        data = vectors.data_of(context, builder, signature.args[0], mesh)
        stored = vectors.data_of(context, builder, signature.args[2], weight)
        total = vectors.constant(_SINGLE, 0.0)
        for a, part in enumerate(_stored(builder, stored, place)):
            line = vectors.load(builder, data, builder.extract_value(lines, a), _SINGLE)
            total = vectors.multiply_add(builder, part, line, total)
        return vectors.sum_lanes(builder, total)

    return signature, codegen
