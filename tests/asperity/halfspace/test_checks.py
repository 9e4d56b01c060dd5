"""Sentences about a map that no model should be trusted on as it is."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity.halfspace.checks import hardness_needed
from asperity.parameters import DEFAULTS
from surfaces import HeightMap, self_affine, turned
from surfaces.checks import lay

BODY = asperity.HalfSpace.from_modulus(1e11)
HARD = asperity.HalfSpace.from_modulus(1e11, hardness=1e9)


def smooth(**changes):
    hm = self_affine((48, 60), (7.2e-5, 6e-5), hurst=0.8, rms_slope=0.1, cutoff=1e-5, seed=1)
    return hm.replace(**changes)


def map_warnings(hm):
    return list(asperity.make_plan(hm, HARD, pressures=[1e6]).warnings)


def test_nothing_is_said_of_a_smooth_map():
    assert map_warnings(smooth()) == []
    curve = asperity.contact_curve(smooth(), HARD, pressures=[1e8])
    assert curve.settings["warnings"] == []
    assert "warning" not in str(curve)


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("place", [(0, 0), (20, 59), (47, 30)])
def test_a_spike_is_named_wherever_it_stands(periodic, place):
    heights = smooth().heights.copy()
    heights[place] += 8 * smooth().rms_height
    (warning,) = [
        text for text in map_warnings(smooth(heights=heights, periodic=periodic)) if "spike" in text
    ]
    assert "--outliers" in warning


def test_noise_is_too_coarse_and_no_spike():
    noise = np.random.default_rng(0).normal(size=(128, 160)) * 1e-8
    (warning,) = map_warnings(HeightMap(noise, (1e-6, 2e-6)))
    assert "too coarse" in warning


def test_clipped_heights_are_named_also_when_levelled_afterwards():
    hm = smooth()
    clipped = np.minimum(hm.heights, 1.5 * hm.rms_height)
    tilted = clipped + 1e-3 * np.arange(60) * hm.spacing[1]
    ridges = np.cos(0.2 * np.arange(48))[:, None] * np.ones(60)
    steps = np.round(hm.heights / hm.rms_height * 300)
    for heights, named in ((clipped, 1), (tilted, 1), (ridges, 1), (steps, 0)):
        found = map_warnings(hm.replace(heights=1e-9 * heights / np.ptp(heights)))
        assert len([text for text in found if "in line" in text]) == named


@pytest.mark.parametrize("angle", [0.0, 0.6, np.pi / 2])
def test_the_lay_is_found_in_any_direction(angle):
    case = {"hurst": 0.8, "rms_slope": 0.1, "rolloff": 4e-4, "cutoff": 8e-5, "seed": 1}
    size = (1.6e-3, 1.92e-3)
    for ratio in (1.0, 4.0):
        hm = self_affine((160, 240), size, anisotropy=ratio, angle=angle, **case)
        assert lay(hm) == pytest.approx(ratio, rel=0.15)


def test_a_graded_body_is_no_metal():
    for m, count in ((0.0, 1), (0.2, 0)):
        body = asperity.HalfSpace.from_modulus(1e11, m)
        assert len(hardness_needed(smooth(), body)[1]) == count


def test_errors_on_turned_ridges_are_not_stated():
    """The load of the model is several times that of boundary elements there."""
    hm = turned(
        (64, 80),
        (6.4e-4, 8e-4),
        feed=2e-4,
        nose_radius=8e-4,
        roughness=2e-7,
        hurst=0.8,
        cutoff=8e-5,
    )
    assert lay(hm) > DEFAULTS.error_estimate.longest_lay
    curve = asperity.contact_curve(hm, BODY, pressures=[1e6])
    assert np.isnan(curve.error_estimate).all()
    assert np.isnan(curve.extra["area_error_estimate"]).all()
    assert "across the lay" in str(curve)


def test_a_curve_carries_the_warnings_of_its_map(tmp_path):
    hm = smooth(heights=1e6 * smooth().heights)
    curve = asperity.contact_curve(hm, BODY, pressures=[1e7])
    assert "check the unit" in str(curve)
    curve.to_hdf5(tmp_path / "c.h5")
    assert asperity.ContactCurve.from_hdf5(tmp_path / "c.h5").settings == curve.settings


@pytest.mark.parametrize("unit", [1.0, 1e-3, 25.4e-3])
def test_digits_that_single_precision_took_are_told(unit):
    """A tenth of the rms height was rounding, and the area 3 % off, without a word."""
    away = smooth().heights + 4e5 * smooth().rms_height
    single = (away / unit).astype(np.float32).astype(np.float64) * unit
    (warning,) = [text for text in map_warnings(smooth(heights=single)) if "rounded to" in text]
    rounding = np.spacing(np.float32(away.max() / unit)) * unit
    assert f"rounded to {rounding:.2g} m" in warning
    for untouched in (away, np.round(away, 7), smooth().heights.astype(np.float32)):
        assert not any("rounded" in text for text in map_warnings(smooth(heights=untouched)))


@pytest.mark.parametrize(("height", "told"), [(0.0, False), (1e-9, False), (100.0, True)])
def test_a_map_that_rounding_made_constant_is_told(height, told):
    """Full contact was certified of 2 nm of roughness at 100 m in single precision."""
    rough = 2e-9 * np.random.default_rng(1).normal(size=(12, 15))
    heights = ((height == 100.0) * rough + height).astype(np.float32)
    solved = asperity.bem_curve(HeightMap(heights, 1e-7), BODY, pressures=[1e6])
    assert any("the map is constant" in text for text in solved.settings["warnings"]) == told
