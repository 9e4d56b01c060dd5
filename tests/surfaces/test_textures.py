"""Machined textures: what makes each of them what it is."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose

import surfaces
from surfaces import textures

SHAPE, SIZE = (128, 160), (1.0, 1.25)


def skewness(h):
    return float(np.mean((h - h.mean()) ** 3) / h.std() ** 3)


def slope_of(hm):
    ny, nx = hm.shape
    fy = np.fft.fftfreq(ny, hm.spacing[0])[:, None]
    fx = np.fft.fftfreq(nx, hm.spacing[1])[None, :]
    power = np.abs(np.fft.fft2(hm.heights) / hm.heights.size) ** 2
    power_y, power_x = (power * (2 * np.pi * f) ** 2 for f in (fy, fx))
    return np.sqrt(power_y.sum()), np.sqrt(power_x.sum())


def test_plateau_honed_has_worn_tops_and_the_asked_slope():
    hm = textures.plateau_honed(SHAPE, SIZE, rms_slope=0.1, cutoff=0.05, seed=3)
    assert hm.periodic and abs(hm.heights.mean()) < 1e-12
    assert_allclose(np.hypot(*slope_of(hm)), 0.1, rtol=1e-9)
    assert skewness(hm.heights) < -0.3
    assert hm.history[0]["step"] == "plateau_honed" and hm.history[0]["seed"] == 3


@pytest.mark.parametrize("angle", [0.0, np.pi / 2])
def test_ground_is_steep_across_the_lay_only(angle):
    hm = textures.ground(SHAPE, SIZE, rms_slope=0.1, cutoff=0.05, angle=angle, seed=1)
    across_y, across_x = slope_of(hm)
    steep, mild = (across_y, across_x) if angle == 0.0 else (across_x, across_y)
    assert steep > 4 * mild


def test_turned_has_one_ridge_per_feed():
    hm = textures.turned((120, 40), (1.2, 0.4), feed=0.1, nose_radius=0.5)
    peaks = surfaces.segment(hm)
    assert len(peaks) == 12
    assert_allclose(np.ptp(hm.heights), 0.1**2 / (8 * 0.5), rtol=0.25)
    rough = textures.turned((120, 40), (1.2, 0.4), feed=0.1, nose_radius=0.5, roughness=1e-4)
    assert_allclose((rough.heights - hm.heights).std(), 1e-4, rtol=1e-9)


def test_two_scale_has_power_in_two_bands_only():
    hm = textures.two_scale(
        SHAPE, SIZE, coarse=0.4, fine=0.05, coarse_height=1.0, fine_height=0.1, seed=2
    )
    power = np.abs(np.fft.fft2(hm.heights) / hm.heights.size) ** 2
    k = np.hypot(
        np.fft.fftfreq(SHAPE[0], hm.spacing[0])[:, None], np.fft.fftfreq(SHAPE[1], hm.spacing[1])
    )
    coarse, fine = (k > 1 / 0.81) & (k < 1 / 0.39), (k > 1 / 0.11) & (k < 1 / 0.049)
    assert_allclose([power[coarse].sum(), power[fine].sum()], [1.0, 0.01], rtol=1e-6)
    assert power[~(coarse | fine)].sum() < 1e-20


@pytest.mark.parametrize(
    ("make", "more"),
    [
        (surfaces.plateau_honed, {"rms_slope": 0.1, "cutoff": 0.1}),
        (surfaces.ground, {"rms_slope": 0.1, "cutoff": 0.1}),
        (surfaces.turned, {"feed": 0.1, "nose_radius": 0.1}),
        (
            surfaces.two_scale,
            {"coarse": 0.2, "fine": 0.1, "coarse_height": 1.0, "fine_height": 0.1},
        ),
    ],
)
def test_no_texture_is_made_of_a_cell_that_is_none(make, more):
    for shape in ((0, 0), (3.5, 4), "ab", (32,)):
        with pytest.raises(surfaces.InputError, match="shape is"):
            make(shape, SIZE, **more)
    with pytest.raises(surfaces.InputError, match="size is"):
        make(SHAPE, 1.0, **more)
    step = make(SHAPE, SIZE, **more).history[0]
    assert step["step"] == make.__name__ and more.items() <= step.items() and "size" not in step


def test_a_blunt_tool_leaves_parabolas():
    """Without cancellation of the radius, which took a sixth of the height at 1000 m."""
    hm = textures.turned((64, 8), (64e-6, 8e-6), feed=16e-6, nose_radius=1e3)
    y = (np.arange(16) - 7.5) * 1e-6
    assert np.ptp(hm.heights) == pytest.approx(np.ptp(y**2 / 2e3), rel=1e-9)


def test_a_seed_is_a_number_whatever_its_type():
    """A small numpy integer ran over where one was added to it."""
    make = partial(textures.ground, SHAPE, SIZE, rms_slope=0.1, cutoff=0.05)
    assert np.array_equal(make(seed=np.uint8(255)).heights, make(seed=255).heights)


def test_ground_without_fine_roughness_is_scratches_alone():
    hm = textures.ground(SHAPE, SIZE, rms_slope=0.1, cutoff=0.05, length=1e3, fine=0.0)
    assert np.ptp(hm.heights, axis=1).max() < 1e-9 * np.ptp(hm.heights)


def test_refusals():
    with pytest.raises(surfaces.InputError, match="plateau is"):
        textures.plateau_honed(SHAPE, SIZE, rms_slope=0.1, cutoff=0.05, plateau=0.0)
    for fine in (-0.1, 1e300, np.inf):
        with pytest.raises(surfaces.InputError, match="fine is"):
            textures.plateau_honed(SHAPE, SIZE, rms_slope=0.1, cutoff=0.05, fine=fine)
    with pytest.raises(surfaces.InputError, match="nose_radius is inf"):
        textures.turned(SHAPE, SIZE, feed=0.1, nose_radius=np.inf)
    with pytest.raises(surfaces.InputError, match="less than two of the"):
        textures.turned((32, 8), (1.0, 1.0), feed=1 / 32, nose_radius=1.0)
    with pytest.raises(surfaces.InputError, match="length is"):
        textures.ground(SHAPE, SIZE, rms_slope=0.1, cutoff=0.05, length=0.5)
    with pytest.raises(surfaces.InputError, match="rms_slope is"):
        textures.ground(SHAPE, SIZE, rms_slope=0.0, cutoff=0.05)
    with pytest.raises(surfaces.InputError, match="feed is"):
        textures.turned(SHAPE, SIZE, feed=0.3, nose_radius=0.1)
    with pytest.raises(surfaces.InputError, match="grooves that fit the cell are 1 m wide"):
        textures.turned((64, 8), (1.0, 1.0), feed=0.7, nose_radius=0.36)
    with pytest.raises(surfaces.InputError, match="coarse > fine"):
        textures.two_scale(SHAPE, SIZE, coarse=0.1, fine=0.2, coarse_height=1, fine_height=1)
    with pytest.raises(surfaces.InputError, match="roughness is -1"):
        textures.turned(SHAPE, SIZE, feed=0.1, nose_radius=0.1, roughness=-1.0)
    for height in (-1.0, np.nan):
        with pytest.raises(surfaces.InputError, match="rms heights"):
            textures.two_scale(
                SHAPE, SIZE, coarse=0.2, fine=0.1, coarse_height=height, fine_height=1
            )
