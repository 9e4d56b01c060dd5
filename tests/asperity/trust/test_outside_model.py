"""Contacts that no law describes, or that the map does not resolve, are within what is stated."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity.errors import ModelRangeError
from asperity.halfspace.scene import default_pressures, pressure_scale
from asperity.parameters import DEFAULTS
from asperity.trust.error_estimate import OUTSIDE_MODEL, terms
from surfaces import HeightMap, PowerLawProfile, resample, self_affine

BODY = asperity.HalfSpace.from_modulus(1e11)
SHAPE, SPACING = (72, 90), (1.5e-6, 1e-6)
LY, LX = SHAPE[0] * SPACING[0], SHAPE[1] * SPACING[1]
Y, X = ((np.indices(SHAPE)[axis] + 0.5) * SPACING[axis] for axis in (0, 1))


def waves(periodic=True):
    """Waves of 8 pixels and more."""
    return self_affine(
        SHAPE, (LY, LX), hurst=0.8, rms_slope=0.1, rolloff=5e-5, cutoff=12e-6, seed=5
    ).replace(periodic=periodic)


def test_a_single_wave_touches_along_all_of_its_ridge():
    hm = HeightMap(1e-7 * np.cos(2 * np.pi * X / LX), SPACING, periodic=True)
    flat = np.pi * BODY.modulus * 1e-7 / LX  # Westergaard: this pressure closes it
    run = asperity.solve_contacts(hm, BODY, pressures=np.array([0.01, 0.05]) * flat)
    curve, states = run.curve, [point.state for point in run.points]
    exact = 2 / np.pi * np.arcsin(np.sqrt([state.mean_pressure / flat for state in states]))
    area = [point.surface.contact_area / hm.area for point in run.points]
    np.testing.assert_allclose(area, exact, rtol=0.15)
    assert not curve.converged.any() and all("overlap end to end" in why for why in curve.reasons)
    for point in run.points:
        assert terms(run.decomposition, point, 0.0)["flat_tops"] == pytest.approx(1.0)
    assert np.isnan(curve.error_estimate).all()  # of such a lay it is not known


def test_the_area_of_tops_cut_off_is_within_the_stated_error_of_the_plateaus():
    hm = waves()
    top = hm.rms_height
    cut = HeightMap(np.minimum(hm.heights, top), SPACING, periodic=True)
    curve = asperity.contact_curve(cut, BODY, pressures=default_pressures(cut, BODY, 4)[:2])
    plateaus = np.mean(cut.heights == top)  # a flat punch touches all over at once
    wrong = np.abs(curve.area_fraction / plateaus - 1)
    assert (wrong <= curve.extra["area_error_estimate"]).all()
    curve = asperity.contact_curve(cut, BODY, pressures=default_pressures(cut, BODY, 4)[2:])
    reference = asperity.bem_curve(cut, BODY, pressures=curve.mean_pressure, tolerance=1e-4)
    np.testing.assert_allclose(curve.contact_area, reference.contact_area, rtol=0.2)
    curve = asperity.contact_curve(cut, BODY, separations=reference.separation)
    np.testing.assert_allclose(curve.load, reference.load, rtol=0.1)


@pytest.mark.parametrize("periodic", [False, True])
def test_a_cut_cone_is_a_flat_punch(periodic):
    y, x = (np.arange(n) * step for n, step in zip((100, 120), (1.2, 1.0), strict=True))
    r = np.hypot(y[:, None] - y[43], x - x[70])
    hm = HeightMap(-0.2 * np.maximum(r - 20.0, 0.0), (1.2, 1.0), periodic=periodic)
    body = asperity.HalfSpace.from_modulus(1.0)
    approach = np.array([0.02, 0.04])
    curve = asperity.contact_curve(
        hm, body, separations=-hm.heights.mean() - approach, boundary="free"
    )
    area = np.count_nonzero(r <= 20.0) * 1.2
    np.testing.assert_allclose(curve.load, 2.0 * 20.3 * approach, rtol=0.06)
    np.testing.assert_allclose(curve.contact_area, area, rtol=0.05)
    assert max(curve.error_estimate) < 0.8


@pytest.mark.parametrize("bend", [-1.0, 1.0], ids=["cup", "hill"])
def test_on_a_cup_the_border_carries_and_the_stated_error_says_so(bend):
    hill = -bend * ((X - LX / 2) ** 2 + (Y - LY / 2) ** 2) / 4e-4
    hm = HeightMap(waves().heights + hill, SPACING)
    curve = asperity.contact_curve(hm, BODY, pressures=default_pressures(hm, BODY, 4)[:2])
    if bend > 0:
        assert max(curve.extra["at_border"]) == 0.0
        return
    fine = resample(hm, np.asarray(SPACING) / 2)  # contacts of three pixels on corners of the map
    reference = asperity.bem_curve(fine, BODY, separations=curve.separation)
    wrong = np.abs(curve.load / reference.load - 1)
    assert min(curve.extra["at_border"]) > 0.9
    assert (wrong <= np.minimum(0.12, curve.error_estimate)).all()


def test_waves_have_no_such_contacts_and_a_shift_moves_none():
    hm, most = waves(), {"unresolved": 1e-3, "overlap": 0.05}
    for name in OUTSIDE_MODEL:
        curve = asperity.contact_curve(hm, BODY, pressures=default_pressures(hm, BODY, 3))
        assert max(curve.extra[name]) < most.get(name, 1e-12)
    steps = hm.replace(heights=np.round(hm.heights / hm.rms_height * 4) * hm.rms_height / 4)
    moved = steps.replace(heights=np.roll(steps.heights, (31, 52), (0, 1)))
    tops = [
        asperity.contact_curve(m, BODY, pressures=default_pressures(m, BODY, 3)).extra["flat_tops"]
        for m in (steps, moved)
    ]
    assert min(tops[0]) > 0.2
    assert tops[1] == pytest.approx(tops[0], rel=0.05)


def tip(k, place=0.5):
    """A hill of slope 0.01 at its foot that falls as r^k, on many pixels, its tip on one of them;
    and its profile."""
    spacing, radius = (1.2e-6, 1e-6), 1.28e-4
    y, x = (np.arange(n) * step for n, step in zip((200, 256), spacing, strict=True))
    r = np.hypot(y[:, None] - y[100], x - x[int(256 * place)])
    return HeightMap(-0.01 * radius ** (1 - k) * r**k, spacing), 0.01 * radius ** (1 - k)


@pytest.mark.parametrize(("k", "least"), [(1, 1e-7), (1.5, 5e-8), (4, 1e-8)])
def test_a_single_tip_is_pressed_where_its_rays_or_its_polynomial_miss_it(k, least):
    hm, scale = tip(k)
    approach = np.array([least, 2e-7, 4e-7])
    curve = asperity.contact_curve(hm, BODY, separations=-hm.heights.mean() - approach)
    exact = asperity.indent(PowerLawProfile(k, scale), BODY, approach)
    np.testing.assert_allclose(curve.load, exact.force, rtol=0.03)
    np.testing.assert_allclose(curve.contact_area, exact.contact_area, rtol=0.05)


def test_a_blunt_tip_that_the_rays_hold_is_not_doubted():
    hm, scale = tip(3)
    approach = np.array([1e-7, 2e-7, 4e-7])
    curve = asperity.contact_curve(hm, BODY, separations=-hm.heights.mean() - approach)
    exact = asperity.indent(PowerLawProfile(3, scale), BODY, approach)
    np.testing.assert_allclose(curve.load, exact.force, rtol=0.01)
    assert max(curve.error_estimate) < 0.2


@pytest.mark.parametrize("loads", [{"pressures": [1e5]}, {"separations": [0.0]}])
def test_a_law_that_has_no_contact_for_the_highest_summit_is_refused(loads):
    with pytest.raises(ModelRangeError, match="'harmonic' has no contact for the highest summit"):
        asperity.contact_curve(tip(1)[0], BODY, law="harmonic", **loads)


def test_summits_that_carry_nothing_are_warned_of():
    """A steep cap and, a little lower, a tip."""
    cap, lower = 8 * tip(2, 0.1)[0].heights, tip(1, 0.6)[0].heights - 2e-7
    hm = HeightMap(np.maximum(cap, lower), (1.2e-6, 1e-6))
    for law, depth, told in (("harmonic", 3e-7, 1), ("harmonic", 1e-7, 0), ("auto", 3e-7, 0)):
        curve = asperity.contact_curve(hm, BODY, separations=[-hm.heights.mean() - depth], law=law)
        assert sum("carry nothing: 1" in why for why in curve.settings["warnings"]) == told


def test_contacts_that_lost_their_area_are_judged():
    hm = waves()
    run = asperity.solve_contacts(hm, BODY, pressures=default_pressures(hm, BODY, 2)[:1])
    vars(run.points[0].state)["area"] = np.zeros(len(run.decomposition.population))
    found = terms(run.decomposition, run.points[0], 0.0)
    assert np.isfinite(list(found.values())).all()


def test_one_contact_among_many_whose_law_tells_nothing_does_little_harm():
    hm = waves()
    run = asperity.solve_contacts(hm, BODY, pressures=default_pressures(hm, BODY, 2)[1:])
    force, table = run.points[0].state.force, run.decomposition.population.table
    table.held.spread[:] = 0.0
    table.held.spread[table.place[force.argmax()]] = 1.0
    share = force.max() / force.sum()
    assert share < 0.8
    found = terms(run.decomposition, run.points[0], 0.0)
    assert found["unsure"] == pytest.approx(share**2)


@pytest.mark.parametrize("height", [4.0, 6.0])
def test_spikes_that_end_above_their_pixels_are_doubted(height):
    """One pixel in a thousand is raised: what carries the load stands between the pixels."""
    size = (192.0, 160.0)
    hm = self_affine((192, 160), size, hurst=0.8, rms_slope=0.1, cutoff=8.0, rolloff=60.0)
    rng = np.random.default_rng(3)
    spikes = (rng.random(hm.shape) > 0.999) * rng.random(hm.shape)
    spiked = hm.replace(heights=hm.heights + height * hm.rms_height * spikes)
    body = asperity.HalfSpace.from_modulus(1.0)
    loads = np.array([1e-3, 5e-3, 2e-2]) * pressure_scale(spiked, body)
    curve = asperity.contact_curve(spiked, body, pressures=loads)
    true = asperity.bem_curve(spiked, body, pressures=loads, accuracy=0.01)
    rate = true.stiffness / true.mean_pressure
    wrong = np.abs(rate * (curve.separation - true.separation))
    weight = DEFAULTS.error_estimate.overshoot
    before = curve.error_estimate - weight * curve.extra["overshoot"]
    assert wrong[0] <= curve.error_estimate[0] and wrong[0] > 1.5 * before[0]
    assert (wrong <= 1.2 * curve.error_estimate).all()  # the bound of nine in ten
    assert np.diff(curve.extra["overshoot"]).max() < 0  # the deeper, the less it matters
    plain = asperity.contact_curve(hm, body, pressures=loads)
    assert plain.extra["overshoot"].max() == 0.0


def test_contacts_smaller_than_a_pixel_are_named_and_doubted():
    """Hills of one pixel's step, their tops between the points of the map."""
    y, x = np.indices((48, 60))
    hm = HeightMap(
        np.cos(2 * np.pi * (y - 0.37) / 12) + np.cos(2 * np.pi * (x - 0.41) / 12), (1.0, 1.0),
        periodic=True,
    )  # fmt: skip
    body = asperity.HalfSpace.from_modulus(1.0)
    loads = np.array([4e-4, 1e-3, 1e-1])
    reference = asperity.bem_curve(hm, body, pressures=loads, tolerance=1e-5)
    curve = asperity.contact_curve(hm, body, separations=reference.separation)
    wrong = np.abs(curve.load / reference.load - 1)
    assert wrong[0] > 0.3
    assert (wrong <= curve.error_estimate).all()
    assert curve.extra["unresolved"][2] == 0.0
    told = [why for why in curve.settings["warnings"] if "as small as a pixel" in why]
    assert len(told) == 1
    light = asperity.contact_curve(hm, body, separations=reference.separation[2:])
    assert not any("as small as a pixel" in why for why in light.settings["warnings"])
