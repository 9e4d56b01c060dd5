"""The half-space operators: influence, symbol, reciprocity."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import periodic_displacement
from samples import displaced

from asperity import HalfSpace
from asperity.bem import convolution
from asperity.bem.operator import HalfSpaceOperator
from asperity.halfspace import influence

CELLS = {
    (0, 0): (1.767747626789, 3.525494348078, 9.400517582781, 27.963424029563),
    (1, 0): (1.008237222449, 1.038049735905, 1.091838884426, 1.137053309933),
    (2, 3): (0.527072375284, 0.278258815588, 0.147143515850, 0.100475635789),
}


@pytest.mark.parametrize("column, m", list(enumerate([-0.5, 0.0, 0.5, 0.8])))
def test_influence_of_near_cells(column, m):
    """Tabulated integrals of r^-(1+m) over unit cells (docs/development/half_space.md)."""
    table = influence.influence((4, 4), (1.0, 1.0), m)
    factor = np.cos(0.5 * np.pi * m) / np.pi / influence.compliance((1.0, 1.0), _unit(m))
    for (row, col), values in CELLS.items():
        assert table[row, col] / factor == pytest.approx(values[column], rel=2e-12)
        assert table[col, row] == pytest.approx(table[row, col], rel=1e-13)


def _unit(m):
    return HalfSpace.from_modulus(1.0, m)


@pytest.mark.parametrize("m", [-0.5, 0.0, 0.3, 0.8])
def test_influence_rules_agree_where_they_meet(m):
    """Corner function, Gauss rule and Taylor series give the same cell where they meet."""
    y, x = np.arange(12) * 2.0, np.arange(12) * 0.5
    corner = influence._corner_mean(y, x, 2.0, 0.5, m)
    gauss = influence._gauss_mean(y, x, 2.0, 0.5, m)
    np.testing.assert_allclose(gauss[8:, :], corner[8:, :], rtol=1e-11)
    series = np.empty((104, 120))
    influence._far_cells((0, 104), 1.0, 0.8, m, 1.0, series)
    gauss = influence._gauss_mean(np.arange(104.0), 0.8 * np.arange(120.0), 1.0, 0.8, m)
    np.testing.assert_allclose(series[100:], gauss[100:], rtol=1e-12)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("shape", [(6, 10), (7, 11), (9, 8)])
@pytest.mark.parametrize("m", [-0.5, 0.0, 0.6])
def test_operator_is_symmetric(boundary, shape, m):
    """Reciprocity: <K p, q> = <p, K q>, on odd and even, non-square grids."""
    operator = HalfSpaceOperator(shape, (0.3, 0.2), HalfSpace.from_modulus(2.0, m), boundary)
    rng = np.random.default_rng(1)
    p, q = rng.standard_normal((2, *shape))
    left, right = np.vdot(displaced(operator, p), q), np.vdot(p, displaced(operator, q))
    assert left == pytest.approx(right, rel=1e-12)


@pytest.mark.parametrize("shape", [(6, 10), (7, 11)])
@pytest.mark.parametrize("m", [-0.5, 0.0, 0.6])
def test_periodic_operator_is_the_symbol(shape, m):
    """The planned operator equals the symbol written out in numpy."""
    operator = HalfSpaceOperator(shape, (0.3, 0.2), HalfSpace.from_modulus(2.0, m))
    p = np.random.default_rng(2).random(shape)
    expected = periodic_displacement(p, (0.3, 0.2), 2.0, m)
    found = displaced(operator, p)
    np.testing.assert_allclose(found, expected, atol=1e-14 * np.abs(expected).max())


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_free_operator_is_the_direct_sum(m):
    """The padded convolution equals the sum over cells, without wrap-around."""
    shape, spacing = (5, 8), (0.3, 0.2)
    material = HalfSpace.from_modulus(2.0, m)
    operator = HalfSpaceOperator(shape, spacing, material, "free")
    table = influence.influence(shape, spacing, m) * influence.compliance(spacing, material)
    p = np.random.default_rng(3).random(shape)
    rows, cols = np.indices(shape)
    expected = [(table[abs(rows - i), abs(cols - j)] * p).sum() for i in range(5) for j in range(8)]
    np.testing.assert_allclose(displaced(operator, p).ravel(), expected, rtol=1e-12)


@pytest.mark.parametrize("shape", [(9, 14), (17, 23)])
def test_both_libraries_transform(shape):
    """FFTW and, for lengths of large factors, scipy: every wave times its symbol."""
    values, symbol = np.random.default_rng(4).random((2, *shape))
    symbol = symbol[: shape[0] // 2 + 1, : shape[1] // 2 + 1]
    pair = convolution.plan(shape, shape)
    pair.values[:] = values
    pair.apply(symbol)
    row = np.arange(shape[0])
    waves = np.fft.rfft2(values) * symbol[np.minimum(row, shape[0] - row)]
    expected = np.fft.irfft2(waves, s=shape) * values.size
    np.testing.assert_allclose(pair.grid[:, : shape[1]], expected, atol=1e-12)
    assert convolution.prefers_fftw(shape) == (shape == (9, 14))
