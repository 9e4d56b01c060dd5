"""The number of spots: two summits that join, boundary elements, and what must not matter."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
import surfaces
from asperity.halfspace.scene import pressure_scale
from surfaces import HeightMap, self_affine

BODY = asperity.HalfSpace.from_modulus(2e11)


def rough(cutoff: float | None, shape=(160, 192), seed=4, hurst=0.8) -> HeightMap:
    """Pixels of 1 by 0.8 um; the shortest wave in um."""
    size = (shape[0] * 1.0e-6, shape[1] * 0.8e-6)
    shortest = cutoff and cutoff * 1e-6
    return self_affine(
        shape, size, hurst=hurst, rms_slope=0.1, rolloff=0.3 * size[0], cutoff=shortest, seed=seed
    )


def test_two_summits_join_where_boundary_elements_have_them_join():
    """A double well of summit curvature 1/R and passes c^2 / 8 R deep, between walls."""
    n, step, radius, apart = 121, 1e-6, 1e-3, 40e-6
    x, y = (np.arange(n) - n // 2) * step, (np.arange(n - 20) - n // 2 + 10) * step
    depth = apart**2 / (32 * radius)
    u = 2 * x / apart
    hm = HeightMap(-(depth * (u**2 - 1) ** 2) - (y**2 / (2 * radius))[:, None], (step, step))
    steps = depth * np.array([0.5, 1.0, 1.4, 2.2, 3.0])
    top = float(hm.heights.max() - hm.heights.mean())
    curve = asperity.contact_curve(hm, BODY, separations=top - 1.4 * steps)
    exact = [asperity.bem_solve(hm, BODY, pressure=p).contacts for p in curve.mean_pressure]
    assert exact[0] == 2 and exact[-1] == 1
    assert curve.contacts[0] == 2 and curve.contacts[-1] == 1
    assert (np.diff(curve.contacts) <= 0).all()
    assert abs(np.argmin(curve.contacts) - np.argmin(exact)) <= 1


@pytest.mark.parametrize("cutoff", [4, 8, 20])
def test_as_many_as_boundary_elements_find(cutoff):
    hm = rough(cutoff)
    loads = np.array([1e-2, 4e-2, 8e-2]) * pressure_scale(hm, BODY)
    curve = asperity.contact_curve(hm, BODY, pressures=loads)
    refined = surfaces.resample(hm, np.asarray(hm.spacing) / 2)
    exact = [asperity.bem_solve(refined, BODY, pressure=p, tolerance=1e-3).contacts for p in loads]
    np.testing.assert_allclose(curve.contacts, exact, rtol=0.2, atol=2)


@pytest.mark.parametrize("hurst", [0.8, 0.5])
def test_fine_waves_part_contacts_as_boundary_elements_do(hurst):
    hm = rough(None, (240, 288), hurst=hurst)
    loads = np.array([5e-3, 2e-2, 8e-2]) * pressure_scale(hm, BODY)
    curve = asperity.contact_curve(hm, BODY, pressures=loads)
    assert curve.settings["shortest_wave"] is not None
    exact = [asperity.bem_solve(hm, BODY, pressure=p, tolerance=1e-3).contacts for p in loads]
    np.testing.assert_allclose(curve.contacts, exact, rtol=0.3)


@pytest.mark.parametrize("m", [0.0, 0.3])
def test_units_do_not_matter(m):
    hm = rough(None, (240, 288))
    stretch = 1e3
    large = HeightMap(stretch * hm.heights, tuple(stretch * d for d in hm.spacing), periodic=True)
    first, other = (asperity.HalfSpace.from_modulus(modulus, m) for modulus in (2e11, 3.0))
    load = np.array([2e-3, 2e-2]) * pressure_scale(hm, first)
    one = asperity.contact_curve(hm, first, pressures=load)
    scale = 3.0 / 2e11 * stretch**m
    two = asperity.contact_curve(large, other, pressures=scale * load)
    np.testing.assert_array_equal(one.contacts, two.contacts)


def test_none_without_load_and_no_more_than_contacts_where_every_summit_is_one():
    hm = rough(8)
    loads = np.array([0.0, 1e-6, 1e-3, 3e-2]) * pressure_scale(hm, BODY)
    curve = asperity.contact_curve(hm, BODY, pressures=loads, scales="all")
    assert curve.contacts[0] == 0 and (curve.contacts[1:] >= 1).all()
    assert (curve.contacts <= curve.extra["microcontacts"]).all()


def test_a_separation_is_found_past_points_that_are_refused():
    """White noise of a body that yields: the fine waves lift the flat so far that the first guess
    of its separation from the longer ones closes more than half of the map, or all of it."""
    hm = HeightMap(np.random.default_rng(0).normal(size=(96, 96)), 5.0, periodic=True)
    body = asperity.HalfSpace.from_modulus(1.0, hardness=0.15)
    loads = pressure_scale(hm, body) * np.array([0.01, 0.03])
    curve = asperity.contact_curve(hm, body, pressures=loads)
    alone = asperity.contact_curve(hm, body, separations=curve.separation[1:])
    assert alone.converged.all(), alone.reasons
    assert alone.area_fraction == pytest.approx(curve.area_fraction[1:], rel=0.01)
    deep = [*curve.separation, 0.3 * curve.separation[1]]
    assert asperity.contact_curve(hm, body, separations=deep).converged.tolist() == [1, 1, 0]
