"""No law is silent: every flag is raised on a constructed profile, by every law."""

from __future__ import annotations

import numpy as np
import pytest

from asperity import HalfSpace, indent
from asperity.microcontact import Flag
from asperity.microcontact.single.indent import SOLVERS
from surfaces import (
    HeightMap,
    PolarProfile,
    PowerLawProfile,
    PowerSumProfile,
    fit_profiles,
    segment,
)
from surfaces.shapes import polygon, random_section

LAWS = [*SOLVERS]
TIPS = ["paper", "harmonic", "ellipse", "ritz", "auto"]
TURN = 2 * np.pi * np.arange(48) / 48
BODY = HalfSpace.from_modulus(1.0)

pytestmark = pytest.mark.filterwarnings("error")


def flags_of(profile, depths, law):
    one = indent(profile, BODY, np.asarray(depths, float), law=law)
    for values in (one.force, one.contact_area, one.stiffness):
        marked = (one.flags & Flag.TURNING) > 0
        assert np.all(np.isfinite(values) | marked)
    assert np.all(one.force[np.isfinite(one.force)] >= 0)
    return [Flag(int(bits)) for bits in one.flags], one


def table(gap, radius=2.5, nodes=60):
    r = np.linspace(0, radius, nodes)
    x, y = r[:, None] * np.cos(TURN), r[:, None] * np.sin(TURN)
    return PolarProfile(r, TURN, gap(x, y))


@pytest.mark.parametrize("law", TIPS)
def test_contour_out_of_range(law):
    """Corners so sharp that the first-order radius turns negative."""
    (flag,), one = flags_of(PowerLawProfile(1, lambda p: 1 + 0.75 * np.cos(3 * p)), [0.1], law)
    assert flag & Flag.CONTOUR_DOUBTFUL
    if law == "paper":
        assert flag & Flag.CONTOUR_NEGATIVE and not one.valid.any()


@pytest.mark.parametrize("law", LAWS)
def test_mean_profile_that_turns_over(law):
    """r^2 - r^4: no approach above a quarter has a solution."""
    flags, one = flags_of(PowerSumProfile([2, 4], [1.0, -1.0]), [0.02, 10.0], law)
    assert flags[0] & ~(Flag.SECOND_SUMMIT) == 0
    assert not one.valid[1]
    if law != "hertz":
        assert np.isnan(one.force[1]) and flags[1] & Flag.TURNING


@pytest.mark.parametrize("law", LAWS)
def test_higher_neighbor(law):
    """A body that stands higher beside the summit meets the flat at any approach."""
    profile = table(lambda x, y: np.minimum(x * x + y * y, (x - 1.5) ** 2 + y * y - 0.3))
    flags, one = flags_of(profile, [1e-3, 0.1], law)
    assert all(flag & Flag.SECOND_SUMMIT for flag in flags) and not one.valid.any()


@pytest.mark.parametrize("law", LAWS)
def test_second_summit_and_falling_rays(law):
    profile = table(lambda x, y: np.minimum(x * x + y * y, (x - 1.5) ** 2 + y * y + 0.05))
    flags, _ = flags_of(profile, [0.01, 0.3, 2.0], law)
    assert flags[0] == 0
    assert flags[1] & Flag.SECOND_SUMMIT
    assert flags[2] & (Flag.RAY_TURNS | Flag.TURNING)


@pytest.mark.parametrize("law", LAWS)
def test_negative_gap_inside_the_contact(law):
    profile = table(lambda x, y: (x * x + y * y) * np.cos(2.0 * np.hypot(x, y)), radius=1.2)
    flags, one = flags_of(profile, [0.01, 1.6], law)
    assert flags[1] & (Flag.NEGATIVE_GAP | Flag.TURNING | Flag.SECOND_SUMMIT)
    assert not one.valid[1]


@pytest.mark.parametrize("law", LAWS)
def test_dent_on_one_side(law):
    """f falls for a stretch of some rays, at 0.5 < r < 0.65 where x > 0."""

    def dented(x, y):
        r = np.hypot(x, y)
        side = np.clip(x / np.maximum(r, 1e-9), 0, None) ** 2
        return r * r - 0.3 * side * np.exp(-(((r - 0.65) / 0.12) ** 2))

    flags, _ = flags_of(table(dented), [0.05, 0.9], law)
    assert not flags[0] & Flag.RAY_TURNS and flags[1] & Flag.RAY_TURNS


@pytest.mark.parametrize("law", LAWS)
def test_contact_beyond_the_sampled_radius(law):
    profile = table(lambda x, y: x * x + 1.5 * y * y, radius=0.2)
    flags, _ = flags_of(profile, [0.01, 0.3], law)
    assert flags[0] == 0 and flags[1] & Flag.BEYOND_RADIUS


@pytest.mark.parametrize("law", TIPS)
def test_contact_inside_the_first_sampled_radius(law):
    """Of r^4 the force was 16 to 100 % low there, at a stated error of 0.1 %."""
    flags, _ = flags_of(table(lambda x, y: (x * x + y * y) ** 2, nodes=21), [1e-5, 0.5], law)
    assert flags[0] & Flag.BEYOND_RADIUS and not flags[1]


@pytest.mark.parametrize("law", ["paper", "harmonic"])
def test_long_contacts_at_strong_grading(law):
    """Near m = 1 their first-order contour is too round to look doubtful."""
    long = PowerLawProfile(2, lambda p: np.cos(p) ** 2 + (np.sin(p) / 9.8) ** 2)
    one = indent(long, HalfSpace.from_modulus(1.0, 0.95), 0.1, law=law)
    assert one.flags & Flag.CONTOUR_DOUBTFUL


@pytest.mark.parametrize("law", LAWS)
def test_small_contacts_are_looked_at_as_closely_as_large_ones(law):
    """Flags of one approach do not depend on the other approaches asked for."""
    profile = table(lambda x, y: np.minimum(x * x + y * y, (x - 1.5) ** 2 + y * y + 0.05))
    alone, _ = flags_of(profile, [0.01], law)
    together, _ = flags_of(profile, [0.01, 1.0], law)
    assert alone[0] == together[0]


def test_no_warning_far_out_of_range():
    """A far too deep approach ends in flags, not in warnings."""
    profile = table(lambda x, y: x * x + 2 * y * y + 0.3 * x**3, radius=0.3)
    for law in LAWS:
        flags, _ = flags_of(profile, [1e-9, 1e3], law)
        assert flags[1]


@pytest.mark.parametrize("law", LAWS)
def test_neighbor_of_a_summit_cut_from_a_map(law):
    """Two bumps with a saddle between: the lower the saddle, the deeper the contact may go."""
    y, x = np.mgrid[0:60, 0:90] * np.array([1.1e-6, 1e-6])[:, None, None]
    bumps = [
        h - ((x - x0) ** 2 + (y - 33e-6) ** 2) / 40e-6 for h, x0 in ((0, 30e-6), (-1e-6, 52e-6))
    ]
    hm = HeightMap(np.maximum(*bumps), (1.1e-6, 1e-6))
    profile = fit_profiles(hm, segment(hm)).profile(0)
    saddle = float(np.min(profile(profile.edge, profile.phi)))
    assert saddle == pytest.approx(3.54e-6, rel=0.1)
    one = indent(profile, BODY, np.array([0.5, 2.0]) * saddle, law=law)
    assert not one.flags[0] & Flag.SECOND_SUMMIT and one.valid[0]
    assert one.flags[1] & Flag.SECOND_SUMMIT and not one.valid[1]


@pytest.mark.parametrize("hardness", [np.inf, 6e7])
def test_harmonics_larger_than_the_mean_radius_leave_an_area(hardness):
    """It was negative and, under a hardness, the force was the elastic one: 18 times that of
    boundary elements at 27 % stated."""
    body, depth = random_section(1.5, deviation=0.3, seed=2), np.array([0.002, 0.02])
    material = HalfSpace.from_modulus(1e9, -0.6, hardness=hardness)
    one = indent(body, material, depth, law="harmonic")
    assert (one.contact_area > 0.0).all() and not one.valid.any()
    assert (one.force <= hardness * one.contact_area * (1.0 + 1e-9)).all()
    best = indent(body, material, depth, law="auto")
    np.testing.assert_allclose(one.force, best.force, rtol=0.03)


def test_contacts_of_a_power_law_are_similar():
    """The search on a kinked body ended elsewhere at each approach, so that areas over the approach
    were up to 7 % apart, and under a hardness loads and approaches within reach were refused."""
    body, depth = polygon(4, 2.0), 0.02 * np.geomspace(0.5, 2.0, 9)
    soft = HalfSpace.from_modulus(1e9, -0.6)
    ratios = [float(indent(body, soft, d, law="auto").contact_area) / d for d in depth]
    np.testing.assert_allclose(ratios, ratios[0], rtol=1e-9)
    hard = HalfSpace.from_modulus(1e9, -0.6, hardness=6e7)
    one = indent(polygon(3, 2.0), hard, depth, law="auto")
    back = indent(polygon(3, 2.0), hard, load=one.force, law="auto")
    np.testing.assert_allclose(back.approach, depth, rtol=1e-6)


@pytest.mark.parametrize("law", TIPS)
def test_gaps_beyond_the_largest_number_are_no_fall(law):
    """Two of them made a RuntimeWarning of a body of a high power, from r^300 on."""
    flags, _ = flags_of(PowerLawProfile(700.0, 1.0), [1e-6, 1.0], law)
    assert not any(bits & Flag.RAY_TURNS for bits in flags)
