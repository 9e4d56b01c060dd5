"""Closed forms for whole surfaces, by the functions and settings that a user meets first."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
import surfaces
from asperity import HalfSpace

MODULUS = 2e11
SPACING = (1e-6, 0.8e-6)


def bumps(shape, places, radii, heights=(0.0, 0.0)):
    """Paraboloids that meet in a valley, and no border near: places (y, x) [m]."""
    y, x = ((np.arange(n) + 0.5) * d for n, d in zip(shape, SPACING, strict=True))
    parts = [
        top - ((y[:, None] - at_y) ** 2 + (x - at_x) ** 2) / (2 * radius)
        for (at_y, at_x), radius, top in zip(places, radii, heights, strict=False)
    ]
    return surfaces.HeightMap(np.maximum.reduce(parts), SPACING)


def paraboloid(approach, radius, m):
    """Force [N] and contact radius [m] of a paraboloid on a graded half-space."""
    a = np.sqrt((1 + m) * radius * approach)
    return 4 * MODULUS * a ** (3 + m) / (radius * (1 + m) ** 2 * (3 + m)), a


@pytest.mark.parametrize("m", [0.0, 0.3, -0.3])
def test_every_output_of_one_bump(m):
    """Hertz and its graded form: force, radius, centre, peak pressure, stiffness, fields."""
    radius, place = 1e-3, (37.3e-6, 44.9e-6)
    hm = bumps((80, 120), [place], [radius])
    approach = np.array([1e-8, 3e-8, 1e-7])
    force, a = paraboloid(approach, radius, m)
    body = HalfSpace.from_modulus(MODULUS, m)
    run = asperity.solve_contacts(hm, body, separations=-approach - hm.heights.mean())
    curve = run.curve
    np.testing.assert_allclose(curve.load, force, rtol=2e-3)
    np.testing.assert_allclose(curve.contact_area, np.pi * a**2, rtol=2e-3)
    stiffness = 2 * MODULUS * a ** (1 + m) / (1 + m) / hm.area
    np.testing.assert_allclose(curve.stiffness, stiffness, rtol=5e-3)
    (contact,) = run.microcontacts()
    assert (contact["centre_y"], contact["centre_x"]) == pytest.approx(place, abs=1e-9)
    radii = [contact[f"radii_{i}"] for i in range(16)]
    np.testing.assert_allclose(radii, a[-1], rtol=2e-3)
    peak = 0.5 * (3 + m) * force[-1] / (np.pi * a[-1] ** 2)
    assert contact["peak_pressure"] == pytest.approx(peak, rel=5e-3)
    pressure, spots = run.pressure_map(), run.spots()
    assert pressure.mean() * hm.area == pytest.approx(curve.load[-1], rel=1e-9)
    assert pressure.max() == pytest.approx(peak, rel=0.05)
    assert np.array_equal(pressure > 0, run.contact_map())
    assert len(spots) == curve.contacts[-1] == 1
    assert spots["area"][0] == pytest.approx(curve.contact_area[-1], rel=1e-9)
    assert (spots["y"][0], spots["x"][0]) == pytest.approx(place, abs=0.2e-6)


@pytest.mark.parametrize("m", [0.0, 0.3, -0.3])
@pytest.mark.parametrize("aligned", [True, False])
def test_two_far_bumps_on_a_free_half_space(aligned, m):
    """Each is pressed by its paraboloid's law, lowered by the point force of the other."""
    radii, tops = (1e-3, 0.6e-3), (0.0, -2e-8)
    places = [(30.5e-6, 40e-6), (30.5e-6 if aligned else 60.5e-6, 180e-6)]
    hm = bumps((96, 280), places, radii, tops)
    body = HalfSpace.from_modulus(MODULUS, m)
    distance = np.hypot(*np.subtract(*places))
    shift = np.cos(0.5 * np.pi * m) / (np.pi * MODULUS * distance ** (1 + m))
    for depth in (3e-8, 1e-7):
        force = np.zeros(2)
        for _ in range(50):
            approach = depth + np.array(tops) - shift * force[::-1]
            force, _ = paraboloid(approach, np.array(radii), m)
        run = asperity.solve_contacts(hm, body, separations=[-depth - hm.heights.mean()])
        table = np.sort(run.microcontacts(), order="x")
        np.testing.assert_allclose(table["force"], force, rtol=5e-3)
        assert table["force"].sum() == pytest.approx(run.curve.load[0], rel=1e-12)
        assert run.curve.load[0] == pytest.approx(force.sum(), rel=2e-3)
