"""Law tables under a hardness: the elastic laws without one, bearing areas with a small one."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import rough

import asperity
import surfaces
from asperity.microcontact import tabulate
from asperity.microcontact.laws import LAWS


@pytest.fixture(scope="module")
def profiles():
    hm = rough((96, 80), cutoff=0.25)
    fit = surfaces.fit_profiles(hm, surfaces.segment(hm))
    return fit.rows(np.flatnonzero(fit.valid)[:60])


def body(hardness, m=0.0):
    return asperity.HalfSpace.from_modulus(1.0, m, hardness=hardness)


@pytest.mark.parametrize("law", LAWS)
def test_a_hardness_that_no_contact_reaches_changes_nothing(profiles, law):
    elastic, hard = (tabulate(profiles, body(h), law=law) for h in (np.inf, 1e9))
    same = (hard.force == elastic.force).all(axis=1)  # a cone yields at its tip, however little
    assert same.mean() > 0.95
    for name in ("reach", "stiffness", "area", "flags"):
        np.testing.assert_array_equal(getattr(hard, name)[same], getattr(elastic, name)[same])
    np.testing.assert_allclose(hard.force, elastic.force, rtol=1e-3)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("hardness", [1e-3, 3e-2, 0.2])
def test_no_pressure_exceeds_the_hardness(profiles, hardness, m):
    table = tabulate(profiles, body(hardness, m), law="auto")
    assert (table.force <= hardness * table.area * (1 + 1e-12)).all()
    assert (table.force[:, 1:] > 0).sum() > 0.9 * table.force[:, 1:].size
    elastic = tabulate(profiles, body(np.inf, m), law="auto")
    at = np.linspace(0.1, 0.9, 9) * np.minimum(table.reach, elastic.reach)[:, None]
    force, free = (t.evaluate(np.arange(len(t))[:, None], at)[0] for t in (table, elastic))
    assert (force <= free * (1 + 0.02) + 1e-12).all()


def test_soft_summits_are_pressed_as_their_bearing_areas_tell(profiles):
    hardness = 1e-6
    table = tabulate(profiles, body(hardness), law="auto")
    usable = np.flatnonzero(table.reach > 0)
    at = np.linspace(0.1, 0.9, 9) * table.reach[usable, None]
    force, _, area = table.evaluate(usable[:, None], at)
    exact = profiles.rows(usable).bearing_areas(at)
    worst = np.abs(force / (hardness * exact) - 1).max(axis=1)
    assert np.median(worst) < 0.03 and worst.mean() < 0.05
    np.testing.assert_allclose(area, force / hardness, rtol=0.1)
    assert np.median(area * hardness / force) < 1.01


@pytest.mark.parametrize("m", [-0.4, 0.0, 0.4])
def test_a_soft_summit_fills_its_basin(profiles, m):
    """One in ten laws ended at nine tenths of it and less; basins pressed alone at half."""
    hardness = 1e-6
    table = tabulate(profiles, body(hardness, m), law="auto")
    basin = 0.5 * np.sum(profiles.weight * profiles.edge**2, axis=1)
    full = table.force[:, -1] / (hardness * basin)
    assert full[table.reach > 0] == pytest.approx(1.0, abs=0.01)


def test_units_do_not_matter(profiles):
    one = tabulate(profiles, body(0.03), law="auto")
    stiff = tabulate(
        profiles, asperity.HalfSpace.from_modulus(2e11, hardness=0.03 * 2e11), law="auto"
    )
    np.testing.assert_allclose(stiff.reach, one.reach, rtol=1e-9)
    np.testing.assert_allclose(stiff.force, 2e11 * one.force, rtol=1e-7)


@pytest.mark.parametrize("law", ["paper", "harmonic", "ritz"])
def test_rounding_does_not_decide_the_stiffness(law):
    """At nodes on a level, and where force and cubic agree but for their last digits."""
    hm = rough((96, 128), cutoff=0.12)
    fit = surfaces.fit_profiles(hm, surfaces.segment(hm))
    one, three = (
        tabulate(fit, asperity.HalfSpace.from_modulus(scale, 0.4, hardness=0.1 * scale), law=law)
        for scale in (1.0, 3.0)
    )
    largest = one.stiffness.max(axis=1, keepdims=True)
    assert np.all(np.abs(three.stiffness / 3.0 - one.stiffness) <= 1e-9 * largest)


def test_forces_grow_and_slopes_are_those_of_the_forces(profiles):
    table = tabulate(profiles, body(0.05), law="auto")
    elastic = tabulate(profiles, body(np.inf), law="auto")
    usable = np.flatnonzero((table.reach > 0) & (np.diff(elastic.force, axis=1) > 0).all(axis=1))
    assert usable.size > 50
    assert (np.diff(table.force[usable], axis=1) >= 0).all()
    at = np.linspace(0.02, 0.2, 15) * table.reach[usable, None]
    step = 1e-5 * at
    more, less = (table.evaluate(usable[:, None], at + s)[0] for s in (step, -step))
    force, stiffness, _ = table.evaluate(usable[:, None], at)
    slope = (more - less) / (2 * step)
    np.testing.assert_allclose(np.maximum(slope, 0.05 * force / at), stiffness, rtol=1e-3)


def test_a_soft_tower_on_a_terrace_is_pressed_as_its_bearing_area_tells():
    """The elastic contact jumps from the top to the terrace; the soft one grows to its foot."""
    y, x = np.mgrid[:96, :96]
    r = np.hypot(y - 48.3, x - 47.6)
    heights = -0.5 * np.tanh((r - 7) / 2) - 0.75 * np.tanh((r - 28) / 3) - 0.002 * r
    hm = surfaces.HeightMap(heights, 1.0, periodic=True)
    flats = heights.max() - np.array([0.4, 0.6, 0.8, 1.3, 1.5])
    curve = asperity.contact_curve(hm, body(1e-5), separations=flats - heights.mean())
    bearing = [(heights > flat).mean() for flat in flats]
    np.testing.assert_allclose(curve.area_fraction, bearing, rtol=0.3)
