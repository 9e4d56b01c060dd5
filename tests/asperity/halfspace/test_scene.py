"""The scene of a run: load points by default, what cannot be one, and sentences about a map that no
model should be trusted on as it is."""

from __future__ import annotations

import numpy as np
import pytest

import asperity
from asperity import bem_curve, bem_solve, compare, contact_curve, make_plan
from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import (
    checked_loads,
    default_pressures,
    expected_area_fraction,
    hardness_needed,
    slope_scale,
)
from asperity.parameters import DEFAULTS
from surfaces import HeightMap, self_affine, turned
from surfaces.checks import lay

BODY = asperity.HalfSpace.from_modulus(1e11)
HARD = asperity.HalfSpace.from_modulus(1e11, hardness=1e9)


def wave(ny: int = 48, nx: int = 64, amplitude: float = 1e-7) -> HeightMap:
    """A sine along x on pixels that are not square."""
    x = (np.arange(nx) + 0.5) / nx
    return HeightMap(
        np.tile(amplitude * np.sin(2 * np.pi * 4 * x), (ny, 1)), (2e-6, 1e-6), periodic=True
    )


def test_slope_and_its_length_of_a_sine():
    hm = wave(nx=512)
    q = 2 * np.pi * 4 / (512e-6)
    slope, length = slope_scale(hm)
    assert slope == pytest.approx(1e-7 * q / np.sqrt(2), rel=5e-3)
    assert length == pytest.approx(1 / q, rel=5e-3)


@pytest.mark.parametrize("m", [-0.3, 0.0, 0.5])
def test_default_pressures_scale_with_modulus_and_slope(m):
    soft, stiff = (HalfSpace.from_modulus(e, m=m) for e in (1e6, 1e9))
    low, high = wave(), wave(amplitude=1e-6)
    p = default_pressures(low, soft)
    np.testing.assert_allclose(default_pressures(low, stiff), 1e3 * p, rtol=1e-12)
    np.testing.assert_allclose(default_pressures(high, soft), 10 * p, rtol=1e-12)
    assert (np.diff(np.log(p)) > 0).all()


def test_forecast_of_the_area_is_monotone_and_bounded():
    material = HalfSpace.from_modulus(1e9)
    areas = [expected_area_fraction(wave(), material, p) for p in np.geomspace(1, 1e12, 30)]
    assert (np.diff(areas) >= 0).all()
    assert areas[-1] == pytest.approx(1.0)
    forecast = expected_area_fraction(wave(), material, default_pressures(wave(), material)[0])
    assert forecast == pytest.approx(1e-3, rel=0.01)


@pytest.mark.parametrize(
    ("pressures", "separations", "match"),
    [
        ([1.0], [1.0], "not both"),
        (np.ones(10_001), None, "10001 load points; give at most 10000"),
        ([1.0, -2.0], None, "-2 Pa is negative"),
        ([1.0, 1e-300], None, "1e-300 Pa is beyond"),
        (None, [1e-7, -1e300], "-1e.300 m is beyond"),
        ([np.nan], None, "finite"),
        (None, [], "at least one"),
        ("heavy", None, "array of numbers"),
        ([1 + 2j], None, "array of numbers"),
        (np.ma.masked_equal([1.0, 2.0], 2.0), None, "must be finite"),
    ],
)
def test_unusable_load_points(pressures, separations, match):
    with pytest.raises(InputError, match=match):
        checked_loads(wave(), HalfSpace.from_modulus(1e9), pressures, separations)


@pytest.mark.parametrize(
    ("load", "match"),
    [
        ({"pressure": 1e300}, r"pressure 1e\+300 Pa is beyond"),
        ({"pressure": 1e-300}, "1e-300 Pa is beyond"),
        ({"separation": -1e300}, r"separation -1e\+300 m is beyond"),
        ({"pressure": -1.0}, "-1 Pa is negative"),
    ],
)
def test_one_unusable_load_point(load, match):
    with pytest.raises(InputError, match=match):
        bem_solve(wave(), HalfSpace.from_modulus(1e9), boundary="free", **load)


@pytest.mark.parametrize("solve", [contact_curve, bem_curve, bem_solve, make_plan, compare])
@pytest.mark.parametrize(
    ("hm", "material", "match"),
    [
        (wave().heights, HalfSpace.from_modulus(1e9), "HeightMap is needed, not ndarray"),
        ("scan.h5", HalfSpace.from_modulus(1e9), r"not str.*surfaces.read"),
        (wave(), 210e9, "HalfSpace is needed, not float"),
    ],
)
def test_what_is_no_map_or_no_material(solve, hm, material, match):
    with pytest.raises(InputError, match=match):
        solve(hm, material)


def test_no_default_loads_without_slope():
    with pytest.raises(InputError, match="name the loads"):
        default_pressures(wave(amplitude=0.0), HalfSpace.from_modulus(1e9))


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
