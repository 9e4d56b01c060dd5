"""Statistics: closed forms of simple maps, and laws of units, shifts and rotations."""

from __future__ import annotations

import math
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import surfaces
from surfaces.errors import SurfaceError
from surfaces.statistics.differences import differences

SIZE = (1e-3, 2e-3)


def rough(**changes: float) -> surfaces.HeightMap:
    options = {"hurst": 0.8, "rms_slope": 0.1, "rolloff": 2e-4, "cutoff": 3e-5} | changes
    return surfaces.self_affine((192, 256), SIZE, seed=5, **options)


def test_a_sine_has_its_textbook_numbers() -> None:
    ny, nx, amplitude, k = 30, 2000, 1e-6, 2 * np.pi * 4 / SIZE[1]
    hm = surfaces.HeightMap(np.zeros((ny, nx)), (SIZE[0] / ny, SIZE[1] / nx), periodic=True)
    hm = hm.replace(heights=amplitude * np.sin(k * hm.x) + 0 * hm.y[:, None])
    found = surfaces.describe(hm)
    assert found.heights["Sq"] == pytest.approx(amplitude / np.sqrt(2))
    assert f"Sq {found.heights['Sq']:.4g} m, " in str(found) and " 1/m^2, Spc " in str(found)
    assert f"Sku {found.heights['Sku']:.4g}, " in str(found)
    assert found.heights["Sa"] == pytest.approx(2 * amplitude / np.pi, rel=1e-4)
    assert found.heights["Ssk"] == pytest.approx(0.0, abs=1e-9)
    assert found.heights["Sku"] == pytest.approx(1.5)
    assert found.heights["Sz"] == pytest.approx(2 * amplitude, rel=1e-4)
    assert found.hybrid["Sdq"] == pytest.approx(k * amplitude / np.sqrt(2), rel=1e-4)
    assert found.hybrid["curvature"] == pytest.approx(0.5 * k**2 * amplitude / np.sqrt(2), rel=1e-4)
    assert found.hybrid["Sdr"] == pytest.approx((k * amplitude) ** 2 / 4, rel=1e-3)
    assert math.degrees(found.texture.direction) == pytest.approx(90.0, abs=2.0)
    assert found.texture.shortest == pytest.approx(np.arccos(0.2) / k, rel=0.02)


def test_curvature_of_a_paraboloid() -> None:
    """Away from the border, second differences of a paraboloid are exact."""
    hm = surfaces.HeightMap(np.zeros((20, 31)), (1e-6, 2e-6))
    y, x = hm.y[:, None], hm.x[None, :]
    found = differences(hm.replace(heights=-(300.0 * x**2 + 100.0 * y**2) / 2))
    assert found["curvature"] == pytest.approx(200.0)


@pytest.mark.parametrize("factor", [1e-3, 7.0])
def test_units(factor: float) -> None:
    """All lengths times a factor: heights scale, slopes and ratios stay."""
    hm = rough()
    scaled = surfaces.HeightMap(
        hm.heights * factor, [d * factor for d in hm.spacing], periodic=True
    )
    one, other = surfaces.describe(hm), surfaces.describe(scaled)
    for name in ("Sq", "Sa", "Sp", "Sv", "Sz"):
        assert other.heights[name] == pytest.approx(factor * one.heights[name])
    for name in ("Ssk", "Sku"):
        assert other.heights[name] == pytest.approx(one.heights[name])
    assert other.hybrid["Sdq"] == pytest.approx(one.hybrid["Sdq"])
    assert other.texture.shortest == pytest.approx(factor * one.texture.shortest)
    assert other.moments.nayak == pytest.approx(one.moments.nayak)
    assert other.fit.cutoff == pytest.approx(factor * one.fit.cutoff)


def test_turning_the_map_by_a_right_angle_turns_the_lay() -> None:
    hm = rough(anisotropy=4.0, angle=0.4)
    turned = surfaces.HeightMap(hm.heights.T, hm.spacing[::-1], periodic=True)
    one, other = surfaces.describe(hm), surfaces.describe(turned)
    assert other.moments.slope_ratio == pytest.approx(one.moments.slope_ratio)
    assert one.moments.lay == pytest.approx(0.4, abs=0.05)
    assert one.moments.lay + other.moments.lay == pytest.approx(np.pi / 2)
    assert one.texture.direction == pytest.approx(0.4, abs=0.25)
    assert one.texture.aspect < 0.5
    assert one.moments.slope_ratio == pytest.approx(4.0, rel=0.1)


def test_a_shift_around_the_seam_changes_nothing() -> None:
    hm = rough()
    shifted = hm.replace(heights=np.roll(hm.heights, (31, 77), axis=(0, 1)) + 1.0)
    one, other = surfaces.describe(hm), surfaces.describe(shifted)
    assert other.heights["Sq"] == pytest.approx(one.heights["Sq"])
    assert other.hybrid["Sdq"] == pytest.approx(one.hybrid["Sdq"])
    assert other.texture.shortest == pytest.approx(one.texture.shortest, rel=1e-6)


def test_spectral_and_finite_differences_meet_on_a_smooth_map_only() -> None:
    smooth = surfaces.describe(rough(cutoff=1.5e-4))
    assert smooth.hybrid["Sdq"] == pytest.approx(smooth.moments.rms_slope, rel=0.02)
    assert not any("resolve" in warning for warning in smooth.warnings)
    fine = surfaces.describe(rough(cutoff=1.6e-5))
    assert any("pixels do not resolve" in warning for warning in fine.warnings)


def test_autocorrelation_is_the_transform_of_the_spectrum() -> None:
    """Around the seam: value at a shift is the mean product, over the variance."""
    hm = rough()
    found = surfaces.autocorrelation(hm)
    z = hm.heights - hm.heights.mean()
    direct = np.mean(z * np.roll(z, (5, -9), axis=(0, 1))) / np.mean(z * z)
    row = np.argmin(np.abs(found.lag_y - 5 * hm.spacing[0]))
    column = np.argmin(np.abs(found.lag_x + 9 * hm.spacing[1]))
    assert found.value[row, column] == pytest.approx(direct)
    assert found.value.max() == pytest.approx(1.0)


def test_a_correlation_may_fall_off_at_the_last_shift() -> None:
    lag_y, lag_x = np.arange(-10.0, 11.0), np.arange(-14.0, 15.0)
    cliff = np.clip(10.0 - np.hypot(lag_y[:, None], lag_x), 0.0, 1.0)
    found = surfaces.texture(surfaces.Autocorrelation(lag_y, lag_x, cliff))
    assert found.shortest == pytest.approx(9.8, abs=0.1)


@pytest.mark.parametrize("periodic", [True, False])
def test_shifts_without_pairs_do_not_end_the_correlation(periodic) -> None:
    """Every second row is missing: no two points are one row apart."""
    hm = surfaces.self_affine((64, 64), (64e-6, 64e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    heights = hm.heights.copy()
    heights[1::2] = np.nan
    whole = surfaces.HeightMap(hm.heights, hm.spacing, periodic=periodic)
    found = surfaces.autocorrelation(whole.replace(heights=heights))
    assert np.isnan(found.value[31]).all() and np.isfinite(found.value[30]).all()
    sal = surfaces.texture(surfaces.autocorrelation(whole)).shortest
    assert surfaces.texture(found).shortest == pytest.approx(sal, rel=0.1)


def test_autocorrelation_with_missing_points_uses_the_pairs_present() -> None:
    hm = surfaces.HeightMap(np.random.default_rng(0).normal(size=(24, 31)), (1e-6, 2e-6))
    full = surfaces.autocorrelation(hm).value
    z = hm.heights - hm.heights.mean()
    expected = np.mean(z[2:, :-3] * z[:-2, 3:]) / np.mean(z * z)
    assert full[12 + 2, 15 - 3] == pytest.approx(expected)
    heights = hm.heights.copy()
    heights[3:7, 4:11] = np.nan
    found = surfaces.autocorrelation(hm.replace(heights=heights))
    z = heights - np.nanmean(heights)
    products = z[2:, 3:] * z[:-2, :-3]
    expected = np.nanmean(products) / np.nanmean(z * z)
    assert found.value[12 + 2, 15 + 3] == pytest.approx(expected)


def test_bearing_curve_of_known_distributions() -> None:
    """Even heights are all core; Gaussian ones have the textbook core."""
    even = np.random.default_rng(1).permutation(np.linspace(-1.0, 1.0, 4000)).reshape(50, 80)
    curve = surfaces.bearing_curve(surfaces.HeightMap(even, 1.0))
    core, volumes = curve.core(), curve.volumes()
    assert core["Sk"] == pytest.approx(2.0, rel=1e-3)
    assert core["Spk"] == pytest.approx(0.0, abs=1e-3)
    assert curve.ratio_at(0.5) == pytest.approx(0.25, abs=1e-3)
    assert curve.height_at(0.25) == pytest.approx(0.5, abs=1e-3)
    assert volumes["Vmp"] == pytest.approx(0.5 * 0.1 * 0.2, rel=0.01)
    assert volumes["Vvv"] == pytest.approx(0.5 * 0.2 * 0.4, rel=0.01)
    normal = surfaces.HeightMap(np.random.default_rng(2).normal(size=(400, 500)), 1.0)
    core = surfaces.bearing_curve(normal).core()
    assert core["Sk"] == pytest.approx(2.57, rel=0.01)
    assert core["Smr1"] == pytest.approx(1.0 - core["Smr2"], abs=0.02)
    assert core["Spk"] == pytest.approx(core["Svk"], rel=0.05)


def test_a_tilt_is_no_spike() -> None:
    """The plane has a slope, but no wave: the spectrum is that of the map without it."""
    level = rough(cutoff=6e-5).replace(periodic=False)
    steep = level.replace(heights=level.heights + 0.5 * level.x)
    told = surfaces.describe(steep).warnings
    assert any("a plane makes up" in text for text in told)
    assert not any("spikes" in text for text in told)


def test_warnings_name_what_is_wrong() -> None:
    hm = rough().replace(periodic=False)
    heights = hm.heights + 0.05 * hm.x
    heights[4] = np.nan  # a whole row, without a warning of numpy
    found = surfaces.describe(hm.replace(heights=heights))
    assert found.moments is None and found.fit is None
    assert any("level the map" in warning for warning in found.warnings)
    assert any("points are missing: no spectrum" in warning for warning in found.warnings)
    assert "warning" in str(found)


@pytest.mark.parametrize("factor", [1e6, 1e-6])
def test_heights_in_another_unit_than_stated_are_noticed(factor: float) -> None:
    hm = surfaces.self_affine((40, 60), (1e-4, 3e-4), hurst=0.8, rms_slope=0.1, cutoff=2e-5)
    assert not any("unit" in text for text in surfaces.describe(hm).warnings)
    wrong = hm.replace(heights=factor * hm.heights)
    assert any("check the unit" in text for text in surfaces.describe(wrong).warnings)


def test_a_constant_map_is_refused() -> None:
    """Also one whose mean is not its height, by rounding."""
    with pytest.raises(SurfaceError, match="constant"):
        surfaces.describe(surfaces.HeightMap(np.full((10, 12), 1e-6), 1e-6))
    with pytest.raises(SurfaceError, match="constant"):
        surfaces.describe(surfaces.HeightMap(np.ones((4, 5)), 1.0))


def test_measured_maps_have_the_slopes_of_their_table(measured: Path) -> None:
    table = {"afm_10um_grains": 0.223, "optical_rubber_missing": 0.136, "wli_milled_a": 0.161}
    for name, slope in table.items():
        hm = surfaces.prepare(surfaces.read(measured / f"{name}.h5"), fill=None)
        assert differences(hm)["Sdq"] == pytest.approx(slope, rel=0.005)


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("gaps", [0, 50])
def test_a_file_in_blocks_has_the_numbers_of_the_map(tmp_path, monkeypatch, periodic, gaps) -> None:
    heights = surfaces.plateau_honed((300, 270), SIZE, rms_slope=0.1, cutoff=3e-5).heights.copy()
    heights[heights > 0.5 * heights.std()] = 0.5 * heights.std()  # many points of one height
    rng = np.random.default_rng(0)
    heights[rng.integers(300, size=gaps), rng.integers(270, size=gaps)] = np.nan
    hm = surfaces.HeightMap(heights, (1e-6, 2e-6), periodic=periodic)
    surfaces.write(hm, tmp_path / "a.h5")
    monkeypatch.setattr("surfaces.numerics.stored_array.BLOCK_BYTES", 80_000)  # 37 rows
    whole = surfaces.describe(hm)
    with surfaces.open(tmp_path / "a.h5") as file:
        stored = file.on_disk()
    found, curve = surfaces.describe(stored), surfaces.bearing_curve(stored)
    for group in ("heights", "spatial", "hybrid", "functional", "features"):
        for name, value in getattr(whole, group).items():
            expected = pytest.approx(value, rel=1e-9, abs=1e-18, nan_ok=True)
            assert getattr(found, group)[name] == expected, name
    exact = surfaces.bearing_curve(hm).height
    np.testing.assert_allclose(curve.height, exact, rtol=0, atol=1e-12 * hm.rms_height)
    assert found.missing == whole.missing
    assert found.warnings == whole.warnings
    assert (found.moments is None) == (gaps > 0)
    np.testing.assert_allclose(
        surfaces.autocorrelation(stored).value[:],
        surfaces.autocorrelation(hm).value,
        rtol=0,
        atol=1e-12,
    )


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("shape", [(300, 271), (259, 304)])
def test_a_map_on_disk_has_the_spectrum_of_the_map(tmp_path, monkeypatch, shape, periodic) -> None:
    """Both parities of both axes; four columns in a section at least."""
    hm = surfaces.self_affine(shape, SIZE, hurst=0.7, rms_slope=0.1, anisotropy=3.0, cutoff=5e-5)
    hm = hm.replace(periodic=periodic)
    surfaces.write(hm, tmp_path / "a.h5")
    least = 384 * 2**20 + 4 * 96 * shape[0]
    with surfaces.open(tmp_path / "a.h5") as file:
        stored = file.on_disk()
    whole, found = surfaces.describe(hm), surfaces.describe(stored)
    monkeypatch.setattr("surfaces.numerics.memory._USUAL", least)
    one, other = surfaces.power_spectrum(hm), surfaces.power_spectrum(stored)
    monkeypatch.setattr("surfaces.numerics.memory._USUAL", least - 1)
    with pytest.raises(surfaces.InputError, match="385 MiB of memory or more, not 384"):
        surfaces.power_spectrum(stored)
    for name in ("q", "density", "modes", "qx", "density_x", "qy", "density_y", "edge", "nyquist"):
        value = getattr(one, name)
        np.testing.assert_allclose(
            getattr(other, name), value, rtol=1e-9, atol=1e-20 * np.max(value)
        )
    assert vars(other.moments) == pytest.approx(vars(one.moments), rel=1e-10, abs=0.0)
    assert found.spatial["Std"] == pytest.approx(whole.spatial["Std"], rel=1e-10)
    assert found.fit.hurst == pytest.approx(whole.fit.hurst, rel=1e-6)


def test_a_file_that_has_no_spectrum_is_told(tmp_path) -> None:
    heights = rough().heights.copy()
    heights[3, 4] = np.nan
    surfaces.write(surfaces.HeightMap(heights, 1e-6), tmp_path / "a.h5")
    with surfaces.open(tmp_path / "a.h5") as file:
        stored = file.on_disk()
    with pytest.raises(SurfaceError, match=r"missing \(1 of"):
        surfaces.power_spectrum(stored)


@pytest.mark.parametrize("rows", [3, 16])
def test_a_strip_tells_the_correlation_length_along_it(rows: int) -> None:
    """Rays in all directions ended at half the shorter side: that was Sal, and Str was 1."""
    wave = np.cos(2 * np.pi * (np.arange(512) + 0.5) / 128)
    strip = surfaces.HeightMap(np.tile(1e-6 * wave, (rows, 1)), 1e-6, periodic=True)
    found = surfaces.texture(surfaces.autocorrelation(strip))
    assert found.shortest == pytest.approx(128e-6 * math.acos(0.2) / (2 * math.pi), rel=1e-3)
    assert found.bounded and found.direction == pytest.approx(math.pi / 2)


def test_rays_over_slim_pixels_take_no_more_memory() -> None:
    """Steps of half the shorter pixel over the length of the map took 830 MB here."""
    square = rough().cut((0, 64), (0, 64))
    correlation = surfaces.autocorrelation(square.replace(spacing=(1e-3, 1e-6)))
    tracemalloc.start()
    found = surfaces.texture(correlation)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10e6
    assert found.shortest < found.longest


def test_a_lay_longer_than_the_map_has_its_own_direction() -> None:
    """Rays beside it are longer within the map, and do not end there either."""
    y = (np.arange(64) + 0.5) * np.ones((256, 1))
    waves = surfaces.HeightMap(np.cos(2 * np.pi * y.T[:, :200] / 32), 1.0, periodic=True)
    assert surfaces.texture(surfaces.autocorrelation(waves)).direction == 0.0


@pytest.mark.parametrize("unit", [1e-6, 3e-6, 5e-7, 7e-7, 1.1e-6, 1e-3, 0.37])
def test_of_equal_parameters_rounding_chooses_none(unit: float) -> None:
    """Both ends of a sine are as flat; two crossed waves are as high."""
    wave = np.tile(np.sin(2 * np.pi * (np.arange(512) + 0.5) / 64 + 0.3), (64, 1))
    core = surfaces.bearing_curve(surfaces.HeightMap(unit * wave, 1e-6, periodic=True)).core()
    assert core["Spk"] == 0.0 and core["Svk"] == pytest.approx(0.426 * unit, rel=1e-2)
    y, x = np.mgrid[:64, :64] * (2 * np.pi / 64)
    for turn in range(5):
        crossed = np.roll(np.cos(5 * x + 3 * y) + np.cos(5 * x - 3 * y), turn, (0, 1))
        found = surfaces.describe(surfaces.HeightMap(unit * crossed, 1e-6, periodic=True))
        assert found.spatial["Std"] == pytest.approx(30.96, abs=0.01)
        assert found.spatial["lay"] == pytest.approx(77.0)


def test_waves_beyond_the_rings_have_no_direction_and_no_exponent() -> None:
    """What is left in the rings is rounding."""
    y, x = np.mgrid[:64, :96]
    waves = 1e-7 * np.cos(2 * np.pi * (20 * y / 64 + 3 * x / 96) + 0.4)
    found = surfaces.describe(surfaces.HeightMap(waves, (1e-6, 2.5e-6), periodic=True))
    assert math.isnan(found.spatial["Std"]) and found.fit is None


def test_a_slope_that_is_not_known_is_no_wrong_unit() -> None:
    heights = np.random.default_rng(0).normal(size=(64, 64)) * 1e-8
    heights[::2] = np.nan
    assert not any(
        "unit" in each for each in surfaces.describe(surfaces.HeightMap(heights, 1e-6)).warnings
    )


def test_arguments_of_another_kind_are_refused() -> None:
    hm = rough()
    holes = np.array(hm.heights)
    holes[0, 0] = np.nan
    with pytest.raises(surfaces.InputError, match="wolf is 'bad'"):
        surfaces.describe(hm.replace(heights=holes), wolf="bad")  # type: ignore[arg-type]
    for function in (surfaces.texture, surfaces.fit_spectrum, surfaces.plot_bearing):
        with pytest.raises(surfaces.InputError, match="is needed, not <HeightMap"):
            function(hm)  # type: ignore[operator]
