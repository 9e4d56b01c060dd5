"""Eight numbers at once: every operation beside numpy."""

from __future__ import annotations

import numpy as np
from numba import njit

from surfaces.numerics import lanes, vectors
from surfaces.numerics.lanes import LANES, load, store
from surfaces.numerics.vectors import where

RNG = np.random.default_rng(3)


@njit
def _arithmetic(a, b, out):
    x, y = load(a, 0), load(b, 0)
    store(out, 0, 2 * x + y / x - (1.0 - y) * x)
    x += y
    x -= 0.5
    x *= y
    x /= 3.0
    store(out, 1, -x)
    mask = (x > y) & ~(y < 0.5) | (x <= -1.0)
    store(out, 2, where(mask, x, 7))
    store(out, 3, lanes.least(x, y))
    store(out, 4, lanes.most(x, y))
    store(out, 5, lanes.between(x, load(out, 7), y))
    return vectors.some(x >= 1e3), vectors.some(x < 1e3)


def test_arithmetic_and_choice():
    a, b = RNG.normal(size=(2, LANES))
    out = np.zeros((8, LANES))
    assert _arithmetic(a, b, out) == (False, True)
    x = (a + b - 0.5) * b / 3
    np.testing.assert_allclose(out[0], 2 * a + b / a - (1 - b) * a)
    np.testing.assert_allclose(out[1], -x)
    np.testing.assert_allclose(out[2], np.where((x > b) & (b >= 0.5) | (x <= -1), x, 7.0))
    np.testing.assert_allclose(out[3:5], [np.minimum(x, b), np.maximum(x, b)])
    np.testing.assert_allclose(out[5], np.minimum(np.maximum(x, 0.0), b))


@njit
def _functions(a, out):
    x = load(a, 0)
    store(out, 0, lanes.exponential(x))
    store(out, 1, lanes.logarithm(vectors.absolute(x)))
    s, c = lanes.sine_cosine(x * 0.1)
    store(out, 2, s)
    store(out, 3, c)
    store(out, 4, vectors.root(vectors.absolute(x)))
    store(out, 5, vectors.whole(x))
    return vectors.total(x)


def test_functions():
    x = RNG.uniform(-12.0, 12.0, LANES)  # sine and cosine, those of x / 10, lose digits further out
    out = np.empty((6, LANES))
    np.testing.assert_allclose(_functions(x, out), x.sum(), rtol=1e-13, atol=1e-13)
    expected = np.exp(x), np.log(np.abs(x)), np.sin(x / 10), np.cos(x / 10), np.abs(x) ** 0.5
    np.testing.assert_allclose(out[:5], expected, rtol=2e-14, atol=1e-15)
    np.testing.assert_array_equal(out[5], np.floor(x))


@njit
def _bounded(a, out):
    x = load(a, 0)
    store(out, 0, lanes.between(x, lanes.splat(1.0), lanes.splat(2.0)))


def test_what_is_no_number_stays_inside_the_bounds():
    out = np.empty(LANES)
    _bounded(np.full(LANES, np.nan), out)
    np.testing.assert_array_equal(out, 1.0)


@njit
def _moved(a, places, out):
    store(out, 0, lanes.pick(a, load(places, 0)))
    store(out, 1, vectors.entries(a, load(places, 0)))
    lanes.transpose(a, 0, 1, out, 2, 1)


def test_places_and_columns():
    a, places = RNG.normal(size=(LANES, LANES)), np.array([3, 0, 7, 1, 1, 5, 2, 6.0])
    out = np.empty((2 + LANES, LANES))
    _moved(a.ravel(), places, out.ravel())
    rows = places.astype(int)
    np.testing.assert_array_equal(out[0], a[rows, np.arange(LANES)])
    np.testing.assert_array_equal(out[1], a.ravel()[rows])
    np.testing.assert_array_equal(out[2:], a.T)


def test_working_space_starts_a_cache_line():
    for count in (1, 3, 40):
        space = lanes.groups(count)
        assert space.size == count * LANES and space.ctypes.data % 64 == 0


def test_rows_of_whole_groups():
    values = RNG.normal(size=(3, 2, 5))
    rows = lanes.packed(values)
    np.testing.assert_array_equal(rows[:, :10], values.reshape(3, 10))
    assert rows.shape == (3, 16) and not rows[:, 10:].any()
    assert lanes.packed(values[:0]).shape == (0, 16)
