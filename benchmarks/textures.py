"""Textures on which the microcontact model is known to fail, or may, pixel size 1."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from common import Scene, rough_heights
from grids import Heights, axes, smoothed, squared_distance
from scipy import stats

import surfaces

__all__ = ["TEXTURES", "textures"]


def _waves(points: int, seed: int, **recipe: float | None) -> Heights:
    """Self-affine heights on a square grid."""
    return rough_heights((points, points), seed, **recipe)


def _fine(points: int, seed: int, rms: float, cutoff: float = 4.0) -> Heights:
    """Waves of a sixteenth of the map and less."""
    waves = _waves(points, seed, rolloff=points / 16, cutoff=cutoff)
    return waves * rms / waves.std()


def round_hill(points: int, seed: int) -> Heights:
    """One round hill with roughness of 1 to 3 % of its height."""
    rng = np.random.default_rng(seed)
    y, x = axes((points, points))
    hill = points / 40 * np.exp(-8 * ((y - 0.5) ** 2 + (x - 0.5) ** 2) / rng.uniform(0.3, 1.0))
    return hill + _fine(points, seed, rng.uniform(0.01, 0.03) * np.ptp(hill))


def wavy_hill(points: int, seed: int) -> Heights:
    """A wave as long as the map in both directions, with fine roughness."""
    rng = np.random.default_rng(seed)
    y, x = axes((points, points))
    wave = points / 80 * (np.cos(2 * np.pi * y) + np.cos(2 * np.pi * x))
    return wave + _fine(
        points, seed, rng.uniform(0.01, 0.03) * np.ptp(wave), rng.choice([4, 8, 16])
    )


def few_summits(points: int, seed: int) -> Heights:
    """Waves as long as the map and hardly shorter, with fine roughness."""
    long = _waves(points, seed, cutoff=points / 4)
    return long + _fine(points, seed + 1, 0.02 * np.ptp(long), 8.0)


def terraces(points: int, seed: int) -> Heights:
    """Random heights in steps, smoothed over a pixel or two."""
    rng = np.random.default_rng(seed)
    waves = _waves(points, seed, cutoff=16.0)
    step = rng.uniform(0.3, 1.0) * waves.std()
    return smoothed(step * np.round(waves / step), rng.uniform(0.7, 1.5))


def turned(points: int, seed: int) -> Heights:
    """Ridges of a turned surface with roughness."""
    rng = np.random.default_rng(seed)
    feed = points / rng.integers(6, 16)
    shape, size = (points, points), (float(points), float(points))
    ridges = surfaces.turned(shape, size, feed=feed, nose_radius=2 * feed).heights
    return ridges + _fine(points, seed, rng.uniform(0.02, 0.2) * ridges.std(), 6.0)


def cusps(points: int, seed: int) -> Heights:
    """The same upside down: sharp ridges."""
    return -turned(points, seed)


def long_lay(points: int, seed: int) -> Heights:
    """Lay of 10:1."""
    return _waves(points, seed, anisotropy=10.0, rolloff=points / 8)


def turned_lay(points: int, seed: int) -> Heights:
    """Lay of 5:1 at 30 degrees."""
    return _waves(points, seed, anisotropy=5.0, angle=np.pi / 6, rolloff=points / 8)


def clipped(points: int, seed: int) -> Heights:
    """Heights cut off, with noise of rounding."""
    rng = np.random.default_rng(seed)
    waves = _waves(points, seed, cutoff=8.0, rolloff=points / 8)
    flat = np.minimum(waves, rng.uniform(0.5, 1.5) * waves.std())
    return flat + 10.0 ** rng.choice([-12, -9, -6]) * waves.std() * rng.normal(size=waves.shape)


def cliff(points: int, seed: int) -> Heights:
    """A part of a larger map, taken as periodic."""
    return _waves(2 * points, seed, cutoff=6.0)[:points, :points]


def weibull(points: int, seed: int) -> Heights:
    """Heights of a Weibull distribution, upside down."""
    waves = _waves(points, seed, cutoff=8.0, rolloff=points / 8)
    share = stats.norm.cdf(waves / waves.std())
    heights = stats.weibull_min.ppf(np.clip(share, 1e-9, 1 - 1e-9), 1.3)
    return -heights * 0.1


def skewed(points: int, seed: int) -> Heights:
    """Exponential of random heights: few high hills."""
    waves = _waves(points, seed, cutoff=8.0, rolloff=points / 8)
    return np.exp(waves / waves.std())


def beads(points: int, seed: int) -> Heights:
    """Spherical grains of scattered size and height."""
    rng = np.random.default_rng(seed)
    heights = np.full((points, points), -1e9)
    for _ in range(80):
        r2 = squared_distance(heights.shape, rng.random(2) * points)
        radius, top = points / 16 * rng.uniform(0.7, 1.3), rng.normal() * points / 400
        cap = np.where(r2 < radius**2, np.sqrt(np.maximum(radius**2 - r2, 0)) - radius + top, -1e9)
        heights = np.maximum(heights, cap)
    floor = -points / 40
    return smoothed(np.maximum(heights, floor), 1.0)


def scratches(points: int, seed: int) -> Heights:
    """Fine random waves crossed by grooves."""
    rng = np.random.default_rng(seed)
    waves = _waves(points, seed, rolloff=points / 8)
    y, x = axes((points, points))
    for _ in range(8):
        turns, start = rng.integers(-3, 4), rng.random()
        away = np.abs((y + turns * x - start + 0.5) % 1.0 - 0.5) * points
        waves = waves - 3 * waves.std() * np.exp(-((away / 4.0) ** 2))
    return waves


def noise(points: int, seed: int) -> Heights:
    """White noise."""
    return np.random.default_rng(seed).normal(size=(points, points))


def dimples(points: int, seed: int) -> Heights:
    """A fine random surface with round holes."""
    rng = np.random.default_rng(seed)
    waves = _waves(points, seed, rolloff=points / 16)
    for centre in rng.random((12, 2)):
        r2 = squared_distance(waves.shape, centre, (1 / points, 1 / points))
        waves = waves - 5 * waves.std() * np.exp(-r2 / 0.002)
    return waves


def random_waves(points: int, seed: int) -> Heights:
    """Gaussian map, cut off at two pixels."""
    return _waves(points, seed, cutoff=2.0, rolloff=points / 8)


TEXTURES: dict[str, Callable[[int, int], Heights]] = {
    make.__name__.replace("_", " "): make
    for make in (
        round_hill,
        wavy_hill,
        few_summits,
        terraces,
        turned,
        cusps,
        long_lay,
        turned_lay,
        clipped,
        cliff,
        weibull,
        skewed,
        beads,
        scratches,
        noise,
        dimples,
        random_waves,
    )
}


def textures(seed: int, sizes: list[int]) -> dict[str, Callable[[], Scene]]:
    """The textures of one seed, of all sizes."""

    def scene(name: str, points: int) -> Scene:
        heights = TEXTURES[name](points, seed)
        return surfaces.HeightMap(heights, (1.0, 1.0), periodic=True), 0.0, None

    return {f"{name} {n}": partial(scene, name, n) for name in TEXTURES for n in sizes}
