"""`asperity.indent` under a hardness, by every law."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity import HalfSpace
from asperity.errors import ModelRangeError
from asperity.microcontact.laws import LAWS
from asperity.microcontact.single import circle
from surfaces import PolarProfile, PolynomialProfile, PowerLawProfile, PowerSumProfile
from surfaces.shapes import polygon, rounded_polygon

BALL = PowerLawProfile(2.0, 0.5)
RIDGE = PolynomialProfile({(2, 0): 0.5, (0, 2): 1.5})
MIXED = PolynomialProfile({(2, 0): 0.5, (0, 2): 0.8, (4, 0): 0.2, (2, 2): 0.4, (0, 4): 0.2})
HARD = HalfSpace.from_modulus(1.0, hardness=0.2)
SHAPES = ["round", "curvatures 3:1", "steepening", "pyramid"]


@pytest.mark.parametrize("law", LAWS)
def test_every_law(law):
    """The round paraboloid, by approach and by load."""
    one = asperity.indent(BALL, HARD, np.array([-1.0, 0.09, 1.0]), law=law)
    exact = asperity.indent(BALL, HARD, one.approach, law="hertz")
    np.testing.assert_allclose(one.force, exact.force, rtol=1e-6)
    np.testing.assert_allclose(one.stiffness, exact.stiffness, rtol=1e-5)
    np.testing.assert_array_equal(one.saturated[:2], 0)
    assert np.all(np.diff(one.force[1:]) > 0) and np.all(np.diff(one.saturated[1:]) > 0)
    back = asperity.indent(BALL, HARD, load=one.force[2:], law=law)
    np.testing.assert_allclose(back.approach, one.approach[2:], rtol=1e-9)
    start = np.pi * 0.2 / 2
    np.testing.assert_allclose(
        one.first_yield, [start**2, 2 / 3 * np.pi * 0.2 * start**2], rtol=1e-6
    )


@pytest.mark.parametrize("law", ["auto", "harmonic", "hertz"])
def test_hard_enough_is_elastic_to_the_last_digit(law):
    depth = np.array([0.0, 0.1, 0.4])
    body = HalfSpace.from_modulus(1.0, hardness=1e3)
    bounded, free = (asperity.indent(MIXED, mat, depth, law=law) for mat in (body, body.elastic))
    for name in ("approach", "force", "contact_area", "stiffness", "flags"):
        np.testing.assert_array_equal(getattr(bounded, name), getattr(free, name))
    np.testing.assert_array_equal(bounded.pressure(0.1, 0.0), free.pressure(0.1, 0.0))
    assert free.first_yield == free.fully_plastic == (np.inf, np.inf)


@pytest.mark.parametrize("profile", [BALL, RIDGE, MIXED, polygon(4)], ids=SHAPES)
def test_curve(profile):
    """The stiffness is the slope of the curve; never above H A or the elastic force."""
    depth = np.array([0.05, 0.2, 0.6])
    step = 1e-3
    rows = [
        asperity.indent(profile, HARD, depth * np.exp(step * i), law="harmonic") for i in (-1, 0, 1)
    ]
    slope = (rows[2].force - rows[0].force) / (2 * step * depth)
    np.testing.assert_allclose(rows[1].stiffness, slope, rtol=2e-6)
    elastic = asperity.indent(profile, HARD.elastic, depth, law="harmonic")
    assert np.all(rows[1].force <= elastic.force * (1 + 1e-12))
    assert np.all(rows[1].contact_area >= elastic.contact_area * (1 - 1e-12))
    assert np.all(rows[1].force <= 0.2 * rows[1].contact_area)


@pytest.mark.parametrize("profile", [BALL, RIDGE, MIXED, polygon(4)], ids=SHAPES)
def test_pressure_is_bounded_and_carries_the_force(profile):
    one = asperity.indent(profile, HARD, 0.4, law="harmonic")
    x = np.linspace(-1.5, 1.5, 301)
    p = one.pressure(x, x[:, None])
    assert p.max() <= 0.2
    assert np.sum(p) * (x[1] - x[0]) ** 2 == pytest.approx(float(one.force), rel=0.01)


def test_fully_plastic():
    one = asperity.indent(BALL, HARD, 0.5, law="hertz")
    depth, force = one.fully_plastic
    there = asperity.indent(BALL, HARD, depth, law="hertz")
    assert there.force == pytest.approx(force)
    assert there.mean_pressure == pytest.approx(0.975 * 0.2)
    assert there.saturated == pytest.approx(0.95, abs=0.005)
    assert "saturated" in str(there) and "hardness 0.2" in str(there)


@pytest.mark.parametrize("curvature", [1e3, 1e6, 1e9])
def test_yielding_does_not_depend_on_the_unit_of_length(curvature):
    """Also of tips that are sharp on a scale of metres."""
    one, unit = (
        asperity.indent(PowerLawProfile(2.0, k / 2), HARD, 0.1 / k, law="hertz")
        for k in (curvature, 1.0)
    )
    scale = 1.0 / curvature, 1.0 / curvature**2
    for name in ("first_yield", "fully_plastic"):
        np.testing.assert_allclose(getattr(one, name), np.multiply(getattr(unit, name), scale))


def test_cones_yield_from_the_first_touch():
    """Their mean pressure is the same at every load."""
    cone = PowerLawProfile(1.0, 1.0)
    harder, softer = (
        asperity.indent(cone, HalfSpace.from_modulus(1.0, hardness=h), 0.3) for h in (0.5, 0.1)
    )
    assert harder.first_yield == softer.first_yield == softer.fully_plastic == (0.0, 0.0)
    assert harder.fully_plastic == (np.inf, np.inf)


def test_a_load_above_what_the_profile_carries_is_refused():
    r, phi = np.linspace(0, 1, 33), 2 * np.pi * np.arange(16) / 16
    profile = PolarProfile(r, phi, np.outer(r**2 / 2, np.ones(16)))
    carried = asperity.indent(profile, HARD, load=0.5, law="harmonic")
    assert carried.contact_area == pytest.approx(0.5 / 0.2, rel=0.01)
    with pytest.raises(
        ModelRangeError, match=r"more than the area of the profile carries .*0.6283"
    ):
        asperity.indent(profile, HARD, load=0.63)


@pytest.mark.parametrize(
    "profile",
    [BALL, PolynomialProfile({(2, 0): 0.5, (0, 2): 5.0}), MIXED, PowerLawProfile(4.0, 1.0)],
    ids=["round", "curvatures 10:1", "steepening", "r^4"],
)
@pytest.mark.parametrize("share", [0.5, 0.8, 1.1])
def test_boundary_elements_agree(profile, share):
    """Hardnesses below, near and above the mean elastic pressure."""
    depth = 0.4
    elastic = asperity.indent(profile, HARD.elastic, depth, law="auto")
    body = HalfSpace.from_modulus(1.0, hardness=share * float(elastic.mean_pressure))
    one = asperity.indent(profile, body, depth, law="auto")
    exact = asperity.indent_bem(profile, body, depth)
    assert exact.converged
    assert one.force == pytest.approx(float(exact.force), rel=0.02)
    there = asperity.indent(profile, body, load=float(exact.force), law="auto")
    assert there.contact_area == pytest.approx(float(exact.contact_area), rel=0.02)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_noise_of_the_expansion_ends_no_search(share):
    """Steps that only follow it were taken sixty times, and the approach refused."""
    tip = PowerSumProfile([1.0, 2.0], [rounded_polygon(3, 2.0).psi, 0.3])
    elastic = asperity.indent(tip, HalfSpace.from_modulus(1.0, 0.3), 0.01, law="auto")
    body = HalfSpace.from_modulus(1.0, 0.3, hardness=share * float(elastic.mean_pressure))
    found = asperity.indent(tip, body, np.array([0.003, 0.01]), law="auto")
    assert (found.force > 0.0).all() and found.force[1] < float(elastic.force)


@pytest.mark.parametrize("law", ["harmonic", "auto"])
@pytest.mark.parametrize("sides", [3, 4, 6])
def test_pressures_are_within_their_bounds_and_carry_the_force(sides, law):
    """Those of corners were multiplied from just below zero to -3e9 times the hardness, and zero on
    a sixth of the contact."""
    tip, mean = polygon(sides, scale=0.1), HalfSpace.from_modulus(1.0, -0.4)
    hardness = 0.3 * float(asperity.indent(tip, mean, 0.01, law=law).mean_pressure)
    body = HalfSpace.from_modulus(1.0, -0.4, hardness=hardness)
    one = asperity.indent(tip, body, 0.01, law=law)
    phi, share = np.meshgrid(2 * np.pi * np.arange(720) / 720, np.sqrt((np.arange(60) + 0.5) / 60))
    r = share * one.contour(phi[0])
    pressure = one.pressure(r * np.cos(phi), r * np.sin(phi))
    assert pressure.min() >= 0.0 and pressure.max() <= hardness
    carried = np.pi * np.mean(pressure.mean(axis=0) * one.contour(phi[0]) ** 2)
    assert carried == pytest.approx(float(one.force), rel=0.01)


def test_no_pressure_of_a_steep_body_exceeds_the_hardness():
    """Not where the model, late, expects no yielding yet."""
    steep = PowerLawProfile(10.0, 1.0)
    elastic = asperity.indent(steep, HalfSpace.from_modulus(1.0), 0.01)
    x = float(elastic.radius) * np.linspace(0.0, 0.999, 200)
    hardness = 0.83 * elastic.pressure(x, 0 * x).max()
    one = asperity.indent(steep, HalfSpace.from_modulus(1.0, hardness=hardness), 0.01)
    assert one.pressure(x, 0 * x).max() <= hardness


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1e3])
def test_a_load_gives_the_contact_of_its_approach_in_every_unit(size):
    """The search begins far from the contact, where the body has another power."""
    body = PowerSumProfile([2.0, 4.0], [1 / size, 1 / size**3])
    hard = HalfSpace.from_modulus(1.0, hardness=0.05)
    pressed = asperity.indent(body, hard, 0.01 * size)
    loaded = asperity.indent(body, hard, load=pressed.force)
    assert loaded.approach == pytest.approx(0.01 * size, rel=1e-6)


def test_each_contact_alone_tells_its_factor_once(monkeypatch):
    """The pressure of n contacts is taken n times for their factors, and n times at the point."""
    taken: list[float] = []

    def even(basis, material, contour, ratios, a, r, phi):
        taken.append(a)
        return np.ones(r.shape)

    monkeypatch.setattr(circle, "history", even)
    turn, r = np.pi / 4 * np.arange(8), np.linspace(0.0, 1.0, 9)
    table = PolarProfile(r, turn, np.outer(r**2, 1 + 0.09 * np.cos(2 * turn)))
    soft = HalfSpace.from_modulus(1.0, hardness=0.05)
    one = asperity.indent(table, soft, [0.02, 0.05, 0.1])
    for count in (6, 9):
        one.pressure(0.01, 0.0)
        assert len(taken) == count
