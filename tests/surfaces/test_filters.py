"""S and L filters of ISO 16610-61 and -62: what passes, what is kept, linearity."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import diags_array, eye_array, kron
from scipy.sparse.linalg import spsolve

import surfaces

SPACING = (2e-6, 3e-6)
SHAPE = (96, 80)
BOTH = pytest.mark.parametrize("filter", ["gaussian", "spline"])
BORDER = pytest.mark.parametrize("periodic", [False, True])


def map_of(heights: np.ndarray, periodic: bool = True) -> surfaces.HeightMap:
    return surfaces.HeightMap(heights, SPACING, periodic=periodic)


def wave(ny: int, nx: int) -> np.ndarray:
    """A wave with that many periods along y and x."""
    y, x = np.meshgrid(*(np.arange(0.5, n) / n for n in SHAPE), indexing="ij")
    return np.cos(2 * np.pi * (ny * y + nx * x) + 0.3)


def length(ny: int, nx: int) -> float:
    """Its wavelength [m]."""
    size = np.array(SHAPE) * SPACING
    return float(1 / np.hypot(ny / size[0], nx / size[1]))


def passed(heights: np.ndarray, before: np.ndarray) -> float:
    """Share of a wave that is left, after making sure that nothing else is."""
    share = float(np.sum(heights * before) / np.sum(before**2))
    np.testing.assert_allclose(heights, share * before, atol=1e-12)
    return share


@BOTH
@pytest.mark.parametrize("periods", [(6, 0), (0, 7), (5, 4)])
def test_half_of_the_wave_at_the_cutoff_passes(filter: str, periods: tuple[int, int]) -> None:
    """As S filter and as L filter; exact but for an oblique spline."""
    before, cutoff = wave(*periods), length(*periods)
    short = passed(surfaces.bandpass(map_of(before), cutoff, filter=filter).heights, before)
    long = passed(surfaces.bandpass(map_of(before), None, cutoff, filter=filter).heights, before)
    exact = filter == "gaussian" or 0 in periods
    assert short == pytest.approx(0.5, abs=1e-12 if exact else 0.01)
    assert short + long == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("ratio", [0.5, 0.9, 1.7, 4.0])
def test_transmission(ratio: float) -> None:
    """Gaussian 2^-(1/r)^2 and spline 1 / (1 + r^-4) of waves r times as long as the cut-off."""
    before = wave(3, 0)
    cutoff = length(3, 0) / ratio
    found = {
        name: passed(surfaces.bandpass(map_of(before), cutoff, filter=name).heights, before)
        for name in ("gaussian", "spline")
    }
    assert found["gaussian"] == pytest.approx(2.0 ** -(ratio**-2.0), abs=1e-12)
    sines = np.sin(np.pi * 2e-6 / length(3, 0)) / np.sin(np.pi * 2e-6 / cutoff)
    assert found["spline"] == pytest.approx(1 / (1 + sines**4), abs=1e-12)
    assert found["spline"] == pytest.approx(1 / (1 + ratio**-4.0), abs=0.01)


@BOTH
@BORDER
def test_linearity_and_constants(filter: str, periodic: bool) -> None:
    one, other = np.random.default_rng(3).normal(size=(2, *SHAPE))

    def smooth(heights: np.ndarray) -> np.ndarray:
        return surfaces.bandpass(map_of(heights, periodic), 3e-5, filter=filter).heights

    total = smooth(2.0 * one - 3.0 * other + 5.0)
    expected = 2.0 * smooth(one) - 3.0 * smooth(other) + 5.0
    np.testing.assert_allclose(total, expected, atol=1e-7)
    assert np.std(total) < 0.3 * np.std(2.0 * one - 3.0 * other)


def test_the_spline_keeps_planes_and_the_gaussian_constants() -> None:
    hm = map_of(np.zeros(SHAPE), False)
    plane = hm.replace(heights=0.2 * hm.y[:, None] - 0.1 * hm.x + 3e-5)
    kept = surfaces.bandpass(plane, 5e-5, filter="spline")
    np.testing.assert_allclose(kept.heights, plane.heights, atol=1e-8 * np.ptp(plane.heights))
    flat = surfaces.bandpass(plane, None, 5e-5, filter="spline")
    np.testing.assert_allclose(flat.heights, plane.heights.mean(), atol=1e-12)


def test_a_spline_far_longer_than_the_map_keeps_planes_or_is_refused() -> None:
    """At a cut-off of 39 sides heights were off by 7e-5 rms heights, at 195 by 4 %."""
    rough = surfaces.self_affine((96, 128), (96.0, 128.0), hurst=0.8, rms_slope=0.1)
    rough = rough.replace(periodic=False)
    level = surfaces.level(rough)
    one, two = (surfaces.bandpass(hm, 39 * 128.0, filter="spline") for hm in (rough, level))
    moved = one.heights - two.heights - (rough.heights - level.heights)
    assert np.abs(moved).max() < 1e-6 * rough.rms_height
    with pytest.raises(surfaces.SurfaceError, match="more than 40 times as long"):
        surfaces.bandpass(rough, 41 * 128.0, filter="spline")


def test_the_spline_solves_its_equation() -> None:
    """Against the sparse matrix of all second differences."""
    ny, nx, cutoff = 14, 11, 2.4e-5
    z = np.random.default_rng(1).normal(size=(ny, nx))

    def differences(count: int) -> tuple:
        first = diags_array([-1.0, 1.0], offsets=[0, 1], shape=(count - 1, count))
        second = diags_array([1.0, -2.0, 1.0], offsets=[0, 1, 2], shape=(count - 2, count))
        return first, second, eye_array(count)

    (y1, y2, y0), (x1, x2, x0) = differences(ny), differences(nx)
    a, b = (1 / (4 * np.sin(np.pi * d / cutoff) ** 2) for d in SPACING)
    parts = [a * kron(y2, x0), b * kron(y0, x2), np.sqrt(2 * a * b) * kron(y1, x1)]
    matrix = eye_array(z.size) + sum(part.T @ part for part in parts)
    expected = spsolve(matrix.tocsc(), z.ravel()).reshape(z.shape)
    found = surfaces.bandpass(map_of(z, False), cutoff, filter="spline")
    np.testing.assert_allclose(found.heights, expected, atol=1e-8)


@BOTH
def test_a_band_is_both_filters_in_turn(filter: str) -> None:
    hm = map_of(np.random.default_rng(2).normal(size=SHAPE), False)
    band = surfaces.prepare(hm, level=None, bandpass=(1e-5, 5e-5), filter=filter)
    short = surfaces.bandpass(hm, 1e-5, filter=filter)
    turn = surfaces.bandpass(short, None, 5e-5, filter=filter)
    np.testing.assert_allclose(band.heights, turn.heights, atol=1e-8)
    step = band.history[-1]
    assert (step["filter"], step["shortest"], step["longest"]) == (filter, 1e-5, 5e-5)


def test_a_map_of_one_profile_is_filtered_as_that_profile() -> None:
    """ISO 16610-22: (1 + alpha^4 Q) w = z with free ends, alpha = 1 / (2 sin(pi d / cutoff))."""
    z, cutoff = np.random.default_rng(5).normal(size=40), 4e-5
    alpha = 1 / (2 * np.sin(np.pi * SPACING[1] / cutoff))
    second = np.diff(np.eye(40), 2, axis=0)
    profile = np.linalg.solve(np.eye(40) + alpha**4 * second.T @ second, z)
    found = surfaces.bandpass(map_of(np.tile(z, (9, 1)), False), cutoff, filter="spline")
    np.testing.assert_allclose(found.heights, np.tile(profile, (9, 1)), atol=1e-8)
