"""One microcontact by boundary elements: Hertz and its graded and elliptic relatives."""

from __future__ import annotations

import numpy as np
import pytest

from asperity import HalfSpace, errors, indent_bem
from asperity.microcontact import Flag
from surfaces import PolarProfile, PowerLawProfile

HERTZ = {-0.3: 6.0468631897, 0.0: 8.0 / 3.0, 0.5: 1.0158730159}
ELLIPSE = {
    -0.3: (1.6794704167, 0.1792193700, 0.4587518116, 4.6542113387),
    0.0: (2.1565156475, 0.3151532066, 0.8959028209, 4.1887902048),
    0.5: (2.7404681726, 0.5571280017, 1.8821902521, 3.5903916041),
}


@pytest.mark.parametrize("m", HERTZ)
def test_graded_hertz(m):
    """Force, area and contour of the paraboloid, for every grading."""
    found = indent_bem(
        PowerLawProfile(2.0, 1.0), HalfSpace.from_modulus(1.0, m), 2 / (1 + m), grid=96
    )
    assert found.valid and found.certificate.worst < 1e-6
    assert found.force == pytest.approx(HERTZ[m], rel=2e-4)
    assert found.contact_area == pytest.approx(np.pi, rel=0.01)
    assert found.contour(np.linspace(0, 6, 7)) == pytest.approx(np.ones(7), abs=0.02)
    centre = (3 + m) / 2 * HERTZ[m] / np.pi
    assert found.pressure(0.0, 0.0) == pytest.approx(centre, rel=0.005)
    assert found.pressure(0.5, 0.0) == pytest.approx(centre * 0.75 ** ((1 + m) / 2), rel=0.01)


@pytest.mark.parametrize("m", ELLIPSE)
def test_graded_ellipse(m):
    """Elliptic paraboloid, axes 2 and 1 (docs/development/half_space.md), the long one along x."""
    depth, a, b, force = ELLIPSE[m]
    profile = PowerLawProfile(2.0, lambda phi: a * np.cos(phi) ** 2 + b * np.sin(phi) ** 2)
    found = indent_bem(profile, HalfSpace.from_modulus(1.0, m), depth, grid=96)
    assert found.valid
    assert found.force == pytest.approx(force, rel=5e-4)
    assert found.contact_area == pytest.approx(2 * np.pi, rel=0.01)
    assert found.contour([0.0, np.pi / 2]) == pytest.approx([2.0, 1.0], rel=0.02)


def test_convergence_rate():
    """The error of the Hertz force falls at least with the 1.5th power of the pixel."""
    body, profile = HalfSpace.from_modulus(1.0), PowerLawProfile(2.0, 1.0)
    miss = [
        abs(indent_bem(profile, body, 2.0, grid=n, tolerance=1e-8).force / HERTZ[0.0] - 1)
        for n in (24, 48, 96)
    ]
    slope = np.polyfit(np.log([24, 48, 96]), np.log(miss), 1)[0]
    assert slope < -1.5


def test_several_approaches_and_scaling():
    """F ~ d^(3/2) for the paraboloid, and arrays keep their shape."""
    body = HalfSpace.from_modulus(1.0)
    found = indent_bem(PowerLawProfile(2.0, 1.0), body, [1e-9, 4e-9], grid=48)
    assert found.force.shape == found.contact_area.shape == found.converged.shape == (2,)
    assert found.force[1] / found.force[0] == pytest.approx(8.0, rel=1e-4)
    assert found.x.shape == found.y.shape == (48,)
    assert found.pressure_map.shape == (48, 48)
    assert found.contour([0.0, 1.0, 2.0]).shape == found.pressure([0.0] * 3, 0.0).shape == (2, 3)
    assert found.contour(0.0) == pytest.approx(found.radius, rel=0.05)
    assert found.pressure(0.0, 0.0)[1] / found.pressure(0.0, 0.0)[0] == pytest.approx(2, rel=0.01)


def test_a_contact_beyond_the_known_profile_is_flagged():
    r, phi = np.linspace(0, 1e-6, 12), 2 * np.pi * np.arange(8) / 8
    profile = PolarProfile(r, phi, np.outer(r**2, np.full(8, 1e5)))
    found = indent_bem(profile, HalfSpace.from_modulus(1e9), [1e-8, 5e-7], grid=32)
    assert found.converged.all()
    assert found.valid.tolist() == [True, False]
    assert found.flags.tolist() == [0, Flag.BEYOND_RADIUS]


@pytest.mark.parametrize(
    "approach, grid, words",
    [(0.0, 64, "positive"), (1.0, 4, "at least 16"), (1.0, 10**6, "of 1000000 x .* take fewer")],
)
def test_refusals(approach, grid, words):
    """Wrong approach or grid: one sentence."""
    body = HalfSpace.from_modulus(1.0)
    with pytest.raises(errors.InputError, match=words):
        indent_bem(PowerLawProfile(2.0, 1.0), body, approach, grid=grid)


@pytest.mark.parametrize("m", [-0.3, 0.4])
def test_load_control_finds_the_approach(m):
    from surfaces.shapes import bent_body

    body, mat = bent_body(curvature=1e5, size=1e-5), HalfSpace.from_modulus(2e9, m)
    pressed = indent_bem(body, mat, 3e-7, grid=64)
    loaded = indent_bem(body, mat, load=pressed.force, grid=64)
    assert loaded.converged
    assert loaded.force == pytest.approx(pressed.force, rel=1e-6)
    assert loaded.approach == pytest.approx(3e-7, rel=1e-4)
    with pytest.raises(errors.InputError, match="either approach or load"):
        indent_bem(body, mat)
    with pytest.raises(errors.InputError, match="load must be positive"):
        indent_bem(body, mat, load=-1.0)
