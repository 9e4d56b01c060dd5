"""Vectors in compiled loops: each function beside numpy, for two widths and precisions."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from surfaces.numerics import vectors

RNG = np.random.default_rng(5)
KINDS = [(np.float64, 8), (np.float32, 16)]
both = pytest.mark.parametrize(("dtype", "width"), KINDS, ids=["8 doubles", "16 floats"])
store, lane = vectors.store, vectors.lane


@both
def test_vectors_are_read_and_written_from_any_element_on(dtype, width):
    load = vectors.loader(width)

    @njit
    def copy(a, out):
        store(out, 5, load(a, 3))
        return lane(load(a, 3), 2)

    a, out = RNG.normal(size=40).astype(dtype), np.zeros(40, dtype)
    assert copy(a, out) == a[5]
    np.testing.assert_array_equal(out[5 : 5 + width], a[3 : 3 + width])
    assert not out[:5].any() and not out[5 + width :].any()


@both
def test_groups_are_counted(dtype, width):
    load, put, add = vectors.loader(width, True), vectors.storer(True), vectors.add

    @njit
    def moved(a, out):
        put(out, 0, load(a, 1))
        add(out, 0, load(a, 0))

    a, out = RNG.normal(size=2 * width).astype(dtype), np.zeros(width, dtype)
    moved(a, out)
    np.testing.assert_array_equal(out, a[:width] + a[width:])


def test_precision_is_that_of_the_array():
    load = vectors.loader(4)

    @njit
    def converted(values, single, whole, double):
        store(single, 0, load(values, 0))
        store(whole, 0, load(values, 0))
        store(double, 0, load(single, 0))

    values = RNG.normal(size=4) * 9
    single, whole, double = np.zeros(4, np.float32), np.zeros(4, np.int64), np.zeros(4)
    converted(values, single, whole, double)
    np.testing.assert_array_equal(single, values.astype(np.float32))
    np.testing.assert_array_equal(whole, np.trunc(values))
    np.testing.assert_array_equal(double, single)


@both
def test_one_number_in_every_lane(dtype, width):
    repeat, splat = vectors.repeater(width), vectors.splatter(width)

    @njit
    def spread(a, out):
        store(out, 0, repeat(a, 2))
        store(out, width, splat(a[1]) + 0.5)

    a, out = RNG.normal(size=4).astype(dtype), np.zeros(2 * width, dtype)
    spread(a, out)
    assert (out[:width] == a[2]).all() and (out[width:] == a[1] + dtype(0.5)).all()


@both
def test_arithmetic_and_choice(dtype, width):
    load = vectors.loader(width)

    @njit
    def compute(a, b, out):
        x, y = load(a, 0), load(b, 0)
        store(out[0], 0, vectors.multiply_add(x, y, x) - 2.0 / y)
        store(out[1], 0, vectors.whole(-x))
        mask = (x > y) & ~(y < 0.5) | (x <= -1.0)
        store(out[2], 0, vectors.where(mask, x, y))
        return vectors.some(mask), vectors.some(x > 1e3)

    a, b = RNG.normal(size=(2, width)).astype(dtype)
    out = np.zeros((3, width), dtype)
    mask = (a > b) & (b >= 0.5) | (a <= -1.0)
    assert compute(a, b, out) == (mask.any(), False)
    error = 8 * np.finfo(dtype).eps
    np.testing.assert_allclose(out[0], a * b + a - 2 / b, rtol=error, atol=error)
    np.testing.assert_array_equal(out[1], np.floor(-a))
    np.testing.assert_array_equal(out[2], np.where(mask, a, b))


@both
def test_elements_at_places(dtype, width):
    load, pick = vectors.loader(width), vectors.pick

    @njit
    def read(a, places, out):
        store(out, 0, vectors.entries(a, load(places, 0)))
        store(out, width, pick(a, load(places, 0)))

    a = RNG.normal(size=10 * width).astype(dtype)
    places, out = RNG.integers(0, 10, width), np.zeros(2 * width, dtype)
    read(a, places.astype(dtype), out)
    np.testing.assert_array_equal(out[:width], a[places])
    np.testing.assert_array_equal(out[width:], a[places * width + np.arange(width)])


def test_two_numbers_at_once():
    a = RNG.normal(size=(5, 2)).astype(np.float32)
    assert njit(lambda a, k: vectors.two_floats(a, np.uint64(k)))(a, 3) == tuple(a[3])


@both
def test_sums_over_the_lanes(dtype, width):
    load = vectors.loader(width)

    @njit
    def summed(a):
        return vectors.total(load(a, width))

    a = RNG.normal(size=3 * width).astype(dtype)
    error = width * np.finfo(dtype).eps
    np.testing.assert_allclose(summed(a), a[width : 2 * width].sum(), atol=error)


def test_sums_of_several_vectors():
    load = vectors.loader(4)

    @njit
    def summed(a, out):
        store(out, 0, vectors.sums((load(a, 0), load(a, 4), load(a, 8), load(a, 12))))

    a, out = RNG.normal(size=(4, 4)), np.zeros(4)
    summed(a.ravel(), out)
    np.testing.assert_allclose(out, a.sum(axis=1), atol=1e-14)


@both
def test_rows_become_columns(dtype, width):
    transpose = vectors.transposer(width)

    @njit
    def turned(a, out):
        transpose(a, 0, width, out, 0, width)

    a, out = RNG.normal(size=(width, width)).astype(dtype), np.zeros(width * width, dtype)
    turned(a.ravel(), out)
    np.testing.assert_array_equal(out.reshape(width, width), a.T)
