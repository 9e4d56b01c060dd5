"""Waves near the pixel: how much of the slope they hold, and a grid that shows their summits.

Summits are found on pixels, and the surface between them is interpolated. Where waves of two to
four pixels hold much of the slope, summits are missed or come out too low, and so does the load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asperity.parameters import DEFAULTS, PixelWaves
from surfaces.heightmap import HeightMap
from surfaces.preparation.filtering import resample

__all__ = [
    "Strength",
    "fineness",
    "refined_map",
    "resolution_warning",
    "strength",
]

Array = NDArray[np.float64]

PARTS = 48
"""Parts of each axis over which the strength of the finest waves is a mean; fewer blur the border
that `prepare` fades."""

LINES = 128
"""Rows and columns that suffice to find it."""

LEVELS = 32
"""Levels of height, each of as many points: over them the strength of worn waves is a mean."""


def fineness(hm: HeightMap) -> float:
    """Share of the squared slope that is lost when heights are taken two pixels apart, not one.

    0 for a smooth map, 0.03 for a spectrum that ends at 8 pixels, 0.09 at 4, 0.14 at 3 and 0.2 to
    0.4 at the pixel, 0.75 for noise.

    Notes
    -----
    For differences d, d' of neighboring pairs, <(d - d')^2> = 4 <d^2> - <(d + d')^2>.
    """
    found = hm.roughness
    bend = np.asarray(found.curvature) * hm.spacing
    return float(bend @ bend) / (4.0 * found.rms_slope**2)


@dataclass(frozen=True, eq=False)
class Strength:
    """Variance of the finest waves over its mean: a product of one of y, one of x, one of height.

    Attributes
    ----------
    along
        Its values over equal parts of y and of x.
    worn
        Heights [m] above the mean plane, and its values below, between and above them.
    """

    along: tuple[Array, Array] = (np.ones(1), np.ones(1))
    worn: tuple[Array, Array] = (np.zeros(0), np.ones(1))

    def at(self, y: Array, x: Array, height: Array | float = 0.0) -> Array:
        """Strength at the places y, x, from 0 to 1 across the map, at a height [m]."""
        of_y, of_x = (
            part[(place * part.size).astype(np.int64) % part.size]
            for place, part in zip((y, x), self.along, strict=True)
        )
        levels, between = self.worn
        return np.asarray(of_y * of_x * between[np.searchsorted(levels, height)])


def strength(hm: HeightMap, waves: PixelWaves = DEFAULTS.pixel_waves) -> Strength | None:
    """Where the finest waves of a map are how strong; None if they are not random: with spikes,
    steps, tops of one height.

    Notes
    -----
    Random waves are known by the kurtosis of their second differences. A border that fades
    multiplies them by a window of y times one of x: they are random again over the root of the
    product of their mean squares along lines and columns. Such maps have no law unless their waves
    reach the pixel: else all summits cost little, and fewer contacts are nearer to them. Wear
    presses the high parts of a map together, and their waves with them: these are random again over
    the root of their mean square at their height.
    """
    if all(abs(value - 3.0) <= waves.kurtosis for value in hm.roughness.kurtosis):
        return Strength()
    if min(hm.shape) < 2 * PARTS:
        return None
    faded = _faded(hm, waves.kurtosis) if fineness(hm) >= waves.to_the_pixel else None
    return faded or _worn(hm, waves.worn_kurtosis)


def _faded(hm: HeightMap, kurtosis: float) -> Strength | None:
    """Strength under a border that fades, if that makes the waves random."""
    squares = [np.square(_bends(hm, 0)).T, np.square(_bends(hm, 1))]
    found = Strength((_along(squares, 0), _along(squares, 1)))
    for square in squares:
        y, x = ((np.arange(n) + 0.5) / n for n in square.shape)
        even = float(np.mean(square)) * found.at(y[:, None], x)
        if abs(np.mean(square**2) / np.mean(even**2) - 3.0) > kurtosis:
            return None
    return found


def _worn(hm: HeightMap, kurtosis: float) -> Strength | None:
    """Strength by height, if that makes the waves random."""
    bends = [_bends(hm, axis) / hm.spacing[axis] for axis in (0, 1)]
    heights = [_lines(hm, axis)[:, 1:-1].ravel() - hm.roughness.mean for axis in (0, 1)]
    some = np.concatenate(heights)[::8]  # a quantile needs no more
    levels = np.quantile(some, np.arange(1, LEVELS) / LEVELS)
    total = np.zeros(LEVELS)
    for bend, height in zip(bends, heights, strict=True):
        square, level = np.square(bend).ravel(), np.searchsorted(levels, height)
        mean, fourth = (
            np.bincount(level, power, LEVELS) / np.maximum(np.bincount(level, minlength=LEVELS), 1)
            for power in (square, np.square(square))
        )
        if not mean.all() or np.mean(np.abs(fourth / mean**2 - 3.0)) > kurtosis:
            return None
        total += mean
    return Strength(worn=(levels, total / total.mean()))


def _lines(hm: HeightMap, axis: int) -> Array:
    """Some of the lines of a map along an axis, a periodic one with a point more at each end."""
    lines = hm.heights if axis else hm.heights.T
    lines = lines[:: max(1, lines.shape[0] // LINES)]
    if hm.periodic:
        lines = np.concatenate((lines[:, -1:], lines, lines[:, :1]), axis=1)
    return np.asarray(lines)


def _bends(hm: HeightMap, axis: int) -> Array:
    """Second differences [m] along an axis, on some of the lines of a map, shape (lines, n)."""
    return np.asarray(np.diff(_lines(hm, axis), 2, axis=1))


def _along(squares: list[Array], axis: int) -> Array:
    """Means over the parts of an axis, over their mean; those of several arrays multiplied."""
    means = np.ones(PARTS)
    for square in squares:
        lines = square.mean(axis=1 - axis)
        cuts = np.arange(1, PARTS) * lines.size // PARTS
        means *= [part.mean() for part in np.split(lines, cuts)]
    return np.asarray(np.sqrt(means) / np.sqrt(means).mean())


def resolution_warning(hm: HeightMap, waves: PixelWaves = DEFAULTS.pixel_waves) -> list[str]:
    """What a map too coarse for its roughness leaves uncertain; empty where its pixels resolve it.

    Parameters
    ----------
    hm
        Height map without missing points.
    waves
        Which waves are near the pixel.
    """
    share = fineness(hm)
    if share < waves.to_the_pixel:
        return []
    return [
        "the map is too coarse for its roughness: between one pixel and two "
        f"{100 * share:.0f} % of the squared slope is lost, so that contact area and number of "
        "spots depend on the pixel size"
    ]


def refined_map(hm: HeightMap, waves: PixelWaves = DEFAULTS.pixel_waves) -> HeightMap | str | None:
    """A map whose finest waves are near the pixel on more points, by its own spectrum.

    Parameters
    ----------
    hm
        Height map without missing points.
    waves
        Which waves are near the pixel.

    Returns
    -------
    The map on the finer grid; why it was left where a finer one would take too long; None if its
    own grid holds it.
    """
    if fineness(hm) < waves.to_the_pixel:
        return None
    for ratio, most in waves.finer:
        if ratio**2 * hm.heights.size <= most:
            return resample(hm, np.asarray(hm.spacing) / ratio)
    return "a finer one would hold the waves near its pixels better, but takes long"
