"""The split of a map into longer waves and a law of the finer ones."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from strategies import STEEL, broad

import asperity
import surfaces
from asperity.errors import InputError
from asperity.halfspace.influence import compliance
from asperity.model.plan import make_plan
from asperity.multiscale.wave_split import split_scales
from surfaces import HeightMap


def test_the_map_is_the_band_of_longer_waves(rough):
    split = split_scales(rough, STEEL)
    coarse, fine = split.coarse, split.fine
    shell = 1 / max(rough.size)
    edge = 1 / (1 / fine.shortest + 0.5 * shell)
    band = surfaces.resample(surfaces.bandpass(rough, shortest=edge), coarse.spacing)
    assert band.shape == coarse.shape
    assert fine.shortest >= 6 * max(coarse.spacing) > 0.9 * fine.shortest
    np.testing.assert_allclose(coarse.heights, band.heights, atol=1e-9 * rough.rms_height)


def sums(hm: HeightMap, body) -> tuple[float, float, np.ndarray]:
    """Variance of the pressure and energy per area of a map pressed flat, and its slope tensor."""
    waves = np.abs(np.fft.fft2(hm.heights) / hm.heights.size) ** 2
    qy, qx = np.meshgrid(
        *(2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(hm.shape, hm.spacing, strict=True)),
        indexing="ij",
    )
    stiffness = np.hypot(qy, qx) ** (1 - body.m) / compliance((1.0, 1.0), body)
    tensor = np.array([[(waves * a * b).sum() for a in (qy, qx)] for b in (qy, qx)])
    return (waves * stiffness**2).sum(), 0.5 * (waves * stiffness).sum(), tensor


@pytest.mark.parametrize("more", [{}, {"anisotropy": 3.0, "angle": 0.5}])
@pytest.mark.parametrize("m", [0.0, 0.3, -0.3])
def test_pressure_and_energy_are_those_of_the_waves_left_out(m, more):
    hm, body = broad(**more), asperity.HalfSpace.from_modulus(2e11, m=m)
    split = split_scales(hm, body)
    coarse, fine = split.coarse, split.fine
    (whole, stored, slopes), (longer, held, gentle) = (sums(map_, body) for map_ in (hm, coarse))
    assert fine.variance == pytest.approx(whole - longer, rel=1e-6)
    assert fine.energy == pytest.approx(stored - held, rel=1e-6)
    assert fine.ratio == pytest.approx(whole / longer - 1, rel=1e-6)
    low, high = np.linalg.eigvalsh(slopes - gentle)
    assert fine.evenness == pytest.approx(2 * np.sqrt(low * high) / (low + high), rel=1e-6)


@pytest.mark.parametrize("more", [{}, {"anisotropy": 3.0, "angle": 0.5}])
def test_a_finer_split_is_one_of_the_same_waves(more):
    """It has only the longer of them at hand, and the sums of all."""
    hm = broad((400, 480), **more)
    split = split_scales(hm, STEEL)
    finer = split.finer(STEEL)
    assert finer.shells.waves.size < 0.6 * hm.heights.size / 2
    assert finer.fine.shortest < 0.75 * split.fine.shortest
    (whole, stored, _), (longer, held, _) = (sums(map_, STEEL) for map_ in (hm, finer.coarse))
    assert finer.fine.variance == pytest.approx(whole - longer, rel=1e-6)
    assert finer.fine.energy == pytest.approx(stored - held, rel=1e-6)
    assert finer.finer(STEEL) is finer


def test_a_free_map_is_taken_with_its_mirror_images(rough):
    free = dataclasses.replace(rough, periodic=False)
    split = split_scales(free, STEEL)
    coarse, fine = split.coarse, split.fine
    mirrored, smooth = (
        surfaces.prepare(hm, level=None, periodic="mirror") for hm in (free, coarse)
    )
    (whole, stored, _), (longer, held, _) = (sums(hm, STEEL) for hm in (mirrored, smooth))
    assert fine.variance == pytest.approx(whole - longer, rel=1e-6)
    assert fine.energy == pytest.approx(stored - held, rel=1e-6)
    edge = (1 + 1e-9) / (1 / fine.shortest + 0.5 / max(rough.size))
    band = surfaces.resample(surfaces.bandpass(mirrored, shortest=edge), smooth.spacing)
    ny, nx = coarse.shape
    np.testing.assert_allclose(coarse.heights, band.heights[:ny, :nx], atol=1e-9 * rough.rms_height)
    periodic = split_scales(rough, STEEL)
    assert fine.variance == pytest.approx(periodic.fine.variance, rel=0.1)


def test_the_law_does_not_jump_at_a_homogeneous_body_nor_at_no_lay(rough):
    plain = split_scales(rough, STEEL).fine
    near = split_scales(rough, asperity.HalfSpace.from_modulus(2e11, m=1e-7)).fine
    for name in ("shortest", "spread", "energy", "variance", "ratio"):
        assert getattr(near, name) == pytest.approx(getattr(plain, name), rel=1e-5)
    assert near.lift(0.1) == pytest.approx(plain.lift(0.1), rel=1e-6)
    assert plain.evenness == pytest.approx(1.0, abs=5e-3)
    even, nearly = (dataclasses.replace(plain, evenness=w) for w in (1.0, 1.0 - 1e-7))
    assert nearly.spread == pytest.approx(even.spread, rel=1e-6)


def test_with_lay_waves_are_told_apart_along_and_across(rough):
    """Of a map squeezed in one direction the shortest that is kept is squeezed half as far."""
    law = split_scales(rough, STEEL).fine
    for factors in ((1.0, 3.0), (3.0, 1.0)):
        spacing = tuple(d * f for d, f in zip(rough.spacing, factors, strict=True))
        split = split_scales(HeightMap(rough.heights, spacing, periodic=True), STEEL)
        coarse, fine = split.coarse, split.fine
        waves = np.abs(np.fft.fft2(coarse.heights))
        kept = waves > 1e-9 * waves.max()
        reach = [
            np.abs(np.fft.fftfreq(n, d))[kept.any(axis=1 - axis)].max()
            for axis, (n, d) in enumerate(zip(coarse.shape, coarse.spacing, strict=True))
        ]
        assert reach[0] / reach[1] == pytest.approx(np.sqrt(factors[1] / factors[0]), rel=0.05)
        assert fine.shortest == pytest.approx(1 / np.sqrt(np.prod(reach)), rel=0.05)
        assert law.shortest < fine.shortest < np.sqrt(3.0) * law.shortest
        assert 0.45 < fine.evenness < 0.6  # those left out have more of the lay than all, 0.6


def test_maps_that_keep_all_their_summits(monkeypatch):
    def why(hm, body=STEEL):
        found = split_scales(hm, body)
        assert isinstance(found, str)
        return found

    rough = broad()
    assert "|m| <= 0.5" in why(rough, asperity.HalfSpace.from_modulus(2e11, m=0.6))
    assert "direction" in why(broad(anisotropy=12.0))
    assert "direction" in why(broad(anisotropy=8.0, hurst=0.3, cutoff=4.4e-6))
    assert "narrow" in why(broad(anisotropy=5.0))
    with monkeypatch.context() as less:
        less.setattr("asperity.multiscale.wave_split.SURELY_WORTH_IT", 0.5)
        assert not isinstance(split_scales(broad(anisotropy=5.0), STEEL), str)
        assert "direction" in why(broad(anisotropy=5.0, angle=0.5))
    for angle in (0.0, 0.8):
        lay = dataclasses.replace(broad(anisotropy=3.0, angle=angle), periodic=False)
        assert "for periodic maps only" in why(lay)
    assert "narrow" in why(broad(cutoff=1.2e-5))
    spikes = rough.heights.copy()
    spikes[::40, ::40] += 4 * rough.rms_height
    assert "not random" in why(rough.replace(heights=spikes))
    assert make_plan(rough, STEEL, scales="all").fine is None
    assert make_plan(rough, STEEL, interaction=False).fine is None
    with pytest.raises(InputError, match="choose one of auto, all"):
        make_plan(rough, STEEL, scales="coarse")


def test_no_wave_shorter_than_three_pixels_is_kept():
    """A spectrum that is not broad is cut there if it holds much beyond, else not at all."""
    for hurst in (0.6, 0.7):
        hm = broad(rolloff=2.9e-5, hurst=hurst, cutoff=2.2e-6)
        kept = split_scales(hm, STEEL).fine.shortest / max(hm.spacing)
        assert 3.0 <= kept < 3.1
    for hurst, cutoff, rolloff in ((0.8, 2.2e-6, 2.9e-5), (0.9, 2.2e-6, 2.9e-5), (0.8, 3e-6, 6e-5)):
        found = split_scales(broad(rolloff=rolloff, hurst=hurst, cutoff=cutoff), STEEL)
        assert isinstance(found, str) and "narrow" in found


@pytest.mark.parametrize("hurst", [0.5, 0.8, 1.0])
def test_without_a_rolloff_enough_waves_are_kept(hurst):
    """The longest waves make a spectrum as broad as one likes, and all others would be short."""
    hm = broad(hurst=hurst, rolloff=None)
    side = np.sqrt(hm.area)
    assert side / split_scales(hm, STEEL).fine.shortest == pytest.approx(50, rel=0.02)
    assert "too few waves" in split_scales(broad(hurst=hurst, rolloff=None, cutoff=5e-6), STEEL)
