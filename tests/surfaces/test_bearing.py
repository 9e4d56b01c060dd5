"""Bearing areas of profiles: exact summits, and the bearing curve of the whole map."""

from __future__ import annotations

import numpy as np
import pytest

import surfaces
from surfaces.peaks.profiles import bearing_areas


@pytest.mark.parametrize("k", [1.0, 2.0, 4.0])
def test_powers_of_the_radius_to_the_edge_of_their_basin(k):
    rays, t, edge = 12, np.linspace(0.0, 1.0, 41), 2.0
    radii = np.where(t > 0, t, 1e-3) * edge
    q = np.tile(radii ** (k - 2), (1, rays, 1))
    weight = np.full((1, rays), 2 * np.pi / rays)
    depths, area = np.array([[0.0, 0.01, 0.1, 0.3, 1.0, 3.0, 20.0]]), np.zeros((1, 7))
    bearing_areas((0, 1), q, t, np.full((1, rays), edge), weight, depths, area)
    exact = np.pi * np.minimum(depths ** (2 / k), edge**2)
    np.testing.assert_allclose(area, exact, rtol=1e-9 if k == 2 else 5e-2, atol=2e-3)


@pytest.mark.parametrize("seed", range(3))
def test_all_basins_together_are_the_bearing_curve(seed):
    hm = surfaces.self_affine(
        (160, 160), (1.0, 1.0), hurst=0.8, rms_slope=0.1, rolloff=0.25, cutoff=0.05, seed=seed
    )
    fit = surfaces.fit_profiles(hm, surfaces.segment(hm))
    for share in (0.02, 0.1):
        level = np.quantile(surfaces.resample(hm, np.array([0.25, 0.25]) / 160).heights, 1 - share)
        depth = np.maximum(fit.height - level, 0.0)[fit.valid, None]
        area = fit.rows(np.flatnonzero(fit.valid)).bearing_areas(depth).sum()
        assert area == pytest.approx(share, rel=0.06)


@pytest.mark.parametrize("ratio", [10.0, -0.1, np.nan, "10 %", [0.1, 0.2]])
def test_material_ratios_are_fractions(ratio):
    """Ten per cent given as 10 is refused, not read as the deepest dale."""
    hm = surfaces.self_affine((32, 48), (32.0, 48.0), hurst=0.8, rms_slope=0.1, cutoff=8.0)
    curve = surfaces.bearing_curve(hm)
    for asked in (curve.height_at, curve.material_volume, curve.void_volume):
        with pytest.raises(surfaces.InputError, match="ratio is"):
            asked(ratio)
    with pytest.raises(surfaces.InputError, match="height is"):
        curve.ratio_at("0")
