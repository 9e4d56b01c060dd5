"""The finest waves of a map: how they are judged, the finer grid, and the split by their law."""

from __future__ import annotations

import contextlib
import dataclasses

import numpy as np
import pytest
from strategies import STEEL, broad

import asperity
import surfaces
from asperity.errors import InputError
from asperity.halfspace.influence import compliance
from asperity.halfspace.scene import pressure_scale
from asperity.model.plan import make_plan
from asperity.multiscale.wave_split import refined_map, split_scales
from asperity.parameters import DEFAULTS, PixelWaves
from surfaces import HeightMap, self_affine
from surfaces.checks import fineness

BODY = asperity.HalfSpace.from_modulus(1.0)


def wavy(shape=(160, 192), seed=2, **more) -> HeightMap:
    size = (float(shape[0]), 0.8 * shape[1])
    given = {"hurst": 0.8, "rms_slope": 0.1, "rolloff": 0.25 * size[0], **more}
    return self_affine(shape, size, seed=seed, **given)


@pytest.mark.parametrize(("ny", "nx"), [(1, 0), (3, 0), (0, 5), (4, 7)])
def test_share_of_the_slope_lost_over_two_pixels(ny, nx):
    """Of one wave sin(k d / 2)^2 is lost along each axis, weighed by its slope."""
    y, x = np.meshgrid(np.arange(48.0), np.arange(60.0), indexing="ij")
    ky, kx = 2 * np.pi * ny / 48, 2 * np.pi * nx / 60
    hm = HeightMap(np.sin(ky * y + kx * x + 0.3), (2.0, 0.5), periodic=True)
    lost = np.sin([ky / 2, kx / 2]) ** 2
    steep = lost / np.square(hm.spacing)
    assert fineness(hm) == pytest.approx(lost @ steep / steep.sum(), rel=0.08)


def test_the_finer_grid_holds_the_same_waves():
    for hm in (wavy(), dataclasses.replace(wavy(), periodic=False)):
        fine = refined_map(hm, DEFAULTS)
        assert isinstance(fine, HeightMap)
        assert fine.shape == tuple(2 * n for n in hm.shape)
        assert fine.periodic == hm.periodic
        back = surfaces.resample(fine, hm.spacing)
        np.testing.assert_allclose(back.heights, hm.heights, atol=1e-9 * hm.rms_height)


def test_only_where_waves_reach_the_pixel():
    for cutoff in (4.0, 8.0):
        assert refined_map(wavy(cutoff=cutoff), DEFAULTS) is None


def test_large_maps_are_refined_less_and_it_is_said():
    hm, ((ratio, most), (less, more)) = wavy(), DEFAULTS.pixel_waves.finer
    assert ratio > less
    assert ratio**2 * 1024**2 <= most <= less**2 * 2048**2 <= more
    less = dataclasses.replace(DEFAULTS, pixel_waves=PixelWaves(finer=((2.0, 0), (1.5, 10**6))))
    assert refined_map(hm, less).shape == (240, 288)
    none = PixelWaves(finer=((2.0, 0), (1.5, 0)))
    parameters = dataclasses.replace(DEFAULTS, pixel_waves=none)
    assert "takes long" in str(refined_map(hm, parameters))
    plan = asperity.make_plan(hm, BODY, interaction=False, parameters=parameters)
    assert plan.resampled is None
    assert "160 x 192 points, a finer one would hold" in str(plan)


def test_nearer_to_boundary_elements_than_on_the_map_itself():
    hm, body = wavy(hurst=0.6), asperity.HalfSpace.from_modulus(1.0, m=0.6)
    loads = np.array([1e-2, 5e-2]) * pressure_scale(hm, body)
    exact = asperity.bem_curve(
        surfaces.resample(hm, np.asarray(hm.spacing) / 2), body, pressures=loads, tolerance=1e-4
    )
    auto, every = (
        asperity.contact_curve(hm, body, separations=exact.separation, scales=scales)
        for scales in ("auto", "all")
    )
    assert auto.settings["shortest_wave"] is None
    error, before = (np.abs(c.mean_pressure / loads - 1) for c in (auto, every))
    assert (error < 0.6 * before).all()
    assert error.max() < 0.06


def test_the_map_is_the_band_of_longer_waves(rough):
    split = split_scales(rough, STEEL, DEFAULTS)
    (coarse, corner), fine = split.coarse, split.law
    shell = 1 / max(rough.size)
    edge = 1 / (1 / fine.shortest + 0.5 * shell)
    band = surfaces.resample(surfaces.bandpass(rough, shortest=edge), coarse.spacing)
    assert band.shape == coarse.shape
    assert fine.shortest >= 6 * max(coarse.spacing) > 0.9 * fine.shortest
    down, right = (
        np.exp(2j * np.pi * np.fft.fftfreq(n, step) * place)
        for n, step, place in zip(band.shape, band.spacing, corner, strict=True)
    )
    moved = np.fft.ifft2(np.fft.fft2(band.heights) * down[:, None] * right).real
    np.testing.assert_allclose(coarse.heights, moved, atol=1e-9 * rough.rms_height)


def test_a_point_of_the_other_grid_is_the_highest_of_the_map(rough):
    corners = []
    for turn in (0, 17):
        hm = rough.replace(heights=np.roll(rough.heights, (turn, -2 * turn), (0, 1)))
        coarse, corner = split_scales(hm, STEEL, DEFAULTS).coarse
        top = [(n + 0.5) * step for n, step in zip(hm.roughness.summit, hm.spacing, strict=True)]
        at = (np.array(top) - corner) / coarse.spacing - 0.5
        np.testing.assert_allclose(at, np.round(at), atol=1e-9)
        assert all(0 <= place < step for place, step in zip(corner, coarse.spacing, strict=True))
        corners.append((corner, np.roll(coarse.heights, -np.round(at).astype(int), (0, 1))))
    assert corners[0][0] != corners[1][0]
    np.testing.assert_allclose(corners[0][1], corners[1][1], atol=1e-9 * rough.rms_height)


def sums(hm: HeightMap, body) -> tuple[float, float]:
    """Variance of the pressure and energy per area of a map pressed flat."""
    waves = np.abs(np.fft.fft2(hm.heights) / hm.heights.size) ** 2
    qy, qx = np.meshgrid(
        *(2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(hm.shape, hm.spacing, strict=True)),
        indexing="ij",
    )
    stiffness = np.hypot(qy, qx) ** (1 - body.m) / compliance((1.0, 1.0), body)
    return (waves * stiffness**2).sum(), 0.5 * (waves * stiffness).sum()


@pytest.mark.parametrize("m", [0.0, 0.3, -0.3])
def test_pressure_and_energy_are_those_of_the_waves_left_out(m):
    hm, body = broad(), asperity.HalfSpace.from_modulus(2e11, m=m)
    split = split_scales(hm, body, DEFAULTS)
    coarse, fine = split.coarse.hm, split.law
    (whole, stored), (longer, held) = (sums(map_, body) for map_ in (hm, coarse))
    assert fine.variance == pytest.approx(whole - longer, rel=1e-6)
    assert fine.energy == pytest.approx(stored - held, rel=1e-6)
    assert fine.ratio == pytest.approx(whole / longer - 1, rel=1e-6)


def test_a_free_map_is_taken_with_its_mirror_images(rough):
    free = dataclasses.replace(rough, periodic=False)
    split = split_scales(free, STEEL, DEFAULTS)
    coarse, fine = split.coarse.hm, split.law
    assert split.coarse.corner == (0.0, 0.0)
    mirrored, smooth = (
        surfaces.prepare(hm, level=None, periodic="mirror") for hm in (free, coarse)
    )
    (whole, stored), (longer, held) = (sums(hm, STEEL) for hm in (mirrored, smooth))
    assert fine.variance == pytest.approx(whole - longer, rel=1e-6)
    assert fine.energy == pytest.approx(stored - held, rel=1e-6)
    edge = (1 + 1e-9) / (1 / fine.shortest + 0.5 / max(rough.size))
    band = surfaces.resample(surfaces.bandpass(mirrored, shortest=edge), smooth.spacing)
    ny, nx = coarse.shape
    np.testing.assert_allclose(coarse.heights, band.heights[:ny, :nx], atol=1e-9 * rough.rms_height)
    periodic = split_scales(rough, STEEL, DEFAULTS)
    assert fine.variance == pytest.approx(periodic.law.variance, rel=0.1)


@pytest.mark.parametrize("shape", [(300, 240), (250, 250), (240, 288)])
def test_waves_between_two_shells_are_told_apart_alike_in_any_unit(shape):
    """Of mirror images every second wave along an axis lies there: rounding took it twice or lost
    it, up to 0.6 % of the rms height."""
    size = tuple(1e-6 * n for n in shape)
    hm = self_affine(shape, size, hurst=0.8, rms_slope=0.1, rolloff=6e-5, seed=5)
    hm = dataclasses.replace(hm, periodic=False)
    first = split_scales(hm, STEEL, DEFAULTS)
    for unit in (0.3, 1.1, 3.7, 1e3, 1e6):
        scaled = HeightMap(unit * hm.heights, tuple(unit * d for d in hm.spacing))
        split = split_scales(scaled, STEEL, DEFAULTS)
        np.testing.assert_allclose(
            split.coarse.hm.heights / unit, first.coarse.hm.heights, atol=1e-9 * hm.rms_height
        )
        (whole, _), (longer, _) = (
            sums(surfaces.prepare(map_, level=None, periodic="mirror"), STEEL)
            for map_ in (scaled, split.coarse.hm)
        )
        assert split.law.variance == pytest.approx(whole - longer, rel=1e-9)
        assert split.law.variance == pytest.approx(first.law.variance, rel=1e-9)


def test_the_law_does_not_jump_at_a_homogeneous_body_(rough):
    plain = split_scales(rough, STEEL, DEFAULTS).law
    near = split_scales(rough, asperity.HalfSpace.from_modulus(2e11, m=1e-7), DEFAULTS).law
    for name in ("shortest", "spread", "energy", "variance", "ratio"):
        assert getattr(near, name) == pytest.approx(getattr(plain, name), rel=1e-5)
    assert near.lift(1e-8, 0.1) == pytest.approx(plain.lift(1e-8, 0.1), rel=1e-6)


def test_maps_that_keep_all_their_summits():
    def why(hm, body=STEEL):
        found = split_scales(hm, body, DEFAULTS)
        assert isinstance(found, str)
        return found

    rough = broad()
    assert "|m| <= 0.5" in why(rough, asperity.HalfSpace.from_modulus(2e11, m=0.6))
    assert "have a lay" in why(broad(anisotropy=3.0))
    for angle in (0.0, 0.8):
        lay = dataclasses.replace(broad(anisotropy=3.0, angle=angle), periodic=False)
        assert "have a lay" in why(lay)
    assert "narrow" in why(broad(cutoff=1.2e-5))
    spikes = rough.heights.copy()
    spikes[::40, ::40] += 4 * rough.rms_height
    assert "not random" in why(rough.replace(heights=spikes))
    assert make_plan(rough, STEEL, scales="all").sub_contact_law is None
    assert make_plan(rough, STEEL, interaction=False).sub_contact_law is None
    with pytest.raises(InputError, match="choose one of auto, all"):
        make_plan(rough, STEEL, scales="coarse")


def test_no_wave_shorter_than_three_pixels_is_kept():
    """A spectrum that is not broad is cut there if it holds much beyond, else not at all."""
    for hurst in (0.6, 0.7):
        hm = broad(rolloff=2.9e-5, hurst=hurst, cutoff=2.2e-6)
        kept = split_scales(hm, STEEL, DEFAULTS).law.shortest / max(hm.spacing)
        assert 3.0 <= kept < 3.1
    for hurst, cutoff, rolloff in ((0.8, 2.2e-6, 2.9e-5), (0.9, 2.2e-6, 2.9e-5), (0.8, 3e-6, 6e-5)):
        found = split_scales(broad(rolloff=rolloff, hurst=hurst, cutoff=cutoff), STEEL, DEFAULTS)
        assert isinstance(found, str) and "narrow" in found


@pytest.mark.parametrize("hurst", [0.5, 0.8, 1.0])
def test_without_a_rolloff_enough_waves_are_kept(hurst):
    """The longest waves make a spectrum as broad as one likes, and all others would be short."""
    hm = broad(hurst=hurst, rolloff=None)
    side = np.sqrt(hm.area)
    assert side / split_scales(hm, STEEL, DEFAULTS).law.shortest == pytest.approx(50, rel=0.02)
    assert "too few waves" in split_scales(
        broad(hurst=hurst, rolloff=None, cutoff=5e-6), STEEL, DEFAULTS
    )


def test_the_longer_waves_keep_some_of_the_slope():
    """Where they hold next to none, as with a low Hurst exponent, their contacts would cover half
    of the map at a tenth of contact."""
    hm = self_affine((1024, 1024), (1024.0,) * 2, hurst=0.2, rms_slope=0.1, seed=3)
    run = asperity.solve_contacts(hm, BODY)
    law, least = run.decomposition.plan.sub_contact_law, DEFAULTS.wave_split.kept_slope
    assert least <= 1.0 / (1.0 + law.ratio) < 1.05 * least
    assert run.curve.area_fraction[-1] > 0.08
    assert run.points[-1].state.contact_area < 0.35 * hm.area


def test_a_flat_map_loses_no_slope():
    assert fineness(HeightMap(np.full((8, 9), 3.0), (1.0, 1.0))) == 0.0


@pytest.mark.parametrize("level", [2.0, 2.5, 3.0])
def test_heights_cut_off_have_no_law_of_fine_waves(level):
    """The kurtosis of the second differences does not tell of so few points, which touch first."""
    hm = self_affine((256, 256), (256.0, 256.0), hurst=0.8, rms_slope=0.1, cutoff=4.0, seed=2)
    assert asperity.make_plan(hm, BODY).sub_contact_law is not None
    cut = hm.replace(heights=np.minimum(hm.heights, level * hm.rms_height))
    assert asperity.make_plan(cut, BODY).sub_contact_law is None
    light = 2e-3 * pressure_scale(hm, BODY)
    exact = asperity.bem_solve(cut, BODY, pressure=light)
    with pytest.warns(match="in line") if level < 3.0 else contextlib.nullcontext():
        model = asperity.contact_curve(cut, BODY, separations=[exact.separation])
    assert model.load[0] == pytest.approx(exact.load, rel=0.06)
