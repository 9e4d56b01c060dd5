"""One contact: closed forms, consistency of stiffness, symmetries, scalings, load control."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import GRADINGS, POWERS

from asperity import HalfSpace, InputError, ModelRangeError, indent
from asperity.halfspace.transforms import kappa
from asperity.microcontact import Flag
from asperity.microcontact.hertz import elliptic_contact
from surfaces import PolarProfile, PolynomialProfile, PowerLawProfile, PowerSumProfile

EXPONENTS = [-0.5, -0.3, 0.0, 0.3, 0.5, 0.8]
GRADED_HERTZ = {-0.3: 6.0468631897, 0.0: 8 / 3, 0.5: 1.0158730159}
TURN = 2 * np.pi * np.arange(48) / 48


def wavy(k):
    """Power-law body with a second, third and fifth harmonic."""
    return PowerLawProfile(
        k, lambda p: 1 + 0.1 * np.cos(2 * p + 1) + 0.06 * np.cos(3 * p) + 0.02 * np.sin(5 * p)
    )


def body():
    """Body whose section changes with height."""
    return PowerSumProfile(
        [2.0, 3.0, 4.0],
        [
            lambda p: 1 + 0.15 * np.cos(2 * p),
            lambda p: 0.2 * np.cos(3 * p),
            lambda p: -0.1 + 0.05 * np.cos(p),
        ],
    )


def tabulated(profile, radius=1.0, nodes=24):
    """A profile as a table."""
    r = np.linspace(0, radius, nodes)
    return PolarProfile(r, TURN, profile(r[:, None], TURN))


@settings(max_examples=30, deadline=None, derandomize=True)
@given(k=POWERS, m=GRADINGS, scale=st.floats(1e-6, 1e6))
def test_axisymmetric_power_law_is_exact(k, m, scale):
    profile, material = PowerLawProfile(k, scale), HalfSpace.from_modulus(7.0, m)
    a = 0.3
    depth = kappa(m, k) * scale * a**k
    for law in ("paper", "harmonic"):
        one = indent(profile, material, depth, law=law)
        expected = 14.0 / (1 + m) * k / (k + m + 1) * depth * a ** (1 + m)
        assert one.force == pytest.approx(expected, rel=1e-11)
        assert one.contact_area == pytest.approx(np.pi * a * a, rel=1e-11)
        assert one.stiffness == pytest.approx(14.0 * a ** (1 + m) / (1 + m), rel=1e-11)
        assert one.flags == 0 and one.valid


@pytest.mark.parametrize("m", GRADED_HERTZ)
def test_unit_paraboloid_has_the_known_force(m):
    depth = kappa(m, 2.0)
    one = indent(PowerLawProfile(2, 1.0), HalfSpace.from_modulus(1.0, m), depth)
    assert one.force == pytest.approx(GRADED_HERTZ[m], abs=1e-10)


def test_cone_is_sneddon():
    one = indent(PowerLawProfile(1, 0.4), HalfSpace.from_modulus(2.0), 0.05, law="paper")
    a = 2 * 0.05 / (np.pi * 0.4)
    assert one.force == pytest.approx(2 * 2.0 * 0.05**2 / (np.pi * 0.4), rel=1e-13)
    r = np.array([0.2, 0.5, 0.9]) * a
    expected = 0.5 * 2.0 * 0.4 * np.arccosh(a / r)
    np.testing.assert_allclose(one.pressure(r, 0.0), expected, rtol=1e-12)


@pytest.mark.parametrize("law", ["paper", "harmonic"])
@pytest.mark.parametrize("m", EXPONENTS)
def test_pressure_of_the_round_paraboloid_is_graded_hertz(law, m):
    one = indent(PowerLawProfile(2, 0.5), HalfSpace.from_modulus(1.0, m), 0.02, law=law)
    r = np.linspace(0, 1.2, 14) * one.radius
    mean = one.force / (np.pi * one.radius**2)
    inside = np.maximum(1 - (r / one.radius) ** 2, 0)
    expected = mean * (3 + m) / 2 * inside ** ((1 + m) / 2)
    np.testing.assert_allclose(one.pressure(r, 0.0), expected, rtol=1e-10, atol=1e-15)


@pytest.mark.parametrize(("k", "factors"), [(1, (2.5, 1.5)), (2, (5 / 3, 2 / 3))])
def test_published_contour_of_power_laws(k, factors):
    profile = wavy(k)
    one = indent(profile, HalfSpace.from_modulus(1.0), 0.01, law="paper")
    expected = one.radius * (factors[0] - factors[1] * profile.psi(TURN))
    np.testing.assert_allclose(one.contour(TURN), expected, rtol=1e-12)


@pytest.mark.parametrize("m", EXPONENTS)
def test_hertz_is_exact_on_ellipses_and_the_others_approach_it_at_their_order(m):
    material = HalfSpace.from_modulus(1.0, m)
    errors = {"paper": [], "harmonic": []}
    for ratio in (1.1, 1.21):
        profile = PolynomialProfile({(2, 0): ratio / 2, (0, 2): 0.5})
        exact = elliptic_contact(ratio, 1.0, 0.1, material)
        hertz = indent(profile, material, 0.1, law="hertz")
        assert hertz.force == pytest.approx(exact.force, rel=1e-12)
        np.testing.assert_allclose(
            hertz.contour([0, np.pi / 2]), [exact.semi_minor, exact.semi_major], rtol=1e-12
        )
        for law, found in errors.items():
            one = indent(profile, material, 0.1, law=law)
            found.append(one.force / exact.force - 1)
    assert errors["paper"][1] / errors["paper"][0] == pytest.approx(4, rel=0.1)
    assert errors["harmonic"][1] / errors["harmonic"][0] == pytest.approx(16, rel=0.15)


@pytest.mark.parametrize("powers, factors", [([2, 2], [0.2, 0.3]), ([1, 2, 4], [0.0, 0.5, 0.0])])
def test_terms_of_one_power_add_up_and_those_without_factor_count_for_nothing(powers, factors):
    material = HalfSpace.from_modulus(1.0)
    for law in ("hertz", "harmonic"):
        one = indent(PowerSumProfile(powers, factors), material, 0.01, law=law)
        assert one.force == pytest.approx(4 / 3 * 0.01**1.5, rel=1e-9)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
@pytest.mark.parametrize("law", ["hertz", "paper", "harmonic"])
@pytest.mark.parametrize("kind", ["closed", "table"])
def test_stiffness_is_the_derivative_of_the_force(law, m, kind):
    profile = tabulated(body()) if kind == "table" else body()
    material, depth, step = HalfSpace.from_modulus(1.0, m), np.array([0.02, 0.2, 0.5]), 1e-5
    up, down = (indent(profile, material, depth * (1 + s), law=law) for s in (step, -step))
    slope = (up.force - down.force) / (2 * step * depth)
    stiffness = indent(profile, material, depth, law=law).stiffness
    np.testing.assert_allclose(slope, stiffness, rtol=1e-7)


@pytest.mark.parametrize("law", ["paper", "harmonic"])
@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_table_agrees_with_the_closed_multipliers(law, m):
    material, depth = HalfSpace.from_modulus(1.0, m), np.array([0.05, 0.2, 0.5])
    closed = indent(body(), material, depth, law=law)
    table = indent(tabulated(body()), material, depth, law=law)
    np.testing.assert_allclose(table.force, closed.force, rtol=1e-5)
    np.testing.assert_allclose(table.contact_area, closed.contact_area, rtol=2e-5)
    np.testing.assert_allclose(table.contour(TURN), closed.contour(TURN), rtol=1e-4)
    x = np.array([0.0, 0.05, 0.1])
    np.testing.assert_allclose(
        table.pressure(x, 0.02), closed.pressure(x, 0.02), rtol=1e-3, atol=1e-3
    )


def test_first_harmonic_is_a_shift_only_in_the_resolved_law():
    """A paraboloid about a point beside its summit: the spot is the same circle, moved."""
    eps, depth = 1e-4, 0.02
    shifted = PolynomialProfile({(1, 0): -2 * eps, (2, 0): 1.0, (0, 2): 1.0})
    one = indent(shifted, HalfSpace.from_modulus(1.0), depth)
    moved = (one.contour(0.0) - one.contour(np.pi)) / 2
    assert moved == pytest.approx(eps, rel=1e-3)
    assert indent(shifted, HalfSpace.from_modulus(1.0), depth, law="paper").contour(
        0.0
    ) - one.radius == pytest.approx(1.178 * eps, rel=1e-3)


@pytest.mark.parametrize("law", ["hertz", "paper", "harmonic"])
def test_load_control_inverts_the_force(law):
    material, depth = HalfSpace.from_modulus(3e9, 0.1), np.array([1e-3, 0.1, 0.4])
    for profile in (body(), tabulated(body())):
        force = indent(profile, material, depth, law=law).force
        again = indent(profile, material, load=force, law=law)
        np.testing.assert_allclose(again.approach, depth, rtol=1e-9)


def test_a_body_that_turns_over_has_no_solution_beyond():
    body = PowerSumProfile([2, 4], [1.0, -1.0])
    one = indent(body, HalfSpace.from_modulus(1.0), np.array([0.1, 10.0]))
    assert np.isfinite(one.force[0]) and np.isnan(one.force[1])
    assert one.flags[1] & Flag.TURNING and not one.valid[1]
    lost = indent(body, HalfSpace.from_modulus(1.0), 10.0)
    assert np.all(np.isnan(lost.contour(TURN))) and np.isnan(lost.pressure(0.1, 0.0))
    assert np.isnan(lost.pressure(0.1, 0.0, history=True))
    assert np.isnan(indent(body, HalfSpace.from_modulus(1.0), 10.0, law="hertz").error_estimate)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda b, m: indent(b, m), InputError, "either approach or load"),
        (lambda b, m: indent(b, m, 1.0, load=1.0), InputError, "either approach or load"),
        (lambda b, m: indent(b, m, np.nan), InputError, "approach is nan; it must be finite"),
        (lambda b, m: indent(b, m, "deep"), InputError, "it must be a number"),
        (lambda b, m: indent(b, m, 1j), InputError, "it must be a number"),
        (lambda b, m: indent(b, m, np.ones((2, 2))), InputError, r"has the shape \(2, 2\)"),
        (lambda b, m: indent("cone", m, 1.0), InputError, "profile must be one of surfaces"),
        (lambda b, m: indent(b, 1e9, 1.0), InputError, "HalfSpace is needed, not float"),
        (lambda b, m: indent(b, m, load=-1.0), InputError, "load must be positive"),
        (lambda b, m: indent(wavy(1), m, 0.1, law="hertz"), ModelRangeError, "has no curvature"),
        (
            lambda b, m: indent(PowerLawProfile(2, -1.0), m, 0.1),
            ModelRangeError,
            "does not rise from its summit",
        ),
        (
            lambda b, m: indent(PowerSumProfile([2, 4], [1.0, -1.0]), m, load=50.0),
            ModelRangeError,
            "reaches no load",
        ),
    ],
)
def test_unusable_requests_are_refused_in_one_sentence(call, error, message):
    with pytest.raises(error, match=message):
        call(body(), HalfSpace.from_modulus(1.0))


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_resolved_contour_encloses_the_contact_area(m):
    one = indent(body(), HalfSpace.from_modulus(1.0, m), np.array([0.05, 0.3]))
    fine = 2 * np.pi * np.arange(720) / 720
    np.testing.assert_allclose(
        np.pi * np.mean(one.contour(fine) ** 2, axis=1), one.contact_area, rtol=1e-8
    )


@pytest.mark.parametrize("law", ["hertz", "paper", "harmonic"])
def test_the_homogeneous_body_is_the_limit_of_graded_ones(law):
    forces = [
        float(indent(body(), HalfSpace.from_modulus(1.0, m), 0.2, law=law).force)
        for m in (-1e-6, 0.0, 1e-6)
    ]
    assert forces[0] == pytest.approx(forces[1], rel=1e-5)
    assert forces[0] + forces[2] == pytest.approx(2 * forces[1], rel=1e-11)
