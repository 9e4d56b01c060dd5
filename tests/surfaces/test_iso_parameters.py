"""ISO 25178-2 parameters of surfaces for which they are exact by formula.

Sums of cosines as in Todhunter et al. 2020 (Surf. Topogr.: Metrol. Prop. 8); spherical caps;
normal heights; planes. What is no mean of a power of the heights converges with the grid.
"""

from __future__ import annotations

import functools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import dblquad, quad
from scipy.optimize import brentq
from scipy.stats import norm

import surfaces
from surfaces.statistics.parameters import PARAMETERS

HEIGHT, LENGTH = 1e-6, 20e-6
WAVE = 2 * math.pi / LENGTH


def lattice(
    points: int, periodic: bool = True, cells: tuple[int, int] = (3, 2)
) -> surfaces.HeightMap:
    """cos + cos, with about so many points per wave, half as many more along x, no two alike."""
    ny, nx = points * cells[0] + 1, 3 * points * cells[1] // 2 - 1
    spacing = (cells[0] * LENGTH / ny, cells[1] * LENGTH / nx)
    y, x = (d * (np.arange(n) + 0.623) for d, n in zip(spacing, (ny, nx), strict=True))
    heights = HEIGHT * (np.cos(WAVE * y)[:, None] + np.cos(WAVE * x))
    return surfaces.HeightMap(heights, spacing, periodic=periodic)


def share(height: float) -> float:
    """Share of cos u + cos v above a height."""
    ends = [math.acos(c) for c in (height - 1, height + 1) if -1 < c < 1]
    above = lambda v: math.acos(min(1.0, max(-1.0, height - math.cos(v)))) / math.pi  # noqa: E731
    return quad(above, 0, math.pi, points=ends or None, limit=200)[0] / math.pi


def functional(above, at, top: float) -> dict[str, float]:
    """Functional parameters of heights that are as often up as down.

    The share of the surface above a height, its inverse, and the highest height.
    """
    least = quad(lambda r: (r - 0.5) * at(r), 0.3, 0.7, epsabs=1e-10)[0] / (2 * 0.2**3 / 3)
    upper = -least / 2
    material = lambda z: quad(above, z, top, limit=200, epsabs=1e-12)[0]  # noqa: E731
    void = lambda z: material(-z)  # noqa: E731
    z10, z80 = at(0.1), at(0.8)
    reduced = 2 * material(upper) / above(upper)
    return {
        "Sk": -least,
        "Spk": reduced,
        "Svk": reduced,
        "Smr1": above(upper),
        "Smr2": 1 - above(upper),
        "Smr": 0.5,
        "Smc": z10,
        "Sxp": at(0.025),
        "Vm": material(z10),
        "Vv": void(z10),
        "Vmp": material(z10),
        "Vmc": material(z80) - material(z10),
        "Vvc": void(z10) - void(z80),
        "Vvv": void(z80),
    }


@functools.cache
def exact() -> dict[str, float]:
    """All parameters of the lattice, from integrals over one wave."""
    root = functools.cache(lambda r: brentq(lambda h: share(h) - r, -2, 2, xtol=1e-12))
    slope = HEIGHT * WAVE
    area = dblquad(
        lambda u, v: math.sqrt(1 + slope**2 * (math.sin(u) ** 2 + math.sin(v) ** 2)),
        *(0, math.pi / 2, 0, math.pi / 2),
    )[0]
    volume = 4 / math.pi**2 * HEIGHT * LENGTH**2
    shares = ("Smr", "Smr1", "Smr2")
    curve = functional(share, root, 2.0)
    short, long = math.sqrt(2) * math.acos(0.2), math.acos(-0.6)
    return {
        "Sq": HEIGHT,
        "Ssk": 0.0,
        "Sku": 2.25,
        "Sp": 2 * HEIGHT,
        "Sv": 2 * HEIGHT,
        "Sz": 4 * HEIGHT,
        "Sa": 8 / math.pi**2 * HEIGHT,
        "Sal": short / WAVE,
        "Str": short / long,
        "Sdq": slope,
        "Sdr": area * 4 / math.pi**2 - 1,
        "curvature": 0.5 * HEIGHT * WAVE**2,
        **{name: v if name in shares else v * HEIGHT for name, v in curve.items()},
        "Spd": LENGTH**-2,
        "Svd": LENGTH**-2,
        "Spc": HEIGHT * WAVE**2,
        "Svc": -HEIGHT * WAVE**2,
        "S5p": 2 * HEIGHT,
        "S5v": 2 * HEIGHT,
        "S10z": 4 * HEIGHT,
        "Sha": LENGTH**2,
        "Sda": LENGTH**2,
        "Shv": volume,
        "Sdv": volume,
    }


@functools.cache
def errors(points: int) -> dict[str, float]:
    """Relative errors of the lattice, absolute of what is zero or a share."""
    found = surfaces.describe(lattice(points)).parameters
    return {
        name: abs(found[name] - value) / (1.0 if name in ("Ssk", "Smr") else abs(value))
        for name, value in exact().items()
    }


FORMULA = ("Sq", "Ssk", "Sku", "Spd", "Svd", "Sha", "Sda")
CURVE = ("Sk", "Spk", "Svk", "Smr1", "Smr2", "Smr", "Smc", "Sxp", "Vm", "Vv", "Vmp", "Vmc", "Vvc")
CURVE += ("Vvv",)
SECOND = [name for name in exact() if name not in FORMULA + CURVE]


@pytest.mark.parametrize("name", FORMULA)
def test_means_and_counts_are_exact(name: str) -> None:
    assert errors(48)[name] < 1e-12


@pytest.mark.parametrize("name", SECOND)
def test_the_error_falls_with_the_square_of_the_pixel(name: str) -> None:
    sizes = np.array([32, 64, 128, 256])
    found = np.array([errors(points)[name] for points in sizes])
    rate = np.polyfit(np.log(sizes), np.log(found), 1)[0]
    assert rate < -1.6 and found[-1] < 2e-4


@pytest.mark.parametrize("name", CURVE)
def test_the_error_of_the_bearing_curve_falls_with_the_pixel(name: str) -> None:
    for points in (32, 64, 128, 256):
        assert errors(points)[name] < 0.7 / points


def test_a_hill_without_a_neighbor_stands_on_the_lowest_point() -> None:
    hm = lattice(32, cells=(1, 1))
    found = surfaces.describe(hm).features
    assert found["Spd"] * hm.area == pytest.approx(1.0)
    volume = float(hm.heights.mean() - hm.heights.min()) * hm.area
    assert (found["Sha"], found["Shv"]) == pytest.approx((hm.area, volume), rel=1e-9, abs=0.0)


def test_three_waves_in_resonance() -> None:
    """Moments of waves of which one is the sum of two others.

    The texture is that of the second, whose amplitude times wave number is the largest.
    """
    amplitudes, phases = np.array([3.0, 2.0, 1.0]) * 1e-7, (0.3, 1.1, 0.9)
    periods = np.array([(2, 3), (5, -1), (7, 2)])
    hm = surfaces.HeightMap(np.zeros((60, 44)), (1e-6, 2e-6), periodic=True)
    y, x = hm.y[:, None] / hm.size[0], hm.x / hm.size[1]
    waves = [2 * np.pi * (ky * y + kx * x) + p for (ky, kx), p in zip(periods, phases, strict=True)]
    heights = sum(a * np.cos(w) for a, w in zip(amplitudes, waves, strict=True))
    found = surfaces.describe(hm.replace(heights=heights)).parameters
    square = np.sum(amplitudes**2) / 2
    third = 1.5 * np.prod(amplitudes) * math.cos(phases[0] + phases[1] - phases[2])
    pairs = [amplitudes[i] ** 2 * amplitudes[j] ** 2 for i, j in ((0, 1), (0, 2), (1, 2))]
    fourth = 3 / 8 * np.sum(amplitudes**4) + 1.5 * sum(pairs)
    assert found["Sq"] == pytest.approx(math.sqrt(square), rel=1e-12)
    assert found["Ssk"] == pytest.approx(third / square**1.5, rel=1e-10)
    assert found["Sku"] == pytest.approx(fourth / square**2, rel=1e-10)
    across = math.degrees(math.atan2(5 / hm.size[0], -1 / hm.size[1]))
    assert found["Std"] == pytest.approx(across, abs=1e-6)


def test_closed_features_of_a_map_with_a_border() -> None:
    """Some hills and dales of the lattice do not reach the border; all count for the density."""
    found = surfaces.describe(lattice(96, periodic=False, cells=(4, 3))).features
    for name in ("Sha", "Sda"):
        assert found[name] == pytest.approx(LENGTH**2, rel=0.01)
    for name in ("Shv", "Sdv"):
        assert found[name] == pytest.approx(exact()["Shv"], rel=0.01, abs=0.0)
    assert found["Spd"] > LENGTH**-2


def test_normal_heights() -> None:
    """Functional parameters of sorted normal heights, thrown over the map."""
    count = 256 * 200
    heights = norm.ppf((np.arange(count) + 0.5) / count)
    heights = np.random.default_rng(0).permutation(heights).reshape(256, 200)
    found = surfaces.describe(surfaces.HeightMap(heights, (1.0, 2.0))).functional
    curve = functional(norm.sf, lambda r: norm.ppf(1 - r), 12.0)
    assert found == pytest.approx(curve, rel=1e-4)


def test_a_plane() -> None:
    hm = surfaces.HeightMap(np.zeros((150, 90)), (1e-6, 2e-6))
    found = surfaces.describe(hm.replace(heights=0.3 * hm.y[:, None] + 0.0 * hm.x)).parameters
    height = 0.3 * 150e-6
    assert found["Sdq"] == pytest.approx(0.3)
    assert found["Sdr"] == pytest.approx(math.sqrt(1 + 0.3**2) - 1)
    for name, value in {"Sq": 12**-0.5, "Sa": 0.25, "Sk": 1.0, "Smc": 0.4, "Sxp": 0.475}.items():
        assert found[name] == pytest.approx(value * height, rel=0.01)
    for name, value in {"Vmp": 0.005, "Vmc": 0.315, "Vvc": 0.385, "Vvv": 0.02}.items():
        assert found[name] == pytest.approx(value * height, rel=0.02)


@pytest.mark.parametrize("points", [60, 120])
def test_spherical_caps(points: int) -> None:
    """Caps of known radius on a flat: peaks, volumes above the flat and additional area."""
    radii, edge, pitch = np.array([40.0, 50.0, 60.0, 70.0, 80.0, 90.0]) * 1e-6, 12e-6, 30e-6
    n = np.array([2 * points, 3 * points - 1])
    spacing = np.array([2, 3]) * pitch / n
    y, x = (d * np.arange(0.5, count) for d, count in zip(spacing, n, strict=True))
    heights = np.zeros(n)
    tops = radii - np.sqrt(radii**2 - edge**2)
    for number, (radius, top) in enumerate(zip(radii, tops, strict=True)):
        row, column = divmod(number, 3)
        square = (y[:, None] - (row + 0.45) * pitch) ** 2 + (x - (column + 0.53) * pitch) ** 2
        cap = np.sqrt(np.maximum(radius**2 - square, 0.0)) - (radius - top)
        heights = np.maximum(heights, cap)
    hm = surfaces.HeightMap(heights, spacing, periodic=True)
    found = surfaces.describe(hm, wolf=1.0).parameters
    volumes = math.pi * tops * (3 * edge**2 + tops**2) / 6
    mean = volumes.sum() / (6 * pitch**2)
    assert found["Spd"] == pytest.approx(pitch**-2)
    assert found["Spc"] == pytest.approx(np.mean(1 / radii), rel=0.6 / points)
    assert found["S5p"] == pytest.approx(np.sort(tops)[-5:].mean() - mean, rel=0.1 / points)
    assert found["Shv"] == pytest.approx(volumes.mean(), rel=0.1 / points, abs=0.0)
    extra = 2 * math.pi * radii * tops - math.pi * edge**2
    assert found["Sdr"] == pytest.approx(extra.sum() / (6 * pitch**2), rel=2.0 / points)


def test_hills_of_the_negated_map_are_dales() -> None:
    """And turning the map by a right angle or another unit changes nothing else."""
    hm = surfaces.self_affine((80, 96), (80e-6, 192e-6), hurst=0.8, rms_slope=0.1, cutoff=2e-5)
    for periodic in (True, False):
        hm = hm.replace(periodic=periodic)
        one = surfaces.describe(hm).features
        other = surfaces.describe(hm.replace(heights=-hm.heights)).features
        turned = hm.replace(heights=hm.heights.T, spacing=hm.spacing[::-1])
        same = pytest.approx(one, rel=1e-9, abs=0.0, nan_ok=True)
        assert surfaces.describe(turned).features == same
        for hill, dale in (("Spd", "Svd"), ("S5p", "S5v"), ("Sha", "Sda"), ("Shv", "Sdv")):
            both = pytest.approx((other[dale], other[hill]), rel=1e-9, abs=0.0, nan_ok=True)
            assert (one[hill], one[dale]) == both
        assert one["Spc"] == pytest.approx(-other["Svc"])
    scaled = surfaces.HeightMap(1e3 * hm.heights, [1e3 * d for d in hm.spacing])
    powers = {"m": 1, "-": 0, "1/m": -1, "1/m^2": -2, "m^2": 2, "m^3": 3, "deg": 0}
    expected = surfaces.describe(hm).parameters
    for name, value in surfaces.describe(scaled).parameters.items():
        factor = 1e3 ** powers[PARAMETERS[name][0]]
        scale = pytest.approx(factor * expected[name], rel=1e-6, abs=1e-12, nan_ok=True)
        assert value == scale, name


@pytest.mark.parametrize("factor", [1.0, 1e-6, 3e-7, 1.7e-9])
def test_half_a_map_of_one_height_has_no_core(factor: float) -> None:
    """What is level belongs to the core, whatever the unit, above dales and below hills."""
    for seed in range(3):
        heights = factor * np.minimum(np.random.default_rng(seed).standard_normal((50, 40)), 0.0)
        top, bottom = (
            surfaces.bearing_curve(surfaces.HeightMap(z, 1.0)).core() for z in (heights, -heights)
        )
        share, depth = np.mean(heights == 0.0), -heights.mean()
        assert top["Smr2"] == pytest.approx(share, abs=1e-3)
        assert top["Svk"] == pytest.approx(2.0 * depth / (1.0 - share), rel=2e-3)
        assert bottom["Smr1"] == pytest.approx(1.0 - share, abs=1e-3)
        assert bottom["Spk"] == pytest.approx(top["Svk"], rel=2e-3)
        assert (top["Sk"], top["Spk"], bottom["Sk"], bottom["Svk"]) == (0.0,) * 4


def test_pruning_leaves_fewer_features() -> None:
    hm = surfaces.self_affine((80, 96), (80e-6, 96e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    counts = [surfaces.describe(hm, wolf=wolf).features["Spd"] for wolf in (0.0, 5.0, 20.0)]
    assert counts[0] > counts[1] > counts[2] > 0
    assert surfaces.describe(hm).features["Spd"] == counts[1]


def test_tables(tmp_path: Path) -> None:
    """CSV and JSON hold every parameter with its unit; what is not known is empty."""
    hm = lattice(16)
    heights = hm.heights.copy()
    heights[3, 4] = np.nan
    for made in (hm, hm.replace(heights=heights)):
        found = surfaces.describe(made)
        found.to_csv(tmp_path / "a.csv")
        found.to_json(tmp_path / "a.json")
        rows = json.loads((tmp_path / "a.json").read_text())
        assert rows == found.rows() and list(found.parameters) == list(PARAMETERS)
        assert {row["parameter"]: row["unit"] for row in rows}["Shv"] == "m^3"
        assert (rows[-1]["value"] is None) == bool(made.missing)
        pandas = pytest.importorskip("pandas")
        table = pandas.read_csv(tmp_path / "a.csv").set_index("parameter")
        expected = pytest.approx(list(found.parameters.values()), rel=1e-12, abs=0.0, nan_ok=True)
        assert table["value"].tolist() == expected
        assert pandas.DataFrame([found.parameters]).shape == (1, len(PARAMETERS))


def test_a_table_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    """It was a traceback of FileNotFoundError, and a file that was cut off where the disk ended."""
    found = surfaces.describe(lattice(16))
    for write in (found.to_csv, found.to_json):
        with pytest.raises(surfaces.InputError, match="cannot be written"):
            write(tmp_path / "nowhere" / "table")
