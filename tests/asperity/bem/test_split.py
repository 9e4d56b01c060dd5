"""The split operator and its stencils against the exact operator."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import rough

from asperity import HalfSpace
from asperity.bem import _grid_kernels, split, stencil
from asperity.bem.contact_list import ContactList
from asperity.bem.full_grid import FullGridOperator
from asperity.bem.operator import HalfSpaceOperator

CASES = [
    ((140, 200), (0.01, 0.01), "periodic", 0.0),
    ((150, 131), (0.02, 0.01), "periodic", -0.5),
    ((144, 160), (0.01, 0.013), "periodic", 0.8),
    ((140, 150), (0.01, 0.01), "free", 0.0),
    ((129, 160), (0.01, 0.015), "free", 0.4),
]


def listed(shape, filling=0.3, seed=0):
    """A list of points in patches, some at the border and across the seam, and its mask."""
    ny, nx = shape
    hm = rough(shape, size=(1.0, nx / ny), cutoff=12.0, seed=seed)
    mask = hm.heights > np.quantile(hm.heights, 1 - filling)
    rows, columns = np.nonzero(mask)
    start = np.searchsorted(rows, np.arange(ny + 1))
    return ContactList(start, columns.astype(np.int32)), mask


@pytest.mark.parametrize("shape, spacing, boundary, m", CASES)
def test_split_operator_is_close_to_the_exact_one(shape, spacing, boundary, m):
    """A rough pressure on a list: displacement within 2 % of its variation, long waves better."""
    exact = HalfSpaceOperator(shape, spacing, HalfSpace.from_modulus(1.0, m), boundary)
    points, mask = listed(shape)
    nearly = split.SplitOperator(exact)
    rng = np.random.default_rng(1)
    for values, bound in ((rng.standard_normal(len(points)), 0.02), (np.ones(len(points)), 2e-3)):
        exact.pressure[:] = 0.0
        exact.pressure[:, : shape[1]][mask] = values
        expected = exact.apply()[:, : shape[1]][mask]
        nearly.bind(points)
        found = nearly.apply(values.astype(np.float32))
        assert np.abs(found - expected).max() < bound * np.abs(expected).max()


@pytest.mark.parametrize("shape, spacing, boundary, m", CASES)
def test_split_operator_and_preconditioner_are_symmetric(shape, spacing, boundary, m):
    """<S p, q> = <p, S q>, and both are positive."""
    exact = HalfSpaceOperator(shape, spacing, HalfSpace.from_modulus(1.0, m), boundary)
    points, _ = listed(shape)
    p, q = np.random.default_rng(2).standard_normal((2, len(points))).astype(np.float32)
    for kind in (split.SplitOperator, FullGridOperator):
        operator = kind(exact)
        operator.bind(points)
        for action in (operator.apply, operator.precondition):
            left, right = np.vdot(action(p), q), np.vdot(p, action(q))
            size = np.linalg.norm(action(p)) * np.linalg.norm(q)
            assert abs(left - right) < 1e-5 * size
            assert np.vdot(action(p), p) > 0


@pytest.mark.parametrize("shape, spacing, boundary, m", CASES)
def test_full_grid_operator_is_the_exact_one(shape, spacing, boundary, m):
    """On a list, up to single precision."""
    exact = HalfSpaceOperator(shape, spacing, HalfSpace.from_modulus(1.0, m), boundary)
    points, mask = listed(shape)
    single = FullGridOperator(exact)
    values = np.random.default_rng(3).standard_normal(len(points))
    exact.pressure[:, : shape[1]][mask] = values
    expected = exact.apply()[:, : shape[1]][mask]
    single.bind(points)
    found = single.apply(values.astype(np.float32))
    np.testing.assert_allclose(found, expected, atol=2e-6 * np.abs(expected).max())


@pytest.mark.parametrize("m", [-0.5, 0.0, 0.5, 0.8])
@pytest.mark.parametrize("aspect", [1.0, 2.0])
def test_fitted_symbol(m, aspect):
    """Outside the coarse band the stencil alone is within 6 % of the symbol."""
    taps = stencil.fitted_stencil(aspect, m, False)
    f = np.linspace(0.0, 0.5, 41)[1:]
    found = stencil.stencil_symbol(taps, f, f)
    q = 2 * np.pi * np.hypot(f[:, None] / np.sqrt(aspect), f[None, :] * np.sqrt(aspect))
    outside = np.maximum(f[:, None], f[None, :]) > 0.125
    relative = np.abs(found / q ** (m - 1) - 1)
    assert relative[outside].max() < 0.06


@pytest.mark.parametrize("m", [-0.99, -0.88, -0.5, 0.0, 0.5, 0.99])
@pytest.mark.parametrize("aspect", [1e-6, 0.4, 1.0, 3.0])
def test_preconditioner_is_positive(m, aspect):
    """The symbol of the cut-off stencil has no zero."""
    taps = stencil.precondition_stencil(aspect, m)
    f = np.linspace(0, 0.5, 200)
    assert stencil.stencil_symbol(taps, f, f).min() > 0.02 * taps.max()


def test_stencil_sum_is_the_direct_sum():
    """The vectorized stencil equals a loop over its taps, across the seam or not."""
    shape = (140, 150)
    points, mask = listed(shape, 0.2, seed=4)
    values = np.random.default_rng(5).standard_normal(len(points)).astype(np.float32)
    for boundary in ("periodic", "free"):
        exact = HalfSpaceOperator(shape, (1.0, 1.0), HalfSpace.from_modulus(1.0), boundary)
        operator = split.SplitOperator(exact)
        operator.bind(points)
        fold = np.abs(np.arange(-4, 5))
        taps = stencil.precondition_stencil(1.0, 0.0)[np.ix_(fold, fold)]
        dense = np.zeros(shape)
        dense[mask] = values
        dense = np.pad(dense, 4, mode="wrap" if boundary == "periodic" else "constant")
        windows = np.lib.stride_tricks.sliding_window_view(dense, (9, 9))[mask]
        expected = np.einsum("kij,ij->k", windows, taps)
        np.testing.assert_allclose(operator.precondition(values), expected, atol=2e-5)


@pytest.mark.parametrize("cap", [np.inf, 0.6])
def test_sums_and_selected_points(cap):
    """Sums and candidate list are those of numpy; values are put back in place."""
    rng = np.random.default_rng(6)
    displacement, heights = rng.random((2, 9, 14))
    pressure = np.where(rng.random((9, 14)) < 0.2, rng.random((9, 14)), 0.0)
    heights.setflags(write=False)
    gap = displacement - heights
    low = np.empty((9, 1))
    sums = _grid_kernels.contact_sums((0, 9), pressure, displacement, heights, cap, low)
    touching, held = pressure > 0, pressure >= cap
    inside = touching & ~held
    expected = (
        inside.sum(),
        gap[inside].sum(),
        (pressure * gap)[~held].sum(),
        pressure.sum(),
        (pressure * displacement).sum(),
        held.sum(),
        gap[held].sum(),
        np.maximum(pressure - cap, 0.0).sum(),
        gap[~held].min(),
        gap[held].max(initial=-np.inf),
        displacement.max(),
    )
    assert sums == pytest.approx(expected, rel=1e-13)
    np.testing.assert_array_equal(
        low[:, 0], np.where(touching.any(axis=1), -np.inf, gap.min(axis=1))
    )
    start, columns, p, g = _grid_kernels.select(pressure, displacement, heights, low, -0.3)
    mask = (gap <= -0.3) | touching
    rows, where = np.nonzero(mask)
    np.testing.assert_array_equal(columns, where)
    np.testing.assert_array_equal(np.repeat(np.arange(9), np.diff(start)), rows)
    np.testing.assert_array_equal(p, pressure[mask])
    np.testing.assert_array_equal(g, gap[mask])
    _grid_kernels.put((0, 9), pressure, start, columns, p + 1.0)
    np.testing.assert_array_equal(pressure[mask], p + 1.0)
