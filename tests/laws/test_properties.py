"""Laws that hold for any body: scalings, rotation, mirror, monotony, limits, extreme units."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import axisymmetric

from asperity import HalfSpace, indent
from asperity.microcontact import Flag
from asperity.microcontact.hertz import elliptic_contact
from asperity.microcontact.single.indent import SOLVERS
from surfaces import PolynomialProfile, PowerLawProfile, PowerSumProfile

LAWS = [*SOLVERS]
QUICK = ["hertz", "paper", "harmonic", "ellipse"]
TURN = 2 * np.pi * np.arange(24) / 24

pytestmark = pytest.mark.filterwarnings("error")

exponent = st.floats(-0.5, 0.8)
few = settings(max_examples=6, deadline=None, derandomize=True)


def summit(ratio=2.0, third=0.1, turn=0.0, mirror=1.0, length=1.0, height=1.0):
    """Paraboloid with a third harmonic and a quartic, turned, mirrored and scaled."""

    def term(k, psi):
        factor = height / length**k
        return lambda p: factor * psi(mirror * (p - turn))

    root = np.sqrt(ratio)
    return PowerSumProfile(
        [2.0, 3.0, 4.0],
        [
            term(2, lambda p: 0.5 * (np.cos(p) ** 2 / root + root * np.sin(p) ** 2)),
            term(3, lambda p: third * np.cos(3 * p + 0.4)),
            term(4, lambda p: 0.05 + 0 * p),
        ],
    )


@few
@given(m=exponent, length=st.floats(1e-9, 1e3), height=st.floats(1e-6, 1e3))
def test_lengths_and_heights_scale(m, length, height):
    """x -> s x, f -> z f: d -> z d, F -> z s^(1+m) F, A -> s^2 A, nanometres to kilometres."""
    material = HalfSpace.from_modulus(1e9, m)
    for law in QUICK:
        one = indent(summit(), material, 0.02, law=law)
        other = indent(summit(length=length, height=height), material, 0.02 * height, law=law)
        assert other.force == pytest.approx(height * length ** (1 + m) * one.force, rel=1e-6)
        assert other.contact_area == pytest.approx(length**2 * one.contact_area, rel=1e-5)
        assert other.flags == one.flags


@few
@given(m=exponent, turn=st.floats(0.1, 6.0), mirrored=st.booleans())
def test_rotation_and_mirror(m, turn, mirrored):
    """Turned and mirrored bodies have turned and mirrored contacts."""
    material = HalfSpace.from_modulus(1.0, m)
    sign = -1.0 if mirrored else 1.0
    for law in QUICK:
        one = indent(summit(), material, 0.05, law=law)
        other = indent(summit(turn=turn, mirror=sign), material, 0.05, law=law)
        assert other.force == pytest.approx(one.force, rel=1e-7)
        assert other.contact_area == pytest.approx(one.contact_area, rel=1e-6)
        np.testing.assert_allclose(other.contour(turn + sign * TURN), one.contour(TURN), rtol=2e-4)


@few
@given(m=exponent, third=st.floats(-0.15, 0.15), ratio=st.floats(1.0, 4.0))
def test_force_stiffness_and_area_rise_with_the_approach(m, third, ratio):
    material, depth = HalfSpace.from_modulus(1.0, m), np.array([0.01, 0.02, 0.05])
    for law in QUICK:
        one = indent(summit(ratio, third), material, depth, law=law)
        for values in (one.force, one.stiffness, one.contact_area):
            assert np.all(np.diff(values) > 0)
        power = np.log(one.force[1] / one.force[0]) / np.log(2.0)
        assert 1.0 <= power <= 3.0


@few
@given(m=exponent, raised=st.floats(0.02, 0.5))
def test_the_force_falls_when_the_gap_is_raised(m, raised):
    material = HalfSpace.from_modulus(1.0, m)
    low = summit()
    high = PowerSumProfile([2.0, 3.0, 4.0, 6.0], [*low.angular, lambda p: raised * (1 + np.cos(p))])
    for law in ("paper", "harmonic", "ellipse"):
        forces = [float(indent(body, material, 0.1, law=law).force) for body in (low, high)]
        assert forces[1] < forces[0]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("ratio", [30.0, 1000.0])
def test_extreme_ratios(law, ratio):
    """1000:1: exact, or marked; never a number that is not finite and not marked."""
    body = PolynomialProfile({(2, 0): 0.5 / np.sqrt(ratio), (0, 2): 0.5 * np.sqrt(ratio)})
    material = HalfSpace.from_modulus(1.0)
    one = indent(body, material, 0.01, law=law)
    exact = elliptic_contact(np.sqrt(ratio), 1 / np.sqrt(ratio), 0.01, material)
    error = abs(float(one.force / exact.force) - 1)
    if law == "hertz" or (law in ("ellipse", "auto") and ratio == 30.0):
        assert error < 1e-6 and one.flags == 0
    else:
        assert one.flags != 0 or error <= float(one.error_estimate) + 0.02
    assert np.isfinite(one.force) or one.flags & Flag.TURNING


@pytest.mark.parametrize("law", ["paper", "harmonic", "ellipse", "ritz", "auto"])
def test_near_flat_body(law):
    """r^50 is nearly a flat punch of radius 1: the contact fills it, the force is linear."""
    material, depth = HalfSpace.from_modulus(1.0), np.array([1e-3, 1e-2])
    one = indent(PowerLawProfile(50.0, 1.0), material, depth, law=law)
    radius, force = axisymmetric(50.0, depth)
    marked = (one.flags != 0) | (np.abs(one.force / force - 1) <= one.error_estimate + 1e-3)
    assert np.all(marked) and np.all(np.isfinite(one.force) | (one.flags > 0))
    if law in ("paper", "harmonic"):
        assert one.force == pytest.approx(force, rel=1e-6)
        assert one.radius == pytest.approx(radius, rel=1e-6)


@pytest.mark.parametrize("law", LAWS)
def test_nothing_at_no_approach(law):
    one = indent(summit(), HalfSpace.from_modulus(1.0), np.array([-1.0, 0.0]), law=law)
    for values in (
        one.force, one.contact_area, one.stiffness, one.mean_pressure, one.error_estimate
    ):  # fmt: skip
        assert np.all(values == 0)
    assert np.all(one.flags == 0)
    assert np.all(one.contour(TURN) == 0)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("size", [1e-9, 1e3])
def test_nanometres_and_kilometres(law, size):
    """Bodies of 1 nm and 1 km: the force scales, without warnings."""
    material = HalfSpace.from_modulus(1e9)
    one = indent(summit(), material, 0.02, law=law)
    other = indent(summit(length=size, height=size), material, 0.02 * size, law=law)
    assert other.force == pytest.approx(size**2 * one.force, rel=1e-5)
    assert other.flags == one.flags


@pytest.mark.parametrize("law", ["paper", "harmonic", "ellipse"])
@pytest.mark.parametrize("m", [-0.5, 0.8])
def test_limits_of_grading_and_tip(law, m):
    """Edges of the grading, and k = 1 as the limit of k -> 1 from either side."""
    material = HalfSpace.from_modulus(1.0, m)
    forces = [
        float(indent(PowerLawProfile(k, lambda p: 1 + 0.05 * np.cos(3 * p)), material, 0.1,
                     law=law).force)
        for k in (1 - 1e-6, 1.0, 1 + 1e-6)
    ]  # fmt: skip
    assert forces[0] == pytest.approx(forces[1], rel=1e-5)
    assert forces[0] + forces[2] == pytest.approx(2 * forces[1], rel=1e-7)
