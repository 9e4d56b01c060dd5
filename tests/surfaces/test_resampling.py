"""A smooth map is held by few points; what does not show in its spectrum keeps the full grid."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import surfaces
from surfaces.preparation.resampling import coarse_map, resample_waves, shortest_wave


def smooth(cutoff=0.09, shape=(240, 288), size=(1.0, 1.8)):
    return surfaces.self_affine(
        shape, size, hurst=0.8, rms_height=0.01, rolloff=0.5, cutoff=cutoff, seed=2
    )


def test_the_same_surface_on_fewer_points():
    hm = smooth()
    found = coarse_map(hm)
    assert found is not None and found.hm.heights.size < 0.5 * hm.heights.size
    coarse, corner = found
    assert_allclose(coarse.size, hm.size, rtol=1e-12)
    assert_allclose(coarse.heights.mean(), hm.heights.mean(), atol=1e-12)
    assert_allclose(np.divide(*coarse.spacing), np.divide(*hm.spacing), rtol=0.1)
    few, many = (surfaces.fit_profiles(m, surfaces.segment(m)) for m in (coarse, hm))
    few, many = (fit.rows(np.argsort(-fit.height)[:8]) for fit in (few, many))
    for name, step, place in zip("yx", hm.spacing, corner, strict=True):
        assert_allclose(getattr(few, name) + place, getattr(many, name), atol=0.02 * step)
    assert_allclose(few.height, many.height, rtol=1e-4)
    assert_allclose(few.curvature, many.curvature, rtol=0.02)


def test_the_shortest_wave_of_a_sine():
    y, x = np.mgrid[:80, :120]
    hm = surfaces.HeightMap(
        np.sin(2 * np.pi * y / 20) + np.sin(2 * np.pi * x / 15), (1.0, 2.0), periodic=True
    )
    assert shortest_wave(hm, 0) == pytest.approx(20)
    assert shortest_wave(hm, 1) == pytest.approx(15)


@pytest.mark.parametrize("periodic", [True, False])
def test_power_of_lines_is_that_of_the_map(periodic):
    hm = smooth(cutoff=0.04).replace(periodic=periodic)
    slopes = []
    for power, length in zip(hm.line_power, hm.size, strict=True):
        number = np.pi * (1 + periodic) * np.arange(power.size) / length
        slopes.append(np.sqrt(power @ number**2))
    assert_allclose(slopes, hm.roughness.slope, rtol=0.05)


@pytest.mark.parametrize("fewer", [(2, 1), (1, 3), (4, 4), (3, 4)])
def test_a_part_of_the_points_holds_the_waves(fewer):
    hm = smooth()
    for shape in ((60, 72), (50, 71)):
        whole = resample_waves(hm.heights, *shape)
        assert_allclose(
            resample_waves(hm.heights, *shape, fewer), whole, atol=1e-12 * hm.rms_height
        )


def test_pixels_that_begin_elsewhere_hold_the_same_waves():
    hm, count = smooth(), (60, 72)
    corner = 5 / 240, 7 / 288
    rolled = np.roll(hm.heights, (-5, -7), (0, 1))
    assert_allclose(
        resample_waves(hm.heights, *count, corner=corner),
        resample_waves(rolled, *count),
        atol=1e-12 * hm.rms_height,
    )


def test_maps_that_need_their_own_grid():
    hm = smooth()
    assert coarse_map(smooth(cutoff=0.02)) is None
    assert coarse_map(hm.replace(periodic=False)) is None
    assert coarse_map(smooth(shape=(48, 60))) is None


def test_a_single_spike_keeps_the_full_grid():
    """Too narrow to matter in the spectrum, and the first to touch."""
    hm = smooth()
    heights = hm.heights.copy()
    heights[np.unravel_index(heights.argmax(), hm.shape)] += 0.1 * hm.rms_height
    spiked = hm.replace(heights=heights)
    assert shortest_wave(spiked, 0) == pytest.approx(shortest_wave(hm, 0), rel=0.1)
    assert coarse_map(spiked) is None
