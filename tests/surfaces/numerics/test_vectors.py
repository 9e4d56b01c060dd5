"""Vector instructions: each function that emits some, beside numpy, for two kinds of vectors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from surfaces.numerics import vectors as vectors

RNG = np.random.default_rng(5)
KINDS = [
    (np.float64, ir.VectorType(ir.DoubleType(), 8)),
    (np.float32, ir.VectorType(ir.FloatType(), 16)),
]
both = pytest.mark.parametrize(("dtype", "kind"), KINDS, ids=["8 doubles", "16 floats"])


def _run(emit: Any, a: np.ndarray, out: np.ndarray, *places: int) -> np.ndarray:
    """Compile a function whose code is ``emit(builder, data of a, data of out, places)``."""

    @intrinsic
    def function(typing: Any, a: Any, out: Any, first: Any, second: Any) -> Any:
        def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            data = (vectors.data_of(context, builder, sig.args[k], args[k]) for k in (0, 1))
            emit(builder, *data, *args[2:])
            return context.get_dummy_value()

        return types.void(a, out, types.intp, types.intp), code

    @njit
    def call(a, out, first, second):
        function(a, out, first, second)

    call(a, out, *(*places, 0, 0)[:2])
    return out


@both
def test_vectors_are_read_and_written_from_any_element_on(dtype, kind):
    a = RNG.normal(size=40).astype(dtype)

    def emit(builder, data, out, first, second):
        vectors.store(builder, vectors.load(builder, data, first, kind), out, second)

    out = _run(emit, a, np.zeros(40, dtype), 3, 5)
    np.testing.assert_array_equal(out[5 : 5 + kind.count], a[3 : 3 + kind.count])
    assert not out[:5].any() and not out[5 + kind.count :].any()


@both
def test_one_number_in_every_lane(dtype, kind):
    a = RNG.normal(size=4).astype(dtype)

    def emit(builder, data, out, first, second):
        scalar = builder.load(builder.gep(data, [first]))
        spread = vectors.everywhere(builder, scalar, kind.count)
        vectors.store(builder, builder.fadd(spread, vectors.constant(kind, 0.5)), out, second)

    np.testing.assert_array_equal(_run(emit, a, np.zeros(kind.count, dtype), 2), a[2] + dtype(0.5))


@both
def test_elementwise_instructions(dtype, kind):
    n = kind.count
    a = RNG.normal(size=3 * n).astype(dtype)

    def emit(builder, data, out, first, second):
        x, y, z = (
            vectors.load(builder, data, ir.Constant(first.type, k * n), kind) for k in range(3)
        )
        vectors.store(builder, vectors.multiply_add(builder, x, y, z), out, first)
        vectors.store(builder, vectors.instruction(builder, "floor", x), out, second)

    x, y, z = a.reshape(3, n)
    found, floor = _run(emit, a, np.zeros(2 * n, dtype), 0, n).reshape(2, n)
    error = 4 * np.finfo(dtype).eps
    np.testing.assert_allclose(found, x * y + z, rtol=error, atol=error)
    np.testing.assert_array_equal(floor, np.floor(x))


@both
def test_lanes_in_a_new_order(dtype, kind):
    n = kind.count
    a, order = RNG.normal(size=2 * n).astype(dtype), RNG.permutation(2 * n)[:n]

    def emit(builder, data, out, first, second):
        x, y = (vectors.load(builder, data, place, kind) for place in (first, second))
        vectors.store(builder, vectors.shuffled(builder, x, y, order.tolist()), out, first)

    np.testing.assert_array_equal(_run(emit, a, np.zeros(n, dtype), 0, n), a[order])


@both
def test_elements_at_places(dtype, kind):
    n = kind.count
    a = RNG.normal(size=50).astype(dtype)
    places = RNG.integers(0, 50, n)

    def emit(builder, data, out, first, second):
        at = ir.Constant(ir.VectorType(ir.IntType(64), n), places.tolist())
        vectors.store(builder, vectors.gathered(builder, data, at, kind), out, first)

    np.testing.assert_array_equal(_run(emit, a, np.zeros(n, dtype)), a[places])


def _rows(builder: Any, data: Any, first: Any, kind: Any) -> list[Any]:
    n = kind.count
    return [vectors.load(builder, data, ir.Constant(first.type, k * n), kind) for k in range(n)]


@both
def test_sums_over_the_lanes(dtype, kind):
    n = kind.count
    a = RNG.normal(size=(n, n)).astype(dtype)

    def emit(builder, data, out, first, second):
        rows = _rows(builder, data, first, kind)
        vectors.store(builder, vectors.sums_of_each(builder, rows), out, first)
        one = vectors.sum_lanes(builder, rows[3])
        builder.store(one, builder.gep(out, [second]))

    found = _run(emit, a.ravel(), np.zeros(n + 1, dtype), 0, n)
    error = n * np.finfo(dtype).eps
    np.testing.assert_allclose(found[:n], a.sum(axis=1), atol=error)
    np.testing.assert_allclose(found[n], a[3].sum(), atol=error)


@both
def test_rows_become_columns(dtype, kind):
    n = kind.count
    a = RNG.normal(size=(n, n)).astype(dtype)

    def emit(builder, data, out, first, second):
        columns = vectors.transposed(builder, _rows(builder, data, first, kind))
        for k, column in enumerate(columns):
            vectors.store(builder, column, out, ir.Constant(first.type, k * n))

    found = _run(emit, a.ravel(), np.zeros(n * n, dtype))
    np.testing.assert_array_equal(found.reshape(n, n), a.T)
