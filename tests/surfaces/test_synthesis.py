"""Self-affine synthesis: moments, band, isotropy, lay, and the recorded benchmark surface."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import surfaces

RECORDED_64 = [-0.012873564660625968, 0.018926087828911434, 0.01797393223444611]
RECORDED_128 = [0.0070373837551980685, -0.0022976212074151863, -0.018106214162561286]


def spectrum(hm):
    """Full power |h_k|^2 and the frequencies (fy, fx) in cycles per metre."""
    power = np.abs(np.fft.fft2(hm.heights) / hm.heights.size) ** 2
    fy = np.fft.fftfreq(hm.shape[0], hm.spacing[0])[:, None]
    fx = np.fft.fftfreq(hm.shape[1], hm.spacing[1])[None, :]
    return power, fy, fx


@pytest.mark.parametrize("shape", [(48, 65), (65, 48), (33, 81), (64, 40)])
def test_rms_slope_and_height_are_met(shape):
    band = {"hurst": 0.7, "rolloff": 0.5, "cutoff": 0.15, "seed": 4}
    steep = surfaces.self_affine(shape, (2.0, 3.0), rms_slope=0.3, **band)
    power, fy, fx = spectrum(steep)
    slope = np.sqrt(np.sum(power * (2 * np.pi) ** 2 * (fy**2 + fx**2)))
    assert_allclose(slope, 0.3, rtol=1e-12)
    assert abs(steep.heights.mean()) < 1e-15
    assert steep.size == pytest.approx((2.0, 3.0))
    high = surfaces.self_affine(shape, (2.0, 3.0), rms_height=1e-6, **band)
    assert_allclose(high.rms_height, 1e-6, rtol=1e-12)
    assert_allclose(high.heights / high.rms_height, steep.heights / steep.rms_height, atol=1e-12)


def test_spectrum_has_the_asked_exponent_and_band():
    hurst, rolloff, cutoff = 0.6, 0.25, 0.05
    hm = surfaces.self_affine(
        (96, 120), (1.0, 1.5), hurst=hurst, rms_height=1.0, rolloff=rolloff, cutoff=cutoff, seed=2
    )
    power, fy, fx = spectrum(hm)
    k = np.hypot(fy, fx)
    assert power[k > 1.001 / cutoff].max() < 1e-28
    flat = power[(k > 0) & (k < 1 / rolloff)]
    assert_allclose(flat, flat[0], rtol=1e-9)
    fall = (k > 1 / rolloff) & (k < 0.99 / cutoff)
    slope = np.polyfit(np.log(k[fall]), np.log(power[fall]), 1)[0]
    assert_allclose(slope, -2 * (1 + hurst), rtol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.5, np.pi / 2])
def test_anisotropy_stretches_the_spectrum_along_the_lay(angle):
    """Second spectral moments across and along the lay: ratio of the stretch squared."""
    hm = surfaces.self_affine(
        (256, 256), (1.0, 1.0), hurst=0.8, rms_height=1.0, rolloff=1 / 8, cutoff=1 / 24,
        anisotropy=4.0, angle=angle, seed=1,
    )  # fmt: skip
    power, fy, fx = spectrum(hm)
    along = np.sum(power * (fx * np.cos(angle) + fy * np.sin(angle)) ** 2)
    across = np.sum(power * (fy * np.cos(angle) - fx * np.sin(angle)) ** 2)
    assert_allclose(across / along, 16.0, rtol=0.1)


def test_equals_the_recorded_benchmark_surface():
    """The benchmark's self_affine(64, 16, 8, 0.8, 0) and self_affine(128, 37, 13, 0.8, 2)."""
    hm = surfaces.self_affine(
        (64, 64), (1, 1), hurst=0.8, rms_slope=1.0, rolloff=1 / 8, cutoff=1 / 16, seed=0
    )
    assert_allclose(hm.heights[[0, 3, 40], [0, 5, 63]], RECORDED_64, rtol=0, atol=1e-12)
    hm = surfaces.self_affine(
        (128, 128), (1, 1), hurst=0.8, rms_slope=1.0, rolloff=1 / 13, cutoff=1 / 37, seed=2
    )
    assert_allclose(hm.heights[[0, 77, 127], [0, 9, 64]], RECORDED_128, rtol=0, atol=1e-12)


def test_seed_names_the_surface():
    def make(seed):
        return surfaces.self_affine((32, 48), (1, 1), hurst=0.5, rms_height=1.0, seed=seed).heights

    assert np.array_equal(make(3), make(3))
    assert not np.allclose(make(3), make(4))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"hurst": 1.5}, "hurst is 1.5"),
        ({"rms_height": 1.0}, "either rms_slope .* or rms_height"),
        ({"rms_slope": None}, "either rms_slope .* or rms_height"),
        ({"rms_slope": -1.0}, "must be positive"),
        ({"cutoff": 0.0}, "cutoff is 0"),
        ({"cutoff": 50.0}, "no wave lies"),
        ({"anisotropy": 0.5}, "anisotropy is 0.5"),
        ({"shape": (2, 20)}, "whole number, at least 3"),
        ({"shape": (20.5, 20)}, "whole number, at least 3"),
        ({"size": (0.0, 1.0)}, "size is"),
        ({"size": (1.0, 1e-300)}, "size is"),
        ({"shape": 20}, r"points \(ny, nx\)"),
        ({"size": 1.0}, r"lengths \(Ly, Lx\)"),
        ({"shape": (10**6, 10**7)}, "GB of memory"),
        ({"seed": -1}, "seed is -1"),
        ({"seed": 1.5}, "seed is 1.5"),
        ({"anisotropy": 4.0, "angle": np.nan}, "angle is nan"),
        ({"anisotropy": np.inf}, "anisotropy is inf"),
        ({"anisotropy": 1e300}, "no calculation holds"),
        ({"rms_slope": np.inf}, "positive and finite"),
    ],
)
def test_wrong_input_is_refused_in_one_sentence(changes, message):
    options = {"shape": (20, 24), "size": (1.0, 1.2), "hurst": 0.8, "rms_slope": 0.1} | changes
    with pytest.raises(surfaces.InputError, match=message):
        surfaces.self_affine(options.pop("shape"), options.pop("size"), **options)


def test_redistribute_gives_the_heights_and_keeps_the_spectrum():
    hm = surfaces.self_affine(
        (48, 64), (1.0, 1.3), hurst=0.7, rms_height=1.0, rolloff=0.3, cutoff=0.05, seed=1
    )

    def quantile(p):
        return -np.log1p(-p)  # exponential heights

    other = surfaces.redistribute(hm, quantile)
    n = hm.heights.size
    assert_allclose(np.sort(other.heights, axis=None), quantile((np.arange(n) + 0.5) / n))
    old, new = (np.abs(np.fft.rfft2(m.heights - m.heights.mean())) for m in (hm, other))
    assert np.corrcoef(old.ravel(), new.ravel())[0, 1] > 0.98
    for wrong in (lambda p: 1.0, lambda p: p[:5], lambda p: -p, lambda p: "abc"):
        with pytest.raises(surfaces.InputError, match="quantile"):
            surfaces.redistribute(hm, wrong)
    with pytest.raises(surfaces.InputError, match="periodic map"):
        surfaces.redistribute(hm.replace(periodic=False), np.sort)
    with pytest.raises(surfaces.InputError, match="not a constant one"):
        surfaces.redistribute(
            surfaces.HeightMap(np.ones((4, 5)), 1.0, periodic=True), lambda share: share
        )
    with pytest.raises(surfaces.InputError, match="iterations is -3"):
        surfaces.redistribute(hm, lambda share: share, iterations=-3)


@pytest.mark.parametrize("shape", [(700, 33), (601, 64), (40, 903)])
@pytest.mark.parametrize("anisotropy", [1.0, 5.0])
def test_a_map_in_blocks_is_the_map_in_memory(tmp_path, monkeypatch, shape, anisotropy):
    """Both parities of both axes; several blocks of columns and of rows."""
    waves = {"hurst": 0.6, "rms_slope": 0.2, "rolloff": 0.3, "anisotropy": anisotropy, "seed": 7}
    whole = surfaces.self_affine(shape, (1.0, 1.3), angle=0.4, **waves)
    monkeypatch.setattr("surfaces.numerics.memory._PROGRAM", 0)
    monkeypatch.setattr("surfaces.random_waves._TILE", 200)
    tiled = surfaces.self_affine(shape, (1.0, 1.3), angle=0.4, **waves)
    assert_allclose(tiled.heights, whole.heights, rtol=0, atol=1e-14 * whole.rms_height)
    least = max(16 * shape[0], 40 * min(shape[0], 256) * shape[1])
    path = tmp_path / "map.h5"
    monkeypatch.setattr("surfaces.numerics.memory._USUAL", least)
    surfaces.write_self_affine(path, shape, (1.0, 1.3), angle=0.4, **waves)
    found = surfaces.read(path)
    assert_allclose(found.heights, whole.heights, rtol=0, atol=1e-12 * whole.rms_height)
    assert found.history == whole.history and found.periodic and found.spacing == whole.spacing
    monkeypatch.setattr("surfaces.numerics.memory._USUAL", least - 1)
    with pytest.raises(surfaces.InputError, match="MiB of memory or more, not"):
        surfaces.write_self_affine(path, shape, (1.0, 1.3), **waves)
    assert surfaces.read(path).digest == found.digest and list(tmp_path.iterdir()) == [path]
