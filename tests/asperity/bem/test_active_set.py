"""The active set on a list, with a dense matrix as the operator, and its compiled passes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from asperity.bem import _list_kernels
from asperity.bem.active_set import solve_on_list


class DenseOperator:
    """A positive matrix and its diagonal as preconditioner."""

    aim = 1e-3

    def __init__(self, matrix):
        self.matrix = matrix

    def apply(self, pressure):
        return (self.matrix @ pressure).astype(np.float32)

    def precondition(self, residual):
        return (residual / np.diag(self.matrix)).astype(np.float32)


def kernel(rng):
    """A positive matrix that falls with the distance of 60 random places."""
    x = rng.random((60, 2))
    distance = np.hypot(*(x[:, None] - x[None, :]).transpose(2, 0, 1))
    return 1.0 / (distance + 0.05)


@pytest.mark.parametrize("seed", range(4))
def test_small_contact_problem(seed):
    """p >= 0, K p - h >= level, complementary: compared with non-negative least squares."""
    rng = np.random.default_rng(seed)
    matrix = kernel(rng)
    heights = rng.random(60)
    pressure = np.full(60, 0.01)
    gap = matrix @ pressure - heights
    total = 0.3
    solve_on_list(
        DenseOperator(matrix),
        pressure,
        gap,
        scale=heights.std(),
        tolerance=1e-5,
        longest=500,
        total=total,
        cap=np.inf,
    )
    assert pressure.min() >= 0.0
    assert pressure.sum() == pytest.approx(total, rel=1e-12)
    final = matrix @ pressure - heights
    level = final[pressure > 0].mean()
    assert np.abs(final[pressure > 0] - level).max() < 1e-3 * heights.std()
    assert final.min() > level - 1e-4 * heights.std()
    factor = np.linalg.cholesky(matrix).T
    expected, _ = nnls(factor, np.linalg.solve(factor.T, heights + level))
    np.testing.assert_allclose(pressure, expected, atol=2e-3 * expected.max())


def test_passes_match_numpy():
    """One step of the compiled passes equals the same step written out."""
    rng = np.random.default_rng(7)
    n = 500
    p = np.where(rng.random(n) < 0.5, rng.random(n), 0.0)
    start_gap = rng.standard_normal(n)
    change, z, direction, response = rng.standard_normal((4, n)).astype(np.float32)
    active = np.empty(n, np.bool_)
    residual, before = np.zeros((2, n), np.float32)
    moved = rng.standard_normal(n).astype(np.float32)
    level, error, count, energy, shift = _list_kernels.measure(
        p, moved, start_gap, change, active, residual, np.inf, False
    )
    assert energy == pytest.approx((moved * (start_gap + 0.5 * change)).sum(), rel=1e-5)
    assert shift == pytest.approx(moved.sum(dtype=float), rel=1e-5)
    expected = start_gap + change
    assert level == pytest.approx(expected[p > 0].mean())
    mean = (p * expected).sum() / p.sum()
    assert error == pytest.approx(max(mean, level) - expected.min())
    chosen = (p > 0) | (expected < level)
    np.testing.assert_array_equal(active, chosen)
    assert count == chosen.sum()
    np.testing.assert_allclose(residual, np.where(chosen, expected - level, 0), atol=1e-6)

    before[:] = rng.standard_normal(n)
    old = direction.copy()
    norm = _list_kernels.turn(active, count, z, residual, before, direction, 2.0)
    zc = z[chosen] - z[chosen].mean()
    assert norm == pytest.approx((zc * residual[chosen]).sum(), rel=1e-5)
    beta = max(0.0, (zc * (residual - before)[chosen]).sum() / 2.0)
    np.testing.assert_allclose(direction[chosen], zc + beta * old[chosen], rtol=1e-4, atol=1e-5)
    assert not direction[~chosen].any()

    response += 3.0 * direction
    length = (residual * direction)[chosen].sum() / (
        (response[chosen] - response[chosen].mean()) * direction[chosen]
    ).sum()
    new_p = np.where(chosen, p - length * direction, p)
    negative = _list_kernels.advance(
        active, count, p, start_gap, change, residual, before, direction, response, np.inf
    )
    np.testing.assert_allclose(p, new_p, rtol=1e-4, atol=1e-6)
    assert negative == (new_p[chosen] < 0).sum()
    np.testing.assert_allclose(
        start_gap + change, expected - length * response, rtol=1e-4, atol=1e-5
    )
    assert residual[chosen].mean() == pytest.approx(0.0, abs=1e-6)

    base, moved = rng.random(n), np.empty(n, np.float32)
    largest = _list_kernels.cut(p, base, moved, 5.0, np.inf)
    clipped = np.maximum(new_p, 0.0)
    clipped *= 5.0 / clipped.sum()
    np.testing.assert_allclose(p, clipped, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(moved, clipped - base, atol=1e-5)
    assert largest == pytest.approx(np.abs(clipped - base).max(), rel=1e-4)


def test_a_direction_without_curvature_is_refused():
    """Nothing changes and the caller is told."""
    n = 8
    zeros = np.zeros(n, np.float32)
    p, gap, active = np.ones(n), np.ones(n), np.ones(n, np.bool_)
    arrays = [zeros.copy() for _ in range(5)]
    assert _list_kernels.advance(active, n, p, gap, *arrays, np.inf) == -1
    assert (p == 1).all() and (gap == 1).all()


def test_restored_loads_stay_between_the_bounds():
    """Points at the cap stay there; the others are scaled; or those that moved are shifted."""
    cap, moved = 1.0, np.empty(4, np.float32)
    p = np.array([1.0, -0.2, 0.4, 0.4])
    _list_kernels.cut(p, np.zeros(4), moved, 2.0, cap)
    np.testing.assert_allclose(p, [1.0, 0.0, 0.5, 0.5])
    p = np.array([1.0, -0.2, 0.9, 0.4])
    _list_kernels.cut(p, np.zeros(4), moved, 2.6, cap)
    np.testing.assert_allclose(p, [1.0, 0.0, 1.0, 0.6])
    p = np.array([1.0, 40.0, 38.8, -70.0])
    moving = np.array([False, True, True, True])
    p[moving] += _list_kernels.leveling(p, moving, 2.3, cap)
    _list_kernels.cut(p, np.zeros(4), moved, 2.3, cap)
    np.testing.assert_allclose(p, [1.0, 1.0, 0.3, 0.0], atol=1e-12)


def test_a_level_can_be_held_in_place_of_the_load():
    """Under a cap: the gap is zero inside the bounds, positive without pressure, negative at it."""
    rng = np.random.default_rng(2)
    matrix = kernel(rng)
    heights, pressure, cap = rng.random(60), np.full(60, 0.001), 0.012
    gap = matrix @ pressure - heights
    solve_on_list(
        DenseOperator(matrix),
        pressure,
        gap,
        scale=heights.std(),
        tolerance=1e-6,
        longest=500,
        total=None,
        cap=cap,
    )
    final = matrix @ pressure - heights
    held, empty = pressure == cap, pressure == 0.0
    assert held.any() and empty.any() and (~held & ~empty).any()
    assert np.abs(final[~held & ~empty]).max() < 1e-4
    assert final[empty].min() > -1e-4 and final[held].max() < 1e-4
