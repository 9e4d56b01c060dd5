"""Load points: defaults scale with the surface, and what cannot be a load is refused."""

from __future__ import annotations

import numpy as np
import pytest

from asperity import bem_curve, bem_solve, compare, contact_curve, make_plan
from asperity.errors import InputError
from asperity.halfspace.load_points import (
    checked_loads,
    default_pressures,
    expected_area_fraction,
    slope_scale,
)
from asperity.halfspace.material import HalfSpace
from surfaces import HeightMap


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
