"""Preparation: known form, spikes and gaps go in, and come out again; nothing is done silently."""

from __future__ import annotations

import numpy as np
import pytest
from samples import SPACING, form, noise

import surfaces
from surfaces.errors import InputError, SurfaceError


def smooth(ny: int = 64, nx: int = 90) -> surfaces.HeightMap:
    y, x = np.meshgrid(np.arange(ny), np.arange(nx), indexing="ij")
    waves = np.sin(2 * np.pi * y / 32 + 0.3) + np.cos(2 * np.pi * x / 45)
    return surfaces.HeightMap(1e-7 * waves, SPACING)


def test_outliers_of_a_periodic_map_move_with_it() -> None:
    heights = np.random.default_rng(4).standard_normal((60, 70))
    heights[10, 20] += 40.0
    heights[30:32, 41] += 60.0
    found = [
        np.isnan(surfaces.mark_outliers(surfaces.HeightMap(z, 1.0, periodic=True), 3.0).heights)
        for z in (heights, np.roll(heights, (7, 9), (0, 1)))
    ]
    np.testing.assert_array_equal(np.roll(found[0], (7, 9), (0, 1)), found[1])


@pytest.mark.parametrize("width", [1, 2, 3])
def test_spikes_are_found_and_at_most_a_neighbor_more(width: int) -> None:
    hm = smooth()
    heights = hm.heights + np.random.default_rng(5).normal(0.0, 3e-9, hm.shape)
    where = np.zeros(hm.shape, dtype=bool)
    for row, column in ((4, 0), (20, 30), (40, 71), (60, 80)):
        where[row : row + width, column : column + width] = True
    heights[where] += 1e-6
    marked = surfaces.mark_outliers(hm.replace(heights=heights), 6.0)
    found = np.isnan(marked.heights)
    assert found[where].all()
    assert np.count_nonzero(found) <= np.count_nonzero(where) + (0 if width == 1 else 3)
    assert marked.history[-1]["count"] == np.count_nonzero(found)


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("aspect", [1 / 300, 1.0, 300.0])
def test_filling_is_harmonic(periodic: bool, aspect: float) -> None:
    """A plane is harmonic, so a gap in it is filled exactly; other fills obey the mean value."""
    hm = noise().replace(spacing=(SPACING[0], aspect * SPACING[1]))
    gap = np.zeros(hm.shape, dtype=bool)
    gap[0:9, 70:84] = gap[25:40, 20:50] = gap[50, 3] = True
    holed = hm.replace(heights=np.where(gap, np.nan, hm.heights), periodic=periodic)
    filled = surfaces.fill_missing(holed, limit=0.2)
    np.testing.assert_array_equal(filled.heights[~gap], hm.heights[~gap])
    mode = "wrap" if periodic else "edge"
    padded = np.pad(filled.heights, 1, mode=mode)
    ratio = (hm.spacing[1] / hm.spacing[0]) ** 2
    across = padded[1:-1, 2:] + padded[1:-1, :-2] - 2 * filled.heights
    along = padded[2:, 1:-1] + padded[:-2, 1:-1] - 2 * filled.heights
    assert np.abs((across + ratio * along)[gap]).max() < 1e-10 * max(1.0, ratio) * hm.rms_height
    assert filled.history[-1]["count"] == gap.sum()


def test_a_plane_is_filled_exactly() -> None:
    hm = noise()
    plane = form(hm, (0.2, -0.1), 0.0, 0.0)
    holed = plane.copy()
    holed[13:33, 9:41] = np.nan
    np.testing.assert_allclose(
        surfaces.fill_missing(hm.replace(heights=holed), limit=0.2).heights, plane, atol=1e-18
    )


def test_a_gap_that_holds_scattered_points() -> None:
    """Factors of its equations fill up: these took 97 s, and larger maps did not end."""
    hm = surfaces.self_affine((256, 256), (256e-6, 256e-6), hurst=0.8, rms_slope=0.1)
    holes = np.random.default_rng(1).random(hm.shape) < 0.85
    filled = surfaces.fill_missing(hm.replace(heights=np.where(holes, np.nan, hm.heights)), limit=1)
    z = filled.heights
    left = sum(np.roll(z, step, axis) for step in (1, -1) for axis in (0, 1)) - 4.0 * z
    assert np.abs(left[holes]).max() < 1e-10 * hm.rms_height


def test_the_fill_limit_holds() -> None:
    hm = noise()
    holed = np.where(np.random.default_rng(0).random(hm.shape) < 0.2, np.nan, hm.heights)
    with pytest.raises(SurfaceError, match=r"missing \(.* more than the fill limit of 10 %"):
        surfaces.prepare(hm.replace(heights=holed))
    assert surfaces.prepare(hm.replace(heights=holed), fill_limit=0.3).missing == 0


@pytest.mark.parametrize("periodic", [False, True])
def test_bandpass_splits_the_map(periodic: bool) -> None:
    """Short and long parts add up to the map, and filtering twice changes nothing."""
    hm = noise().replace(periodic=periodic)
    short = surfaces.bandpass(hm, longest=2e-5)
    long = surfaces.bandpass(hm, shortest=2.00001e-5)
    total = short.heights + long.heights - hm.heights.mean()
    np.testing.assert_allclose(total, hm.heights, atol=1e-20)
    again = surfaces.bandpass(short, longest=2e-5)
    np.testing.assert_allclose(again.heights, short.heights, atol=1e-20)


def test_bandpass_keeps_the_wave_inside_and_drops_the_one_outside() -> None:
    ny, nx = 64, 90
    x = (np.arange(nx) + 0.5) * 3e-6
    wave = lambda n: np.broadcast_to(np.sin(2 * np.pi * n * x / (nx * 3e-6)), (ny, nx))  # noqa: E731
    hm = surfaces.HeightMap(wave(3) + wave(20), SPACING, periodic=True)
    kept = surfaces.bandpass(hm, 20e-6, None)
    np.testing.assert_allclose(kept.heights, wave(3), atol=1e-12)
    with pytest.raises(SurfaceError, match="first must be the shorter"):
        surfaces.bandpass(hm, 1e-5, 1e-6)
    with pytest.raises(SurfaceError, match="no wavelength"):
        surfaces.bandpass(hm, 1.0, 2.0)


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("factor", [0.5, 2.0, 1.7])
def test_resampling_keeps_smooth_maps(periodic: bool, factor: float) -> None:
    """A wave that both grids hold is the same wave on both, at the same place."""

    def wave(hm: surfaces.HeightMap) -> np.ndarray:
        y, x = hm.y[:, None] / hm.size[0], hm.x[None, :] / hm.size[1]
        if periodic:
            return np.sin(2 * np.pi * (2 * y + 3 * x)) + np.cos(4 * np.pi * y + 1)
        return np.cos(3 * np.pi * y) * np.cos(5 * np.pi * x)

    hm = noise().replace(periodic=periodic)
    hm = hm.replace(heights=wave(hm))
    moved = surfaces.resample(hm, tuple(d * factor for d in SPACING))
    assert moved.size == pytest.approx(hm.size)
    np.testing.assert_allclose(moved.heights, wave(moved), atol=1e-12)


def test_mirror_has_no_cliff_and_taper_fades() -> None:
    hm = smooth()
    mirrored = surfaces.make_periodic(hm, "mirror")
    assert mirrored.periodic and mirrored.shape == (128, 180)
    assert mirrored.history[-1]["seam_step"] == 0.0
    assert mirrored.rms_height == pytest.approx(hm.rms_height)
    tapered = surfaces.make_periodic(hm, "taper", width=2e-5)
    step = tapered.history[-1]
    assert step["seam_step"] < step["inner_step"]
    assert 0.0 < step["area_changed"] < 0.5 and "np." not in str(step)
    inside = (slice(12, -12), slice(8, -8))
    np.testing.assert_allclose(tapered.heights[inside], hm.heights[inside], atol=1e-22)
    step = surfaces.make_periodic(hm, "smooth").history[-1]
    assert step["seam_step"] < 2 * step["inner_step"]
    wrapped = surfaces.make_periodic(hm, "wrap").history[-1]
    assert wrapped["seam_step"] > 1.2 * wrapped["inner_step"]


def test_a_taper_is_no_steeper_than_the_map_and_no_wider_than_that_asks_for() -> None:
    """The strip is wide where heights vary slowly, narrow where they vary at once; the mean stays,
    and the fade adds less to the slopes than the map has."""
    spectrum = {"hurst": 0.8, "rms_height": 1e-6, "seed": 2}
    fine = surfaces.self_affine((256, 256), (1e-3, 1e-3), rolloff=6e-5, cutoff=2e-5, **spectrum)
    coarse = surfaces.self_affine((256, 256), (1e-3, 1e-3), rolloff=2.4e-4, cutoff=8e-5, **spectrum)
    made = [surfaces.make_periodic(h.replace(periodic=False), "taper") for h in (fine, coarse)]
    narrow, wide = (hm.history[-1]["width"] for hm in made)
    assert wide == pytest.approx(4 * narrow, rel=0.2)
    assert made[0].roughness.rms_slope < 1.1 * fine.roughness.rms_slope
    assert made[0].rms_height > 0.97 * fine.rms_height
    hill = surfaces.HeightMap(1e-6 * np.cos(np.linspace(-1, 1, 64))[:, None] * np.ones(64), 1e-6)
    assert surfaces.make_periodic(hill, "taper").history[-1]["width"] == pytest.approx(6.4e-6)
    flat = surfaces.HeightMap(np.zeros((16, 16)), 1e-6)
    assert not surfaces.make_periodic(flat, "taper").heights.any()


def test_history_has_one_step_per_thing_done() -> None:
    hm = smooth()
    heights = hm.heights + np.random.default_rng(5).normal(0.0, 3e-9, hm.shape)
    heights[30, 40], heights[10, 10] = 1e-5, np.nan
    ready = surfaces.prepare(
        hm.replace(heights=heights), outliers=6.0, bandpass=(1e-5, None), periodic="mirror"
    )
    names = [step["step"] for step in ready.history]
    assert names == ["level", "outliers", "fill", "bandpass", "periodic"]
    assert ready.history[2]["count"] == 2
    assert ready.missing == 0 and ready.periodic


def test_nothing_asked_nothing_done() -> None:
    hm = noise()
    for nothing in (None, "none"):
        same = surfaces.prepare(hm, level=nothing, fill=nothing)
        assert same.digest == hm.digest and same.history == ()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"level": "septic"}, "level is 'septic'"),
        ({"bandpass": (1e-5, None), "filter": "box"}, "filter is 'box'"),
        ({"bandpass": (3e-6, None), "filter": "spline"}, "shorter than two pixels"),
        ({"fill": "zero"}, "fill is 'zero'"),
        ({"outliers": 1.0}, "use 3 or more"),
        ({"periodic": "glue"}, "periodic is 'glue'"),
        ({"fill_limit": 2.0}, "fill_limit is 2.0"),
        ({"fill_limit": 0.3, "fill": None}, "nothing is filled: leave it out, or pass fill="),
        ({"filter": "gaussian"}, "nothing is filtered: leave it out, or pass bandpass="),
    ],
)
def test_unknown_options(options: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        surfaces.prepare(noise(), **options)


def test_missing_points_stop_what_needs_a_full_map() -> None:
    hm = noise()
    heights = hm.heights.copy()
    heights[3, 4] = np.nan
    for options in ({"bandpass": (None, 1e-4)}, {"periodic": "mirror"}):
        with pytest.raises(SurfaceError, match=r"heights\[3, 4\] is missing .*--fill harmonic"):
            surfaces.prepare(hm.replace(heights=heights), fill=None, **options)


def test_nothing_is_left_of_a_map_that_is_the_form_itself() -> None:
    """Not the rounding of the fit, which would look like a rough surface of 1e-22 m."""
    y, x = np.mgrid[:40, :57] * 1e-6
    for heights in (0.01 * y, 0.2 * x - 0.1 * y + 3e-3, np.full(x.shape, 0.7)):
        levelled = surfaces.level(surfaces.HeightMap(heights, (1e-6, 2e-6)), "plane")
        assert not levelled.heights.any()
    rough = surfaces.HeightMap(np.hypot(x, y) * 1e-6 + 1e-3, (1e-6, 2e-6))
    assert surfaces.level(rough, "plane").rms_height > 1e-12


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda hm: surfaces.prepare(hm, bandpass=1e-5), "shortest, longest"),
        (lambda hm: surfaces.resample(hm, (1e-6, 2e-6, 3e-6)), "give the pixel size"),
        (lambda hm: surfaces.resample(hm, "fine"), "give the pixel size"),
        (lambda hm: surfaces.resample(hm, 1e-13), r"GB of memory .* take larger pixels"),
        (lambda hm: surfaces.crop(hm, (0.5, 10), (0, 10)), "whole numbers"),
        (lambda hm: surfaces.crop(hm, None, (0, 10)), "whole numbers"),
    ],
)
def test_arguments_that_name_no_length_or_pixel(change, match: str) -> None:
    y, x = np.mgrid[:40, :57] * 1e-6
    with pytest.raises(SurfaceError, match=match):
        change(surfaces.HeightMap(np.hypot(x, y), (1e-6, 2e-6)))


def test_smooth_seams():
    """A periodic map stays as it is, a plane goes, and inside only the smoothest part is lost."""
    hm = surfaces.self_affine((48, 64), (48.0, 64.0), hurst=0.8, rms_slope=0.1, cutoff=8.0, seed=1)
    wave = np.cos(2 * np.pi * np.arange(48) / 48)[:, None] * np.ones(64)
    same = surfaces.make_periodic(hm.replace(heights=0 * wave + 3.0, periodic=False), "smooth")
    np.testing.assert_allclose(same.heights, 3.0, rtol=1e-12)
    part = surfaces.crop(hm, (0, 40), (0, 50))
    ready = surfaces.make_periodic(part, "smooth")
    assert ready.periodic and abs(ready.heights.mean() - part.heights.mean()) < 1e-9
    laplacian = [
        np.roll(h, 1, 0) + np.roll(h, -1, 0) + np.roll(h, 1, 1) + np.roll(h, -1, 1) - 4 * h
        for h in (part.heights, ready.heights)
    ]
    inside = (slice(1, -1), slice(1, -1))  # where the carrier is harmonic
    np.testing.assert_allclose(laplacian[1][inside], laplacian[0][inside], atol=1e-9)


@pytest.mark.parametrize(
    ("shape", "spacing"), [((100, 100), (1e-6, 3e-5)), ((4, 64), 1e-6), ((8, 8), 1e-6)]
)
def test_a_taper_fades_along_both_axes(shape: tuple[int, int], spacing: float) -> None:
    """A strip of less than a pixel left the cliff at the seam as it was."""
    ramp = np.add.outer(*(np.linspace(-1e-7, 1e-7, n) for n in shape))
    hm = surfaces.HeightMap(ramp, spacing)
    faded = surfaces.make_periodic(hm, "taper").heights
    for axis in (0, 1):
        step = np.abs(np.take(faded, 0, axis) - np.take(faded, -1, axis)).max()
        assert step < 0.35 * np.abs(np.take(ramp, 0, axis) - np.take(ramp, -1, axis)).max()
    for width, how in ((1e-5, "mirror"), (1.5 * max(hm.spacing), "taper")):
        with pytest.raises(surfaces.InputError, match=r"(width|strip) is"):
            surfaces.make_periodic(hm, how, width=width)


def test_a_far_spike_does_not_hide_the_others() -> None:
    """One point at -9999 left the rest to the rounding of single precision."""
    rough = surfaces.self_affine((96, 80), (96e-6, 80e-6), hurst=0.8, rms_height=6e-7, cutoff=8e-6)
    heights = rough.heights.copy()
    heights[[10, 30, 60], [10, 50, 20]] += [2e-5, 3e-5, -2e-5]
    assert surfaces.mark_outliers(rough.replace(heights=heights)).missing == 3
    heights[80, 70] = -1e4
    assert surfaces.mark_outliers(rough.replace(heights=heights)).missing == 4


def test_a_limit_of_filling_is_a_number() -> None:
    heights = np.ones((8, 8))
    heights[2:4] = np.nan
    with pytest.raises(surfaces.SurfaceError, match="fill limit"):
        surfaces.fill_missing(surfaces.HeightMap(heights, 1e-6), limit=np.nan)
