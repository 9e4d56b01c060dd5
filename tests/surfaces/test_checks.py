"""A map is random if its waves of every length are, not only the finest."""

from __future__ import annotations

import numpy as np
import pytest

import surfaces
from surfaces.checks import fine_waves_random, random_map

SHAPE, ALLOWED = (512, 480), 0.25


def waves(seed: int, **recipe) -> surfaces.HeightMap:
    given = {"hurst": 0.8, "rms_slope": 0.1, "seed": seed}
    return surfaces.self_affine(SHAPE, tuple(map(float, SHAPE)), **given | recipe)


def on(shape: np.ndarray, noise: float, *, periodic: bool = True) -> surfaces.HeightMap:
    """A surface of unit size under fine random waves."""
    fine = waves(7, hurst=0.3, rolloff=12.0)
    return surfaces.HeightMap(
        shape / np.std(shape) + noise * fine.heights / fine.rms_height,
        (1.0, 1.0),
        periodic=periodic,
    )


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    "recipe",
    [{}, {"hurst": 0.2}, {"rolloff": 60.0, "cutoff": 8.0}, {"cutoff": 16.0}, {"rolloff": 30.0}],
)
def test_random_waves_of_any_length_are_random(seed, recipe):
    hm = waves(seed, **recipe)
    assert random_map(hm, ALLOWED)
    assert random_map(hm.replace(periodic=False), ALLOWED)


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("count", [(9, 13), (20, 15)])
def test_a_lattice_under_fine_noise_is_not(count, periodic):
    y, x = (np.arange(n) / n for n in SHAPE)
    lattice = np.cos(2 * np.pi * count[0] * y)[:, None] * np.cos(2 * np.pi * count[1] * x)
    hm = on(lattice, 0.05, periodic=periodic)
    assert fine_waves_random(hm, ALLOWED) and not random_map(hm, ALLOWED)


def test_hills_of_few_heights_under_fine_noise_are_not():
    long = waves(3, rolloff=80.0, cutoff=30.0)
    hills = np.exp(1.2 * long.heights / long.rms_height)
    hm = on(hills, 0.1)
    assert fine_waves_random(hm, ALLOWED) and not random_map(hm, ALLOWED)


def test_neither_units_nor_turns_matter():
    y, x = (np.arange(n) / n for n in SHAPE)
    lattice = on(np.cos(22 * np.pi * y)[:, None] * np.cos(26 * np.pi * x), 0.05)
    for hm in (lattice, waves(5)):
        known = random_map(hm, ALLOWED)
        for heights in (1e-9 * hm.heights, -hm.heights, hm.heights.T, hm.heights[:, ::-1]):
            assert random_map(hm.replace(heights=heights), ALLOWED) == known


def test_random_waves_have_a_kurtosis_of_three():
    hm = waves(2, rolloff=80.0)
    assert hm.roughness.kurtosis == pytest.approx((3.0, 3.0), abs=0.2)
    assert hm.replace(periodic=False).roughness.kurtosis == pytest.approx((3.0, 3.0), abs=0.2)
    assert fine_waves_random(hm, ALLOWED)
    steps = np.round(waves(2, rolloff=40.0, cutoff=8.0).heights / 0.5)
    assert not fine_waves_random(surfaces.HeightMap(steps, hm.spacing, periodic=True), ALLOWED)
    spikes = hm.heights.copy()
    spikes[::40, ::40] += 4 * hm.rms_height
    assert not fine_waves_random(hm.replace(heights=spikes), ALLOWED)
    assert not fine_waves_random(
        surfaces.prepare(hm.replace(heights=spikes), periodic="taper"), ALLOWED
    )
    assert not fine_waves_random(hm.replace(heights=np.minimum(hm.heights, 0.0)), ALLOWED)  # worn
    ridges = surfaces.HeightMap(
        np.tile(np.sin(np.arange(40.0)), (30, 1)), (1.0, 1.0), periodic=True
    )
    assert ridges.roughness.kurtosis[0] == np.inf
