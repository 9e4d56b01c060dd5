"""Outlines of contacts, against the law of the single contact; distribution of contact sizes."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import sampled

import surfaces
from asperity import HalfSpace, indent, size_distribution
from asperity.contacts.run import solve_contacts
from asperity.contacts.table import DIRECTIONS, outlines
from asperity.errors import InputError
from asperity.microcontact.hertz import axis_ratios, elliptic_contact
from asperity.model.plan import make_plan
from surfaces.shapes import bent_body

SPACING = (0.012, 0.01)


@pytest.mark.parametrize(("m", "error"), [(-0.3, 0.025), (0.0, 0.015), (0.3, 0.012)])
def test_outlines_follow_the_shape_at_their_depth(m, error):
    """An ellipse at the summit, a triangle further out: ellipses err by up to 4 %."""
    body = bent_body()
    y, x = ((np.arange(n) - n // 2) * step for n, step in zip((121, 151), SPACING, strict=True))
    heights = -body(np.hypot(y[:, None], x), np.arctan2(y[:, None], x))
    hm = surfaces.HeightMap(heights, SPACING)
    summit = surfaces.fit_profiles(hm, surfaces.segment(hm)).rows(np.zeros(1, np.int64))
    turn = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    for depth in (0.005, 0.02, 0.06):
        one = indent(body, HalfSpace.from_modulus(1.0, m=m), depth, law="ellipse")
        radii, filled = outlines(
            summit,
            np.array([depth]),
            np.array([float(one.contact_area)]),
            axis_ratios(summit.curvature, m),
            m,
        )
        assert np.sqrt(np.mean((radii[0] / one.contour(turn) - 1) ** 2)) < error
        assert filled[0] == 0.0


@pytest.mark.parametrize("length", [1.0, 2.0**20, 2.0**-20])
def test_outlines_do_not_depend_on_the_unit_of_length(length):
    """The law of a ray ends level on a plateau: it fills its basin where it stays below."""

    def body(r, phi):
        return np.where(np.cos(phi) > 0.1, np.minimum(r, 0.3), r) ** 2

    summit = sampled([body], [1.0])
    summit.q, summit.edge = summit.q / length, summit.edge * length
    summit.curvature, summit.angle = np.full((1, 2), 2.0 / length), np.zeros(1)
    area = np.array([1.6 * length**2])
    radii, filled = outlines(summit, np.array([0.3 * length]), area, np.ones(1), 0.0)
    assert filled[0] == pytest.approx(7 / 16)
    beyond = np.cos(2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS) > 0.1
    np.testing.assert_allclose(radii[0, beyond], length, rtol=1e-12)
    assert radii[0, ~beyond].max() < 0.5 * length


def test_every_contact_is_in_one_bin_and_all_the_area_is_shared():
    area = np.random.default_rng(1).lognormal(-25, 2, 500)
    table = size_distribution(area, bins=7)
    assert len(table) == 7 and table["contacts"].sum() == 500
    assert table["area_share"].sum() == pytest.approx(1.0)
    np.testing.assert_allclose(table["upper"][:-1], table["lower"][1:])
    inside = (area >= table["lower"][3]) & (area < table["upper"][3])
    assert table["contacts"][3] == np.count_nonzero(inside)
    assert table["area_share"][3] == pytest.approx(area[inside].sum() / area.sum())


def test_power_law_has_its_exponent():
    """n(A) ~ A^-2 puts half as many contacts into each bin twice as wide."""
    area = 1.0 / (1.0 - np.linspace(0, 1 - 2.0**-10, 100_001))
    contacts = size_distribution(area, bins=10)["contacts"]
    np.testing.assert_allclose(contacts[1:] / contacts[:-1], 0.5, rtol=0.02)


@pytest.mark.parametrize(("area", "rows"), [([], 0), ([2.0], 4), ([2.0, 2.0], 4)])
def test_few_and_equal_contacts(area, rows):
    table = size_distribution(area, bins=4)
    assert len(table) == rows and table["contacts"].sum() == len(area)


@pytest.mark.parametrize(
    ("area", "bins", "match"),
    [
        ([-1.0], 3, "positive"),
        ([np.nan], 3, "finite"),
        ([1.0], 0, "at least 1"),
        ([1.0], 2.5, "whole number"),
    ],
)
def test_what_is_no_area_or_no_bin(area, bins, match):
    with pytest.raises(InputError, match=match):
        size_distribution(area, bins=bins)


def test_a_whole_table_is_no_column():
    with pytest.raises(InputError, match="the column"):
        size_distribution(np.ones(3, dtype=[("area", float), ("force", float)]))


@pytest.mark.parametrize("m", [-0.8, 0.0, 0.6])
def test_axes_of_a_contact_are_those_of_its_grading(m):
    """They were those of a fit to homogeneous bodies: 26 % too short at m = -0.8."""
    place = (np.arange(121) + 0.5) * 1e-6
    x, y = np.meshgrid(place - 60.3e-6, place - 60.7e-6)
    hm = surfaces.HeightMap(-(x**2 / 10 + y**2) / 2e-4, 1e-6)
    body = HalfSpace.from_modulus(1e9, m)
    separation = [hm.heights.max() - hm.heights.mean() - 1e-6]
    plan = make_plan(hm, body, law="hertz", separations=separation)
    run = solve_contacts(hm, body, plan, separations=separation)
    one = run.microcontacts()[0]
    exact = elliptic_contact(1e4, 1e3, one["approach"], body)
    assert one["semi_major"] == pytest.approx(float(exact.semi_major), rel=1e-3)
    assert one["semi_minor"] == pytest.approx(float(exact.semi_minor), rel=1e-3)


@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_summits_pressed_as_one_contact_have_its_axes(turn):
    """Each of two equal balls is round; the contact that holds both is long from one to the other.

    Boundary elements: 0.37 by second moments of the pressure, 0.41 by those of the contact."""
    y, x = (np.arange(64) - 31.5)[:, None], np.arange(80) - 39.5
    c, s = 5.0 * np.cos(turn), 5.0 * np.sin(turn)
    away = [(x + side * c) ** 2 + (y + side * s) ** 2 for side in (-1, 1)]
    hm = surfaces.HeightMap(np.maximum(-np.minimum(*away) / 100.0, -1.0), (1.0, 1.0))
    separation = -0.5 - float(hm.heights.mean())
    run = solve_contacts(hm, HalfSpace.from_modulus(1.0), separations=[separation])
    table = run.microcontacts()
    assert len(table) == 1
    assert table["angle"][0] == pytest.approx(turn, abs=0.02)
    assert 0.3 < table["semi_minor"][0] / table["semi_major"][0] < 0.5
