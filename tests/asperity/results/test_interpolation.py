"""What is read off a curve, and its stiffness from its tangents and its separations."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import asperity
from asperity.halfspace.scene import pressure_scale
from asperity.results.curve import ContactCurve
from asperity.results.interpolation import curve_stiffness, log_ratio
from surfaces import self_affine


@pytest.mark.parametrize("power", [1.0, 1.3, 1.5, 4.0])
def test_power_laws_are_exact_whatever_share_the_tangent_has(power):
    depth = np.geomspace(0.1, 3.0, 7)[[3, 0, 6, 1, 5, 2, 4]]
    pressure, exact = depth**power, power * depth ** (power - 1)
    good = np.ones(7, bool)
    found = curve_stiffness(pressure, -depth, 0.9 * exact, good)
    np.testing.assert_allclose(found, exact, rtol=1e-9)


def test_a_share_that_changes_is_told_within_a_per_cent():
    """p = exp(-s): k = p."""
    pressure = np.geomspace(1e-3, 1e-1, 10)
    share = 1 - 0.03 * np.log10(pressure / 1e-4)
    good = np.ones(10, bool)
    found = curve_stiffness(pressure, -np.log(pressure), share * pressure, good)
    np.testing.assert_allclose(found[1:-1], pressure[1:-1], rtol=2e-3)
    np.testing.assert_allclose(found, pressure, rtol=1e-2)


def test_failed_lone_and_unloaded_points_keep_their_tangent():
    pressure = np.array([0.0, 1.0, 2.0, 4.0, 1e4])
    separation, tangent = -np.log(pressure + 1e-9), 0.8 * pressure
    separation[2] = np.nan
    found = curve_stiffness(pressure, separation, tangent, np.array([1, 1, 1, 1, 1], bool))
    np.testing.assert_array_equal(found[[0, 2, 4]], tangent[[0, 2, 4]])
    np.testing.assert_allclose(found[[1, 3]], pressure[[1, 3]], rtol=1e-6)
    failed = curve_stiffness(pressure, separation, tangent, np.array([1, 1, 1, 0, 1], bool))
    np.testing.assert_array_equal(failed, tangent)
    assert curve_stiffness(*np.zeros((3, 0)), np.zeros(0, bool)).shape == (0,)


def test_noise_of_points_that_lie_close_is_not_raised():
    pressure = np.geomspace(1.0, 3.0, 60)
    noise = 2e-3 * np.sin(np.arange(60.0) ** 2)
    found = curve_stiffness(pressure, -np.log(pressure) + noise, pressure, np.ones(60, bool))
    np.testing.assert_allclose(found, pressure, rtol=2e-2)


@pytest.mark.parametrize(("cutoff", "m"), [(8, 0.0), (8, 0.3), (None, 0.0)])
def test_stiffness_of_a_curve_is_that_of_boundary_elements(cutoff, m):
    hm = self_affine(
        (240, 288), (240.0, 230.4), hurst=0.8, rms_slope=0.1, rolloff=60.0, cutoff=cutoff, seed=3
    )
    body = asperity.HalfSpace.from_modulus(1.0, m=m)
    loads = np.geomspace(4e-3, 4e-2, 5) * pressure_scale(hm, body)
    curve = asperity.contact_curve(hm, body, pressures=loads)
    near = loads[2] * np.array([0.95, 1.05])
    exact = asperity.bem_curve(hm, body, pressures=near, tolerance=1e-5)
    slope = -np.diff(exact.mean_pressure) / np.diff(exact.separation)
    assert curve.stiffness[2] == pytest.approx(slope[0], rel=0.05)


def test_runs_that_are_joined_have_the_stiffness_of_all_points():
    # so many hills that no two of them are pressed as one at the heaviest load, and at others not
    hm = self_affine(
        (96, 120), (96.0, 96.0), hurst=0.8, rms_slope=0.1, rolloff=16.0, cutoff=8, seed=3
    )
    body = asperity.HalfSpace.from_modulus(1.0)
    loads = np.geomspace(4e-3, 4e-2, 4) * pressure_scale(hm, body)
    first, later = (asperity.contact_curve(hm, body, pressures=p) for p in (loads[:3], loads[3:]))
    joined = first.joined(later)
    whole = asperity.contact_curve(hm, body, pressures=loads)
    np.testing.assert_array_equal(later.stiffness, later.extra["tangent_stiffness"])
    # the last point was started elsewhere: its tangent differs by 0.3 %
    np.testing.assert_allclose(joined.stiffness, whole.stiffness, rtol=0.02)
    assert joined.stiffness[3] > 1.002 * later.stiffness[0]


def test_ratio_of_what_is_not_known_or_infinite_is_one_and_warns_of_nothing():
    """A contact without a stiffness, in full contact, and not solved."""
    found = log_ratio(np.ones(4), np.array([np.e, 0.0, np.inf, np.nan]))
    assert found[0] == pytest.approx(-1.0) and not found[1:].any()


@pytest.mark.parametrize("question", ["separation", "area_fraction", "load"])
def test_what_was_read_off_leads_back_to_the_pressure(question):
    """Of few points the cubics of separation over load and of load over separation differ."""
    pressure = np.array([1e6, 2e7, 5e7, 9e8, 1e9])
    separation = np.array([9.0, 8.8, 5.0, 4.9, 1.0])
    curve = made(pressure, separation)
    asked = np.geomspace(1e6, 1e9, 101)
    found = getattr(curve.at(pressure=asked), question)
    back = curve.at(**{question: found})
    np.testing.assert_allclose(back.mean_pressure, asked, rtol=1e-8)
    np.testing.assert_array_equal(getattr(back, question), found)


def made(pressure, separation):
    """A curve of an area that grows with the pressure."""
    n = len(pressure)
    share = 1e-10 * pressure**0.9
    return ContactCurve(
        separation=separation,
        mean_pressure=pressure,
        load=2.0 * pressure,
        area_fraction=share,
        contact_area=2.0 * share,
        contacts=np.ones(n),
        stiffness=np.full(n, np.nan),
        converged=np.ones(n, bool),
        residual=np.zeros(n),
        error_estimate=np.zeros(n),
        model="made",
    )


@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-5])
@pytest.mark.parametrize("twice", [0, 1, 2, 3])
def test_a_load_that_was_solved_twice_changes_nothing_between_others(twice, gap):
    """The slope between both is that of two solutions: areas were three times as large."""
    pressure = np.array([1e6, 3e7, 1e9, 3e9])
    separation = np.array([9.0, 7.0, 4.0, 3.0])
    curve = made(pressure, separation)
    again = made(
        np.insert(pressure, twice + 1, pressure[twice] * (1.0 + gap)),
        np.insert(separation, twice + 1, separation[twice] - 1e-4),
    )
    asked = np.geomspace(1e6, 3e9, 41)
    one, other = (each.at(pressure=asked) for each in (curve, again))
    np.testing.assert_allclose(other.separation, one.separation, atol=5e-3)
    np.testing.assert_allclose(other.area_fraction, one.area_fraction, rtol=5e-3)
    ends = again.at(separation=separation[[0, -1]])
    np.testing.assert_allclose(ends.mean_pressure, [1e6, 3e9], rtol=1e-3)


def test_equal_areas_are_read_as_they_are_found():
    """Boundary elements count pixels: points of equal area were left out of one question alone."""
    curve = made(np.array([1e6, 2e6, 3e6, 1e7, 1e8]), np.array([9.0, 8.9, 8.8, 7.0, 4.0]))
    share = np.array([1.0, 2.0, 2.0, 5.0, 40.0]) * 1e-4
    curve = dataclasses.replace(curve, area_fraction=share, contact_area=2.0 * share)
    area = curve.at(pressure=4e6).area_fraction
    assert curve.at(area_fraction=area).mean_pressure == pytest.approx(4e6, rel=1e-9)


def test_loads_that_lie_close_are_all_read():
    """A chain of steps below that of a knot keeps every other point, not its ends alone."""
    pressure = np.append(1e6, np.geomspace(1e8, 1.2e8, 400))
    separation = 9.0 - np.log(pressure / 1e6) - 0.01 * np.sin(40 * np.log(pressure / 1e8))
    curve = made(pressure, separation)
    asked = np.geomspace(1.01e8, 1.19e8, 50)
    found = curve.at(pressure=asked).separation
    np.testing.assert_allclose(
        found, np.interp(np.log(asked), np.log(pressure), separation), atol=1e-4
    )


def test_a_curve_goes_on_in_full_contact():
    """The gap stays, the load does not: all of it is within the curve, also for partial slip."""
    pressure = np.array([1.0, 10.0, 100.0, 1e3, 1e4])
    separation = np.array([2.0, 1.0, 0.0, 0.0, 0.0])
    curve = made(pressure, separation)
    found = curve.at(pressure=[100.0, 5e3, 1e4])
    assert (found.separation == 0.0).all()
    np.testing.assert_allclose(curve.at(load=curve.load[4]).mean_pressure, 1e4)
    np.testing.assert_allclose(curve.at(separation=0.0).mean_pressure, 100.0)
    slip = asperity.friction_curve(curve, 1e4, friction=0.3, modulus_ratio=1.2)
    assert slip.displacement[0] == slip.displacement[1] == 0.0
    assert slip.displacement[-1] == pytest.approx(0.3 * 1.2 * 2.0)
