"""Planes, cylinders and polynomials are taken out of a map."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from samples import form, noise

import surfaces

STABLE = settings(max_examples=20, deadline=None, derandomize=True)


@STABLE
@given(slope=st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)), offset=st.floats(-1e-3, 1e-3))
def test_plane_comes_out_exactly(slope: tuple, offset: float) -> None:
    hm = noise()
    tilted = hm.replace(heights=hm.heights + form(hm, slope, 0.0, 0.0) + offset)
    once, direct = surfaces.level(tilted), surfaces.level(hm)
    np.testing.assert_allclose(once.heights, direct.heights, atol=1e-16 + 1e-13 * abs(offset))
    np.testing.assert_allclose(once.history[-1]["slope"], slope, atol=3e-5)


def test_plane_is_the_least_squares_plane_without_spikes() -> None:
    hm = noise()
    y, x = np.meshgrid(hm.y, hm.x, indexing="ij")
    columns = np.stack([np.ones(y.size), y.ravel(), x.ravel()], axis=1)
    fit = columns @ np.linalg.lstsq(columns, hm.heights.ravel(), rcond=None)[0]
    expected = hm.heights - fit.reshape(hm.shape)
    np.testing.assert_allclose(surfaces.level(hm).heights, expected, atol=1e-20)


def test_spikes_do_not_tilt_the_plane() -> None:
    hm = noise()
    spiked = hm.heights.copy()
    spiked[:20, :30][np.random.default_rng(2).random((20, 30)) < 0.3] += 1e-4
    levelled = surfaces.level(hm.replace(heights=spiked))
    good = spiked == hm.heights
    difference = (levelled.heights - surfaces.level(hm).heights)[good]
    assert np.abs(difference).max() < 2e-9
    assert levelled.history[-1]["left_out"] == np.count_nonzero(~good)


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.5, 2.6])
def test_cylinder_comes_out_with_its_radius_and_direction(angle: float) -> None:
    hm = noise()
    curved = hm.replace(heights=hm.heights + form(hm, (0.01, -0.02), -50.0, angle))
    levelled = surfaces.level(curved, "cylinder")
    step = levelled.history[-1]
    assert levelled.rms_height == pytest.approx(hm.rms_height, rel=0.01)
    assert step["curvature"][0] == pytest.approx(-50.0, abs=1.5)
    assert np.cos(2 * (step["angle"] - angle)) == pytest.approx(1.0, abs=1e-3)


def test_quadratic_takes_out_a_saddle() -> None:
    hm = noise()
    saddle = form(hm, (0, 0), 40.0, 0.3) - form(hm, (0, 0), 25.0, 0.3 + np.pi / 2)
    levelled = surfaces.level(hm.replace(heights=hm.heights + saddle), "quadratic")
    assert levelled.rms_height == pytest.approx(hm.rms_height, rel=0.01)
    np.testing.assert_allclose(levelled.history[-1]["curvature"], [40.0, -25.0], atol=1.5)


@pytest.mark.parametrize(("form", "order"), [("cubic", 3), ("quartic", 4), ("quintic", 5)])
def test_polynomials_of_their_order_come_out(form: str, order: int) -> None:
    """And what is left of the next order has no part of the lower ones."""
    hm = noise()
    y, x = hm.y[:, None] / hm.size[0], hm.x / hm.size[1]
    made = sum(1e-6 * (k - 1.5) * x ** (order - k) * y**k for k in range(order + 1))
    levelled = surfaces.level(hm.replace(heights=hm.heights + made), form)
    np.testing.assert_allclose(levelled.heights, surfaces.level(hm, form).heights, atol=1e-14)
    left = surfaces.level(hm.replace(heights=x ** (order + 1) + 0.0 * y), form).heights
    assert 0.0 < np.abs(left).max() < 0.2
    assert np.abs(np.sum(left * x**order)) < 1e-9


def test_periodic_maps_lose_their_mean_only() -> None:
    hm = noise().replace(periodic=True)
    levelled = surfaces.level(hm, "plane")
    np.testing.assert_allclose(levelled.heights, hm.heights - hm.heights.mean(), atol=1e-22)
    assert levelled.history[-1]["form"] == "mean"


def test_missing_points_do_not_count() -> None:
    hm = noise()
    holed = hm.heights + form(hm, (0.1, 0.2), 0.0, 0.0)
    holed[10:20, 5:40] = np.nan
    levelled = surfaces.level(hm.replace(heights=holed))
    assert levelled.missing == 350
    assert abs(np.nanmean(levelled.heights)) < 1e-20
    np.testing.assert_allclose(levelled.history[-1]["slope"], [0.1, 0.2], atol=3e-5)
