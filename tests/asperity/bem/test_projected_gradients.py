"""Projected conjugate gradients on a list, a dense matrix as the operator, and compiled passes."""

from __future__ import annotations

import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

from asperity.bem import _list_kernels
from asperity.bem.projected_gradients import solve_on_list


class DenseOperator:
    """A positive matrix and a preconditioner, that of its diagonal if none is given."""

    aim = 1e-3

    def __init__(self, matrix, inverse=None):
        self.matrix = matrix
        self.inverse = np.diag(1.0 / np.diag(matrix)) if inverse is None else inverse

    def apply(self, pressure):
        return (self.matrix @ pressure).astype(np.float32)

    def precondition(self, residual):
        return (self.inverse @ residual).astype(np.float32)


def solve(operator, pressure, heights, *, total, cap=np.inf, tolerance=1e-5):
    """Change a pressure until it closes the gap below the heights; returns the steps spent."""
    return solve_on_list(
        operator,
        pressure,
        operator.matrix @ pressure - heights,
        scale=heights.std(),
        tolerance=tolerance,
        total=total,
        cap=cap,
    )


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
    pressure, total = np.full(60, 0.01), 0.3
    solve(DenseOperator(matrix), pressure, heights, total=total)
    assert pressure.min() >= 0.0
    assert pressure.sum() == pytest.approx(total, rel=1e-12)
    final = matrix @ pressure - heights
    level = final[pressure > 0].mean()
    assert np.abs(final[pressure > 0] - level).max() < 1e-3 * heights.std()
    assert final.min() > level - 1e-4 * heights.std()
    factor = np.linalg.cholesky(matrix).T
    expected, _ = nnls(factor, np.linalg.solve(factor.T, heights + level))
    np.testing.assert_allclose(pressure, expected, atol=2e-3 * expected.max())


def test_points_at_the_hardness_that_hardly_bear_the_load():
    """Of three springs one is held at the cap, the next has the rest of a load of 1.05 caps. As the
    step takes that one out, it must not come back with so much that the first leaves the cap."""
    pressure, heights = np.array([0.87, 0.18, 0.0]), np.array([0.67, 0.0, -1.0])
    assert solve(DenseOperator(0.5 * np.eye(3)), pressure, heights, total=1.05, cap=1.0) < 10
    np.testing.assert_allclose(pressure, [1.0, 0.05, 0.0], atol=1e-9)


def test_a_direction_that_is_cut_off_again_does_not_end_the_search():
    """One point bears all and the preconditioner would press it still harder: cut to the load, the
    pressure is what it was. The plain direction takes the load to the highest one."""
    skewed = np.array([[2.0, 1.2, 0.0], [1.2, 1.0, 0.0], [0.0, 0.0, 0.1]])
    pressure, heights = np.array([1.0, 0.0, 0.0]), np.array([0.0, 4.9, 0.1])
    assert solve(DenseOperator(0.1 * np.eye(3), skewed), pressure, heights, total=1.0) < 10
    np.testing.assert_allclose(pressure, [0.0, 1.0, 0.0], atol=1e-9)


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
        active, count, p, change, residual, direction, response, np.inf
    )
    np.testing.assert_allclose(p, new_p, rtol=1e-4, atol=1e-6)
    assert negative == (new_p[chosen] < 0).sum()
    np.testing.assert_allclose(
        start_gap + change, expected - length * response, rtol=1e-4, atol=1e-5
    )

    base, moved = rng.random(n), np.empty(n, np.float32)
    total = 0.9 * np.maximum(new_p, 0.0).sum()
    shift, factor = leveled = _list_kernels.leveling(p, total, np.inf)
    largest = _list_kernels.cut(p, base, moved, leveled, np.inf)
    clipped = np.maximum(new_p + shift, 0.0)
    assert shift < 0.0 and factor == 1.0 and clipped.sum() == pytest.approx(total, rel=1e-5)
    np.testing.assert_allclose(p, clipped, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(moved, clipped - base, atol=1e-5)
    assert largest == pytest.approx(np.abs(clipped - base).max(), rel=1e-4)


def test_a_direction_without_curvature_is_refused():
    """Nothing changes and the caller is told."""
    n = 8
    zeros = np.zeros(n, np.float32)
    p, active = np.ones(n), np.ones(n, np.bool_)
    change, *arrays = (zeros.copy() for _ in range(4))
    assert _list_kernels.advance(active, float(n), p, change, *arrays, np.inf) == -1
    assert (p == 1.0).all() and not change.any()


def restored(p, total, cap):
    """The pressure after the compiled passes that restore its sum."""
    p, moved = np.array(p), np.empty(len(p), np.float32)
    _list_kernels.cut(p, np.zeros(len(p)), moved, _list_kernels.leveling(p, total, cap), cap)
    return p


def test_restored_loads_stay_between_the_bounds():
    """All positive pressures are shifted by one value, those at a bound stay there."""
    np.testing.assert_allclose(restored([0.9, -0.2, 0.4, 0.1], 1.0, np.inf), [0.75, 0, 0.25, 0])
    np.testing.assert_allclose(restored([1.0, -0.2, 0.4, 0.4], 2.0, 1.0), [1.0, 0.0, 0.5, 0.5])
    np.testing.assert_allclose(restored([1.0, -0.2, 0.9, 0.4], 2.6, 1.0), [1.0, 0.0, 1.0, 0.6])
    np.testing.assert_allclose(restored([1.0, 40.0, 38.8, -70.0], 2.3, 1.0), [1.0, 1.0, 0.3, 0.0])


@pytest.mark.parametrize("total", [1e-8, 1e-20, 1e-40])
def test_loads_far_below_the_pressures_of_a_step_are_restored(total):
    """Where no shift has that sum by rounding, what is left is scaled."""
    pressure = restored([0.1, -0.7, 0.6, 0.6 - 2e-16], total, np.inf)
    assert pressure.sum() == pytest.approx(total, rel=1e-7) and (pressure >= 0.0).all()


@given(hnp.arrays(float, 30, elements=st.floats(-1.0, 1.0)), st.floats(0.01, 0.99))
def test_the_restored_pressure_is_the_nearest_of_its_load(p, share):
    """Euclidean projection: no feasible pressure is on the far side of it."""
    p = p + (1.0 - p.max())
    total = share * np.maximum(p, 0.0).sum()
    nearest = restored(p, total, np.inf)
    assert nearest.min() >= 0.0 and nearest.sum() == pytest.approx(total, rel=1e-12)
    for corner in np.eye(30) * total:
        assert (p - nearest) @ (corner - nearest) <= 1e-12


def test_directions_stay_conjugate_as_points_leave():
    """The new direction has no mean over the points that are left, so that the load stays."""
    rng = np.random.default_rng(1)
    z, residual, before, direction = rng.standard_normal((4, 40)).astype(np.float32)
    active = rng.random(40) < 0.6
    _list_kernels.turn(active, float(active.sum()), z, residual, before, direction, 0.1)
    assert abs(direction[active].mean()) < 1e-5 * np.abs(direction).max()
    assert not direction[~active].any()


def test_a_contact_without_pressure_begins_at_the_lowest_gap():
    """Whatever start is given, the load is borne."""
    rng = np.random.default_rng(3)
    matrix = kernel(rng)
    heights, pressure = rng.random(60), np.zeros(60)
    solve(DenseOperator(matrix), pressure, heights, total=0.01)
    assert pressure.sum() == pytest.approx(0.01, rel=1e-12)
    assert pressure.argmax() == heights.argmax()


def test_a_level_can_be_held_in_place_of_the_load():
    """Under a cap: the gap is zero inside the bounds, positive without pressure, negative at it."""
    rng = np.random.default_rng(2)
    matrix = kernel(rng)
    heights, pressure, cap = rng.random(60), np.full(60, 0.001), 0.012
    solve(DenseOperator(matrix), pressure, heights, total=None, cap=cap, tolerance=1e-6)
    final = matrix @ pressure - heights
    held, empty = pressure == cap, pressure == 0.0
    assert held.any() and empty.any() and (~held & ~empty).any()
    assert np.abs(final[~held & ~empty]).max() < 1e-4
    assert final[empty].min() > -1e-4 and final[held].max() < 1e-4
