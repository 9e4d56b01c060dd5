"""Texture direction Std: of lays of known direction, of single waves, and what it is invariant to.

Crops are not periodic, and their amplitudes scatter: the direction of a weak lay does, too.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import surfaces
from surfaces.statistics.density import density_of, texture_direction

LAYS = (5, 20, 35, 60, 80, 110, 160)
SHORT = {"rms_slope": 0.1, "cutoff": 8e-6}
LONG = {"hurst": 0.8, "rms_slope": 0.1, "rolloff": 64e-6}
SQUARE = (512, 512), (512e-6, 512e-6)
ROUGH = surfaces.self_affine
MAPS = {
    "ground": (surfaces.ground, *SQUARE, SHORT),
    "2:1": (ROUGH, *SQUARE, LONG | {"anisotropy": 2.0}),
    "2:1, no roll-off": (ROUGH, *SQUARE, LONG | {"anisotropy": 2.0, "rolloff": None}),
    "4:1": (ROUGH, *SQUARE, LONG | {"anisotropy": 4.0}),
    "4:1, pixels 1:2": (ROUGH, (300, 256), (300e-6, 512e-6), LONG | {"anisotropy": 4.0}),
    "4:1, strip": (ROUGH, (64, 512), (64e-6, 512e-6), LONG | {"anisotropy": 4.0}),
    "8:1": (ROUGH, *SQUARE, LONG | {"anisotropy": 8.0}),
}
LONGEST_DECIDE = {"2:1, no roll-off": 1.5, "4:1, strip": 0.8}
"""Errors [deg] where the longest waves are as long as a side of the map."""


def made(kind: str, lay: float, seed: int = 1) -> surfaces.HeightMap:
    synthesis, shape, size, options = MAPS[kind]
    return synthesis(shape, size, angle=math.radians(lay), seed=seed, **options)


def direction(hm: surfaces.HeightMap) -> float:
    return math.degrees(texture_direction(density_of(hm)))


def apart(one: float, other: float) -> float:
    """Angle between two directions [deg]."""
    return abs((one - other + 90.0) % 180.0 - 90.0)


@pytest.mark.parametrize("lay", LAYS)
@pytest.mark.parametrize("kind", MAPS)
def test_across_an_oblique_lay(kind: str, lay: float) -> None:
    """It was up to 85 degrees off, at the directions of the longest waves: 0, 45, 90, 135."""
    assert apart(direction(made(kind, lay)), lay + 90.0) < LONGEST_DECIDE.get(kind, 0.1)


@pytest.mark.parametrize(
    ("kind", "middle", "most"), [("ground", 0.3, 0.6), ("8:1", 0.5, 2.0), ("4:1", 1.5, 5.0)]
)
def test_across_the_oblique_lay_of_a_crop(kind: str, middle: float, most: float) -> None:
    """The middle of the errors of three surfaces per direction, and the largest."""
    errors = [
        apart(direction(surfaces.crop(made(kind, lay, seed), (0, 400), (0, 400))), lay + 90.0)
        for lay in LAYS
        for seed in (1, 2, 3)
    ]
    assert np.median(errors) < middle and max(errors) < most


@pytest.mark.parametrize("shape", [(60, 44), (61, 45), (8, 256)])
def test_one_wave_has_its_direction(shape: tuple[int, int]) -> None:
    """Of any length: up to the largest full ring, and of one period."""
    hm = surfaces.HeightMap(np.zeros(shape), (1e-6, 1.7e-6), periodic=True)
    reach = [math.floor(0.5 * length / 1.7e-6) for length in hm.size]
    y, x = hm.y[:, None] / hm.size[0], hm.x / hm.size[1]
    for ky in range(0, reach[0] + 1, 2):
        for kx in range(-reach[1], reach[1] + 1, 5 if shape[1] < 50 else 17):
            exact = math.degrees(math.atan2(ky / hm.size[0], kx / hm.size[1]))
            if 0.0 < math.hypot(ky / hm.size[0], kx / hm.size[1]) < 0.5 / 1.7e-6:
                wave = hm.replace(heights=1e-7 * np.cos(2 * np.pi * (ky * y + kx * x) + 0.4))
                assert apart(direction(wave), exact) < 1e-6


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("kind", ["2:1", "4:1, pixels 1:2", "4:1, strip"])
def test_turned_maps_have_turned_directions(kind: str, periodic: bool) -> None:
    """Transposed, mirrored, rolled if periodic, and in other units."""
    hm = made(kind, 35.0).replace(periodic=periodic)
    found = direction(hm)
    turned = hm.replace(heights=hm.heights.T, spacing=hm.spacing[::-1])
    assert apart(direction(turned), 90.0 - found) < 1e-6
    for mirrored in (hm.heights[::-1], hm.heights[:, ::-1]):
        assert apart(direction(hm.replace(heights=mirrored)), -found) < 1e-6
    scaled = surfaces.HeightMap(3e3 * hm.heights, [7e5 * d for d in hm.spacing], periodic=periodic)
    assert direction(scaled) == pytest.approx(found, abs=1e-9)
    if periodic:
        rolled = hm.replace(heights=np.roll(hm.heights, (7, 31), (0, 1)))
        assert direction(rolled) == pytest.approx(found, abs=1e-9)


@pytest.mark.parametrize("periodic", [True, False])
def test_mirrored_maps_have_mirrored_directions_near_an_axis(periodic: bool) -> None:
    """It was 2 to 6 degrees off: the longest wave across the ray counted on one side of it."""
    hm = ROUGH((33, 48), (66e-6, 48e-6), hurst=0.8, rms_slope=0.1, seed=3)
    hm = hm.replace(periodic=periodic)
    mirrored = direction(hm.replace(heights=hm.heights[:, ::-1]))
    assert apart(mirrored, -direction(hm)) < 1e-6
