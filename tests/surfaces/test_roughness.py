"""The means over a map in one pass are those of numpy, missing points left out."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import surfaces
from surfaces.roughness import ROW_BANDS


def by_numpy(hm):
    """Rms of first and second differences along y and x."""
    dy, dx = hm.spacing
    out = []
    for order in (1, 2):
        for axis, step in ((0, dy), (1, dx)):
            change = np.diff(hm.heights, n=order, axis=axis) / step**order
            out.append(np.sqrt(np.nanmean(change**2)))
    return out


@pytest.mark.parametrize("missing", [False, True])
@pytest.mark.parametrize("shape", [(3, 4), (150, 133)])
def test_same_means_as_numpy(shape, missing):
    h = 5.0 + np.random.default_rng(2).normal(size=shape)
    if missing:
        h[0, 0] = h[1, 2:4] = np.nan
    hm = surfaces.HeightMap(h, (0.3, 0.7))
    found = hm.roughness
    assert_allclose(found.mean, np.nanmean(h), rtol=1e-12)
    assert_allclose(found.rms_height, np.nanstd(h), rtol=1e-12)
    assert (found.lowest, found.highest) == (np.nanmin(h), np.nanmax(h))
    assert found.missing == hm.missing == 3 * missing
    assert_allclose([*found.slope, *found.curvature], by_numpy(hm), rtol=1e-12)


@pytest.mark.parametrize("missing", [False, True])
@pytest.mark.parametrize("shape", [(3, 4), (150, 133)])
def test_a_periodic_map_has_no_border(shape, missing):
    """Slopes and curvatures left out the seam, and depended on where the map was cut."""
    h = np.random.default_rng(2).normal(size=shape)
    if missing:
        h[0, 0] = h[1, 2:4] = np.nan
    dy, dx = spacing = (0.3, 0.7)
    found, moved = (
        surfaces.HeightMap(z, spacing, periodic=True).roughness
        for z in (h, np.roll(h, (2, 3), (0, 1)))
    )
    steps = [(np.roll(h, -1, axis) - h) / d for axis, d in ((0, dy), (1, dx))]
    bends = [
        (np.roll(h, -1, axis) - 2 * h + np.roll(h, 1, axis)) / d**2
        for axis, d in ((0, dy), (1, dx))
    ]
    exact = [np.sqrt(np.nanmean(change**2)) for change in (*steps, *bends)]
    assert_allclose([*found.slope, *found.curvature], exact, rtol=1e-12)
    assert_allclose([*moved.slope, *moved.curvature], exact, rtol=1e-12)
    assert_allclose(moved.kurtosis, found.kurtosis, rtol=1e-12)


@pytest.mark.parametrize("shape", [(3, 4), (150, 133)])
def test_highest_points_of_the_columns_of_each_band(shape):
    h = np.random.default_rng(4).normal(size=shape)
    h[0, 1] = np.nan
    found, bands = surfaces.HeightMap(h, (0.3, 0.7)).roughness, min(ROW_BANDS, shape[0])
    assert found.tops.shape == (bands, shape[1])
    for band in range(bands):
        rows = slice(shape[0] * band // bands, shape[0] * (band + 1) // bands)
        assert_array_equal(found.tops[band], np.nanmax(h[rows], axis=0, initial=-np.inf))
    present = np.isfinite(found.tops)
    assert_array_equal(h[found.rows, np.arange(shape[1])][present], found.tops[present])


def test_kurtosis_of_second_differences_sees_the_border_of_a_periodic_map():
    h = np.random.default_rng(3).normal(size=(15, 20))
    for periodic in (True, False):
        found = surfaces.HeightMap(h, (0.3, 0.7), periodic=periodic).roughness.kurtosis
        for axis in (0, 1):
            ring = np.concatenate((h.take([-1], axis), h, h.take([0], axis)), axis)
            bend = np.diff(ring if periodic else h, 2, axis)
            wanted = np.mean(bend**4) / np.mean(bend**2) ** 2
            assert_allclose(found[axis], wanted, rtol=1e-12)


def test_a_plane_has_a_slope_and_never_turns():
    y, x = np.mgrid[:30, :40]
    found = surfaces.HeightMap(2.0 * y - x, (1.0, 0.5)).roughness
    assert found.slope == (2.0, 2.0)
    assert found.length == np.inf


def test_a_changed_map_has_its_own_means():
    hm = surfaces.HeightMap(np.eye(4), 1.0)
    assert hm.roughness.highest == 1.0
    assert hm.replace(heights=3.0 * hm.heights).roughness.highest == 3.0
