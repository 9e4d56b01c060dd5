"""Waves near the pixel: what they are judged by, and the finer grid."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import asperity
import surfaces
from asperity.halfspace.load_points import pressure_scale
from asperity.multiscale.pixel_waves import fineness, random_waves, refined_map
from asperity.parameters import DEFAULTS
from asperity.parameters.constants import PixelWaves
from surfaces import HeightMap, self_affine

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


def test_random_waves_have_a_kurtosis_of_three():
    hm = wavy((320, 360))
    assert hm.roughness.kurtosis == pytest.approx((3.0, 3.0), abs=0.2)
    assert dataclasses.replace(hm, periodic=False).roughness.kurtosis == pytest.approx(
        (3.0, 3.0), abs=0.2
    )
    assert random_waves(hm)
    steps = np.round(wavy(cutoff=8.0).heights / 0.5)
    assert not random_waves(HeightMap(steps, hm.spacing, periodic=True))
    spikes = hm.heights.copy()
    spikes[::40, ::40] += 4 * hm.rms_height
    assert not random_waves(hm.replace(heights=spikes))
    assert not random_waves(surfaces.prepare(hm.replace(heights=spikes), periodic="taper"))
    assert not random_waves(hm.replace(heights=np.minimum(hm.heights, 0.0)))  # worn
    ridges = HeightMap(np.tile(np.sin(np.arange(40.0)), (30, 1)), (1.0, 1.0), periodic=True)
    assert ridges.roughness.kurtosis[0] == np.inf


def test_the_finer_grid_holds_the_same_waves():
    for hm in (wavy(), dataclasses.replace(wavy(), periodic=False)):
        fine = refined_map(hm)
        assert isinstance(fine, HeightMap)
        assert fine.shape == tuple(2 * n for n in hm.shape)
        assert fine.periodic == hm.periodic
        back = surfaces.resample(fine, hm.spacing)
        np.testing.assert_allclose(back.heights, hm.heights, atol=1e-9 * hm.rms_height)


def test_only_where_waves_reach_the_pixel():
    for cutoff in (4.0, 8.0):
        assert refined_map(wavy(cutoff=cutoff)) is None


def test_large_maps_are_refined_less_and_it_is_said():
    hm, ((ratio, most), (less, more)) = wavy(), DEFAULTS.pixel_waves.finer
    assert ratio > less
    assert ratio**2 * 1024**2 <= most <= less**2 * 2048**2 <= more
    assert refined_map(hm, PixelWaves(finer=((2.0, 0), (1.5, 10**6)))).shape == (240, 288)
    none = PixelWaves(finer=((2.0, 0), (1.5, 0)))
    assert "takes long" in str(refined_map(hm, none))
    parameters = dataclasses.replace(DEFAULTS, pixel_waves=none)
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
