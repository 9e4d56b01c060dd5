"""Basins pressed alone: exact contacts, whatever the grid, and what a law table makes of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import asperity
from asperity.errors import Flag
from asperity.microcontact.basin_bem import press
from asperity.microcontact.hertz import elliptic_contact
from asperity.microcontact.laws import tabulate
from asperity.microcontact.yielding import capped
from asperity.model.corrections import pressed_basins
from asperity.model.law_rows import LawRows, LoadShares
from asperity.parameters import DEFAULTS
from surfaces import HeightMap, resample, segment, self_affine
from surfaces.peaks._climb import PLATEAU
from surfaces.peaks.summits import Summits, locate_summits

BODY = asperity.HalfSpace.from_modulus(2.0)


def summits_of(hm: HeightMap) -> Summits:
    return locate_summits(hm, segment(hm))


def ellipsoid(k1: float, k2: float, angle: float) -> HeightMap:
    """A paraboloid on pixels that are not square, its summit between them."""
    ny, nx, dy, dx = 61, 83, 1.3, 0.9
    y, x = (np.arange(ny) - 29.7)[:, None] * dy, (np.arange(nx) - 41.2) * dx
    c, s = np.cos(angle), np.sin(angle)
    gap = 0.5 * (k2 * (c * x + s * y) ** 2 + k1 * (c * y - s * x) ** 2)
    return HeightMap(-gap, (dy, dx))


def lumpy(points: int) -> HeightMap:
    """One smooth summit with lobes, the same surface at any number of points."""
    y, x = np.meshgrid(
        *((np.arange(n) + 0.5) / n - 0.5 for n in (points, points + 12)), indexing="ij"
    )
    gap = 3 * x**2 + 8 * y**2 + 9 * x**3 - 25 * x * y**2 + 60 * (x**4 + y**4) + 8 * x * y
    return HeightMap(-gap, (1.0 / points, 1.0 / (points + 12)))


@pytest.mark.parametrize("m", [0.0, 0.4, -0.3])
@pytest.mark.parametrize(("ratio", "angle"), [(1.0, 0.0), (6.0, 0.5), (25.0, -1.1)])
def test_ellipsoid(m, ratio, angle):
    k2 = 0.01
    body = asperity.HalfSpace.from_modulus(2.0, m=m)
    depth = np.array([[0.1, 0.7]])
    found = press.press(
        summits_of(ellipsoid(ratio * k2, k2, angle)), np.zeros(1, np.int64), depth, body
    )[0]
    exact = elliptic_contact(ratio * k2, k2, depth[0], body)
    np.testing.assert_allclose(found[:, 0], exact.force, rtol=6e-3)
    area = np.pi * exact.semi_major * exact.semi_minor
    np.testing.assert_allclose(found[:, 1], area, rtol=0.03 if m >= 0 else 0.04)
    np.testing.assert_allclose(found[:, 2:4], 0.0, atol=0.02 * np.sqrt(area.max()))
    long, short = exact.semi_major**2 / (5 + m), exact.semi_minor**2 / (5 + m)
    c, s = np.cos(angle), np.sin(angle)
    moments = np.array(
        [long * s * s + short * c * c, long * c * c + short * s * s, (long - short) * s * c]
    )
    np.testing.assert_allclose(found[:, 4:7], moments.T, atol=0.02 * long.max())


def areas(hm: HeightMap, force: float, depth: float, body: asperity.HalfSpace, tilt=None) -> float:
    one, summits = np.zeros(1, np.int64), summits_of(hm)
    if tilt is not None:
        summits = summits.tilted(one, np.array([tilt]), np.array([0.1 * depth]))
    return float(press.areas_under(summits, one, np.array([force]), np.array([depth]), body)[0])


@pytest.mark.parametrize("m", [0.0, 0.4, -0.3])
@pytest.mark.parametrize(("ratio", "angle"), [(1.0, 0.0), (6.0, 0.5)])
def test_ellipsoid_by_a_force_under_a_hardness(m, ratio, angle):
    """Its law before yield; the law of yielded ellipsoids; force over hardness at last."""
    k2, depth = 0.01, 0.5
    hm, elastic = ellipsoid(ratio * k2, k2, angle), asperity.HalfSpace.from_modulus(2.0, m=m)
    exact = elliptic_contact(ratio * k2, k2, depth, elastic)
    force, stiffness = float(exact.force), float(exact.stiffness)
    area = float(np.pi * exact.semi_major * exact.semi_minor)
    level = 0.5 * np.sqrt(ratio) * k2 * area / np.pi
    for over, within in ((10.0, 0.04), (1.2, 0.04), (0.8, 0.04), (0.5, 0.04), (0.1, 0.01)):
        body = asperity.HalfSpace.from_modulus(2.0, m=m, hardness=over * force / area)
        law = capped(depth, force, area, stiffness, body, level=level)
        found = areas(hm, float(law.force), float(law.approach), body)
        assert found == pytest.approx(area, rel=within)
        assert found >= law.force / body.hardness * (1.0 - 1e-9)


@pytest.mark.parametrize("depth", [0.2, 0.5, 1.5])
def test_about_the_approach_is_enough_for_an_area(depth):
    body = asperity.HalfSpace.from_modulus(2.0, hardness=0.06)
    hm = ellipsoid(0.03, 0.01, 0.5)
    assert areas(hm, 2.0, depth, body) == pytest.approx(areas(hm, 2.0, 0.4, body), rel=0.03)


def test_a_far_too_large_approach_does_not_go_on_for_ever():
    """Saw teeth, whose spline lies above their highest pixels, and a flat that hardly enters them:
    the next approach was zero, and the grid of elements without size. Cells of 37 x 32 points."""
    heights = np.tile(np.arange(32.0) % 4, (37, 1))
    hm = HeightMap(heights, (1e-4, 1.7e-3), periodic=True)
    body = asperity.HalfSpace.from_modulus(1.0, hardness=1.3e-9)
    curve = asperity.contact_curve(hm, body, pressures=[2.5e-17])
    assert curve.converged.all()
    assert curve.contact_area[0] >= curve.load[0] / body.hardness


def test_a_tilted_paraboloid_is_a_paraboloid():
    body = asperity.HalfSpace.from_modulus(2.0, hardness=0.06)
    hm = ellipsoid(0.03, 0.01, 0.5)
    level = areas(hm, 2.0, 0.4, body)
    assert areas(hm, 2.0, 0.4, body, tilt=(0.06, -0.05)) == pytest.approx(level, rel=0.03)


def test_a_softer_body_has_a_larger_area():
    hm, hardness = lumpy(60), np.geomspace(2.0, 0.1, 7)
    bodies = [asperity.HalfSpace.from_modulus(2.0, hardness=h) for h in hardness]
    found = np.array([areas(hm, 2e-3, 0.03, body) for body in bodies])
    assert (np.diff(found) > -0.02 * found[1:]).all() and found[-1] > 1.5 * found[0]
    assert (found >= 2e-3 / hardness * (1.0 - 1e-9)).all()


def test_more_than_a_basin_bears_at_the_hardness_has_no_area():
    body = asperity.HalfSpace.from_modulus(2.0, hardness=1e-3)
    assert areas(ellipsoid(0.03, 0.01, 0.5), 1e6, 0.4, body) == 0.0


def test_lobes_as_the_whole_map_pressed():
    hm = lumpy(60)
    fine = resample(hm, np.asarray(hm.spacing) / 4)
    summits = summits_of(hm)
    depth = np.array([[0.02, 0.1]])
    found = press.press(summits, np.zeros(1, np.int64), depth, BODY)[0]
    for d, (force, area, *_) in zip(depth[0], found, strict=True):
        level = summits.height[0] - d - fine.heights.mean()
        whole = asperity.bem_solve(fine, BODY, separation=level, boundary="free")
        assert force == pytest.approx(whole.load, rel=5e-3)
        assert area == pytest.approx(whole.contact_area, rel=0.02)


def test_pixels_do_not_matter():
    depth = np.array([[0.03, 0.08, 0.15]])
    coarse, fine = (
        press.press(summits_of(lumpy(n)), np.zeros(1, np.int64), depth, BODY)[0] for n in (40, 90)
    )
    np.testing.assert_allclose(coarse[:, 0], fine[:, 0], rtol=4e-3)
    np.testing.assert_allclose(coarse[:, 1], fine[:, 1], rtol=0.03)


def test_exchanging_the_axes_exchanges_the_centre():
    """The lobed contact lies askew to the pixels and beside its summit."""
    hm, depth = lumpy(48), np.array([[0.03, 0.1]])
    turned = HeightMap(hm.heights.T, hm.spacing[::-1])
    found, other = (
        press.press(summits_of(each), np.zeros(1, np.int64), depth, BODY)[0]
        for each in (hm, turned)
    )
    size = np.sqrt(found[:, 1])
    assert (np.abs(found[:, 2:4]).min(axis=1) > 0.01 * size).all()
    np.testing.assert_allclose(other[:, :2], found[:, :2], rtol=6e-3)
    np.testing.assert_allclose(other[:, 2:4], found[:, 3:1:-1], atol=3e-3 * size.max())
    moments = found[:, [5, 4, 6]]
    np.testing.assert_allclose(other[:, 4:7], moments, atol=3e-3 * np.square(size.max()))


@pytest.mark.parametrize("shift", [(0, 0), (-30, -41), (-31, -42), (30, 41)])
def test_a_contact_across_the_seam_of_a_periodic_map(shift):
    """Its summit lies between pixels on both sides of the seam."""
    hm = ellipsoid(0.03, 0.01, 0.5)
    there = HeightMap(np.roll(hm.heights, shift, (0, 1)), hm.spacing, periodic=True)
    depth = np.array([[0.05, 0.4]])
    found = press.press(summits_of(there), np.zeros(1, np.int64), depth, BODY)[0]
    exact = elliptic_contact(0.03, 0.01, depth[0], BODY)
    np.testing.assert_allclose(found[:, 0], exact.force, rtol=6e-3)
    np.testing.assert_allclose(found[:, 2:4], 0.0, atol=0.02 * exact.semi_major.max())


def test_below_what_was_segmented_nothing_is_pressed():
    hm = ellipsoid(0.03, 0.01, 0.5)
    summits = locate_summits(hm, segment(hm, above=-0.5))
    found = press.press(summits, np.zeros(1, np.int64), np.array([[0.4, 0.6]]), BODY)[0]
    assert found[0, 0] > 0 and not found[1].any()


@pytest.fixture(scope="module")
def rough() -> Summits:
    return summits_of(
        self_affine(
            (96, 128), (96.0, 160.0), hurst=0.8, rms_slope=0.1, rolloff=60.0, cutoff=9.0,
            anisotropy=3.0, seed=4,
        )
    )  # fmt: skip


def test_tables_keep_what_the_expansion_describes(rough):
    rows = np.flatnonzero(rough.valid)[:12]
    table = tabulate(rough.rows(rows), BODY, law="ellipse")
    before = {name: getattr(table, name).copy() for name in ("force", "stiffness", "area")}
    beyond = (table.flags & Flag.BEYOND_RADIUS) > 0
    slots = np.flatnonzero(beyond.any(axis=1) & (table.reach > 0))
    assert slots.size
    press.put(table, slots, rough, rows[slots], BODY)
    for slot in range(len(rows)):
        kept = int(beyond[slot].argmax()) - 1 if slot in slots else table.nodes + 1
        for name, values in before.items():
            np.testing.assert_array_equal(getattr(table, name)[slot, :kept], values[slot, :kept])
    new = table.spread[slots] == press.EXPECTED_ERROR
    assert new[:, -1].all()
    assert (table.force[slots] > 0)[:, 1:].all()
    assert (np.diff(table.force[slots], axis=1) > 0).all()


def test_stiffness_is_the_slope_of_the_force(rough):
    rows = np.flatnonzero(rough.valid)[:12]
    table = tabulate(rough.rows(rows), BODY, law="ellipse")
    slots = np.flatnonzero((table.flags & Flag.BEYOND_RADIUS).any(axis=1) & (table.reach > 0))
    press.put(table, slots, rough, rows[slots], BODY)
    depth = table.reach[slots, None] * np.linspace(0.45, 0.95, 9) ** 2
    step = 1e-4 * table.reach[slots, None]
    high, low = (table.evaluate(slots[:, None], depth + s)[0] for s in (step, -step))
    slope = table.evaluate(slots[:, None], depth)[1]
    np.testing.assert_allclose((high - low) / (2 * step), slope, rtol=1e-3)


def pressed_slots(summits, rows, table):
    """Slots of the laws that are pressed alone."""
    shares = LoadShares.of(summits)
    profiles = summits.rows(rows)
    return pressed_basins.pressed_slots(
        LawRows(table, rows, profiles, summits, shares, BODY, DEFAULTS)
    )


def test_few_contacts_are_dominant_whatever_is_asked_for(rough):
    rows = np.flatnonzero(rough.valid)
    table = tabulate(rough.rows(rows), BODY, law="ellipse")
    chosen = pressed_slots(rough, rows, table)
    assert 0 < chosen.size < 0.5 * len(rows)
    part = rows[::3]
    some = pressed_slots(rough, part, tabulate(rough.rows(part), BODY, law="ellipse"))
    np.testing.assert_array_equal(part[some], np.intersect1d(rows[chosen], part))
    inside = replace(table, flags=np.zeros_like(table.flags))
    assert pressed_slots(rough, rows, inside).size == 0


LONG_RIDGES = {
    "shape": (256, 256),
    "size": (256.0, 256.0),
    "hurst": 0.8,
    "rolloff": 32.0,
    "cutoff": 8.0,
} | {"anisotropy": 4.0, "seed": 13}

SMOOTH_HILLS = (  # a coarser grid holds them
    {"shape": (120, 160), "size": (120.0, 192.0), "hurst": 0.9, "cutoff": 24.0, "seed": 8}
)


@pytest.mark.parametrize(
    ("recipe", "pressure"), [(LONG_RIDGES, 4e-4), (SMOOTH_HILLS, 6e-3)], ids=["ridges", "hills"]
)
def test_load_of_few_contacts_comes_out(recipe, pressure):
    hm = self_affine(**recipe, rms_slope=0.1)
    fine = resample(hm, np.asarray(hm.spacing) / 2)
    exact = asperity.bem_solve(fine, BODY, pressure=pressure, tolerance=1e-3)
    apart, alone = (
        asperity.contact_curve(hm, BODY, separations=exact.separation, law=law)
        for law in ("auto", "ellipse")
    )
    assert apart.load[0] == pytest.approx(exact.load, rel=0.012)
    assert abs(alone.load[0] / exact.load - 1) > 0.02


def test_peaks_without_a_summit_of_their_own_are_pressed_sooner(rough):
    rows = np.flatnonzero(rough.valid)
    table = tabulate(rough.rows(rows), BODY, law="ellipse")
    chosen = pressed_slots(rough, rows, table)
    beyond = (table.flags & Flag.BEYOND_RADIUS).any(axis=1) & (table.reach > 0)
    other = np.setdiff1d(np.flatnonzero(beyond & ~rough.border[rows]), chosen)[:1]
    kinds = rough.kinds.copy()
    kinds[rows[other]] = PLATEAU
    found = pressed_slots(replace(rough, kinds=kinds), rows, table)
    np.testing.assert_array_equal(np.setdiff1d(found, chosen), other)


def test_the_law_of_joined_summits_goes_on_from_the_first(rough):
    pairs = rough.owner[rough.peaks.neighbors]
    some = rough.valid[pairs].all(axis=1) & ~rough.border[pairs].any(axis=1)
    some &= pairs[:, 0] != pairs[:, 1]
    pair, low = pairs[some][:1], rough.peaks.passes[some][:1]
    one = rough.joined(pair, low - 0.1)
    into, lost = sorted(pair[0], key=lambda row: -rough.height[row])
    assert one.owner[lost] == into and one.owner[into] == into
    table = tabulate(one.rows(np.array([into, lost])), BODY, law="ellipse")
    assert table.reach[1] == 0.0  # the lower one carries nothing of its own
    before = table.force[0].copy()
    slots = pressed_slots(one, np.array([into, lost]), table)
    np.testing.assert_array_equal(slots, [0])
    press.put(table, slots, one, np.array([into]), BODY)
    touch = rough.height[into] - rough.height[lost]
    ahead = table.approach()[0] < 0.9 * touch
    beyond = (table.flags[0] & Flag.BEYOND_RADIUS) > 0
    kept = ahead & ~beyond
    np.testing.assert_allclose(table.force[0, kept], before[kept], rtol=5e-3)
    assert (np.diff(table.force[0]) > 0).all()


def test_small_contacts_far_apart_get_elements_of_their_own():
    """Nine equal spheres pressed as one: elements resolve contacts, not the box about them all."""
    radius, pitch, depth = 40.0, 30, np.array([0.1, 0.2, 0.3, 0.5, 0.8])
    place = (np.arange(3 * pitch) % pitch - 14.7) ** 2
    one = summits_of(HeightMap(-(place[:, None] + place) / (2.0 * radius), (1.0, 1.0)))
    pairs = np.array([(0, other) for other in range(1, 9)])
    joined = one.joined(pairs, np.full(8, one.peaks.passes.min() - 0.1))
    found = press.press(joined, joined.owner[:1], depth[None], BODY)[0]
    apart = np.hypot(*(one.places[:, None] - one.places).T)
    sunk = 1.0 / (np.pi * BODY.modulus * np.where(apart > 0.0, apart, np.inf))
    left = np.tile(depth, (9, 1))
    for _ in range(50):  # Hertz, each in the field of the others
        force = 4.0 / 3.0 * BODY.modulus * (radius * left**3) ** 0.5
        left = depth - sunk @ force
    np.testing.assert_allclose(found[:, 0], force.sum(axis=0), rtol=0.025)
    np.testing.assert_allclose(found[:, 1], np.pi * radius * left.sum(axis=0), rtol=0.1)
