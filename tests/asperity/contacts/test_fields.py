"""Contact and pressure maps: closed forms, what is conserved, and boundary elements."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import asperity
import surfaces
from asperity.contacts.fields import pressed_pixels
from asperity.contacts.run import ContactRun, solve_contacts
from asperity.halfspace.scene import pressure_scale
from asperity.model.plan import make_plan
from surfaces import HeightMap, self_affine
from surfaces.files.stored_map import StoredMap
from surfaces.numerics import memory
from surfaces.patches import label_patches

STEEL = asperity.HalfSpace.from_modulus(2e11)


def map_of(cutoff: float | None, shape=(160, 192), seed=3, **more) -> HeightMap:
    """A self-affine map on pixels that are not square, its shortest wave in pixels of 1 um."""
    size = (shape[0] * 1.0e-6, shape[1] * 0.8e-6)
    return self_affine(
        shape,
        size,
        hurst=0.8,
        rms_slope=0.1,
        rolloff=0.25 * size[1],
        cutoff=cutoff and cutoff * 1e-6,
        seed=seed,
        **more,
    )


def run_of(hm: HeightMap, load=(5e-3, 4e-2), body=STEEL, **choices) -> ContactRun:
    pressures = np.array(load) * pressure_scale(hm, body)
    plan = make_plan(hm, body, pressures=pressures, **choices)
    return solve_contacts(hm, body, plan, pressures=pressures)


@pytest.fixture(scope="module")
def broad() -> HeightMap:
    return map_of(None, (240, 288))


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_one_cap_has_the_pressure_of_hertz(m, boundary):
    ny, nx, dy, dx, radius = 81, 101, 1.2e-6, 1e-6, 1e-3
    r2 = ((np.arange(ny) - 40) * dy)[:, None] ** 2 + ((np.arange(nx) - 50) * dx) ** 2
    hm = HeightMap(-r2 / (2 * radius), (dy, dx), periodic=boundary == "periodic")
    body = asperity.HalfSpace.from_modulus(2e11, m)
    run = solve_contacts(hm, body, pressures=[2e7 * (1e-5) ** m])
    pressure, state = run.pressure_map(), run.points[0].state
    shape = np.maximum(1 - r2 * np.pi / state.contact_area, 0) ** (0.5 * (1 + m))
    exact = 0.5 * (3 + m) * run.curve.load[0] / state.contact_area * shape
    assert np.abs(pressure - exact).sum() < 0.04 * exact.sum()
    assert pressure.max() == pytest.approx(exact.max(), rel=0.03)


@pytest.mark.parametrize(
    ("cutoff", "choices"),
    [
        (None, {}),
        (None, {"scales": "all"}),
        (8, {}),
        (30, {}),
        (None, {"boundary": "free"}),
        (8, {"boundary": "free"}),
        (8, {"interaction": False}),
    ],
)
def test_each_contact_keeps_its_force_and_its_area(cutoff, choices):
    hm = map_of(cutoff, (240, 288) if cutoff is None else (160, 192))
    run = run_of(hm, **choices)
    size = hm.spacing[0] * hm.spacing[1]
    for number, point in enumerate(run.points):
        state = point.state
        pixel, own, pressure = pressed_pixels(run.decomposition, point)
        carried = np.bincount(own, pressure * size, len(state.force))
        np.testing.assert_allclose(carried, state.force, rtol=1e-9)
        pixels = np.bincount(own, minlength=len(state.force))
        area = point.closed_area
        # no contact has less than a pixel, none more than its basin
        wanted = np.where(state.force > 0, np.maximum(area / size, 1), 0)
        assert (pixels <= wanted + 1.01).all() and ((pixels > 0) == (state.force > 0)).all()
        assert pixels.sum() == pytest.approx(wanted.sum(), rel=0.02)
        field = run.pressure_map(number)
        np.testing.assert_allclose(np.bincount(pixel, pressure), field.ravel()[: pixel.max() + 1])
        np.testing.assert_array_equal(run.contact_map(number), field > 0)


def test_maps_move_with_the_surface():
    hm = map_of(8)
    moved = hm.replace(heights=np.roll(hm.heights, (31, 57), (0, 1)))
    one, other = run_of(hm), run_of(moved)
    first, second = np.roll(one.contact_map(), (31, 57), (0, 1)), other.contact_map()
    assert np.count_nonzero(first & second) > 0.97 * np.count_nonzero(first | second)


def test_maps_are_mirrored_with_the_surface_on_a_grid_twice_as_fine():
    hm = map_of(2, (96, 128))
    run = run_of(hm, load=(4e-2,), interaction=False)
    assert run.decomposition.solved.shape[1] == 2 * hm.shape[1]  # middles lie between pixels
    for turned in (np.flipud, np.fliplr):
        mirrored = run_of(hm.replace(heights=turned(hm.heights)), load=(4e-2,), interaction=False)
        one, other = run.pressure_map(), turned(mirrored.pressure_map())
        # at the edge of a contact pressure rises from nothing within a pixel
        assert other == pytest.approx(one, rel=1e-4, abs=1e-9 * one.max())


def test_nothing_touches_at_no_load(broad):
    run = run_of(broad, load=(0.0, 1e-3))
    assert not run.pressure_map(0).any() and not run.contact_map(0).any()
    assert len(run.spots(0)) == 0 and len(run.spots(1)) > 0


@pytest.mark.parametrize(
    ("cutoff", "right", "likeness"), [(None, 0.98, 0.97), (8, 0.98, 0.99), (30, 0.96, 0.99)]
)
def test_maps_are_those_of_boundary_elements(broad, cutoff, right, likeness):
    """Of the pixels in contact so many are right, and the pressures are alike."""
    hm = broad if cutoff is None else map_of(cutoff)
    run = run_of(hm)
    for point, load in enumerate(run.curve.mean_pressure):
        exact = asperity.bem_solve(hm, STEEL, pressure=load, tolerance=1e-3)
        mine = run.contact_map(point)
        hits = np.count_nonzero(mine & exact.contact) / np.count_nonzero(mine)
        assert hits > right
        pressure = run.pressure_map(point)
        assert np.corrcoef(pressure.ravel(), exact.pressure.ravel())[0, 1] > likeness


def test_a_plateau_bears_its_load():
    """Where all heights of a contact are equal none lies over the next one: pressures were NaN."""
    wave = 1e-7 * np.cos(2 * np.pi * 3 * (np.arange(48) + 0.5) / 48)
    tops = HeightMap(np.minimum(wave + wave[:, None], 0.5e-7), (1e-6, 1e-6), periodic=True)
    run = solve_contacts(tops, STEEL, pressures=[1e6, 1e8])
    for point, load in enumerate(run.curve.load):
        assert run.pressure_map(point).mean() * tops.area == pytest.approx(load)
        assert run.spots(point)["force"].sum() == pytest.approx(load)


def test_fewer_points_give_nearly_the_same_maps():
    hm = map_of(30)
    run = run_of(hm)
    assert run.decomposition.plan.resampled is not None
    whole = dataclasses.replace(run.decomposition.plan, resampled=None)
    other = solve_contacts(hm, STEEL, whole, pressures=run.curve.mean_pressure)
    few, many = run.pressure_map(), other.pressure_map()
    assert np.abs(few - many).sum() < 0.12 * many.sum()


def test_spots_hold_the_load_and_the_area(broad):
    for hm, choices in (
        (broad, {}),
        (map_of(8), {"boundary": "free"}),
        (map_of(None), {"boundary": "free"}),
    ):
        run = run_of(hm, **choices)
        for point in range(2):
            table = run.spots(point)
            load = run.curve.mean_pressure[point] * hm.area
            assert table["force"].sum() == pytest.approx(load, rel=1e-9)
            area = run.curve.contact_area[point]
            assert table["area"].sum() == pytest.approx(area, rel=1e-9)
            assert (np.diff(table["area"]) <= 0).all()
            assert (table["peak_pressure"] > 0).all()
            pressure = run.pressure_map(point)
            assert table["pixels"].sum() == np.count_nonzero(pressure)
            assert table["peak_pressure"].max() == pressure.max()
            strongest = table[table["peak_pressure"].argmax()]
            row, col = np.unravel_index(pressure.argmax(), hm.shape)
            near = np.sqrt(strongest["area"])
            for at, where, length in (
                (strongest["y"], hm.y[row], hm.size[0]),
                (strongest["x"], hm.x[col], hm.size[1]),
            ):
                away = abs(at - where)
                assert min(away, length - away) < near and 0 <= at < length


@pytest.mark.parametrize("scales", ["auto", "all"])
def test_no_spot_bears_more_than_the_hardness(scales):
    """Where it fills basins, their contacts have fewer pixels than they need: the map lacked 1 to
    2 % of the load, and spots of few pixels bore up to 1.14 times the hardness."""
    hm = map_of(None, (128, 128), seed=1)
    hardness = 0.05 * pressure_scale(hm, STEEL)
    body = asperity.HalfSpace.from_modulus(STEEL.modulus, hardness=hardness)
    loads = np.array([0.1, 0.3]) * hardness
    run = solve_contacts(
        hm, body, make_plan(hm, body, pressures=loads, scales=scales), pressures=loads
    )
    for i, load in enumerate(loads):
        spots, pressure = run.spots(i), run.pressure_map(i)
        assert pressure.mean() == pytest.approx(load, rel=1e-5)
        assert pressure.max() <= hardness
        assert spots["force"].sum() == pytest.approx(run.curve.load[i])
        assert spots["area"].sum() == pytest.approx(run.curve.contact_area[i])
        mean, peak = spots["mean_pressure"] / hardness, spots["peak_pressure"] / hardness
        assert (mean < 1.0 + 1e-9).all() and (peak < 1.0 + 1e-9).all() and (mean <= peak).all()


def test_no_pixel_bears_more_than_the_hardness():
    """A contact without a pixel took that of its summit beside another, and both added up to twice
    the hardness."""
    hm = self_affine((128, 96), (128e-6, 144e-6), hurst=0.8, rms_slope=0.1, rolloff=32e-6, seed=8)
    body = asperity.HalfSpace.from_modulus(1e9, hardness=2e7)
    run = solve_contacts(hm, body, make_plan(hm, body, law="paper"))
    assert run.pressure_map(9).max() <= 2e7 * (1.0 + 1e-9)
    assert run.spots(9)["peak_pressure"].max() <= 2e7 * (1.0 + 1e-9)
    total = run.pressure_map(9).mean()
    assert total == pytest.approx(run.curve.mean_pressure[9], rel=1e-6)


def test_fine_waves_part_contacts_into_spots(broad):
    """About as many as boundary elements find, more than the longer waves have contacts."""
    run = run_of(broad)
    assert run.decomposition.plan.sub_contact_law is not None
    for point, load in enumerate(run.curve.mean_pressure):
        refined = surfaces.resample(broad, np.asarray(broad.spacing) / 2)
        exact = asperity.bem_solve(refined, STEEL, pressure=load, tolerance=1e-3)
        assert len(run.spots(point)) == pytest.approx(exact.contacts, rel=0.25)
        assert run.points[point].state.active < exact.contacts


def test_a_spot_across_the_seam_is_one(broad):
    contact = run_of(broad).contact_map()
    count = len(run_of(broad).spots())
    assert count <= label_patches(contact, periodic=True)[1]
    assert count < label_patches(contact, periodic=False)[1]


def test_table_and_curve_count_the_same_spots():
    """Where no wave is a law, but for one that holds no pixel; both as boundary elements count."""
    for cutoff, seed, shape in ((8, 3, (240, 320)), (16, 51, (160, 192))):
        size = (shape[0] * 5e-6, shape[1] * 1e-5)
        hm = self_affine(shape, size, hurst=0.8, rms_slope=0.1, cutoff=cutoff * 1e-5, seed=seed)
        loads = np.array([5e-3, 2e-2, 5e-2]) * pressure_scale(hm, STEEL)
        run = asperity.solve_contacts(hm, STEEL, pressures=loads)
        assert run.decomposition.plan.sub_contact_law is None
        exact = asperity.bem_curve(hm, STEEL, pressures=loads, tolerance=1e-4).contacts
        unseen = run.curve.contacts - [len(run.spots(i)) for i in range(3)]
        assert set(unseen) <= {0.0, 1.0}
        np.testing.assert_allclose(run.curve.contacts, exact, rtol=0.25, atol=2)


def test_where_waves_are_a_law_both_counts_scatter_about_that_of_boundary_elements(broad):
    run = run_of(broad)
    for point, load in enumerate(run.curve.mean_pressure):
        exact = asperity.bem_solve(broad, STEEL, pressure=load, tolerance=1e-3).contacts
        assert len(run.spots(point)) <= run.curve.contacts[point]
        for count in (len(run.spots(point)), run.curve.contacts[point]):
            assert count == pytest.approx(exact, rel=0.35)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_maps_of_a_measured_surface_are_those_of_boundary_elements(measured, boundary):
    whole = surfaces.read(measured / "afm_10um_grains.h5")
    hm = surfaces.crop(whole, (100, 260), (60, 252))
    hm = surfaces.prepare(hm, periodic="taper" if boundary == "periodic" else None)
    run = run_of(hm, load=(2e-2,), boundary=boundary)
    load = run.curve.mean_pressure[0]
    exact = asperity.bem_solve(hm, STEEL, pressure=load, tolerance=1e-2, boundary=boundary)
    mine, pressure = run.contact_map(), run.pressure_map()
    assert np.mean(exact.contact[mine]) > 0.93
    assert np.corrcoef(pressure.ravel(), exact.pressure.ravel())[0, 1] > 0.95
    assert len(run.spots()) == pytest.approx(exact.contacts, rel=0.25, abs=3)
    assert run.curve.contacts[0] == pytest.approx(exact.contacts, rel=0.2, abs=3)


@pytest.mark.parametrize("cutoff", [None, 8])
def test_fields_of_a_map_on_disk_are_those_of_the_map_in_memory(cutoff: float | None) -> None:
    """Flooded in strips, its labels stay on disk."""
    hm = map_of(cutoff)
    blocks = [(0, hm.heights)]
    kept = StoredMap.of_blocks(blocks, hm.shape, np.float64, hm.spacing, periodic=hm.periodic)
    found, known = run_of(kept), run_of(hm)
    pressure = known.pressure_map()
    np.testing.assert_allclose(found.pressure_map(), pressure, atol=1e-5 * pressure.max())
    assert len(found.spots()) == len(known.spots())


def test_fields_that_do_not_fit_into_the_memory_are_refused(monkeypatch):
    """They are made in memory, of a map on disk too."""
    run = run_of(map_of(8))
    monkeypatch.setattr(memory, "available_bytes", lambda: 3_000_000)
    for ask in (run.pressure_map, run.spots):
        with pytest.raises(surfaces.SurfaceError, match=r"192 points needs .*--memory"):
            ask()
