"""The stiffness of a contact of boundary elements as its load begins to grow, and to fall."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import rough

from asperity import HalfSpace, bem_curve, bem_solve
from asperity.bem import correction
from surfaces import HeightMap

BODY = HalfSpace.from_modulus(1.0)
HM = rough((48, 60))
SCALE = HM.roughness.rms_slope
"""E* times the rms slope of the map."""


def body(hardness: float, m: float = 0.0) -> HalfSpace:
    """Half-space whose hardness is given over E* h'."""
    return HalfSpace.from_modulus(1.0, m, hardness=hardness * SCALE)


def ball(n: int) -> HeightMap:
    """A paraboloid of radius 1e4 pixels."""
    y, x = np.mgrid[-n : n + 1, -n : n + 1]
    return HeightMap(-(x**2 + y**2) / 2e4, (1.0, 1.0))


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize(
    "mat", [BODY, HalfSpace.from_modulus(1.0, 0.4), body(0.3), body(0.3, -0.3)]
)
@pytest.mark.parametrize("pressure", [0.01, 0.1])
def test_stiffness_is_the_slope_of_the_curve(boundary, mat, pressure):
    """Also that of a load solved alone; what has reached the hardness bears no more."""
    loads = pressure * SCALE * np.array([0.9999, 1.0, 1.0001])
    options = {"boundary": boundary, "tolerance": 1e-11}
    low, high = bem_curve(HM, mat, pressures=loads[[0, 2]], **options).separation
    alone = bem_curve(HM, mat, pressures=loads[1:2], **options)
    assert alone.stiffness[0] == pytest.approx((loads[2] - loads[0]) / (low - high), rel=0.01)


def test_stiffness_by_the_work_of_a_curve():
    """What the load does is stored."""
    curve = bem_curve(HM, BODY, pressures=np.linspace(0.02, 0.05, 7) * SCALE, tolerance=1e-8)
    fall = np.gradient(curve.extra["elastic_energy"] / HM.area, curve.mean_pressure)
    np.testing.assert_allclose(
        fall[1:-1], curve.mean_pressure[1:-1] / curve.stiffness[1:-1], rtol=0.04
    )


@pytest.mark.parametrize("hardness", [np.inf, 1e3])
def test_stiffness_of_a_sphere_is_that_of_its_circle(hardness):
    """2 E* a (Johnson 1985, section 3.3), with the radius of Hertz, loading and unloading."""
    hm, mat = ball(40), HalfSpace.from_modulus(1.0, hardness=hardness * SCALE)
    force = np.array([12.0, 24.0]) ** 3 * 4 / 3 * BODY.modulus / 1e4
    curve = bem_curve(hm, mat, pressures=force / hm.area)
    found = [curve.stiffness, curve.extra.get("unloading_stiffness", curve.stiffness)]
    for stiff in found:
        np.testing.assert_allclose(stiff * hm.area, 2 * np.array([12, 24]), rtol=0.02)


def test_what_bears_the_hardness_does_not_stiffen_a_growing_load():
    """Up to none that does, where both are the same."""
    soft, hard = (bem_curve(HM, body(x), pressures=[0.06 * SCALE]) for x in (0.2, 30.0))
    unloading = [curve.extra["unloading_stiffness"][0] for curve in (soft, hard)]
    assert soft.stiffness[0] < 0.5 * unloading[0]
    assert hard.stiffness[0] == pytest.approx(unloading[1], rel=1e-6)


@pytest.mark.parametrize(("pressure", "found"), [(0.0, 0.0), (10.0, np.inf)])
@pytest.mark.parametrize("hardness", [np.inf, 30.0])
def test_stiffness_without_contact_and_all_over(pressure, found, hardness):
    curve = bem_curve(HM, body(hardness), pressures=[pressure * SCALE])
    assert curve.converged.all() and curve.stiffness[0] == found
    assert curve.extra.get("unloading_stiffness", curve.stiffness)[0] == found
    assert np.isfinite(curve.error_estimate[0])


def test_contacts_that_all_bear_the_hardness_have_no_stiffness():
    """Until others touch; single pixels bear the hardness at once, and bear no more."""
    hm = HeightMap(np.eye(16) * np.linspace(1.0, 2.0, 16), (1.0, 1.0), periodic=True)
    mat = HalfSpace.from_modulus(1.0, hardness=1e-3)
    curve = bem_curve(hm, mat, pressures=[4e-3 / 256])
    assert curve.converged[0] and curve.extra["plastic_share"][0] == 1.0
    assert curve.stiffness[0] == 0.0 < curve.extra["unloading_stiffness"][0]


def test_a_load_that_is_not_solved_has_no_stiffness(monkeypatch):
    monkeypatch.setattr(correction, "_MAX_CORRECTIONS", 1)
    curve = bem_curve(HM, body(0.3), pressures=[0.01 * SCALE, 0.1 * SCALE])
    assert not curve.converged.any() and np.isnan(curve.stiffness).all()
    assert np.isnan(curve.extra["unloading_stiffness"]).all()
    assert np.isnan(bem_solve(HM, BODY, pressure=0.1 * SCALE).stiffness)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_unloading_stiffness_is_that_of_the_unloaded_surface(boundary):
    """The load that the surface left behind gives back, as the flat is lifted a little."""
    mat, p = body(0.3), 0.06 * SCALE
    options = {"boundary": boundary, "tolerance": 1e-9}
    stiffness = bem_curve(HM, mat, pressures=[p], **options).extra["unloading_stiffness"][0]
    left = bem_solve(HM, mat, pressure=p, **options).unloaded()
    loads = np.array([0.998, 1.0]) * p
    one, two = (bem_solve(left, BODY, pressure=load, **options).separation for load in loads)
    assert stiffness == pytest.approx(np.diff(loads)[0] / (one - two), rel=0.01)
