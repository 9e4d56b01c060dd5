"""Spectrum: Parseval, single waves, and the known truth of synthetic surfaces."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import surfaces
from surfaces.errors import SurfaceError

SIZE = (1e-3, 2e-3)


def noise(ny: int = 45, nx: int = 64, periodic: bool = True) -> surfaces.HeightMap:
    heights = np.random.default_rng(7).normal(0.0, 1e-7, (ny, nx))
    return surfaces.HeightMap(heights, (SIZE[0] / ny, SIZE[1] / nx), periodic=periodic)


@pytest.mark.parametrize("shape", [(45, 64), (44, 63), (45, 63), (44, 64)])
def test_parseval(shape: tuple[int, int]) -> None:
    """The sum of the density over all modes, per area, is the variance of the heights."""
    hm = noise(*shape)
    qy, qx, density = surfaces.power_spectrum_2d(hm)
    weight = np.full(len(qx), 2.0)
    weight[0] = 1.0
    if shape[1] % 2 == 0:
        weight[-1] = 1.0
    assert (density @ weight).sum() / hm.area == pytest.approx(hm.rms_height**2, rel=1e-12, abs=0.0)
    spectrum = surfaces.power_spectrum(hm)
    assert spectrum.moments.rms_height == pytest.approx(hm.rms_height, rel=1e-12)
    assert len(qy) == shape[0]


@pytest.mark.parametrize("waves", [(0, 5), (4, 0), (3, 7)])
def test_one_wave_has_its_moments(waves: tuple[int, int]) -> None:
    hm = noise()
    kx, ky = 2 * np.pi * waves[1] / SIZE[1], 2 * np.pi * waves[0] / SIZE[0]
    wave = np.sqrt(2.0) * 1e-6 * np.sin(kx * hm.x[None, :] + ky * hm.y[:, None])
    spectrum = surfaces.power_spectrum(hm.replace(heights=wave))
    moments = spectrum.moments
    assert moments.rms_height == pytest.approx(1e-6)
    assert moments.rms_slope == pytest.approx(1e-6 * np.hypot(kx, ky))
    assert moments.rms_curvature == pytest.approx(0.5e-6 * np.hypot(kx, ky) ** 2)
    across = (moments.lay + np.pi / 2 - np.arctan2(ky, kx)) % np.pi
    assert min(across, np.pi - across) < 1e-6
    peak = spectrum.q[np.argmax(spectrum.density)]
    assert peak == pytest.approx(np.hypot(kx, ky), rel=0.25)


@pytest.mark.parametrize("shape", [(44, 64), (45, 64), (44, 63)])
def test_a_mirrored_map_has_the_mirrored_slopes(shape: tuple[int, int]) -> None:
    """A wave of two pixels runs both ways: it adds nothing to the covariance of the slopes."""
    hm = noise(*shape)
    one, other = (
        surfaces.power_spectrum(hm.replace(heights=z)).moments
        for z in (hm.heights, hm.heights[::-1])
    )
    assert other.m11 == pytest.approx(-one.m11, abs=1e-12 * one.m20)
    assert other.slope_ratio == pytest.approx(one.slope_ratio)


def test_profiles_along_the_axes() -> None:
    hm = noise()
    k = 2 * np.pi * 6 / SIZE[1]
    spectrum = surfaces.power_spectrum(hm.replace(heights=hm.y[:, None] * 0 + np.sin(k * hm.x)))
    assert spectrum.qx[np.argmax(spectrum.density_x)] == pytest.approx(k)
    total = 2 * spectrum.density_x.sum() / SIZE[1]
    assert total == pytest.approx(0.5, rel=1e-9)
    assert spectrum.density_y.max() < 1e-20 * spectrum.density_x.max()


def test_white_noise_is_flat_with_and_without_window() -> None:
    for periodic in (True, False):
        hm = noise(180, 256, periodic)
        spectrum = surfaces.power_spectrum(hm)
        expected = 1e-14 * hm.spacing[0] * hm.spacing[1]
        wide = spectrum.modes > 100
        np.testing.assert_allclose(spectrum.density[wide], expected, rtol=0.25)
        assert spectrum.moments.rms_height == pytest.approx(1e-7, rel=0.03)


def test_nayak_of_a_flat_isotropic_band() -> None:
    """A narrow ring of waves has the smallest Nayak parameter, 1.5."""
    hm = surfaces.self_affine((256, 512), SIZE, hurst=0.8, rms_height=1e-6, cutoff=4e-5)
    ring = surfaces.bandpass(hm, 3.9e-5, 4.3e-5)
    assert surfaces.power_spectrum(ring).moments.nayak == pytest.approx(1.5, rel=0.02)


@pytest.mark.parametrize("hurst", [0.3, 0.5, 0.8])
@pytest.mark.parametrize("periodic", [True, False])
def test_known_spectrum_in_known_spectrum_out(hurst: float, periodic: bool) -> None:
    hm = surfaces.self_affine(
        (512, 768), SIZE, hurst=hurst, rms_height=1e-6, rolloff=2e-4, cutoff=1.6e-5, seed=2
    )
    fit = surfaces.fit_spectrum(surfaces.power_spectrum(hm.replace(periodic=periodic)))
    assert fit.cutoff_kind == "sharp" and fit.self_affine
    assert fit.hurst == pytest.approx(hurst, abs=0.01 if periodic else 0.08)
    assert fit.rolloff == pytest.approx(2e-4, rel=0.02 if periodic else 0.2)
    assert fit.cutoff == pytest.approx(1.6e-5, rel=0.01 if periodic else 0.05)
    for value, error, truth in (
        (fit.hurst, fit.hurst_error, hurst),
        (fit.rolloff, fit.rolloff_error, 2e-4),
        (fit.cutoff, fit.cutoff_error, 1.6e-5),
    ):
        assert abs(value - truth) < 3.0 * error + 1e-3 * truth


def random_field(seed: int) -> np.ndarray:
    """Gaussian surface, random amplitudes as well as phases, H = 0.5, 384 x 512 points."""
    noise = np.random.default_rng(seed).normal(size=(384, 512))
    fy = np.fft.fftfreq(384, SIZE[0] / 384)[:, None]
    fx = np.fft.rfftfreq(512, SIZE[1] / 512)[None, :]
    k = np.maximum(np.hypot(fy, fx), 1 / 2e-4)
    amplitude = np.where(np.hypot(fy, fx) > 1 / 1.6e-5, 0.0, k**-1.5)
    return np.fft.irfft2(np.fft.rfft2(noise) * amplitude, s=noise.shape)


@pytest.mark.parametrize("periodic", [True, False])
def test_a_fit_is_the_same_in_other_units_and_of_the_turned_map(periodic: bool) -> None:
    """Waves on the limit of a ring, as of sides of 8 to 15, do not change it by rounding."""
    rough = surfaces.self_affine(
        (72, 96), (64e-6, 120e-6), hurst=0.7, rms_slope=0.1, rolloff=30e-6, cutoff=4e-6
    )
    heights, spacing = rough.heights, np.array(rough.spacing)
    one, *others = (
        (
            spectrum.edge * unit,
            (fit := surfaces.fit_spectrum(spectrum)).hurst,
            fit.cutoff_error / unit,
        )
        for unit, spectrum in (
            (u, surfaces.power_spectrum(surfaces.HeightMap(u * z, u * d, periodic=periodic)))
            for u, z, d in (
                (1.0, heights, spacing),
                (1e-6, heights, spacing),
                (1e3, heights, spacing),
                (1e12, heights, spacing),
                (1.0, heights.T, spacing[::-1]),
            )
        )
    )
    for other in others:
        assert other == pytest.approx(one, rel=1e-7)


@pytest.mark.parametrize("periodic", [True, False])
def test_uncertainties_cover_the_truth(periodic: bool) -> None:
    """Whole periodic fields, and pieces cut out of them: two deviations hold six times in seven."""
    inside = 0
    for seed in range(12):
        heights = random_field(seed)
        part = heights if periodic else heights[:192, :256]
        spacing = (SIZE[0] / 384, SIZE[1] / 512)
        hm = surfaces.HeightMap(part, spacing, periodic=periodic)
        fit = surfaces.fit_spectrum(surfaces.power_spectrum(hm))
        inside += abs(fit.hurst - 0.5) < 2.0 * fit.hurst_error
        inside += abs(fit.rolloff - 2e-4) < 2.0 * fit.rolloff_error
        inside += abs(fit.cutoff - 1.6e-5) < 2.0 * fit.cutoff_error
    assert inside >= 6 * 36 / 7


def test_a_noise_floor_is_called_a_floor() -> None:
    hm = surfaces.self_affine((384, 512), SIZE, hurst=0.8, rms_height=1e-6, rolloff=4e-4)
    noisy = hm.heights + np.random.default_rng(1).normal(0.0, 1e-7, hm.shape)
    fit = surfaces.fit_spectrum(surfaces.power_spectrum(hm.replace(heights=noisy)))
    assert fit.cutoff_kind == "floor"
    assert fit.hurst == pytest.approx(0.8, abs=0.1)


def test_without_roll_off_or_cut_off_none_is_claimed() -> None:
    hm = surfaces.self_affine((256, 384), SIZE, hurst=0.6, rms_height=1e-6, seed=1)
    fit = surfaces.fit_spectrum(surfaces.power_spectrum(hm))
    assert np.isnan(fit.rolloff) and np.isnan(fit.cutoff) and fit.cutoff_kind == ""
    assert fit.hurst == pytest.approx(0.6, abs=0.02)
    assert "not seen" in str(fit)


def test_missing_points_are_refused() -> None:
    heights = noise().heights.copy()
    heights[0, 0] = np.nan
    with pytest.raises(SurfaceError, match="1 of 2880 points"):
        surfaces.power_spectrum(noise().replace(heights=heights))


def test_too_few_rings() -> None:
    with pytest.raises(SurfaceError, match="rings of the spectrum carry power"):
        surfaces.fit_spectrum(surfaces.power_spectrum(noise(6, 5)))


def test_an_exponent_of_no_self_affine_surface_is_told() -> None:
    """Shown as any other before: white noise, and a fifth of a decade between two limits."""
    narrow = surfaces.self_affine(
        (64, 64), (64.0, 64.0), hurst=0.8, rms_slope=0.1, rolloff=16.0, cutoff=8.0
    )
    for hm, words in (noise(64, 64), "not between 0 and 1"), (narrow, "0.19 decades"):
        found = surfaces.describe(hm)
        (sentence,) = (text for text in found.warnings if "Hurst exponent" in text)
        assert words in sentence and sentence in str(found)
        assert "doubtful" in str(found.fit)
    clean = surfaces.self_affine((128, 128), (128.0, 128.0), hurst=0.8, rms_slope=0.1)
    fit = surfaces.describe(clean).fit
    assert not fit.warnings
    (sentence,) = dataclasses.replace(fit, hurst=1.16, hurst_error=0.84).warnings
    assert "1.16 +- 0.84" in sentence and "do not tell it" in sentence
