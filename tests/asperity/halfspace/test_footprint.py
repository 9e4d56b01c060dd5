"""Gaussian footprints: integrals, limits, and the rule that fixes their size."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import free_interaction
from scipy.integrate import quad
from scipy.special import gammaincc, i0e, j0

from asperity.halfspace.footprint import (
    OUTSIDE_SHARE,
    Footprints,
    pair_table,
    smooth_part,
    smooth_polynomials,
)

EXPONENTS = (-0.5, -0.3, 0.0, 0.3, 0.8)


@pytest.mark.parametrize("m", EXPONENTS)
@pytest.mark.parametrize(("r", "spread"), [(0.7, 0.3), (0.0, 0.5), (3.0, 0.1)])
def test_interaction_is_the_integral_over_waves(m, r, spread):
    f = Footprints(2.0, m)
    integral = quad(
        lambda q: q**m * np.exp(-q * q * spread / 2) * j0(q * r), 0, 40, limit=400, epsabs=1e-12
    )[0]
    assert free_interaction(f, r, spread) == pytest.approx(
        f.symbol / (2 * np.pi) * integral, rel=1e-7
    )


def test_homogeneous_interaction_has_its_closed_form():
    r, spread = np.array([0.0, 0.3, 2.0, 30.0]), 0.4
    t2 = r * r / spread
    closed = np.sqrt(np.pi / 2) * i0e(t2 / 4) / (np.pi * np.sqrt(spread))
    np.testing.assert_allclose(free_interaction(Footprints(1.0), r, spread), closed, rtol=1e-12)


@pytest.mark.parametrize("m", EXPONENTS)
def test_distant_footprints_are_points(m):
    f = Footprints(3.0, m)
    p = 1 + m
    second = 1 + 0.5 * p * p * 1e-6
    assert free_interaction(f, 1.0, 1e-6) == pytest.approx(f.point * second, rel=1e-10)


@pytest.mark.parametrize("m", EXPONENTS)
def test_self_compliance_of_the_footprint_is_that_of_the_contact(m):
    f, k = Footprints(3.0, m), 0.7
    own = free_interaction(f, 0.0, 2 * f.variance(k))
    assert own == pytest.approx(1 / ((1 + OUTSIDE_SHARE) * k), rel=1e-12)


@pytest.mark.parametrize("m", EXPONENTS)
def test_footprint_has_nearly_the_second_moment_of_the_punch(m):
    """Not fitted: the self-compliance alone gives the punch's a^2/(3+m) per axis to 10 %."""
    k = 2 / (1 + m) / (1 + OUTSIDE_SHARE)
    assert Footprints(1.0, m).variance(k) == pytest.approx(1 / (3 + m), rel=0.1)


def wave(q, m, order, r):
    return (-q * q) ** order * q**m * gammaincc((1 - m) / 2, q * q / 4) * j0(q * r)


@pytest.mark.parametrize("m", EXPONENTS)
def test_smooth_part_and_its_laplacians_are_integrals_over_waves(m):
    f = Footprints(1.0, m)
    for r in (0.0, 0.5, 1.3):
        parts = smooth_part(m, np.array([r * r]))
        for order, part in enumerate(parts[:3]):
            integral = quad(wave, 0, 30, args=(m, order, r), limit=400)[0]
            wanted = f.symbol / (2 * np.pi) * integral
            assert f.point * part[0] == pytest.approx(wanted, rel=1e-7)


@pytest.mark.parametrize("m", EXPONENTS)
def test_slopes_of_the_smooth_part(m):
    """Columns 3 and 4 are f'/r and (Laplacian f)'/r."""
    x, h = np.array([0.01, 0.4, 0.6, 3.0]), 1e-5
    up, down = smooth_part(m, x + h), smooth_part(m, x - h)
    at = smooth_part(m, x)
    for value, slope in ((0, 3), (1, 4)):
        np.testing.assert_allclose(at[slope], (up[value] - down[value]) / h, rtol=1e-6)


@pytest.mark.parametrize("m", EXPONENTS)
def test_pair_table_holds_value_and_slopes(m):
    f, table = Footprints(2.0, m), pair_table(m)
    p, nodes = 1 + m, len(table) - 1
    for r, spread in ((0.5, 0.3), (2.0, 0.02), (0.01, 1.0)):
        reach = r * r + spread
        h, k, j = (np.interp(spread / reach, np.linspace(0, 1, nodes + 1), c) for c in table.T)
        e = 1e-5 * spread
        assert f.point * h * reach ** (-p / 2) == pytest.approx(
            free_interaction(f, r, spread), rel=1e-5
        )
        by_spread = (free_interaction(f, r, spread + e) - free_interaction(f, r, spread - e)) / (
            2 * e
        )
        assert f.point * k * reach ** (-p / 2 - 1) == pytest.approx(by_spread, rel=1e-3)
        e = 1e-4 * r
        by_r = (free_interaction(f, r + e, spread) - free_interaction(f, r - e, spread)) / (2 * e)
        assert f.point * j * reach ** (-p / 2 - 1) == pytest.approx(by_r / r, rel=1e-3)


@pytest.mark.parametrize("m", EXPONENTS)
def test_table_is_fine_enough_for_linear_interpolation(m):
    table = pair_table(m)
    middle = 0.5 * (table[:-2] + table[2:]) - table[1:-1]
    assert np.abs(middle / 4).max() < 3e-5 * np.abs(table).max()


@pytest.mark.parametrize("m", EXPONENTS)
@pytest.mark.parametrize(("limit", "bound"), [(4.0, 1e-8), (12.25, 1e-4)])
def test_polynomials_give_the_smooth_part(m, limit, bound):
    x, a = np.linspace(0.0, limit, 301), (1 + m) / 2
    edge, second = (
        np.polynomial.Polynomial(c)(x - limit / 2) for c in smooth_polynomials(m, limit)
    )
    first = -(x * second + edge) / (a + 1)
    f = (edge - x * first) / a
    laplacian, slope = -4 * (a * first + edge), -8 * (a * second - edge)
    twice = 16 * (a * (a + 1) * second + (1 - a - x) * edge)
    for got, wanted in zip((f, laplacian, twice, 2 * first, slope), smooth_part(m, x), strict=True):
        np.testing.assert_allclose(got, wanted, atol=bound * np.abs(wanted).max())
