"""Known truth in, the same truth out: drawn caps come back from segmentation and fitting."""

from __future__ import annotations

import numpy as np
import pytest
from caps import (
    Cap,
    cone,
    draw,
    ellipsoid,
    paraboloid,
    pyramid,
    random_caps,
    sphere,
    sphere_array,
    star,
)
from numpy.testing import assert_allclose

import surfaces


def found(hm):
    peaks = surfaces.segment(hm)
    return peaks, surfaces.fit_profiles(hm, peaks)


def nearest(fit, cap, hm):
    """Index of the fitted summit next to a cap, and the distance in pixels."""
    away = np.stack([(fit.y - cap.y), (fit.x - cap.x)])
    if hm.periodic:
        size = np.array(hm.size)[:, None]
        away -= size * np.round(away / size)
    away /= np.array(hm.spacing)[:, None]
    distance = np.hypot(*away)
    return int(np.argmin(distance)), float(distance.min())


@pytest.mark.parametrize("spacing", [(1.0, 1.0), (1.0, 1.4), (0.6, 0.5)])
@pytest.mark.parametrize(("kind", "options"), [(paraboloid, {}), (ellipsoid, {"depth": 40.0})])
@pytest.mark.parametrize("periodic", [True, False])
def test_random_caps_come_back(spacing, kind, options, periodic):
    """Positions to 0.02 pixels, curvatures to 1 %: touching, across the seam, at the border."""
    shape = (160, 140)
    for seed in range(2):
        caps = random_caps(
            shape, spacing, 25, distance=16 * max(spacing), curvature=(0.03, 0.08),
            kind=kind, height=1.0, seed=seed, **options,
        )  # fmt: skip
        hm = draw(shape, spacing, caps, base=-8.0, periodic=periodic)
        _, fit = found(hm)
        assert len(fit) <= len(caps)
        hits = 0
        for cap in caps:
            row, col = int(cap.y // spacing[0]), int(cap.x // spacing[1])
            if not periodic and min(row, col, shape[0] - 1 - row, shape[1] - 1 - col) < 1:
                continue  # cut by the border: the highest point need not be the summit
            k, away = nearest(fit, cap, hm)
            if away > 1.0:
                continue  # hidden under a higher cap
            hits += 1
            k2, k1 = (2e6 * float(cap.gap(1e-3, turn)) for turn in (0.0, np.pi / 2))
            assert away < 0.02
            assert_allclose(fit.curvature[k], [k1, k2], rtol=0.01)
            assert abs(fit.height[k] - cap.height) < 0.002 * k1
            if k1 > 1.2 * k2:
                assert abs(np.sin(fit.angle[k] - cap.angle)) < 0.03
        assert hits >= 15


def test_noise_is_pruned_and_the_caps_remain():
    shape, spacing = (150, 170), (1.0, 1.0)
    caps = random_caps(shape, spacing, 12, distance=32, curvature=(0.02, 0.04), height=1.0, seed=5)
    hm = draw(shape, spacing, caps, base=-6.0, periodic=True)
    noise = np.random.default_rng(1).normal(scale=0.01, size=shape)
    noisy = hm.replace(heights=hm.heights + noise)
    assert len(surfaces.segment(noisy)) > 100
    peaks = surfaces.segment(noisy, min_prominence=0.2)
    fit = surfaces.fit_profiles(noisy, peaks)
    assert len(peaks) == len(surfaces.segment(hm)) and fit.valid.all()
    for cap in caps:
        k, away = nearest(fit, cap, hm)
        assert away < 2.0
        exact = cap.gap(fit.edge[k], fit.phi[k] - cap.angle)
        assert np.median(np.abs(fit.f()[k, :, -1] / exact - 1)) < 0.4


def test_profile_of_an_ellipsoid_is_its_gap():
    gap = ellipsoid(0.05, 0.02, depth=10.0)
    cap = Cap(30.3, 24.8, 0.0, gap, 0.5)
    hm = draw((48, 60), (1.0, 1.0), [cap], base=-5.0)
    _, fit = found(hm)
    k, _ = nearest(fit, cap, hm)
    r = fit.t * fit.edge[k][:, None]
    inside = (r > 0) & (r < 8)
    exact = gap(r, fit.phi[k][:, None] - cap.angle)
    assert_allclose(fit.f()[k][inside], exact[inside], rtol=1e-3)


@pytest.mark.parametrize(
    "gap",
    [cone(0.2), pyramid(0.2, 4), pyramid(0.2, 3),
     star(2.0, 0.01, points=5, wave=0.3), star(1.0, 0.1, points=4)],
)  # fmt: skip
def test_sharp_and_star_shaped_peaks_are_single(gap):
    cap = Cap(30.2, 24.7, 1.0, gap, 0.3)
    hm = draw((50, 60), (1.0, 1.0), [cap])
    peaks, fit = found(hm)
    k, away = nearest(fit, cap, hm)
    assert k == 0 and away < 0.75
    inner = np.hypot(peaks.x - cap.x, peaks.y - cap.y) < 20
    assert inner.sum() == 1
    r = fit.t[8:] * fit.edge[0][:, None]
    exact = gap(r, fit.phi[0][:, None] - cap.angle)
    assert_allclose(fit.f()[0][:, 8:], exact, rtol=0.25)


def test_sphere_array():
    hm = sphere_array((64, 96), (1.0, 1.0), rows=2, columns=3, radius=12.0, height_step=0.1)
    _, fit = found(hm)
    assert len(fit) == 6
    assert_allclose(fit.height, -0.1 * np.arange(6), atol=1e-4)
    assert_allclose(fit.curvature, 1 / 12.0, rtol=1e-3)
    assert_allclose([fit.x[0], fit.y[0], fit.x[5], fit.y[5]], [16, 16, 80, 48], atol=1e-3)


def test_refusals():
    with pytest.raises(surfaces.InputError, match="k1 >= k2 > 0"):
        paraboloid(0.1, 0.2)
    with pytest.raises(surfaces.InputError, match="at least 3 sides"):
        pyramid(0.1, 2)
    with pytest.raises(surfaces.InputError, match="wave is"):
        star(1.0, 0.1, wave=1.5)
    with pytest.raises(surfaces.SurfaceError, match="infinite"):
        draw((8, 9), (1.0, 1.0), [Cap(2.0, 2.0, 0.0, sphere(2.0))])
