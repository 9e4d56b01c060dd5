"""Profiles in polar coordinates: they return what was put in, and refuse what they cannot hold."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from surfaces import InputError, PolarProfile, PolynomialProfile, PowerLawProfile

TURN = 2 * np.pi * np.arange(32) / 32


def test_power_law_from_samples_equals_power_law_from_function():
    smooth = PowerLawProfile(1.5, lambda phi: 1 + 0.2 * np.cos(3 * phi))
    angles = 2 * np.pi * np.arange(256) / 256
    sampled = PowerLawProfile(1.5, smooth.psi(angles))
    r, phi = np.linspace(0, 2, 7)[:, None], np.linspace(-4, 9, 31)
    np.testing.assert_allclose(sampled(r, phi), smooth(r, phi), atol=2e-3)
    np.testing.assert_allclose(sampled(r, angles), smooth(r, angles), rtol=1e-14)


def test_polynomial_is_evaluated_in_cartesian_terms():
    profile = PolynomialProfile({(2, 0): 1.0, (1, 1): 0.3, (0, 2): 2.0, (3, 1): 0.1})
    x, y = np.array([0.3, -1.0, 2.0]), np.array([0.1, 0.7, -0.4])
    expected = x**2 + 0.3 * x * y + 2 * y**2 + 0.1 * x**3 * y
    np.testing.assert_allclose(profile(np.hypot(x, y), np.arctan2(y, x)), expected, rtol=1e-13)


@pytest.mark.parametrize(
    "profile",
    [
        PowerLawProfile(2, 0.5),
        PowerLawProfile(1.5, [1.0, 1.1, 1.2, 1.1]),
        PolynomialProfile({(2, 0): 1.0, (1, 1): 0.3, (0, 2): 2.0}),
        PolarProfile(np.arange(5.0), TURN, np.arange(5.0)[:, None] ** 2 + 0 * TURN),
    ],
)
def test_profiles_are_the_same_after_pickling(profile):
    back, r = pickle.loads(pickle.dumps(profile)), np.linspace(0, 4, 9)[:, None]
    np.testing.assert_array_equal(back(r, TURN + 0.1), profile(r, TURN + 0.1))


@pytest.mark.parametrize("k", [1, 2, 3])
def test_table_of_a_polynomial_in_r_is_interpolated_exactly(k):
    r = np.linspace(0, 2, 11) ** 1.2
    psi = 1 + 0.3 * np.cos(2 * TURN)
    profile = PolarProfile(r, TURN, r[:, None] ** k * psi)
    radius = np.linspace(0, r[-1], 57)[:, None]
    np.testing.assert_allclose(profile(radius, TURN), radius**k * psi, atol=1e-12)


@pytest.mark.parametrize("unit", [1e-24, 1e9, 1e15, 1e24])
def test_slopes_do_not_depend_on_the_unit(unit):
    """At radii of 1e9 and more they were off by one per cent of the steepest."""
    r, phi = np.linspace(0, 1, 21), 2 * np.pi * np.arange(16) / 16
    f = r[:, None] ** 2 * (1 + 0.2 * np.cos(2 * phi))
    slope = PolarProfile(unit * r, phi, unit * f).slope
    np.testing.assert_allclose(slope, 2 * f / np.maximum(r, 1e-9)[:, None], atol=1e-12)


def test_table_is_monotone_where_its_values_are():
    r = np.linspace(0, 1, 9)
    steps = np.where(r < 0.5, r, 0.5 + 1e-3 * r)[:, None] * np.ones(TURN.size)
    profile = PolarProfile(r, TURN, steps)
    fine = profile(np.linspace(0, 1, 400)[:, None], TURN)
    assert np.all(np.diff(fine, axis=0) >= -1e-15)


def test_table_continues_with_its_last_slope_beyond_the_last_radius():
    r = np.linspace(0, 1, 9)
    profile = PolarProfile(r, TURN, r[:, None] ** 2 * np.ones(TURN.size))
    inside, edge, outside = profile(np.array([1 - 1e-6, 1.0, 1 + 1e-6]), 0.1)
    assert outside - edge == pytest.approx(edge - inside, rel=1e-5)
    assert profile(3.0, 0.1) == pytest.approx(9.0)


def test_a_turn_far_out_leaves_the_summit_as_it_is():
    """The slopes of the whole ray were those of another cubic: the curvature was half as large
    again, and loads 18 % too small."""
    r = np.linspace(0.0, 1.0, 65)
    f = np.where(r <= 0.7, r**2, np.where(r < 0.75, 0.49 + (r - 0.7) * 40, 2.5 + (r - 0.75) / 100))
    profile = PolarProfile(r, TURN, np.repeat(f[:, None], TURN.size, axis=1))
    np.testing.assert_allclose(profile.slope[:25, 0], 2.0 * r[:25], rtol=1e-5, atol=1e-9)
    fine = np.linspace(0.0, 1.0, 2001)
    assert (np.diff(profile(fine, 0.3)) > -1e-12).all()


@pytest.mark.parametrize("seed", range(20))
def test_rays_of_rising_values_never_fall(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 40))
    r = np.append(0.0, np.cumsum(rng.uniform(0.2, 2.0, count)))
    f = np.cumsum(rng.exponential(size=(count + 1, 8)) ** rng.uniform(0.5, 5.0), axis=0)
    profile = PolarProfile(r, TURN[::4], f - f[0])
    for phi in TURN[::4]:
        rise = np.diff(profile(np.linspace(0.0, r[-1], 3000), phi))
        assert rise.min() > -1e-12 * f.max()


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: PowerLawProfile(0.0, 1.0), "exponent k must be positive"),
        (lambda: PowerLawProfile(1.0, [1.0, 2.0]), "at least 4 equispaced"),
        (lambda: PowerLawProfile(1.0, [1.0, np.nan, 1.0, 1.0]), "must be finite"),
        (lambda: PolynomialProfile({(0, 0): 1.0}), r"i \+ j >= 1"),
        (lambda: PolynomialProfile({(2, 0): "x"}), r"of \(2, 0\) is 'x'; it must be a number"),
        (lambda: PolynomialProfile({(2, 0): np.ones(2)}), r"of \(2, 0\) is array.* a number"),
        (lambda: PolarProfile([0, 1, 2], TURN, np.zeros((3, 31))), "must have the shape"),
        (lambda: PolarProfile([0, 1, 2], TURN, np.zeros((3, 32))), "at least 4 increasing"),
        (lambda: PolarProfile([0, 1, 2, 3], TURN**2, np.zeros((4, 32))), "equispaced"),
    ],
)
def test_unusable_tables_are_refused_in_one_sentence(build, message):
    with pytest.raises(InputError, match=message):
        build()
