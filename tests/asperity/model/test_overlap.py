"""Ground on which the flat comes down without a summit: exact gaps, boundary elements."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import asperity
from asperity.model.overlap import Blocks
from surfaces import HeightMap, self_affine

BODY = asperity.HalfSpace.from_modulus(1e9)
SIDE = 96


def hills(count: int, *, periodic: bool = True) -> HeightMap:
    """Smooth bumps of several heights on a plane, pixels of 10 nm."""
    rng = np.random.default_rng(5)
    y, x = np.indices((SIDE, SIDE))
    heights = np.zeros((SIDE, SIDE))
    for place in range(count):
        row, col = SIDE * (0.25 + 0.5 * (place // 3)), SIDE * (0.2 + 0.3 * (place % 3))
        square = (y - row) ** 2 + (x - col) ** 2
        top, wide = rng.uniform(30, 60), rng.uniform(20, 36)
        heights = np.maximum(heights, top * np.exp(-square / wide))
    return HeightMap(1e-9 * heights, 1e-8, periodic=periodic)


@pytest.mark.parametrize("count", [1, 6])
@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_a_plane_under_hills_is_not_passed_in_silence(boundary, count):
    """Where the plane touches, the hills alone carried 2 to 50 times less than the surface does."""
    hm = hills(count, periodic=boundary == "periodic")
    loads = np.geomspace(1e-2, 1.0, 7) * BODY.modulus * hm.roughness.rms_slope
    exact = asperity.bem_curve(hm, BODY, pressures=loads, accuracy=0.02, boundary=boundary)
    curve = asperity.contact_curve(hm, BODY, separations=exact.separation, boundary=boundary)
    alone, ground = exact.area_fraction < 0.03, exact.area_fraction > 0.25
    assert alone.sum() >= 2 and ground.sum() >= 3
    assert curve.converged[alone].all() and (curve.extra["overlap"][alone] < 0.02).all()
    good = curve.converged
    missed = np.abs(curve.mean_pressure / exact.mean_pressure - 1.0)[good]
    assert (missed <= curve.error_estimate[good] + 0.02).all()
    assert not curve.converged[ground].any()
    if boundary == "periodic":  # the joined hills of a free map fill it
        assert any("no summit" in why for why in curve.reasons)


def test_random_waves_do_not_overlap_at_ordinary_loads():
    hm = self_affine((192, 160), (1.0, 0.8), hurst=0.8, rms_slope=0.1, rolloff=0.2, seed=3)
    loads = np.geomspace(1e-3, 0.05, 4) * BODY.modulus * hm.roughness.rms_slope
    curve = asperity.contact_curve(hm, BODY, pressures=loads)
    assert curve.area_fraction[-1] > 0.08
    assert (curve.extra["overlap"] < 0.01).all()


@pytest.mark.parametrize("m", [0.0, -0.4, 0.5])
def test_far_gaps_about_a_load_are_those_of_a_half_space(m):
    body = asperity.HalfSpace.from_modulus(1e9, m)
    hm = HeightMap(1e-30 * np.eye(80, 64), (1e-6, 2e-6))
    blocks = Blocks.of(hm, 0.0, np.array([20.5e-6]), np.array([61e-6]), body, wraps=False)
    assert blocks.heights.shape == (64, 64)
    y, x = ((np.arange(64) + 0.5) * step for step in (80e-6 / 64, 2e-6))
    away = np.hypot(y[:, None] - 20.6e-6, x - 61e-6)
    point = np.sin((1 - abs(m)) * np.pi / 2) / (np.pi * body.modulus) / away ** (1 + m)
    gap = blocks.gaps(np.array([1e-6]), 0.0)[2:-2, 2:-2]
    far = away[2:-2, 2:-2] > 2e-5
    assert_allclose(gap[far], 1e-6 * point[2:-2, 2:-2][far], rtol=0.03)


def test_the_mean_gap_of_a_periodic_map_is_the_separation():
    heights = 1e-9 * np.random.default_rng(1).normal(size=(30, 50))
    hm = HeightMap(heights, 1e-6, periodic=True)
    place = np.array([1e-5]), np.array([2e-5])
    blocks = Blocks.of(hm, float(heights.mean()), *place, BODY, wraps=True)
    assert blocks.gaps(np.array([2e-6]), 3e-9).mean() == pytest.approx(3e-9)


def test_overlap_counts_volume_and_area():
    """A surface of two levels, half as much of it above the mean plane as below."""
    heights = np.repeat([2e-9, -1e-9, -1e-9], 600)[:, None] * np.ones(60)
    hm = HeightMap(heights, 1e-6, periodic=True)
    place = np.array([3e-4]), np.array([3e-5])
    blocks = Blocks.of(hm, 0.0, *place, BODY, wraps=True)

    def overlap(separation: float, share: float) -> float:
        return blocks.overlap(np.array([1e-30]), separation, share)

    assert overlap(1e-7, 0.1) == 0.0
    assert overlap(0.0, 0.5) == pytest.approx(1.0, rel=0.01)
    assert overlap(0.5e-9, 0.5) == pytest.approx(1.5 / 3.0, rel=0.1)
    assert overlap(0.5e-9, 0.1) == pytest.approx(1.5 / 3.0 + (1 / 3) / 0.1 - 1.0, rel=0.1)
    assert overlap(-1e-7, 0.5) == np.inf
