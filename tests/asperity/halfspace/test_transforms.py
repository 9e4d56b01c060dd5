"""Radial transforms: multipliers, Gauss rules and moments against each other and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from asperity.halfspace.transforms import gauss_jacobi, kappa, moments

GRADINGS = [-0.5, -0.3, 0.0, 0.3, 0.5, 0.8]
TABLE = {
    0.5: [1.8540746773, 1.5497219576, 1.3110287771, 1.1745723357, 1.1107207345, 1.0381191975],
    1.0: [2.6220575543, 2.0283119046, 1.5707963268, 1.3153149714, 1.1981402347, 1.0673798598],
    3.0: [5.2441151086, 3.5793739494, 2.3561944902, 1.7156282236, 1.4377682817, 1.1436212784],
    4.0: [6.4, 4.2328042328, 2.6666666667, 1.8648018648, 1.5238095238, 1.1695906433],
}
LARGE = {-0.5: 12122.98010935356, 0.0: 396.333720593664, 0.8: 3.1530018527362853}


@pytest.mark.parametrize("k", TABLE)
def test_multipliers_of_the_table(k):
    np.testing.assert_allclose([kappa(m, k) for m in GRADINGS], TABLE[k], atol=6e-11)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(m=st.floats(-0.9, 0.9), k=st.floats(0.0, 1e6))
def test_recurrence_of_the_multipliers(m, k):
    expected = kappa(m, k) * (k + 2) / (k + m + 1)
    assert kappa(m, k + 2) == pytest.approx(expected, rel=3e-12)


@pytest.mark.parametrize("m", LARGE)
def test_multipliers_keep_their_digits_at_large_exponents(m):
    """Values at k = 1e5 from 40-digit arithmetic."""
    assert kappa(m, 1e5) == pytest.approx(LARGE[m], rel=1e-13)


@pytest.mark.parametrize("m", GRADINGS)
@pytest.mark.parametrize("points", [3, 6, 12])
def test_gauss_rule_is_exact_for_its_degree(m, points):
    t, w = gauss_jacobi(m, points)
    assert np.all((t > 0) & (t < 1) & (w > 0))
    exact = moments(m, np.array([0.0, 1.0]), np.arange(2 * points))[0]
    np.testing.assert_allclose(t ** np.arange(2 * points)[:, None] @ w, exact, rtol=1e-11)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(m=st.floats(-0.8, 0.8), low=st.floats(0.0, 0.9), width=st.floats(0.01, 0.1))
def test_moments_of_a_segment_agree_with_quadrature(m, low, width):
    high = min(low + width, 0.97)
    x, w = np.polynomial.legendre.leggauss(40)
    t = (low + high) / 2 + (high - low) / 2 * x
    weight = (high - low) / 2 * w * (1 - t * t) ** ((m - 1) / 2)
    found = moments(m, np.array([low, high]), np.arange(5))[0]
    np.testing.assert_allclose(found, t ** np.arange(5)[:, None] @ weight, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("m", GRADINGS)
def test_moments_and_multipliers_are_one_operator(m):
    """e_n of r^k by the moments is kappa_m(k + n)."""
    for n in (0, 1, 2, 5):
        for k in (1, 2, 3):
            mu = moments(m, np.array([0.0, 1.0]), np.array([n + 1 + k]))[0, 0]
            assert (n + 1 + m + k) * mu == pytest.approx(float(kappa(m, k + n)), rel=1e-12)
