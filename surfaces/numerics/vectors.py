"""What hand-written vector code is made of: one place for all of it.

The automatic vectorizer misses loops of few terms, table look-ups and shuffles. Those are written
as explicit vector instructions, by functions that emit them into code under construction. A
`builder` is that of llvmlite, a vector one of its values of `ir.VectorType`: any number of lanes,
any element. Lanes are stored one after another from a place on, at the alignment of the element.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from llvmlite import ir

__all__ = [
    "constant",
    "data_of",
    "everywhere",
    "gathered",
    "instruction",
    "load",
    "multiply_add",
    "prefetch",
    "shuffled",
    "store",
    "sum_lanes",
    "sums_of_each",
    "transposed",
]

_INDEX, _WORD = ir.IntType(32), ir.IntType(64)
_BYTES = {"float": 4, "double": 8, "i32": 4, "i64": 8}


def constant(kind: Any, value: float) -> Any:
    """One number in every lane of a vector type."""
    return ir.Constant(kind, [value] * kind.count)


def everywhere(builder: Any, scalar: Any, lanes: int) -> Any:
    """A scalar in every lane."""
    kind = ir.VectorType(scalar.type, lanes)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), scalar, _index(0))
    return shuffled(builder, first, first, [0] * lanes)


def shuffled(builder: Any, a: Any, b: Any, order: Sequence[int]) -> Any:
    """Lanes of two vectors, those of the second counted on from the first, in a new order."""
    mask = ir.Constant(ir.VectorType(_INDEX, len(order)), list(order))
    return builder.shuffle_vector(a, b, mask)


def data_of(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    """Pointer to the first element of an array of the numba type `kind`."""
    return context.make_array(kind)(context, builder, array).data


def load(builder: Any, data: Any, place: Any, kind: Any) -> Any:
    """Vector of the type `kind` from element `place` of the data on."""
    pointer = builder.bitcast(builder.gep(data, [place]), kind.as_pointer())
    return builder.load(pointer, align=_bytes(kind), typ=kind)


def store(builder: Any, vector: Any, data: Any, place: Any) -> None:
    """Write a vector from element `place` of the data on."""
    pointer = builder.bitcast(builder.gep(data, [place]), vector.type.as_pointer())
    builder.store(vector, pointer, align=_bytes(vector.type))


def gathered(builder: Any, data: Any, places: Any, kind: Any) -> Any:
    """Vector of the type `kind` of the elements of the data at a vector of 64-bit places."""
    lanes = kind.count
    start = everywhere(builder, builder.ptrtoint(data, _WORD), lanes)
    step = constant(places.type, _bytes(kind))
    pointers = ir.VectorType(kind.element.as_pointer(), lanes)
    at = builder.inttoptr(builder.add(start, builder.mul(places, step)), pointers)
    truth = ir.VectorType(ir.IntType(1), lanes)
    takes = ir.FunctionType(kind, [pointers, _INDEX, truth, kind])
    name = f"masked.gather.v{lanes}f{8 * _bytes(kind)}.v{lanes}p0"
    rest = ir.Constant(kind, ir.Undefined)
    return _called(builder, name, takes, at, _index(_bytes(kind)), constant(truth, 1), rest)


def instruction(builder: Any, name: str, *values: Any) -> Any:
    """Elementwise intrinsic ``llvm.<name>`` (sqrt, fabs, floor, ...) of equal vectors."""
    kind = values[0].type
    full = f"{name}.v{kind.count}f{8 * _bytes(kind)}"
    return _called(builder, full, ir.FunctionType(kind, [kind] * len(values)), *values)


def multiply_add(builder: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c, rounded once where the processor can."""
    return instruction(builder, "fmuladd", a, b, c)


def prefetch(builder: Any, data: Any, place: Any) -> None:
    """Ask for the cache line of an element that will be read soon; it need not exist."""
    number = ir.IntType(32)
    pointer = builder.bitcast(builder.gep(data, [place]), ir.IntType(8).as_pointer())
    takes = ir.FunctionType(ir.VoidType(), [pointer.type, number, number, number])
    read, near, values = (ir.Constant(number, n) for n in (0, 3, 1))
    _called(builder, "prefetch.p0", takes, pointer, read, near, values)


def sum_lanes(builder: Any, vector: Any) -> Any:
    """Sum of the lanes of a vector, pairwise; their number is a power of two."""
    lanes = vector.type.count
    while lanes > 1:
        lanes //= 2
        low, high = (
            shuffled(builder, vector, vector, range(start, start + lanes)) for start in (0, lanes)
        )
        vector = builder.fadd(low, high)
    return builder.extract_element(vector, _index(0))


def sums_of_each(builder: Any, vectors: Sequence[Any]) -> Any:
    """Vector of the sums over the lanes of as many vectors as there are lanes, pairwise."""
    step = vectors[0].type.count // 2
    while step:
        half = len(vectors) // 2
        pairs = zip(vectors[:half], vectors[half:], strict=True)
        vectors = [builder.fadd(*_halves(builder, pair, step)) for pair in pairs]
        step //= 2
    return vectors[0]


def transposed(builder: Any, rows: Sequence[Any]) -> list[Any]:
    """Columns of as many vectors as there are lanes."""
    rows = list(rows)
    step = len(rows) // 2
    while step:
        for i in (i for i in range(len(rows)) if not i & step):
            rows[i], rows[i + step] = _halves(builder, (rows[i], rows[i + step]), step)
        step //= 2
    return rows


def _halves(builder: Any, pair: tuple[Any, Any], step: int) -> tuple[Any, Any]:
    """Of two vectors, the lanes whose number has the bit `step` clear, and those that have it set.

    Those of the first vector come to lanes with the bit clear, those of the second to the others.
    """
    lanes = range(pair[0].type.count)
    low = [lane if not lane & step else len(lanes) + lane - step for lane in lanes]
    high = [lane + step if not lane & step else len(lanes) + lane for lane in lanes]
    return shuffled(builder, *pair, low), shuffled(builder, *pair, high)


def _called(builder: Any, name: str, kind: Any, *values: Any) -> Any:
    function = builder.module.globals.get(f"llvm.{name}")
    return builder.call(function or ir.Function(builder.module, kind, f"llvm.{name}"), values)


def _index(lane: int) -> Any:
    return ir.Constant(_INDEX, lane)


def _bytes(kind: Any) -> int:
    """Bytes of an element of a vector type."""
    return _BYTES[str(kind.element)]
