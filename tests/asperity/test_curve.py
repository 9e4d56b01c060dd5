"""The sum of microcontacts: laws that hold for any surface, and the cuts that change nothing."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest

import asperity
from asperity.contacts.run import solve_contacts
from asperity.contacts.table import microcontacts
from asperity.errors import InputError, SurfaceError
from asperity.halfspace.scene import default_pressures
from asperity.model.plan import make_plan
from asperity.parameters import DEFAULTS, Segmentation
from surfaces import HeightMap, self_affine

STEEL = asperity.HalfSpace(210e9, 0.3)


@pytest.fixture(scope="module")
def rough() -> HeightMap:
    return self_affine(
        (120, 160), (1.2e-3, 1.6e-3), hurst=0.8, rms_slope=0.1, rolloff=3e-4, cutoff=8e-5, seed=5
    )


def paraboloid(radius: float, periodic: bool = False) -> HeightMap:
    """One cap of an ellipsoid on pixels that are not square."""
    ny, nx, dy, dx = 81, 101, 1.2e-6, 1e-6
    y, x = (np.arange(ny) - 40) * dy, (np.arange(nx) - 50) * dx
    return HeightMap(
        -(x[None, :] ** 2 + y[:, None] ** 2) / (2 * radius), (dy, dx), periodic=periodic
    )


@pytest.mark.parametrize("law", ["hertz", "paper", "harmonic", "ellipse"])
def test_one_cap_is_hertz(law):
    hm = paraboloid(1e-3)
    top = -hm.heights.mean()
    approach = np.array([2e-8, 1e-7, 3e-7])
    curve = asperity.contact_curve(hm, STEEL, separations=top - approach, law=law)
    force = 4 / 3 * STEEL.modulus * np.sqrt(1e-3) * approach**1.5
    np.testing.assert_allclose(curve.load, force, rtol=2e-3)
    np.testing.assert_allclose(curve.contact_area, np.pi * 1e-3 * approach, rtol=2e-3)
    np.testing.assert_array_equal(curve.contacts, 1)
    np.testing.assert_allclose(curve.stiffness * hm.area, 1.5 * force / approach, rtol=1e-2)


@pytest.mark.parametrize("law", ["auto", "harmonic"])
def test_a_run_is_the_same_after_pickling(rough, law):
    plan = make_plan(rough, STEEL, law=law)
    run = solve_contacts(rough, STEEL, plan, pressures=[1e7, 1e8])
    assert repr(run).startswith(str(run.curve))  # what a notebook shows
    back = pickle.loads(pickle.dumps(run))
    np.testing.assert_array_equal(back.microcontacts(), run.microcontacts())
    np.testing.assert_array_equal(back.pressure_map(0), run.pressure_map(0))
    assert back.points[0].state.normal_stiffness == run.points[0].state.normal_stiffness
    one, other = (
        each.decomposition.population.solve(
            pressure=2e8, state=each.points[-1].state, tolerance=1e-4
        )
        for each in (run, back)
    )
    np.testing.assert_allclose(other.force, one.force, rtol=1e-2, atol=1e-3 * one.force.max())
    assert other.normal_stiffness == pytest.approx(one.normal_stiffness, rel=1e-2)


def test_pressure_and_separation_control_agree(rough):
    loads = default_pressures(rough, STEEL, count=4)
    by_load = asperity.contact_curve(rough, STEEL, pressures=loads)
    by_gap = asperity.contact_curve(rough, STEEL, separations=by_load.separation)
    np.testing.assert_allclose(by_load.mean_pressure, loads, rtol=2e-3)
    np.testing.assert_allclose(by_gap.mean_pressure, loads, rtol=5e-3)
    np.testing.assert_allclose(by_gap.area_fraction, by_load.area_fraction, rtol=5e-3)


def test_ten_points_tell_the_points_between(rough):
    loads = default_pressures(rough, STEEL)
    curve = asperity.contact_curve(rough, STEEL)
    between = np.sqrt(loads[1:] * loads[:-1])[::3]
    solved = asperity.contact_curve(rough, STEEL, pressures=between)
    read = curve.at(pressure=between)
    np.testing.assert_allclose(read.area_fraction, solved.area_fraction, rtol=0.03)
    np.testing.assert_allclose(read.separation, solved.separation, rtol=3e-3)
    every = curve.at(pressure=np.geomspace(loads[0], loads[-1], 60))  # the ends as asked for
    assert (np.diff(every.area_fraction) > 0).all()
    assert (np.diff(every.separation) < 0).all()


def test_load_area_and_contacts_grow_as_the_separation_falls(rough):
    separations = np.linspace(2.0, 0.3, 12) * rough.rms_height
    curve = asperity.contact_curve(rough, STEEL, separations=separations)
    assert curve.converged.all()
    assert (np.diff(curve.load) > 0).all()
    assert (np.diff(curve.area_fraction) > 0).all()
    slope = -np.gradient(curve.mean_pressure, curve.separation)
    np.testing.assert_allclose(curve.stiffness[2:-2], slope[2:-2], rtol=0.1)
    filled = curve.extra["filled_share"]
    assert filled[0] == 0.0 and 0.0 < filled[-1] <= 1.0


@pytest.mark.parametrize("scale", [1e-28, 1e3, 1e30])
def test_scaling_of_lengths_and_modulus(rough, scale):
    """Forces of such maps are no numbers of single precision: fields of a mesh were none then."""
    loads = default_pressures(rough, STEEL, count=3)
    curve = asperity.contact_curve(rough, STEEL, pressures=loads)
    dy, dx = rough.spacing
    larger = rough.replace(heights=scale * rough.heights, spacing=(scale * dy, scale * dx))
    soft = asperity.HalfSpace.from_modulus(STEEL.modulus / 50)
    scaled = asperity.contact_curve(larger, soft, pressures=loads / 50)
    np.testing.assert_allclose(scaled.area_fraction, curve.area_fraction, rtol=1e-4)
    np.testing.assert_allclose(scaled.separation, scale * curve.separation, rtol=1e-4)


def test_adding_a_constant_and_shifting_change_nothing(rough):
    loads = default_pressures(rough, STEEL, count=3)
    run = solve_contacts(rough, STEEL, pressures=loads)
    moved = rough.replace(heights=np.roll(rough.heights, (37, -51), axis=(0, 1)) + 1e-5)
    again = solve_contacts(moved, STEEL, pressures=loads)
    np.testing.assert_allclose(again.curve.area_fraction, run.curve.area_fraction, rtol=2e-3)
    np.testing.assert_allclose(again.curve.separation, run.curve.separation, rtol=2e-3, atol=1e-10)
    np.testing.assert_allclose(again.curve.contacts, run.curve.contacts, atol=1)
    assert overlap(np.roll(run.contact_map(), (37, -51), axis=(0, 1)), again.contact_map()) > 0.98


def test_an_offset_takes_no_digits(rough):
    """3 um of roughness on 1 km, which leaves all but a part in 3e7 of it, and on 1e6 km."""
    pressures = default_pressures(rough, STEEL)[::3]
    for offset, left in ((1e3, True), (1e9, False)):
        far = rough.replace(heights=rough.heights + offset)
        near = rough.replace(heights=far.heights - offset)  # exact
        moved, known = (
            asperity.contact_curve(hm, STEEL, pressures=pressures) for hm in (far, near)
        )
        for name in ("separation", "contact_area", "stiffness"):
            np.testing.assert_allclose(getattr(moved, name), getattr(known, name), rtol=1e-6)
        assert moved.settings["input"] == far.digest
        told = [text for text in moved.settings["warnings"] if "are rounded" in text]
        assert len(told) == (0 if left else 1)


def test_exchanging_the_axes_exchanges_places_and_turns_angles(rough):
    loads = default_pressures(rough, STEEL, count=3)
    run = solve_contacts(rough, STEEL, pressures=loads)
    turned = rough.replace(heights=rough.heights.T.copy(), spacing=rough.spacing[::-1])
    again = solve_contacts(turned, STEEL, pressures=loads)
    np.testing.assert_allclose(again.curve.area_fraction, run.curve.area_fraction, rtol=2e-3)
    np.testing.assert_allclose(again.curve.stiffness, run.curve.stiffness, rtol=5e-3)
    np.testing.assert_allclose(again.curve.contacts, run.curve.contacts, atol=1)
    assert overlap(run.contact_map().T, again.contact_map()) > 0.98
    one, other = run.microcontacts(), again.microcontacts()
    assert len(one) == len(other)
    one, other = one[np.lexsort((one["x"], one["y"]))], other[np.lexsort((other["y"], other["x"]))]
    for mine, its in (("x", "y"), ("centre_x", "centre_y"), ("centre_y", "centre_x")):
        np.testing.assert_allclose(one[mine], other[its], atol=1e-8)
    np.testing.assert_allclose(
        one["force"], other["force"], rtol=0.02, atol=1e-3 * one["force"].max()
    )
    long = one["semi_minor"] < 0.8 * one["semi_major"]
    apart = np.mod(one["angle"] + other["angle"], np.pi)[long]
    np.testing.assert_allclose(apart, np.pi / 2, atol=1e-3)


def overlap(one, other) -> float:
    """Intersection over union of two masks."""
    return np.count_nonzero(one & other) / np.count_nonzero(one | other)


def test_a_free_boundary_cuts_a_periodic_map_at_its_border(rough):
    """Half a summit at the border is half a punch; its other half is not there to carry."""
    loads = default_pressures(rough, STEEL, count=3)
    whole = solve_contacts(rough, STEEL, make_plan(rough, STEEL, boundary="free"), pressures=loads)
    cut = rough.replace(periodic=False)
    other = solve_contacts(cut, STEEL, pressures=loads)
    np.testing.assert_array_equal(whole.curve.separation, other.curve.separation)
    np.testing.assert_array_equal(whole.curve.contacts, other.curve.contacts)
    np.testing.assert_array_equal(whole.pressure_map(), other.pressure_map())


def test_interaction_opens_the_surface(rough):
    """On a half-space at rest far away, neighbors only ever push each other away."""
    case = {"separations": [1.0 * rough.rms_height], "boundary": "free"}
    alone = asperity.contact_curve(rough, STEEL, interaction=False, **case)
    coupled = asperity.contact_curve(rough, STEEL, **case)
    assert coupled.load[0] < alone.load[0]


def test_segmenting_only_the_top_changes_little():
    few = dataclasses.replace(DEFAULTS, segmentation=Segmentation(whole_points=2**18))
    large = self_affine(
        (640, 512), (6.4e-3, 5.12e-3), hurst=0.8, rms_slope=0.1, cutoff=5e-5, seed=4
    )
    loads = default_pressures(large, STEEL, count=3)[:2]
    plan = make_plan(large, STEEL, pressures=loads, scales="all", parameters=few)
    assert plan.above is not None
    cut = asperity.contact_curve(large, STEEL, pressures=loads, plan=plan)
    whole = asperity.contact_curve(
        large, STEEL, pressures=loads, plan=dataclasses.replace(plan, above=None)
    )
    assert cut.settings["above"] is not None
    np.testing.assert_allclose(cut.area_fraction, whole.area_fraction, rtol=2e-2)
    np.testing.assert_allclose(cut.separation, whole.separation, rtol=3e-3)


@pytest.mark.parametrize("law", ["ellipse", "auto"])
def test_a_plan_that_cuts_too_high_is_mended(rough, law):
    loads = default_pressures(rough, STEEL, count=3)
    plan = make_plan(rough, STEEL, pressures=loads, law=law)
    high = dataclasses.replace(plan, above=2.5 * rough.rms_height)
    curve = asperity.contact_curve(rough, STEEL, pressures=loads, plan=high)
    assert curve.settings["above"] is None


def test_leaving_interaction_out_at_vanishing_load_changes_nothing(rough):
    load = 1e-7 * default_pressures(rough, STEEL)[:1]
    plan = make_plan(rough, STEEL, pressures=load)
    coupled = asperity.contact_curve(
        rough, STEEL, pressures=load, plan=dataclasses.replace(plan, interaction=True)
    )
    alone = asperity.contact_curve(
        rough, STEEL, pressures=load, plan=dataclasses.replace(plan, interaction=False)
    )
    np.testing.assert_allclose(alone.area_fraction, coupled.area_fraction, rtol=1e-2)


def test_zero_load_is_first_touch(rough):
    curve = asperity.contact_curve(rough, STEEL, pressures=[0.0, 1e7])
    assert curve.load[0] == 0.0
    assert curve.contacts[0] == 0
    assert curve.separation[0] >= curve.separation[1]


def test_a_separation_above_the_surface_carries_nothing(rough):
    curve = asperity.contact_curve(rough, STEEL, separations=[1.0, 1e3])
    assert curve.converged.all()
    assert not curve.load.any() and not curve.contacts.any()


def test_table_says_where_contacts_lie_and_how_far_to_trust_them(rough):
    """Radii of a paraboloid are those of its circle; on a rough map outlines hold the area, and
    only contacts that fill part of their basin are cut off."""
    hm = paraboloid(1e-3)
    separation = [-hm.heights.mean() - 2e-7]
    run = solve_contacts(hm, STEEL, separations=separation)
    table = microcontacts(run.decomposition, run.points[0])
    np.testing.assert_allclose(_radii(table)[0], table["radius"][0], rtol=2e-3)
    assert table["flags"][0] == 0 and table["filled"][0] == 0 and table["estimate"][0] < 1e-3
    np.testing.assert_allclose(table["centre_x"], table["x"], atol=1e-8)

    run = solve_contacts(rough, STEEL, pressures=default_pressures(rough, STEEL)[-2:])
    table = microcontacts(run.decomposition, run.points[-1])
    radii = _radii(table)
    assert radii.shape == (len(table), 16) and (radii > 0).all()
    enclosed = np.pi * np.mean(radii**2, axis=1)
    loose = table["filled"] == 0
    np.testing.assert_allclose(np.median(enclosed[loose] / table["area"][loose]), 1, atol=0.02)
    assert (table["filled"] <= 1).all() and (table["filled"] > 0).any()
    for place, side in zip(("y", "x"), rough.size, strict=True):
        for name in (place, f"centre_{place}"):
            assert (table[name] >= 0).all() and (table[name] <= side).all()
    assert (table["estimate"] >= 0).all() and np.isfinite(table["estimate"]).all()


def _radii(table):
    return np.stack([table[f"radii_{i}"] for i in range(16)], axis=1)


def test_fewer_points_for_a_smooth_map_change_little():
    hm = self_affine(
        (288, 240), (1.2e-3, 1.2e-3), hurst=0.8, rms_slope=0.1, rolloff=4e-4, cutoff=9e-5, seed=8
    )
    loads = default_pressures(hm, STEEL, count=3)
    plan = make_plan(hm, STEEL, pressures=loads)
    assert plan.resampled is not None
    few = solve_contacts(hm, STEEL, plan, pressures=loads)
    many = solve_contacts(hm, STEEL, dataclasses.replace(plan, resampled=None), pressures=loads)
    np.testing.assert_allclose(few.curve.area_fraction, many.curve.area_fraction, rtol=0.02)
    np.testing.assert_allclose(few.curve.separation, many.curve.separation, rtol=5e-3)
    assert few.curve.settings["grid"] == list(plan.solved(hm).shape)
    for point in range(3):
        mine, full = few.contact_map(point), many.contact_map(point)
        assert mine.shape == hm.shape
        assert np.count_nonzero(mine & full) > 0.9 * np.count_nonzero(mine | full)


def test_maps_with_missing_points_are_refused(rough):
    heights = rough.heights.copy()
    heights[0, 0] = np.nan
    with pytest.raises(SurfaceError, match="fill"):
        asperity.contact_curve(rough.replace(heights=heights), STEEL)


@pytest.mark.parametrize("body", [STEEL, asperity.HalfSpace.from_modulus(1e11, m=0.3)])
@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_without_interaction_the_difference_is_told_and_stated(rough, body, boundary):
    case = {"pressures": default_pressures(rough, body, count=3), "boundary": boundary}
    alone = asperity.contact_curve(rough, body, interaction=False, **case)
    coupled = asperity.contact_curve(
        rough, body, separations=alone.separation, boundary=boundary, scales="all"
    )
    difference = alone.extra["interaction_difference"]
    assert difference == pytest.approx(alone.load / coupled.load - 1, rel=0.02)
    assert abs(difference[-1]) > 0.1
    assert (alone.error_estimate > np.abs(difference)).all()
    assert "left out" in str(alone)
    assert "interaction_difference" not in coupled.extra


def test_independent_contacts_carry_the_load_asked_for(rough):
    asked = default_pressures(rough, STEEL, count=4)
    curve = asperity.contact_curve(rough, STEEL, pressures=asked, interaction=False)
    assert curve.mean_pressure == pytest.approx(asked, rel=1e-5)
    assert curve.at(pressure=asked[-1]).load == pytest.approx(asked[-1] * rough.area)
    light = asperity.contact_curve(rough, STEEL, pressures=[1e-8, 1e-4, 1.0])
    assert light.mean_pressure == pytest.approx([1e-8, 1e-4, 1.0], rel=1e-3)


def test_independent_contacts_are_counted_as_their_table_has_them():
    """Summits that no law is made for, such as those pressed with a neighbor, carry nothing."""
    hm = self_affine((96, 128), (96.0, 128.0), hurst=0.8, rms_slope=0.1, rolloff=24.0, seed=2)
    loads = {"pressures": default_pressures(hm, STEEL)[[3, 9]]}
    run = solve_contacts(hm, STEEL, make_plan(hm, STEEL, interaction=False, **loads), **loads)
    for point, count in enumerate(run.curve.extra["microcontacts"]):
        assert count == len(run.microcontacts(point))


def test_errors_of_other_laws_are_not_estimated(rough):
    loads = default_pressures(rough, STEEL, count=3)[:1]
    for law, known in (("hertz", False), ("ellipse", True)):
        curve = asperity.contact_curve(rough, STEEL, pressures=loads, law=law)
        stated = curve.error_estimate, curve.extra["area_error_estimate"]
        assert np.isfinite(stated).all() == known


def test_a_switch_that_is_no_switch_is_refused(rough):
    with pytest.raises(InputError, match="True or False"):
        asperity.contact_curve(rough, STEEL, interaction="off")
    with pytest.raises(InputError, match="choose one of auto"):
        asperity.contact_curve(rough, STEEL, law=["hertz"])
