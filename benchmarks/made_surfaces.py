"""Further textures (`--made`): as processes make them (blasted, eroded, cut, printed, worn) and as
patterns or statistics far from a Gaussian surface.

Name and seed alone fix a map. Lengths and heights are in pixels, roughness has an rms slope of 0.1
unless said otherwise. `scene` draws a grid, a ratio of the pixels, a grading and a boundary, too.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from common import Scene, rough_heights
from grids import Heights, axes, smoothed, squared_distance, wrapped
from scipy.special import expit

import surfaces

__all__ = ["MADE", "made_surfaces", "scene"]

Shape = tuple[int, int]

SHAPES: list[Shape] = [(256, 256), (240, 200), (192, 288)]
SPACINGS = [(1.0, 1.0), (1.0, 1.3)]
GRADINGS = [0.0, 0.0, 0.0, 0.0, 0.3, -0.3]
"""Exponents of the grading: two thirds of the bodies are homogeneous."""
FREE = 0.2
"""Share of the maps with a free boundary."""


def _distance_from_any(shape: Shape, rng: np.random.Generator) -> Heights:
    """Squared distance from a random point."""
    return squared_distance(shape, rng.random(2) * shape)


def shot_peened(shape: Shape, seed: int) -> Heights:
    """Overlapping round dents with raised rims, and a little roughness."""
    rng = np.random.default_rng(seed)
    heights = np.zeros(shape)
    for _ in range(150):
        r2, radius = _distance_from_any(shape, rng), rng.uniform(8, 25)
        dent = -np.maximum(radius**2 - r2, 0) / (8 * radius)
        rim = 0.02 * radius * np.exp(-(((np.sqrt(r2) - radius) / 3) ** 2))
        heights = np.minimum(heights, dent) + rim
    return smoothed(heights, 1.2) + 0.1 * rough_heights(shape, seed)


def weave(shape: Shape, seed: int) -> Heights:
    """Threads that cross over and under others, with roughness."""
    rng = np.random.default_rng(seed)
    y, x = axes(shape)
    threads = rng.integers(4, 9)
    over_and_under = np.cos(2 * np.pi * threads * y) * np.sign(np.sin(np.pi * threads * x))
    crossed = np.cos(2 * np.pi * threads * x)
    heights = 3 * smoothed(np.maximum(over_and_under + 1, crossed + 0.8), 2.0)
    return heights + rng.uniform(0.02, 0.2) * rough_heights(shape, seed)


def spark_eroded(shape: Shape, seed: int) -> Heights:
    """Craters, each of which levels what was there before."""
    rng = np.random.default_rng(seed)
    heights = np.zeros(shape)
    for _ in range(200):
        r2, radius = _distance_from_any(shape, rng), rng.uniform(5, 18)
        ratio = np.sqrt(r2) / radius
        crater = 0.08 * radius * (ratio**2 - 1) * np.exp(-8 * np.maximum(ratio - 1, 0))
        heights = np.where(ratio < 1.3, 0.3 * heights + crater, heights)
    return smoothed(heights, 1.0)


def cross_hatched(shape: Shape, seed: int) -> Heights:
    """Roughness crossed by grooves of scattered direction, width and depth."""
    rng = np.random.default_rng(seed)
    y, x = axes(shape)
    heights = 0.5 * rough_heights(shape, seed, rolloff=40.0)
    for _ in range(rng.integers(6, 16)):
        turns, start = rng.integers(1, 4) * rng.choice([-1, 1]), rng.random()
        width = rng.uniform(2, 6) / shape[0] * np.sqrt(1 + turns**2)
        away = wrapped(y + turns * x - start, 1.0)
        heights = heights - rng.uniform(0.5, 3) * np.exp(-((away / width) ** 2))
    return heights


def burrs(shape: Shape, seed: int) -> Heights:
    """The cross-hatched texture upside down: narrow ridges."""
    return -cross_hatched(shape, seed)


def modulated(shape: Shape, seed: int) -> Heights:
    """Roughness whose amplitude is lognormal and varies slowly over the map."""
    amplitude = rough_heights(shape, seed + 1, cutoff=60.0)
    return rough_heights(shape, seed, rolloff=30.0) * np.exp(0.8 * amplitude / amplitude.std())


def printed(shape: Shape, seed: int) -> Heights:
    """Tracks of molten powder with sharp ridges between them, and grains that did not melt."""
    rng = np.random.default_rng(seed)
    _, x = axes(shape)
    tracks = -2 * np.abs(np.cos(np.pi * rng.integers(4, 9) * x))
    heights = tracks + 0.3 * rough_heights(shape, seed)
    for _ in range(40):
        r2, radius = _distance_from_any(shape, rng), rng.uniform(3, 9)
        cap = 0.5 * np.sqrt(np.maximum(radius**2 - r2, 0))
        grain = rng.uniform(-1, 1) + np.where(r2 < radius**2, cap, -9)
        heights = np.maximum(heights, grain)
    return smoothed(heights, 1.0)


def facets(shape: Shape, seed: int) -> Heights:
    """Tilted plane facets at scattered heights, with a little roughness."""
    rng = np.random.default_rng(seed)
    y, x = axes(shape)
    centres = rng.random((60, 2))
    nearest = np.argmin([squared_distance(shape, c * shape) for c in centres], axis=0)
    slope, level = 0.05 * rng.normal(size=(60, 2)), 0.5 * rng.normal(size=60)
    heights = level[nearest]
    for i, along in enumerate((y, x)):
        offset = shape[i] * wrapped(along - centres[nearest, i], 1.0)
        heights = heights + slope[nearest, i] * offset
    return smoothed(heights, 1.5) + 0.05 * rough_heights(shape, seed)


def bump_lattice(shape: Shape, seed: int) -> Heights:
    """Square or centered lattice of bumps, with roughness."""
    rng = np.random.default_rng(seed)
    y, x = axes(shape)
    count = rng.integers(5, 10)
    across, along = np.cos(2 * np.pi * count * x), np.cos(2 * np.pi * count * y)
    centered = count % 2 == 0
    bumps = across + (2 * np.cos(np.pi * count * x) * along if centered else along)
    return bumps + rng.choice([0.01, 0.1, 0.5]) * rough_heights(shape, seed)


def laser_grooves(shape: Shape, seed: int) -> Heights:
    """Flat lands between grooves of equal pitch, with roughness."""
    rng = np.random.default_rng(seed)
    _, x = axes(shape)
    phase = x * rng.integers(3, 7) % 1
    grooves = smoothed(np.where(np.abs(phase - 0.5) < 0.2, -3.0, 0.0), 2.0)
    return grooves + rng.uniform(0.1, 1) * rough_heights(shape, seed, rolloff=40.0)


def pyramids(shape: Shape, seed: int) -> Heights:
    """Square pyramids with blunt edges, with roughness."""
    rng = np.random.default_rng(seed)
    count = rng.integers(4, 8)
    along, across = (1 - np.abs(2 * (a * count % 1) - 1) for a in axes(shape))
    heights = smoothed(4 * np.minimum(along, across), 1.5)
    return heights + rng.choice([0.02, 0.2]) * rough_heights(shape, seed)


def lognormal(shape: Shape, seed: int) -> Heights:
    """Heights of a lognormal distribution."""
    rng = np.random.default_rng(seed)
    rough = rough_heights(shape, seed, rolloff=40.0)
    return np.exp(rng.uniform(0.3, 0.9) * rough / rough.std())


def bifractal(shape: Shape, seed: int) -> Heights:
    """Two Hurst exponents: 0.9 of the long waves, 0.3 of the short ones."""
    long = rough_heights(shape, seed, hurst=0.9, cutoff=30.0)
    return long + 0.5 * rough_heights(shape, seed + 7, hurst=0.3, rolloff=30.0, cutoff=4.0)


def ripple(shape: Shape, seed: int) -> Heights:
    """Parallel waves that meander, with roughness."""
    rng = np.random.default_rng(seed)
    y, x = axes(shape)
    ripples = 1.5 * np.cos(2 * np.pi * rng.integers(3, 12) * x + 0.5 * np.sin(2 * np.pi * y))
    return ripples + rng.uniform(0.05, 1) * rough_heights(shape, seed)


def pitted(shape: Shape, seed: int) -> Heights:
    """Roughness with round pits of steep walls."""
    rng = np.random.default_rng(seed)
    heights = rough_heights(shape, seed, rolloff=50.0)
    for _ in range(60):
        r2, radius = _distance_from_any(shape, rng), rng.uniform(2, 7)
        heights = heights - 4 * expit(1.5 * (radius - np.sqrt(r2)))
    return heights


def two_roughnesses(shape: Shape, seed: int) -> Heights:
    """A strip of one roughness beside a strip of another."""
    _, x = axes(shape)
    strip = smoothed(np.where(np.abs(x - 0.5) < 0.25, 1.0, 0.0), 4.0)
    inside = 2 * rough_heights(shape, seed, rolloff=30.0)
    outside = 0.5 * rough_heights(shape, seed + 3, hurst=0.4, rolloff=30.0)
    return strip * inside + (1 - strip) * outside


def any_lay(shape: Shape, seed: int) -> Heights:
    """Lay of 2.5:1 to 6:1 in any direction."""
    rng = np.random.default_rng(seed)
    lay = {"anisotropy": rng.uniform(2.5, 6), "angle": rng.uniform(0, 3)}
    return rough_heights(shape, seed, rolloff=40.0, **lay)


def worn(shape: Shape, seed: int) -> Heights:
    """Heights worn off to a plateau with rounded edges, and fine roughness."""
    rng = np.random.default_rng(seed)
    rough = rough_heights(shape, seed, rolloff=50.0)
    rms = rough.std()
    plateau = rng.uniform(0.2, 1.2) * rms
    fine = rng.uniform(0.02, 0.1) * rough_heights(shape, seed + 1, cutoff=5.0, rolloff=20.0)
    return plateau - rms / 6 * np.logaddexp(0, -6 * (rough - plateau) / rms) + fine


def studs(shape: Shape, seed: int) -> Heights:
    """A few high studs, round or blunt, on a rough floor."""
    rng = np.random.default_rng(seed)
    heights = 0.3 * rough_heights(shape, seed, rolloff=40.0)
    for _ in range(rng.integers(3, 12)):
        r2, radius, height = _distance_from_any(shape, rng), rng.uniform(4, 16), rng.uniform(2, 3)
        heights = heights + height * np.exp(-((r2 / radius**2) ** rng.choice([1, 2])))
    return heights


def ground(shape: Shape, seed: int) -> Heights:
    """Fine lay of 8:1 on long waves."""
    lay = rough_heights(shape, seed, anisotropy=8.0, rolloff=30.0, cutoff=5.0)
    return lay + rough_heights(shape, seed + 1, cutoff=50.0)


def smooth_hills(shape: Shape, seed: int) -> Heights:
    """Waves as long as the map, and weaker ones of a twelfth to a fifth of its shorter side."""
    rng = np.random.default_rng(seed)
    side = min(shape)
    hills = rough_heights(shape, seed, cutoff=side / 3)
    short = rough_heights(shape, seed + 1, cutoff=side / 12, rolloff=side / 5)
    return hills + rng.uniform(0.1, 0.4) * short


def heavy_tails(shape: Shape, seed: int) -> Heights:
    """Powers of Gaussian heights: high summits and deep valleys are frequent."""
    rough = rough_heights(shape, seed, rolloff=40.0)
    normal = rough / rough.std()
    return 0.3 * np.sign(normal) * np.abs(normal) ** 1.3


MADE: dict[str, Callable[[Shape, int], Heights]] = {
    make.__name__.replace("_", " "): make
    for make in (
        shot_peened,
        weave,
        spark_eroded,
        cross_hatched,
        burrs,
        modulated,
        printed,
        facets,
        bump_lattice,
        laser_grooves,
        pyramids,
        lognormal,
        bifractal,
        ripple,
        pitted,
        two_roughnesses,
        any_lay,
        worn,
        studs,
        ground,
        smooth_hills,
        heavy_tails,
    )
}


def scene(name: str, seed: int) -> Scene:
    """Map, exponent of the grading and boundary of one texture and seed."""
    rng = np.random.default_rng([seed, sum(map(ord, name))])
    shape, spacing = SHAPES[rng.integers(len(SHAPES))], SPACINGS[rng.integers(len(SPACINGS))]
    m, boundary = float(rng.choice(GRADINGS)), "free" if rng.random() < FREE else None
    return surfaces.HeightMap(MADE[name](shape, seed), spacing, periodic=True), m, boundary


def made_surfaces(seed: int) -> dict[str, Callable[[], Scene]]:
    """The scenes of one seed."""
    return {name: partial(scene, name, seed) for name in MADE}
