"""Rough surfaces under a hardness: both limits, bounds, order, units, and boundary elements."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import broad

import asperity
import surfaces
from asperity.halfspace.scene import area_over_pressure, default_pressures

LOADS = np.array([5e-3, 2e-2, 8e-2])
"""Area fractions, about."""


def smooth(seed=3, **more):
    size = (160e-6, 192e-6)
    return surfaces.self_affine(
        (160, 192), size, hurst=0.8, rms_slope=0.1, rolloff=45e-6, cutoff=8e-6, seed=seed, **more
    )


def body(hardness, modulus=2e11, m=0.0):
    return asperity.HalfSpace.from_modulus(modulus, m, hardness=hardness)


def curve(hm, material, **options):
    pressures = LOADS / area_over_pressure(hm, material)
    return asperity.contact_curve(hm, material, pressures=pressures, **options)


def bearing(hm, level):
    """Share of the surface above a level over its mean plane."""
    fine = surfaces.resample(hm, np.asarray(hm.spacing) / 4).heights
    return np.mean(fine - fine.mean() > level)


@pytest.mark.parametrize("hm", [smooth(), broad()], ids=["smooth", "fine waves"])
def test_a_hardness_that_is_not_reached_changes_nothing(hm):
    elastic = curve(hm, body(np.inf))
    hard = asperity.contact_curve(hm, body(1e18), pressures=elastic.mean_pressure)
    np.testing.assert_allclose(hard.separation, elastic.separation, rtol=5e-3)
    np.testing.assert_allclose(hard.area_fraction, elastic.area_fraction, rtol=1e-2)
    assert not hard.extra["plastic_share"].any() or hard.extra["plastic_share"].max() < 1e-9


@pytest.mark.parametrize("hm", [smooth(), broad()], ids=["smooth", "fine waves"])
def test_a_soft_body_is_pressed_as_its_bearing_curve_tells(hm):
    material = body(1e-4 * 0.1 * 2e11)
    found = curve(hm, material)
    np.testing.assert_allclose(found.area_fraction, LOADS, rtol=0.02)
    share = [bearing(hm, separation) for separation in found.separation]
    np.testing.assert_allclose(share, LOADS, rtol=0.1)
    assert (found.extra["plastic_share"] > 0.9).all()


@pytest.mark.parametrize("scales", ["auto", "all"])
def test_a_soft_body_carries_the_lightest_loads_at_its_hardness(scales):
    """Near the tip its contacts kept their area as a punch does: 11 times the load over hardness at
    a millionth of the hardness, 1e9 times at 1e-14."""
    hm, material = smooth(), body(1e-4 * 0.1 * 2e11)
    pressures = np.geomspace(1e-14, 1e-4, 6) * material.hardness
    found = asperity.contact_curve(hm, material, pressures=pressures, scales=scales)
    assert found.converged.all()
    np.testing.assert_allclose(found.area_fraction * material.hardness, pressures, rtol=0.02)
    assert (np.diff(found.separation) < 0).all()


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.3])
def test_the_area_carries_the_load_and_grows_as_the_body_gets_softer(m):
    hm = smooth()
    scale = 1.0 / area_over_pressure(hm, body(np.inf, 2e11, m))
    pressures = LOADS * scale * 0.05
    hardnesses = scale * np.array([0.05, 0.2, 0.6, 2.0, np.inf])
    curves = [asperity.contact_curve(hm, body(h, 2e11, m), pressures=pressures) for h in hardnesses]
    for found, hardness in zip(curves, hardnesses, strict=True):
        assert found.converged.all()
        assert (found.area_fraction >= pressures / hardness * (1 - 1e-9)).all()
    areas = np.array([found.area_fraction for found in curves])
    heights = np.array([found.separation for found in curves])
    assert (np.diff(areas, axis=0) <= 0.01 * areas[1:]).all()
    assert (np.diff(heights, axis=0) >= -1e-3 * hm.rms_height).all()
    assert (areas[0] > 2 * areas[-1]).all()


def test_units_and_modulus_scale():
    hm = smooth()
    first = curve(hm, body(5e9))
    larger = hm.replace(heights=hm.heights * 1e3, spacing=tuple(1e3 * s for s in hm.spacing))
    second = curve(larger, body(5.0, 2e2))
    np.testing.assert_allclose(second.area_fraction, first.area_fraction, rtol=1e-3)
    np.testing.assert_allclose(second.separation, 1e3 * first.separation, rtol=1e-3)


def test_default_loads_reach_a_tenth_of_contact_at_any_hardness():
    hm = smooth()
    for hardness in (1e8, 2e9, 2e10, np.inf):
        loads = default_pressures(hm, body(hardness))
        assert loads[-1] < hardness
        area = asperity.contact_curve(hm, body(hardness), pressures=loads[[0, -1]]).area_fraction
        np.testing.assert_allclose(area, [1e-3, 1e-1], rtol=0.7)


def test_more_than_the_hardness_is_refused():
    with pytest.raises(asperity.InputError, match=r"above the hardness.*smaller load"):
        asperity.contact_curve(smooth(), body(1e9), pressures=[1e8, 1.5e9])


def test_the_plan_tells_what_the_hardness_means():
    hm = smooth()
    plan = asperity.make_plan(hm, body(np.inf))
    assert any("metals yield" in warning for warning in plan.warnings)
    assert str(plan).count("metals yield") == 1
    hard = asperity.make_plan(hm, body(2e9))
    assert not any("metals" in warning for warning in hard.warnings)
    assert any(reason.startswith("hardness: 2e+09 Pa") for reason in hard.reasons)
    rubber = asperity.make_plan(hm, body(np.inf, 2e6))
    assert not any("metals" in warning for warning in rubber.warnings)


def test_a_sweep_gives_the_curves_of_each_hardness():
    hm, loads = broad(), np.array([1e6, 4e6])
    hardnesses = [5e8, np.inf, 2e8]
    swept = asperity.hardness_sweep(hm, body(np.inf, 2e9), hardnesses, pressures=loads)
    for found, hardness in zip(swept, hardnesses, strict=True):
        alone = asperity.contact_curve(hm, body(hardness, 2e9), pressures=loads)
        np.testing.assert_allclose(found.separation, alone.separation, rtol=2e-3)
        np.testing.assert_allclose(found.area_fraction, alone.area_fraction, rtol=2e-3)
    with pytest.raises(asperity.InputError, match="at least one hardness"):
        asperity.hardness_sweep(hm, body(np.inf), [])


def test_spots_that_have_yielded_conduct_by_their_areas():
    hm = smooth()
    elastic, soft = (curve(hm, body(h)) for h in (np.inf, 2e8))
    rho = (1e-7, 1e-7)
    by_area = asperity.constriction_conductance(soft, resistivity=rho)
    at_first = asperity.constriction_conductance(elastic, resistivity=rho)
    assert (by_area > 0.5 * at_first).all() and (by_area < at_first).all()
    # one spot of the whole area would conduct least, spots far apart most
    spots = soft.contacts * np.sqrt(soft.contact_area / soft.contacts / np.pi)
    assert (by_area * hm.area < 4 * spots / sum(rho) * 1.3).all()
    assert (soft.extra["unloading_stiffness"] > 2 * soft.extra["tangent_stiffness"]).all()
    solved = asperity.bem_curve(hm, body(2e8), pressures=soft.mean_pressure)
    exact = asperity.constriction_conductance(solved, resistivity=rho)
    np.testing.assert_allclose(by_area, exact, rtol=0.1)


@pytest.mark.parametrize("engine", ["model", "anchored"])
def test_a_falling_load_is_never_softer_than_a_rising_one(engine):
    """The stiffness of a rising load is corrected along the curve and by anchors: by up to 6 % it
    was the larger."""
    recipe = {"hurst": 0.8, "rms_slope": 0.1, "cutoff": 12e-6, "rolloff": 128e-6 / 3}
    hm = surfaces.self_affine((128, 128), (128e-6, 128e-6), seed=9, **recipe)
    material = body(2e11)
    pressures = np.geomspace(5e-4, 0.1, 9) / area_over_pressure(hm, material)
    if engine == "model":
        found = asperity.contact_curve(hm, material, pressures=pressures)
    else:
        choice = {"engine": engine, "accuracy": 0.1, "area_accuracy": 0.2}
        found = asperity.solve(hm, material, pressures=pressures, **choice)
        assert found.settings["engine"] == "anchored"
    assert (found.extra["unloading_stiffness"] >= found.stiffness).all()


def test_a_hardness_leaves_the_doubt_of_steps():
    """Nearly all of the area of the model is plastic, but it does not know that of single steps."""
    waves = surfaces.self_affine(
        (128, 128), (1e-5, 1e-5), hurst=0.8, rms_height=1e-7, cutoff=6e-7, seed=3
    )
    hm = waves.replace(heights=np.round(waves.heights / 3e-8) * 3e-8)
    soft = body(1e9 * 0.02 * hm.roughness.rms_slope, modulus=1e9)
    loads = default_pressures(hm, soft, 4)
    curve = asperity.contact_curve(hm, soft, pressures=loads)
    true = asperity.bem_curve(hm, soft, pressures=loads, accuracy=0.02)
    off = np.abs(np.log(curve.contact_area / true.contact_area))
    assert curve.extra["plastic_share"].min() > 0.9
    assert off.max() > 0.2  # the case tells something
    assert (off <= curve.extra["area_error_estimate"]).all()


def test_flat_tops_that_have_not_yielded_keep_their_area():
    """One small contact that had, and all large ones were pressed by elements: areas fell to a
    quarter, and with the load."""
    hm = surfaces.self_affine(
        (96, 96), (96e-6, 96e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6, rolloff=24e-6, seed=6
    )
    hm = hm.replace(heights=np.minimum(hm.heights, 1.2 * hm.heights.std()))
    loads = np.geomspace(2e4, 2e5, 8)
    soft, elastic = (
        asperity.contact_curve(
            hm, asperity.HalfSpace.from_modulus(1e9, hardness=hardness), pressures=loads
        )
        for hardness in (2e7, np.inf)
    )
    assert (np.diff(soft.contact_area) > 0.0).all()
    assert (soft.contact_area > 0.9 * elastic.contact_area).all()
