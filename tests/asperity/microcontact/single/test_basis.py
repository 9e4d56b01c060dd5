"""The radius at an approach, of profiles of every form."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity.microcontact.single.basis import TableBasis
from surfaces import PolarProfile, PolynomialProfile, PowerSumProfile

BODY = asperity.HalfSpace.from_modulus(1.0)


def test_terms_of_one_power_are_their_sum():
    """The falling one counts, though the body never turns over."""
    parts, whole = (
        asperity.indent(PowerSumProfile(*terms), BODY, [1e-3, 0.01])
        for terms in (([2.0, 2.0], [1.0, -0.3]), ([2.0], [0.7]))
    )
    np.testing.assert_allclose(parts.radius, whole.radius, rtol=1e-12)
    np.testing.assert_allclose(parts.force, whole.force, rtol=1e-12)


def test_a_falling_term_between_rising_ones_counts():
    """On circles D(a) = 2 a^2 - 0.3 (3 pi / 4) a^3 + 8/3 a^4, m = 0."""
    body = PowerSumProfile([2.0, 3.0, 4.0], [1.0, -0.3, 1.0])
    a = asperity.indent(body, BODY, 0.1).radius
    assert 2 * a**2 - 0.225 * np.pi * a**3 + 8 / 3 * a**4 == pytest.approx(0.1, rel=1e-12)


@pytest.mark.parametrize("approach", [1e-90, 1e-50, 1e-20])
def test_a_contact_far_smaller_than_its_table_has_its_radius(approach):
    r, phi = np.linspace(0.0, 1.0, 41), 2 * np.pi * np.arange(16) / 16
    table = PolarProfile(r, phi, 0.5 * r[:, None] ** 2 * np.ones(16))
    radius = asperity.indent(table, BODY, approach).radius
    assert radius == pytest.approx(np.sqrt(approach), rel=1e-6, abs=0.0)


def test_the_last_harmonic_of_an_even_number_of_rays_counts():
    """Four rays on the axes of a paraboloid hold its ellipse: the amplitudes of eight rays."""
    a, r = np.array([0.3, 0.7]), np.linspace(0.0, 1.0, 9)
    turns = (2 * np.pi * np.arange(count) / count for count in (4, 8))
    four, eight = (
        TableBasis(PolarProfile(r, phi, np.outer(r**2, 2.5 - 1.5 * np.cos(2 * phi))), 0.2)
        for phi in turns
    )
    np.testing.assert_allclose(four.amplitudes(a), eight.amplitudes(a)[:, :2], atol=1e-14)
    np.testing.assert_allclose(four.summit(), eight.summit(), atol=1e-13)


@pytest.mark.parametrize("turn", [0.0, 1.0, 2.0, 4.0])
def test_the_tilt_of_a_body_has_no_mean_whatever_its_direction(turn):
    """Rounding of the mean of cos(phi - turn), below zero, is no falling profile."""
    tilt = {(1, 0): 0.05 * np.cos(turn), (0, 1): 0.05 * np.sin(turn)}
    forces = [
        asperity.indent(PolynomialProfile({**terms, (2, 0): 1.0, (0, 2): 1.0}), BODY, 0.1).force
        for terms in (tilt, {(1, 0): 0.05})
    ]
    assert forces[0] == pytest.approx(float(forces[1]), rel=1e-12)


@pytest.mark.parametrize("k", [2.001, 2.0001])
def test_powers_that_nearly_agree_are_nearly_one(k):
    """They turn over at 1e200 m and more, which no floating-point number may hold."""
    near, one = (
        asperity.indent(PowerSumProfile([2.0, k], [1.0, factor]), BODY, 0.1).force
        for k, factor in ((k, -0.3), (2.0, -0.3))
    )
    assert near == pytest.approx(float(one), rel=2e-3)


@pytest.mark.parametrize("size", [1.0, 1e-7, 1e5])
def test_a_load_is_found_on_a_body_that_turns_over_in_every_unit(size):
    """r^2/size - r^4/size^3 turns over at 0.7 size, beyond which no search may begin."""
    body = PowerSumProfile([2.0, 4.0], [1 / size, -1 / size**3])
    pressed = asperity.indent(body, BODY, np.array([1e-4, 0.02, 0.2]) * size)
    loaded = asperity.indent(body, BODY, load=pressed.force)
    np.testing.assert_allclose(loaded.approach, pressed.approach, rtol=1e-10)


def test_a_body_that_only_falls_is_refused_under_a_load():
    with pytest.raises(asperity.ModelRangeError, match="does not rise from its summit"):
        asperity.indent(PowerSumProfile([2.0], [-1.0]), BODY, load=1.0)
