"""Flat punches, partial slip, viscoelastic contact: closed forms and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from asperity import HalfSpace, InputError, ModelRangeError, indent
from asperity.extensions.conductance import total_resistivity
from asperity.extensions.partial_slip import partial_slip, tangential_modulus
from asperity.extensions.viscoelastic import Relaxation, viscoelastic_indent
from asperity.microcontact.single.punch import flat_punch
from surfaces import PolarProfile, PowerLawProfile
from surfaces.shapes import polygon

SPHERE = PowerLawProfile(2, 0.5)
STEEL = HalfSpace(210e9, 0.3)


@pytest.mark.parametrize("m", [-0.5, 0.0, 0.5, 0.8])
def test_round_punch_is_exact(m):
    a, material = 0.3, HalfSpace.from_modulus(2.0, m)
    punch = flat_punch(a, material)
    assert punch.stiffness == pytest.approx(4 * a ** (1 + m) / (1 + m), rel=1e-13)
    assert punch.pressure(0.0, 0.1) == pytest.approx(
        2 / np.pi * (a * a - 0.01) ** ((m - 1) / 2), rel=1e-12
    )
    assert punch.pressure([a, 1.01 * a], 0.0).tolist() == [np.inf, 0.0]
    assert np.all(punch.force([-1.0, 0.0, 2.0]) == [0.0, 0.0, 2 * punch.stiffness])


@pytest.mark.parametrize("b", [0.7, 2e-3, 2e-4])
def test_elliptic_punch_is_exact(b):
    """Stiffness of the elliptic punch, however slender: pi E* a / K(e)."""
    from scipy.special import ellipkm1

    a = 2.0
    punch = flat_punch(
        lambda phi: 1 / np.hypot(np.cos(phi) / a, np.sin(phi) / b), HalfSpace.from_modulus(1.0)
    )
    assert punch.contact_area == pytest.approx(np.pi * a * b, rel=1e-10)
    assert punch.stiffness == pytest.approx(np.pi * a / ellipkm1((b / a) ** 2), rel=1e-10)


def test_a_punch_that_is_next_to_a_line_is_refused():
    with pytest.raises(InputError, match="too slender"):
        flat_punch(lambda phi: 1 / np.hypot(np.cos(phi), 1e6 * np.sin(phi)), STEEL)


def test_square_punch_has_the_stiffness_of_the_theory():
    corners = polygon(4).corners
    punch = flat_punch(
        lambda phi: 1 / polygon(4).psi(phi), HalfSpace.from_modulus(1.0), corners=corners
    )
    assert punch.contact_area == pytest.approx(4.0, rel=1e-13)
    assert punch.stiffness / 2 == pytest.approx(1.1346, abs=5e-5)


def test_punch_without_its_origin_is_refused():
    with pytest.raises(InputError, match="must contain the origin"):
        flat_punch(lambda phi: np.cos(phi), HalfSpace.from_modulus(1.0))


def test_places_that_do_not_fit_together_are_refused():
    body = HalfSpace.from_modulus(1.0)
    for contact in (flat_punch(1.0, body), indent(SPHERE, body, 0.1)):
        with pytest.raises(InputError, match=r"shapes \(2,\) and \(3,\)"):
            contact.pressure(np.zeros(2), np.zeros(3))


@pytest.mark.parametrize(
    "edge", [None, "a", [], [[1.0, 2.0], [3.0, 4.0]], 1e-200, lambda phi: phi[:3]]
)
def test_an_unusable_planform_is_refused(edge):
    with pytest.raises(InputError):
        flat_punch(edge, HalfSpace.from_modulus(1.0))


def test_punch_of_a_function_that_is_constant():
    one = flat_punch(lambda phi: 0.3, HalfSpace.from_modulus(1.0))
    assert one.stiffness == pytest.approx(0.6, rel=1e-12)


def test_a_lifted_punch_has_no_pressure():
    punch = flat_punch(0.3, HalfSpace.from_modulus(1.0))
    assert punch.force(-1.0) == 0.0
    np.testing.assert_array_equal(punch.pressure([0.0, 0.3], 0.0, -1.0), 0.0)


@pytest.mark.parametrize("wrong", ["a", None, np.nan])
def test_fields_of_a_contact_refuse_what_is_no_number(wrong):
    material = HalfSpace.from_modulus(1.0)
    punch, one = flat_punch(0.3, material), indent(PowerLawProfile(2.0, 0.5), material, 0.01)
    for call in (punch.force, lambda d: punch.pressure(0.0, 0.0, d), one.contour):
        with pytest.raises(InputError, match="must be"):
            call(wrong)
    with pytest.raises(InputError, match="must be"):
        one.pressure(wrong, 0.0)


def test_tangential_modulus_of_equal_bodies():
    shear = 210e9 / 2.6
    assert tangential_modulus(STEEL, STEEL) == pytest.approx(2 * shear / 1.7)
    with pytest.raises(InputError, match="graded"):
        tangential_modulus(HalfSpace(1.0, 0.3, 0.2))
    with pytest.raises(InputError, match="needs E and nu"):
        tangential_modulus(HalfSpace.from_modulus(1.0))


@pytest.mark.parametrize("law", ["paper", "harmonic", "hertz"])
def test_sphere_under_partial_slip_is_cattaneo_mindlin(law):
    mu, ratio, depth = 0.3, 1.2, 0.02
    body = HalfSpace.from_modulus(5.0)
    whole = 4 / 3 * 5.0 * depth**1.5
    force = mu * whole * np.array([0.0, 0.2, 0.7, 1.0])
    slip = partial_slip(
        SPHERE, body, depth, friction=mu, modulus_ratio=ratio, tangential_force=force, law=law
    )
    rest = 1 - force / (mu * whole)
    a = np.sqrt(depth)
    np.testing.assert_allclose(slip.stick.radius, a * np.cbrt(rest), rtol=1e-9, atol=1e-12)
    edge = np.repeat(a * np.cbrt(rest)[:, None], 3, axis=1)
    np.testing.assert_allclose(slip.stick.contour([0.0, 1.0, 4.0]), edge, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(
        slip.displacement[:3],
        (mu * ratio * depth * (1 - rest ** (2 / 3)))[:3],
        rtol=1e-9,
        atol=1e-15,
    )
    assert slip.slipping.tolist() == [False, False, False, True]
    r = np.array([0.1, 0.6, 0.95]) * a
    p0, c = 2 * 5.0 * a / np.pi, a * np.cbrt(rest[1])
    expected = mu * p0 * np.sqrt(1 - (r / a) ** 2)
    expected -= mu * p0 * c / a * np.sqrt(np.maximum(1 - (r / c) ** 2, 0))
    np.testing.assert_allclose(slip.traction(r, 0.0)[1], expected, rtol=1e-9, atol=1e-14)


def test_displacement_and_force_control_agree():
    profile, body = polygon(5, 2.0, scale=0.5), HalfSpace.from_modulus(1.0)
    u = np.array([1e-4, 1e-3])
    one = partial_slip(profile, body, 0.02, friction=0.4, modulus_ratio=1.1, displacement=u)
    two = partial_slip(
        profile, body, 0.02, friction=0.4, modulus_ratio=1.1, tangential_force=one.tangential_force
    )
    np.testing.assert_allclose(two.displacement, u, rtol=1e-8)
    assert np.all(np.diff(one.stick_area) < 0)


def test_partial_slip_refuses_what_it_cannot_do():
    body = HalfSpace.from_modulus(1.0)
    with pytest.raises(InputError, match="homogeneous half-space"):
        partial_slip(
            SPHERE, HalfSpace.from_modulus(1.0, 0.1), 0.1, friction=0.3, modulus_ratio=1.0,
            displacement=0.1,
        )  # fmt: skip
    with pytest.raises(ModelRangeError, match=r"normal force of [\d.]+ N: the contact slides"):
        partial_slip(SPHERE, body, 0.1, friction=0.3, modulus_ratio=1.0, tangential_force=1.0)
    with pytest.raises(InputError, match="either displacement or"):
        partial_slip(SPHERE, body, 0.1, friction=0.3, modulus_ratio=1.0)


def test_maxwell_sphere_relaxes_and_creeps_as_known():
    maxwell = Relaxation(0.0, [4.0], [2.0])
    for before in (-1e-9, [0.0, -1.0]):
        with pytest.raises(InputError, match="times after the step"):
            maxwell(before)
    t = np.linspace(0, 6, 13)
    held = viscoelastic_indent(SPHERE, maxwell, t, np.full(t.size, 0.01))
    np.testing.assert_allclose(held.force, 4 / 3 * 0.01**1.5 * 4 * np.exp(-t / 2), rtol=1e-12)
    late = viscoelastic_indent(SPHERE, maxwell, 20 * t, np.full(t.size, 0.01))
    np.testing.assert_allclose(late.force, held.force[0] * np.exp(-10 * t), rtol=1e-12)
    creeping = viscoelastic_indent(SPHERE, maxwell, t, load=np.full(t.size, 0.02))
    expected = (0.75 * 0.02 / 4 * (1 + t / 2)) ** (2 / 3)
    np.testing.assert_allclose(creeping.approach, expected, rtol=1e-9)


def test_standard_solid_creeps_to_its_equilibrium():
    solid = Relaxation(1.0, [3.0], [2.0])
    t = np.append(np.linspace(0, 10, 101), np.linspace(10.2, 60, 80))
    load = np.full(t.size, 0.02)
    found = viscoelastic_indent(SPHERE, solid, t, load=load, law="paper")
    creep = 1 - 0.75 * np.exp(-t / 8)
    np.testing.assert_allclose(found.approach, (0.75 * 0.02 * creep) ** (2 / 3), rtol=4e-4)
    again = viscoelastic_indent(SPHERE, solid, t, found.approach, law="paper")
    np.testing.assert_allclose(again.force, load, rtol=1e-8)


def test_slow_and_fast_loading_are_elastic():
    profile, solid = polygon(4, 1.0), Relaxation(1.0, [3.0], [2.0])
    for factor, modulus in ((1e6, 1.0), (1e-6, 4.0)):
        t = np.linspace(0, factor, 50)
        found = viscoelastic_indent(profile, solid, t, np.linspace(0, 0.1, 50), law="paper")
        expected = modulus * found.elastic.force[-1]
        assert found.force[-1] == pytest.approx(expected, rel=1e-4)


def test_a_shrinking_contact_is_refused():
    with pytest.raises(ModelRangeError, match="would shrink"):
        viscoelastic_indent(SPHERE, Relaxation(1.0, [], []), [0.0, 1.0], [0.2, 0.1])


def bent_down():
    """A hill that becomes flatter and falls, so that laws end before 0.6."""
    r, phi = np.linspace(0.0, 1.0, 40), 2 * np.pi * np.arange(64) / 64
    slope = (r**2 * (1 - 0.9 * r**2))[:, None]
    return PolarProfile(r, phi, slope * (1 + 0.2 * np.cos(2 * phi)))


@pytest.mark.parametrize("depth", [1e-6, 1e-5, 3e-4, 1e-2])
def test_next_to_no_push_moves_nothing_backwards(depth):
    """Rounding left forces and displacements of the wrong sign, and another force than given."""
    case = {"friction": 0.3, "modulus_ratio": 1.2}
    body = HalfSpace.from_modulus(1.0)
    force = np.array([0.0, 1e-30, 1e-25])
    one = partial_slip(bent_down(), body, depth, tangential_force=force, **case)
    np.testing.assert_allclose(one.tangential_force, force, rtol=1e-12)
    assert (one.displacement >= 0).all()
    other = partial_slip(bent_down(), body, depth, displacement=force, **case)
    assert (other.tangential_force >= 0).all()


def test_a_contact_without_a_solution_does_not_slip():
    """It was said to slip, at a force of NaN."""
    for push in ({"displacement": 0.0}, {"tangential_force": 0.0}):
        with pytest.raises(ModelRangeError, match=r"no solution at an approach of 0\.6 m"):
            partial_slip(
                bent_down(), HalfSpace.from_modulus(1.0), 0.6, friction=0.3, modulus_ratio=1, **push
            )


def test_a_body_that_does_not_relax_has_a_modulus_at_every_time():
    assert Relaxation(2.0, [], [])([0.0, 1.0, 5.0]).tolist() == [2.0, 2.0, 2.0]


def test_numbers_without_powers_are_refused():
    """They ended in a division by zero, NaN and warnings of NumPy."""
    t, d = [0.0, 1.0], [0.01, 0.01]
    for numbers in ((0.0, [1e308, 1e308], [1.0, 2.0]), (1.0, [1.0], [1e300]), (1e-300, [], [])):
        with pytest.raises(InputError, match="give numbers from 1e-100 to 1e"):
            Relaxation(*numbers)
    solid = Relaxation(1.0, [3.0], [2.0])
    for wrong in (
        lambda: solid(1e308),
        lambda: viscoelastic_indent(SPHERE, solid, [-1e308, 1e308], d),
        lambda: viscoelastic_indent(SPHERE, Relaxation(1e90, [], []), t, load=[1e-20, 1e-20]),
        lambda: partial_slip(
            SPHERE, STEEL, 0.01, friction=1e-100, modulus_ratio=1e-100, displacement=1e300
        ),
        lambda: total_resistivity((1e308, 1e308)),
        lambda: total_resistivity((1e-320, 0.0)),
    ):
        with pytest.raises(InputError, match="give numbers from 1e-100 to 1e"):
            wrong()
    arms = Relaxation(0.0, [1e100, 1e-100], [1e-100, 1e100])
    assert np.isfinite(
        viscoelastic_indent(SPHERE, arms, [0.0, 1e-100, 1e100], [0.01] * 3).force
    ).all()
