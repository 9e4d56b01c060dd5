"""Maps that measured data bring: one spike of 400 rms, a deep pit, a strong lay, a step."""

from __future__ import annotations

import numpy as np
import pytest
from strategies import rough

from asperity import HalfSpace, bem_curve, bem_solve
from surfaces import HeightMap

BODY = HalfSpace.from_modulus(1.0)


def rescaled(heights, hm):
    """Heights of rms one pixel-slope unit on the pixels of a map."""
    return HeightMap(heights * hm.rms_height / heights.std(), hm.spacing, periodic=True)


def spike(hm):
    """One steep spike whose height is 400 times the rms of the rest."""
    y, x = np.indices(hm.shape)
    peak = np.exp(-np.hypot(y - 50, x - 70) / 1.5)
    return HeightMap(hm.heights + 400 * hm.rms_height * peak, hm.spacing, periodic=True)


def pit(hm):
    """One pixel far below all others."""
    heights = hm.heights.copy()
    heights[40, 0] -= 2000 * hm.rms_height
    return HeightMap(heights, hm.spacing, periodic=True)


def lay(hm):
    """Grooves along x: roughness stretched sixtyfold."""
    wave = np.convolve(hm.heights[:, 0], np.ones(3) / 3, mode="same")
    return rescaled(wave[:, None] + 0.02 * hm.heights, hm)


def step(hm):
    """One half of the map lies 50 rms higher."""
    high = np.where(np.arange(hm.shape[1]) < hm.shape[1] // 2, 50 * hm.rms_height, 0.0)
    return HeightMap(hm.heights + high, hm.spacing, periodic=True)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("change", [spike, pit, lay, step])
def test_extreme_maps_converge(change, boundary):
    """A curve over light to moderate loads is certified in a bounded number of corrections."""
    hm = change(rough((140, 150), size=(1.4, 1.5), slope=0.1, seed=3))
    curve = bem_curve(hm, BODY, pressures=[1e-4, 1e-3, 1e-2], boundary=boundary)
    assert curve.converged.all(), curve.reasons
    assert curve.extra["fft_pairs"].max() <= 12
    assert curve.extra["iterations"].max() <= 800


def test_separation_on_a_spiky_map():
    """The load of a prescribed separation is found on a spiky map too."""
    hm = spike(rough((90, 100), size=(0.9, 1.0), slope=0.1, seed=4))
    loaded = bem_solve(hm, BODY, pressure=1e-3)
    back = bem_solve(hm, BODY, separation=loaded.separation)
    assert loaded.converged and back.converged
    assert back.mean_pressure == pytest.approx(1e-3, rel=1e-3)


@pytest.mark.parametrize("height", [30.0, 300.0])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-5])
def test_a_point_far_above_noise_carries_the_load_alone_first(height, tolerance):
    """The coarse grids do not know how high it is, and start beside it."""
    heights = np.random.default_rng(0).normal(size=(128, 128))
    heights[40, 64] += height
    hm = HeightMap(heights, (50.0, 50.0), periodic=True)
    body = HalfSpace.from_modulus(1.0)
    alone = height / hm.area  # presses the point in by less than it stands out
    curve = bem_curve(hm, body, pressures=[alone, 1e-3], tolerance=tolerance)
    assert curve.converged.all()
    assert curve.extra["contact_area_raw"][0] == hm.spacing[0] * hm.spacing[1]


@pytest.mark.parametrize("height", [0.0, 5.0])
def test_a_flat_punch_scales_with_its_load(height):
    """It has no height that would be a unit: squares of its light pressures must still be held."""
    hm = HeightMap(np.full((16, 16), height), 1e-6)
    body = HalfSpace.from_modulus(1e9)
    loads = np.array([1e-6, 1e-3, 1.0, 1e6])
    curve = bem_curve(hm, body, pressures=loads, accuracy=0.05, boundary="free")
    assert curve.converged.all(), curve.reasons
    np.testing.assert_allclose(curve.stiffness, curve.stiffness[-1], rtol=1e-3)


def test_plateaus_share_a_light_load():
    """Half of the map has one height. The first steps leave the load to a few points of it, from
    which it must get to all the others."""
    shape = 12, 150
    waves = np.fft.fft2(np.random.default_rng(5).normal(size=shape))
    far = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.fftfreq(shape[1]))
    heights = np.fft.ifft2(waves * np.exp(-((9.0 * far) ** 2))).real
    heights = np.minimum(heights, np.median(heights)) / heights.std()
    curve = bem_curve(HeightMap(heights, 10.0, periodic=True), BODY, pressures=[1e-7])
    assert curve.converged.all(), curve.reasons
    assert curve.extra["iterations"][0] < 60
    assert curve.extra["contact_area_raw"][0] == 100.0 * np.count_nonzero(heights == heights.max())
