"""Law auto on batches: the ellipse law, guarded where no polynomial describes the summit."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
import surfaces
from asperity.microcontact import laws, tabulate
from asperity.microcontact.ellipse import batch as ellipse
from asperity.microcontact.law_table import INTERVALS
from asperity.microcontact.ray_laws import tabulate_ritz
from asperity.parameters import LawChoice

STEEL = asperity.HalfSpace(210e9, 0.3)


@pytest.fixture(scope="module")
def profiles() -> surfaces.Profiles:
    hm = surfaces.self_affine(
        (96, 128), (9.6e-4, 1.28e-3), hurst=0.8, rms_slope=0.1, cutoff=4e-5, seed=2
    )
    return surfaces.fit_profiles(hm, surfaces.segment(hm))


def test_summits_that_agree_keep_the_ellipse_law(profiles):
    table, own = tabulate(profiles, STEEL, law="auto"), ellipse.tabulate(profiles, STEEL)
    same = (table.force == own.force).all(axis=1)
    assert same.mean() > 0.9


def test_a_gross_disagreement_takes_the_law_without_a_polynomial(profiles):
    table = laws.tabulate_auto(profiles, STEEL, LawChoice(gross_difference=1.0))
    own = ellipse.tabulate(profiles, STEEL)
    other = tabulate_ritz(profiles, STEEL)
    taken = np.flatnonzero((table.force != own.force).any(axis=1))
    assert taken.size
    np.testing.assert_array_equal(table.force[taken], other.force[taken])
    np.testing.assert_array_equal(table.reach[taken], other.reach[taken])
    assert (table.spread[taken] >= own.spread[taken]).all()
    kept = np.setdiff1d(np.arange(len(table)), taken)
    assert own.centre[taken].any() and not table.centre[taken].any()
    np.testing.assert_array_equal(table.centre[kept], own.centre[kept])


def test_a_noisy_ridge_of_a_measured_map_does_not_carry_everything(measured):
    hm = surfaces.prepare(
        surfaces.read(measured / "optical_rubber_missing.h5"), level="plane", periodic="taper"
    )
    separation = [2.6 * hm.rms_height]
    load = {
        law: asperity.contact_curve(hm, STEEL, separations=separation, law=law).load[0]
        for law in ("auto", "ritz")
    }
    assert load["auto"] == pytest.approx(load["ritz"], rel=0.2)


def test_a_summit_that_the_ellipse_law_gives_up_still_carries(profiles, monkeypatch):
    """A noisy ridge whose smallest polynomial curves up: it must not carry nothing."""
    lost = np.flatnonzero(profiles.valid)[:2]
    tabulated = ellipse.tabulate

    def without(*args, **options):
        table = tabulated(*args, **options)
        table.reach[lost] = 0.0
        return table

    monkeypatch.setattr(ellipse, "tabulate", without)
    table = laws.tabulate_auto(profiles, STEEL, LawChoice())
    other = tabulate_ritz(profiles, STEEL)
    assert (table.reach[lost] > 0).all()
    np.testing.assert_array_equal(table.force[lost], other.force[lost])
    assert (table.spread[lost] == 1.0).all()


@pytest.mark.parametrize("m", [0.0, -0.3])
def test_every_post_of_a_wafer_carries(m):
    """Flat tops whose rays rise level from the summit, so that they pass for tips such as r^4."""
    y, x = np.ogrid[:96, :120]
    tops = np.random.default_rng(3).normal(0.0, 0.15, (4, 5))
    inside = (abs(y % 24 - 12) < 7.2) & (abs(x % 24 - 12) < 7.2)
    heights = 1e-8 * np.where(inside, tops[y // 24, x // 24], -3.0)
    hm = surfaces.HeightMap(heights, (1.3e-6, 0.8e-6), periodic=True)
    body = asperity.HalfSpace.from_modulus(1e9, m)
    separations = 1e-8 * np.quantile(tops, [0.3, 0.7]) - heights.mean()
    curve = asperity.contact_curve(hm, body, separations=separations)
    exact = asperity.bem_curve(hm, body, separations=separations, accuracy=0.01)
    assert not any("carry nothing" in why for why in curve.settings["warnings"])
    np.testing.assert_allclose(curve.load, exact.load, rtol=0.3)


def test_a_plateau_that_pulls_at_first_is_a_paraboloid_up_to_where_it_pushes_most(
    profiles, monkeypatch
):
    tabulated, nodes = tabulate_ritz, INTERVALS

    def pulled(*args, **options):
        table = tabulated(*args, **options)
        table.force[:, 1:6] = -table.force[:, -1:]
        table.force[:, 6] *= 2.0
        return table

    kept, own = (
        tabulate_ritz(profiles, STEEL),
        ellipse.tabulate(profiles, STEEL),
    )
    monkeypatch.setattr(laws, "tabulate_ritz", pulled)
    table = laws.tabulate_auto(profiles, STEEL, LawChoice(gross_difference=1.0))
    taken = np.flatnonzero((table.force != own.force).any(axis=1))
    assert taken.size
    u = np.arange(nodes + 1) / nodes
    paraboloid = 2.0 * kept.force[taken, 6:7] * (u[:7] / u[6]) ** 3
    np.testing.assert_allclose(table.force[taken, :7], paraboloid, rtol=1e-12)
    np.testing.assert_array_equal(table.force[taken, 7:], kept.force[taken, 7:])
    depth = table.reach[taken] * u[3] ** 2
    force, stiffness, area = table.evaluate(taken, depth)
    np.testing.assert_allclose(stiffness * depth, 1.5 * force, rtol=1e-9)
    np.testing.assert_allclose(area, 0.25 * kept.area[taken, 6], rtol=1e-9)


def test_a_level_tip_without_a_polynomial_has_the_harmonic_law(monkeypatch):
    """The curvature of r^4 is rounding, of either sign; ritz is at a third of its force."""
    y, x = np.meshgrid(np.arange(97) - 48.0, np.arange(129) - 64.0, indexing="ij")
    hm = surfaces.HeightMap(-1e-9 * (x**2 + y**2) ** 2, (1.0, 1.0))
    tip = surfaces.fit_profiles(hm, surfaces.segment(hm))
    tabulated = ellipse.tabulate

    def without(*args, **options):
        table = tabulated(*args, **options)
        for name in ("reach", "force", "stiffness", "area"):
            getattr(table, name)[:] = 0.0
        return table

    monkeypatch.setattr(ellipse, "tabulate", without)
    tip.valid[:] = True
    table = laws.tabulate_auto(tip, STEEL, LawChoice())
    depth = table.reach[0] * np.array([0.01, 0.05, 0.2])
    force = table.evaluate(np.zeros(3, np.int64), depth)[0]
    exact = asperity.indent(surfaces.PowerLawProfile(4, 1e-9), STEEL, depth).force
    np.testing.assert_allclose(force, exact, rtol=0.02)
