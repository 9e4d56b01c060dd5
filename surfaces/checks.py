"""What makes a height map doubtful: units, tilt, steps at its sides, spikes, clipped or coarse
heights."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from surfaces.arrays import Array

from .heightmap import HeightMap
from .numerics.stored_array import Source, sampled_lines, windows

__all__ = [
    "constant",
    "digits_warning",
    "fine_waves_random",
    "fineness",
    "lay",
    "random_map",
    "resolution_warning",
    "seam_warning",
    "spike_warning",
    "straight_warning",
    "tilt_warning",
    "unit_warning",
]


SLOPES = 1e-6, 10.0
"""Rms slopes outside which the units may be wrong."""

ROUNDED = 1e-3
"""Least rounding of heights over their rms value that is warned of."""

SINGLE = 2.0**29
"""Rounding of numbers of single precision over that of double precision."""

SPIKE = 3.0
"""Least height of a spike above all its neighbors, in rms heights: noise reaches 2.5, a map that is
rough to the pixel 1."""

CLIFF = 3.0
"""Least rms step across the seam of a periodic map, over the largest between two lines inside, that
is warned of: random waves have 1."""

STRAIGHT = 0.4
"""Least share of the highest points in line with both neighbors for which heights seem clipped: 0.6
to 1 on plateaus, leveled or not, and on ridges; 0.2 on steps of a thirtieth of the rms height and
on the coarsest of eight measured maps."""

STRAIGHT_TO = 1e-6
"""Largest second difference of points in line, over the rms height: rounding is below it, waves of
4 000 points and shorter are above."""

EVEN_TOPS = 4
"""Most columns whose top is the highest of a random map: a summit may lie midway between points."""

LENGTH_OVER_DISTANCE = 6
"""Least length of a line over the distance of differences: few longer waves fit a line."""

KURTOSIS_ERRORS = 2.5
"""Standard errors by which the kurtosis may deviate from 3, in addition to the deviation allowed
for the finest waves. Of 1 440 random maps (Hurst exponents 0 to 1, 192 to 1536 points, with and
without roll-off and cut-off) the worst deviates by 2.2, lattices of 13 x 13 and 9 x 6 waves under
fine noise by 3 to 5, hills of lognormal heights by 40."""

HIGHEST_SHARE, SEARCHED_LINES = 0.02, 16
"""Share of the points that count as the highest; number of rows and of columns searched for them.
"""


def digits_warning(hm: HeightMap) -> list[str]:
    """Heights with an offset so large that their rounding is part of the roughness, or all of it.

    Notes
    -----
    Numbers of single precision in any unit are known by the least difference of heights in some
    rows. What rounding to single precision hides of a constant map is told from the least slope of
    a measured surface on.
    """
    found = hm.roughness
    rounding, single = math.ulp(found.largest), SINGLE * math.ulp(found.largest)
    if found.rms_height == 0.0:
        if found.largest == 0.0 or single < SLOPES[0] * min(hm.spacing):
            return []
        return [
            f"the map is constant: numbers of single precision near {found.largest:.3g} m are "
            f"{single:.2g} m apart, of double {rounding:.2g} m, and hide finer roughness: subtract "
            "the mean of the heights before they are rounded"
        ]
    least = ROUNDED * found.rms_height
    if rounding < least < 2.0 * single:
        rows = sampled_lines(hm.source, 1)
        apart = np.diff(np.unique(rows[np.isfinite(rows)]).astype(np.float64))
        apart = apart[apart > 2.0 * rounding]
        if apart.size and 0.25 * single <= apart.min() <= 2.0 * single:
            rounding = float(apart.min())
    if rounding < least:
        return []
    return [
        f"heights of {found.largest:.3g} m are rounded to {rounding:.2g} m, "
        f"{100 * rounding / found.rms_height:.2g} % of the rms height: subtract their mean before "
        "they are rounded"
    ]


def unit_warning(slope: float) -> list[str]:
    """A slope that no measured surface has: heights or pixels in another unit than stated."""
    if not (slope <= SLOPES[0] or slope >= SLOPES[1]):  # nor where it is not known, NaN
        return []
    return [f"the rms slope is {slope:.2g}: check the unit of the heights and the pixel size"]


def tilt_warning(hm: HeightMap, least: float) -> list[str]:
    """Warning of a tilt: of a plane that makes up the share `least` of the variance, or more.

    A periodic map cannot have a tilt: its sides would not meet (`seam_warning`).

    Notes
    -----
    Where points are missing, the share is that of the means of rows and columns.
    """
    variance = hm.roughness.rms_height**2
    if hm.periodic or variance == 0.0:
        return []
    share = 0.0
    for line in _line_means(hm):
        place = np.linspace(-1.0, 1.0, len(line))
        held = np.isfinite(line)
        slope = np.polyfit(place[held], line[held], 1)[0] if held.sum() > 1 else 0.0
        share += slope**2 * float(np.mean(place**2)) / variance
    if share < least:
        return []
    return [
        f"a plane makes up {100 * min(share, 1.0):.3g} % of the variance of the heights: level the "
        "map (level='plane', --level plane)"
    ]


def _line_means(hm: HeightMap) -> tuple[Array, Array]:
    """Means [m] of the points present in every row and column, NaN where none is present."""
    along: list[Array] = []
    across: Any = 0.0
    present: Any = 0
    with np.errstate(invalid="ignore"):
        for _, _, block in windows(hm.source):
            gaps = np.isnan(block)
            held = np.where(gaps, 0.0, block) if gaps.any() else block
            along.append(held.sum(1) / (block.shape[1] - gaps.sum(1)))
            across = across + held.sum(0)
            present = present + len(block) - gaps.sum(0)
        return np.concatenate(along), across / present


def fineness(hm: HeightMap) -> float:
    """Share of the squared slope that is lost when heights are taken two pixels apart, not one.

    0 for a smooth map, 0.03 for a spectrum that ends at 8 pixels, 0.09 at 4, 0.14 at 3 and 0.2 to
    0.4 at the pixel, 0.75 for noise.

    Notes
    -----
    For differences d, d' of neighboring pairs, <(d - d')^2> = 4 <d^2> - <(d + d')^2>.
    """
    found = hm.roughness
    if found.rms_slope == 0.0:
        return 0.0
    share = np.multiply(found.curvature, hm.spacing) / (2.0 * found.rms_slope)
    return float(share @ share)


def resolution_warning(hm: HeightMap, least: float) -> list[str]:
    """Warning of a map too coarse for its roughness: of a `fineness` of `least` or more."""
    share = fineness(hm)
    if share < least:
        return []
    return [
        "the map is too coarse for its roughness: between one pixel and two "
        f"{100 * share:.0f} % of the squared slope is lost, so that contact area and number of "
        "spots depend on the pixel size; measure on a finer grid, or take the finest waves out "
        "(bandpass=, --bandpass)"
    ]


def spike_warning(hm: HeightMap) -> list[str]:
    """Warning of a highest point that stands far above all its neighbors."""
    rms = hm.roughness.rms_height
    around = np.arange(-1, 2)
    places = (
        np.unique((at + around) % n if hm.periodic else np.clip(at + around, 0, n - 1))
        for at, n in zip(hm.roughness.summit, hm.shape, strict=True)
    )
    second, first = np.partition(hm.source[np.ix_(*places)], -2, axis=None)[-2:]
    above = float(first - second)
    if not above > SPIKE * rms:
        return []
    return [
        f"the highest point stands {above / rms:.0f} rms heights above its neighbors and holds up "
        "the flat: if it is a spike, take it out (outliers=8, --outliers 8)"
    ]


def constant(hm: HeightMap) -> bool:
    """Whether all heights are equal; reads up to the first that differs."""
    first = hm.source[:1, :1]
    return not any((rows != first).any() for _, _, rows in windows(hm.source))


def seam_warning(hm: HeightMap) -> list[str]:
    """Warning of a periodic map whose sides do not meet.

    Notes
    -----
    The rms step across the seam is compared with the largest between two lines inside, which a
    grating has, too.
    """
    if not hm.periodic:
        return []
    worst = 0.0
    for axis, (slope, width) in enumerate(zip(hm.roughness.slope, hm.spacing, strict=True)):
        first, last = (hm.source[(slice(None),) * axis + (at,)] for at in (0, -1))
        seam = float(np.sqrt(np.mean((first - last) ** 2)))
        if seam > CLIFF * slope * width > 0.0:
            inside = _steps(hm)[axis]
            worst = max(worst, seam / float(np.sqrt(inside.max())))
    if worst < CLIFF:
        return []
    return [
        f"the sides of the map do not meet: the step across its seam is {worst:.0f} times the "
        "largest inside; make it periodic (--periodic taper or mirror), or take it as free"
    ]


def _steps(hm: HeightMap) -> tuple[Array, Array]:
    """Mean squares [m^2] of the steps between neighboring rows, and between columns."""
    rows, columns = [], np.zeros(hm.shape[1] - 1)
    for begin, end, window in windows(hm.source, below=1):
        held = window[: min(end + 1, hm.shape[0]) - begin]
        rows.append(np.mean(np.diff(held, axis=0) ** 2, axis=1))
        columns += np.sum(np.diff(held[: end - begin], axis=1) ** 2, axis=0)
    return np.concatenate(rows), columns / hm.shape[0]


def straight_warning(hm: HeightMap) -> list[str]:
    """Highest points in line with their neighbors; empty where few are."""
    heights, straight = hm.source, STRAIGHT_TO * hm.roughness.rms_height
    step = -(-len(heights) // SEARCHED_LINES)
    above, line, below = (heights[at : len(heights) - 2 + at : step] for at in range(3))
    top = line >= np.quantile(line, 1.0 - HIGHEST_SHARE)
    across = (above - 2.0 * line + below)[top]
    along = (line[:, 2:] - 2.0 * line[:, 1:-1] + line[:, :-2])[top[:, 1:-1]]
    share = max(float(np.mean(np.abs(bend) <= straight)) for bend in (along, across) if bend.size)
    if share < STRAIGHT:
        return []
    return [
        f"{100 * share:.0f} % of the highest points lie in line with their neighbors (clipped or "
        "stepped heights, ridges): contact begins on all of them at once, which no law of a summit "
        "describes"
    ]


def lay(hm: HeightMap) -> float:
    """Root-mean-square slope across the lay over that along it, by central differences on lines."""
    step = max(1, hm.shape[0] // (2 * SEARCHED_LINES))
    above, line, below = (hm.source[at : hm.shape[0] - 2 + at : step] for at in range(3))
    dy, dx = hm.spacing
    y, x = (below - above)[:, 1:-1].ravel() / dy, (line[:, 2:] - line[:, :-2]).ravel() / dx
    middle = 0.5 * float(np.mean(y * y) + np.mean(x * x))
    apart = float(np.hypot(0.5 * (np.mean(y * y) - np.mean(x * x)), np.mean(y * x)))
    return float(np.sqrt((middle + apart) / (middle - apart))) if middle > apart else np.inf


def fine_waves_random(hm: HeightMap, allowed: float) -> bool:
    """Whether the finest waves of a map are random: not with spikes, steps, worn plateaus, borders
    that fade, tops of one height.

    Notes
    -----
    Second differences of random waves have a kurtosis of 3, within what is `allowed`; few of the
    highest points are in line (`straight_warning`), and hardly any as high as the highest one.
    """
    found = hm.roughness
    even = np.count_nonzero(found.tops >= found.highest - STRAIGHT_TO * found.rms_height)
    random = all(abs(kurtosis - 3.0) <= allowed for kurtosis in found.kurtosis)
    return random and bool(even <= EVEN_TOPS) and not straight_warning(hm)


def random_map(hm: HeightMap, allowed: float) -> bool:
    """Whether the waves of a map of every length are random: few loads and parts tell of all then.

    No point may be missing; `allowed` is as in `fine_waves_random`.

    Notes
    -----
    Noise on a lattice has the second differences of noise between neighbors, and those of the
    lattice over its own lengths: the kurtosis, 3 for random waves, is therefore looked at over 1,
    2, 4, ... pixels. Its standard error is sqrt(24 / n) of n independent values, of which there are
    about as many as differences change sign, along the lines and across.
    """
    return fine_waves_random(hm, allowed) and all(
        abs(kurtosis - 3.0) <= allowed + KURTOSIS_ERRORS * math.sqrt(24.0 / count)
        for axis in (0, 1)
        for kurtosis, count in _kurtosis(hm.source, axis, hm.periodic)
    )


def _kurtosis(heights: Source, axis: int, periodic: bool) -> Iterator[tuple[float, float]]:
    """Kurtosis of the second differences of some lines along an axis, over ever longer distances,
    and the number of independent ones; of distances over which anything changes."""
    lines = sampled_lines(heights, axis)
    count, distance = lines.shape[1], 1
    while distance <= count // LENGTH_OVER_DISTANCE:
        bend = _bend(lines, distance, periodic)
        up = bend > 0.0
        bend *= bend
        square = float(np.mean(bend))
        if square > 0.0:
            along = count * np.mean(up[:, 1:] != up[:, :-1])
            across = len(lines) * np.mean(up[1:] != up[:-1])
            yield (
                float(np.mean(np.square(bend, out=bend))) / square**2,
                max(along, 1.0) * max(across, 1.0),
            )
        distance *= 2


def _bend(lines: Array, distance: int, periodic: bool) -> Array:
    """Second differences of lines over a distance in pixels."""
    if periodic:
        return np.roll(lines, distance, 1) + np.roll(lines, -distance, 1) - 2.0 * lines
    return lines[:, 2 * distance :] + lines[:, : -2 * distance] - 2.0 * lines[:, distance:-distance]
