"""The curve of the model on large maps, checked on parts of them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import asperity
import surfaces
from asperity.engine import part_misfit, parts
from asperity.halfspace.scene import default_pressures
from asperity.trust.verified import Accuracy
from surfaces.files.stored_map import StoredMap
from surfaces.numerics import stored_array

BODY = asperity.HalfSpace.from_modulus(1.0)


@pytest.fixture(autouse=True)
def small_maps_count(monkeypatch):
    """Maps of 512 points along a side are taken for large ones."""
    monkeypatch.setattr(parts, "PARTS", replace(parts.PARTS, least_points=512))


def waves(**recipe: object) -> surfaces.HeightMap:
    recipe = {"hurst": 0.8, "rms_slope": 0.1, "cutoff": 5.0, "rolloff": 40.0, "seed": 8} | recipe
    return surfaces.self_affine((512, 512), (512.0, 512.0), **recipe)


def truth(hm, body, loads, boundary=None):
    return asperity.bem_curve(hm, body, pressures=loads, accuracy=0.01, boundary=boundary)


def off(curve, true):
    """Errors of load at equal separation and of area at equal load, shape (2, n)."""
    load = true.stiffness / true.mean_pressure * (curve.separation - true.separation)
    return np.abs([load, np.log(curve.contact_area / true.contact_area)])


def bounds(curve):
    return np.array([curve.error_estimate, curve.extra["area_error_estimate"]])


def two_scales() -> surfaces.HeightMap:
    """Long hills, and a band of short waves a tenth as high."""
    size = (768, 768), (768.0, 768.0)
    hills, short = (
        surfaces.self_affine(*size, rms_slope=0.1, **recipe)
        for recipe in (
            {"hurst": 1.0, "cutoff": 38.4, "rolloff": 384.0, "seed": 5},
            {"hurst": 0.8, "cutoff": 4.0, "rolloff": 10.0, "seed": 105},
        )
    )
    ratio = 0.1 * hills.roughness.rms_height / short.roughness.rms_height
    return hills.replace(heights=hills.heights + ratio * short.heights)


SCENES = {
    "periodic": (waves(), BODY, None),
    "broad": (
        surfaces.self_affine((1536, 1536), (1536.0,) * 2, hurst=0.8, rms_slope=0.1, seed=8),
        BODY,
        None,
    ),
    "free": (waves(seed=9), BODY, "free"),
    "as long as parts": (waves(cutoff=20.0, rolloff=133.0, seed=3), BODY, None),
    "two scales": (two_scales(), BODY, None),
}


@pytest.mark.parametrize("name", SCENES)
def test_bounds_hold(name):
    hm, body, boundary = SCENES[name]
    loads = default_pressures(hm, body, 5)
    curve = asperity.solve(hm, body, pressures=loads, engine="sampled", boundary=boundary)
    assert curve.converged.all() and curve.verification["met"]
    true = truth(hm, body, loads, boundary)
    assert (off(curve, true) <= bounds(curve) + bounds(true)).all()


def test_an_error_of_the_model_is_found_and_corrected():
    """Summits taken for round paraboloids that go on for ever."""
    hm = waves(seed=12)
    loads = default_pressures(hm, BODY, 6)
    plan = asperity.make_plan(hm, BODY, pressures=loads, law="hertz")
    run, true = asperity.solve_contacts(hm, BODY, plan, pressures=loads), truth(hm, BODY, loads)
    assert off(run.curve, true)[0].max() > 0.15
    curve = parts.sampled(hm, run, None, Accuracy(), progress=lambda _: None)
    assert (off(curve, true) <= bounds(curve) + bounds(true)).all()
    assert off(curve, true)[0].max() < 0.4 * off(run.curve, true)[0].max()


def test_the_model_answers_on_a_part_as_on_the_whole(monkeypatch):
    """A map of 16 equal parts. Contacts that carry a tenth of a part carry little of the whole,
    and are pressed alone on neither; areas differed by 2 %."""
    part = surfaces.self_affine(
        (64, 64), (64.0, 64.0), hurst=0.8, rms_slope=0.1, cutoff=20.0, seed=3
    )
    hm = part.replace(heights=np.tile(part.heights, (4, 4)))
    loads = 3.0 * default_pressures(hm, BODY, 4)[:3]
    plan = asperity.make_plan(hm, BODY, pressures=loads)
    run, found = asperity.solve_contacts(hm, BODY, plan, pressures=loads), []

    def answered(one, plan, pressures, **told):
        scene = replace(plan, scene=(one, BODY))
        curve = asperity.contact_curve(one, BODY, pressures=pressures, plan=scene)
        if one.shape == part.shape:
            found.append(np.log(curve.area_fraction / np.interp(pressures, loads, areas)))
        return np.zeros((5, len(pressures)))

    areas = run.curve.area_fraction
    monkeypatch.setattr(parts, "PartMisfit", lambda *_: answered)
    parts.sampled(hm, run, None, Accuracy(), progress=lambda _: None)
    assert len(found) >= part_misfit.PARTS.alike
    assert np.abs(np.concatenate(found)).max() < 0.01


def test_the_lightest_contact_is_that_of_the_part_that_carries_most():
    """One that next to nothing presses would stand for no load point of the whole."""
    hm, seen = waves(), []
    loads = default_pressures(hm, BODY, 5)
    asperity.solve(hm, BODY, pressures=loads, engine="sampled", progress=seen.append)
    assert seen and min(point.mean_pressure for point in seen) >= 0.99 * loads[0]


def test_separations_are_answered_as_pressures_are():
    hm = waves()
    loads = default_pressures(hm, BODY, 6)
    by_load = asperity.solve(hm, BODY, pressures=loads, engine="sampled")
    again = asperity.solve(hm, BODY, separations=by_load.separation, engine="sampled")
    np.testing.assert_allclose(again.mean_pressure, loads, rtol=0.05)
    np.testing.assert_allclose(again.contact_area, by_load.contact_area, rtol=0.1)


def test_the_answer_scales():
    """Another unit of length and another modulus: the same numbers."""
    hm = waves(seed=13)
    loads = default_pressures(hm, BODY, 5)
    scaled = surfaces.HeightMap(1e-6 * hm.heights, (1e-6, 1e-6), periodic=True)
    steel = asperity.HalfSpace.from_modulus(3e11)
    one = asperity.solve(hm, BODY, pressures=loads, engine="sampled")
    two = asperity.solve(scaled, steel, pressures=3e11 * loads, engine="sampled")
    np.testing.assert_allclose(two.separation, 1e-6 * one.separation, rtol=1e-4)
    np.testing.assert_allclose(two.area_fraction, one.area_fraction, rtol=1e-3)
    np.testing.assert_allclose(two.error_estimate, one.error_estimate, rtol=1e-2)


@pytest.mark.parametrize("recipe", [{"seed": 14}, {"seed": 3, "cutoff": 20.0, "rolloff": 133.0}])
def test_a_map_moved_or_mirrored_has_the_same_parts(recipe):
    hm = waves(**recipe)
    loads = default_pressures(hm, BODY, 5)
    one = asperity.solve(hm, BODY, pressures=loads, engine="sampled")
    for heights in (np.roll(hm.heights, (101, 333), (0, 1)), hm.heights[:, ::-1], hm.heights.T):
        moved = surfaces.HeightMap(np.ascontiguousarray(heights), (1.0, 1.0), periodic=True)
        two = asperity.solve(moved, BODY, pressures=loads, engine="sampled")
        assert (off(two, one) <= 0.1 * bounds(one)).all()


def test_where_boundary_elements_of_the_whole_do_not_fit(monkeypatch):
    """The bounds are those of the parts, met or not."""
    monkeypatch.setattr("asperity.engine.solve.fits", lambda *_: False)
    hm = waves()
    loads = default_pressures(hm, BODY, 6)
    curve = asperity.solve(hm, BODY, pressures=loads)
    assert curve.settings["engine"] == "sampled" and curve.verification["anchors"] == []
    assert (off(curve, true := truth(hm, BODY, loads)) <= bounds(curve) + bounds(true)).all()


def test_a_map_on_disk_stays_there(monkeypatch):
    """Its parts are read, the whole never is, and the answer is that of the map in memory."""
    monkeypatch.setattr("asperity.engine.solve.fits", lambda *_: False)
    monkeypatch.setattr(stored_array, "BLOCK_BYTES", 8 * 1024 * 60)
    hm = surfaces.self_affine((1024, 1024), (1024.0, 1024.0), hurst=0.8, rms_slope=0.1, seed=8)
    blocks = ((row, hm.heights[row : row + 64]) for row in range(0, 1024, 64))
    kept = StoredMap.of_blocks(blocks, hm.shape, np.float64, hm.spacing, periodic=True)
    loads = default_pressures(hm, BODY, 5)
    known, found = (asperity.solve(each, BODY, pressures=loads) for each in (hm, kept))
    assert "heights" not in vars(kept) and found.settings["engine"] == "sampled"
    for name in ("separation", "contact_area", "error_estimate"):
        np.testing.assert_allclose(getattr(found, name), getattr(known, name), rtol=1e-4)


def test_a_hill_within_one_part_is_not_told_by_the_others(monkeypatch):
    """All of the load is on one part, which would be pressed harder than the whole ever is."""
    monkeypatch.setattr("asperity.engine.solve.fits", lambda *_: False)
    monkeypatch.setattr(parts, "random_map", lambda *_: True)
    monkeypatch.setattr(part_misfit, "PARTS", replace(part_misfit.PARTS, long_waves=1.0))
    loads = default_pressures(hill(), BODY, 5)[-2:]
    curve = asperity.solve(hill(), BODY, pressures=np.geomspace(*loads, 5))
    assert np.isnan(bounds(curve)).all() and not curve.verification["met"]


def test_load_points_of_which_no_part_tells_are_solved_on_the_whole(monkeypatch):
    """The estimate of the model is no bound: it was off fourfold on such a map."""
    hm, told = waves(), part_misfit.misfit_on_parts
    loads = default_pressures(hm, BODY, 6)

    def some_told(*scene):
        misfit, bounds, floor = told(*scene)
        misfit[:, -2:] = bounds[:, -2:] = np.nan
        return misfit, bounds, floor

    monkeypatch.setattr(parts, "misfit_on_parts", some_told)
    curve = asperity.solve(hm, BODY, pressures=loads, engine="sampled")
    assert {3, 5} <= {*curve.verification["anchors"]} and curve.verification["met"]


def test_a_load_point_solved_on_the_whole_serves_those_beside_it(monkeypatch):
    """The lightest alone is solved there; between it and those that parts tell the model is as
    uncertain as parts leave it at best."""
    hm, told = waves(), part_misfit.misfit_on_parts
    loads = default_pressures(hm, BODY, 10)

    def all_but_the_lightest(*scene):
        misfit, bounds, floor = told(*scene)
        misfit[:, 0] = bounds[:, 0] = np.nan
        return misfit, bounds, floor

    monkeypatch.setattr(parts, "misfit_on_parts", all_but_the_lightest)
    curve = asperity.solve(hm, BODY, pressures=loads, engine="sampled")
    assert curve.verification["anchors"] == [0] and curve.verification["met"]
    assert curve.error_estimate[0] < part_misfit.PARTS.floor[0] <= curve.error_estimate[1]
    true = truth(hm, BODY, loads)
    assert (off(curve, true) <= bounds(curve) + bounds(true)).all()


def test_parts_that_carry_most_of_a_heavy_load_are_solved(monkeypatch):
    """They are pressed harder than the mean, and hold most of the area."""
    hm, solved = hill(0.4), []
    monkeypatch.setattr(parts, "PARTS", replace(parts.PARTS, loads=2))
    judged = part_misfit.PartMisfit.__call__

    def seen(judge, part, plan, pressures, **told):
        solved.append(pressures[-1])
        return judged(judge, part, plan, pressures, **told)

    monkeypatch.setattr(part_misfit.PartMisfit, "__call__", seen)
    loads = default_pressures(hm, BODY, 5)
    asperity.solve(hm, BODY, pressures=loads, engine="sampled")
    assert loads[-1] < max(solved) <= part_misfit.PARTS.heaviest * loads[-1]


def hill(height: float = 60.0) -> surfaces.HeightMap:
    """Waves, and a hill of the size of a part in one of them."""
    hm = waves()
    y, x = np.meshgrid(hm.y, hm.x, indexing="ij")
    bump = height * np.exp(-((y - 192.0) ** 2 + (x - 320.0) ** 2) / 40.0**2)
    return surfaces.HeightMap(hm.heights + bump, (1.0, 1.0), periodic=True)


def test_loads_are_shared_out():
    """The shares of the parts make up the load; a map whose hill is in one part puts all there."""
    for each, lone in ((waves(), False), (hill(), True)):
        run = asperity.solve_contacts(each, BODY, pressures=default_pressures(each, BODY, 3))
        for side in (4, 8):
            shares = parts._load_shares(run, side)
            assert shares.shape == (side**2, 3)
            np.testing.assert_allclose(shares.sum(axis=0), 1.0, rtol=1e-12)
        shares = parts._load_shares(run, 4)
        assert (shares[0, 0] == pytest.approx(1.0)) == lone


def test_parts_hold_as_many_points_of_the_grid_whatever_the_map():
    """A map that is solved on a coarse grid has no more parts than that grid can be cut into."""
    for points, grid, side in (
        (1536, 1536, 4),
        (4096, 4096, 8),
        (16384, 16384, 32),
        (16384, 300, 4),
        (16384, 1200, 16),
        (4096, 1200, 8),
    ):
        hm, solved = (SimpleNamespace(shape=(n, 2 * n)) for n in (points, grid))
        assert parts.parts_along(hm, solved) == side


def test_bounds_hold_with_more_parts(monkeypatch):
    monkeypatch.setattr(parts, "PARTS", replace(parts.PARTS, points=100))
    hm = waves(cutoff=4.0, rolloff=20.0)
    loads = default_pressures(hm, BODY, 8)
    curve = asperity.solve(hm, BODY, pressures=loads, engine="sampled")
    true = truth(hm, BODY, loads)
    assert parts.parts_along(hm, hm) == 5
    assert curve.settings["engine"] == "sampled"
    assert (off(curve, true) <= bounds(curve) + bounds(true)).all()


@pytest.mark.parametrize(
    "hm",
    [
        surfaces.self_affine((256, 512), (256.0, 512.0), hurst=0.8, rms_slope=0.1),
        surfaces.HeightMap(np.maximum(waves().heights, 0.0), (1.0, 1.0), periodic=True),
        surfaces.HeightMap(np.random.default_rng(1).normal(size=(640, 768)), 1.0, periodic=True),
    ],
    ids=["small", "worn", "noise"],
)
def test_parts_of_other_maps_do_not_tell_of_the_whole(hm):
    with pytest.raises(asperity.InputError, match="engine is 'sampled', but parts of the map"):
        asperity.solve(hm, BODY, engine="sampled")
    assert asperity.solve(hm, BODY).settings["engine"] != "sampled"


@pytest.mark.parametrize("m", [0.0, 0.3])
def test_parts_do_not_tell_of_a_body_that_yields_or_is_graded(m):
    metal = asperity.HalfSpace.from_modulus(1.0, m, hardness=np.inf if m else 0.02)
    with pytest.raises(asperity.InputError, match="the body yields"):
        asperity.solve(waves(), metal, engine="sampled")


COPIES = {
    "two tiles": lambda part: np.vstack([part, part]),
    "nine tiles": lambda part: np.tile(part, (3, 3)),
    "mirrored": lambda part: np.hstack([part, part[:, ::-1]]),
}


@pytest.mark.parametrize("name", COPIES)
def test_copies_of_a_part_are_told_wherever_they_begin(name):
    part = surfaces.self_affine((96, 90), (96.0, 90.0), hurst=0.8, rms_slope=0.1, seed=4)
    assert not parts.copied(part)
    heights = COPIES[name](part.heights)
    heights = np.roll(heights, (17, 5), axis=(0, 1)) + 1e-6 * np.random.default_rng(1).random(
        heights.shape
    )
    for some in heights, heights.T, -heights:
        assert parts.copied(surfaces.HeightMap(some, (1.0, 1.0), periodic=True))


@pytest.mark.parametrize("seed", range(6))
def test_waves_as_long_as_a_map_are_no_copies(seed):
    hm = surfaces.self_affine(
        (128, 96), (128.0, 96.0), hurst=1.0, rms_slope=0.1, cutoff=48.0, seed=seed
    )
    assert not parts.copied(hm)
