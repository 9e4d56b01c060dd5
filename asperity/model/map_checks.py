"""What makes an answer about a map doubtful, known before anything runs."""

from __future__ import annotations

import math

import numpy as np

from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import AREA_OVER_LOAD, pressure_scale, slope_scale
from asperity.multiscale.wave_split import resolution_warning
from asperity.parameters import DEFAULTS
from surfaces.heightmap import HeightMap
from surfaces.roughness import unit_warning

__all__ = ["hardness_needed", "lay", "map_warnings", "seam_warning", "straight_warning"]

SPIKE = 3.0
"""Height of a point above all its neighbors, in rms heights, from which on it is called a spike:
noise reaches 2.5, a map to the pixel 1."""

STEEP = 0.5
"""Rms slope from which on small-slope elasticity is warned of."""

CLIFF = 3.0
"""Rms step across the seam of a periodic map over the largest between two lines inside from which
on it is told: random waves have 1."""

LONG_LAY = 7.0
"""Slopes across over those along a lay from which on ridges are warned of."""

STRAIGHT = 0.4
"""Share of the highest points in line with both neighbors from which on heights seem clipped: 0.6
to 1 of plateaus, leveled or not, and of ridges; 0.2 of steps of a thirtieth of the rms height and
of the coarsest of eight measured maps."""

STRAIGHT_TO = 1e-6
"""Second difference of heights over the rms height up to which points are in line: noise of
rounding is below it, waves of 4 000 points and shorter are above."""

METALS = 1e10, 1e12
"""Moduli E* [Pa] between which a body may be a metal."""

HARDEST = 0.035
"""Hardness over E* that hardly a metal exceeds: 8 GPa of hardened steel."""

HIGHEST, LINES = 0.02, 16
"""Share of the points that count as the highest, and rows and columns on which they are sought."""


def map_warnings(
    hm: HeightMap, longest_lay: float = DEFAULTS.error_estimate.longest_lay
) -> list[str]:
    """One sentence for each reason why any model of a map may be wrong, but lost digits, which
    every solver tells.

    Parameters
    ----------
    hm
        Height map without missing points.
    longest_lay
        Slopes across over those along a lay from which on no errors are estimated.
    """
    return [
        *unit_warning(hm.roughness.rms_slope),
        *_steep_warning(hm.roughness.rms_slope),
        *resolution_warning(hm),
        *_spike_warning(hm),
        *seam_warning(hm),
        *straight_warning(hm),
        *_lay_warning(lay(hm), longest_lay),
    ]


def hardness_needed(hm: HeightMap, material: HalfSpace) -> tuple[str, list[str]]:
    """What a hardness, given or not, means for the contacts of a map, in one line; and a warning
    where metals would not carry what elastic contacts do."""
    slope, _ = slope_scale(hm)
    if slope == 0.0:
        return "hardness: of no concern, the map has no slope", []
    mean = pressure_scale(hm, material) / AREA_OVER_LOAD
    if material.hardness < math.inf:
        over = mean / material.hardness
        return (
            f"hardness: {material.hardness:.3g} Pa, elastic contacts would carry {over:.2g} of it",
            [],
        )
    share = slope / AREA_OVER_LOAD
    told = f"elastic contacts carry about {mean:.2g} Pa, {100 * share:.2g} % of the modulus"
    metal = material.m == 0.0 and METALS[0] < material.modulus < METALS[1]
    if not (metal and share > HARDEST):
        return f"hardness: none, {told}", []
    told += (
        ": metals yield at 0.3 to 3 % of it, and then touch on more area; give the hardness of the "
        "softer body (hardness=, --hardness) if it is one"
    )
    return f"hardness: none, {told}", [told]


def lay(hm: HeightMap) -> float:
    """Root-mean-square slope across the lay over that along it, by central differences on lines."""
    step = max(1, hm.shape[0] // (2 * LINES))
    above, line, below = (hm.heights[at : hm.shape[0] - 2 + at : step] for at in range(3))
    dy, dx = hm.spacing
    y, x = (below - above)[:, 1:-1].ravel() / dy, (line[:, 2:] - line[:, :-2]).ravel() / dx
    middle = 0.5 * float(np.mean(y * y) + np.mean(x * x))
    apart = float(np.hypot(0.5 * (np.mean(y * y) - np.mean(x * x)), np.mean(y * x)))
    return float(np.sqrt((middle + apart) / (middle - apart))) if middle > apart else np.inf


def _steep_warning(slope: float) -> list[str]:
    if slope < STEEP:
        return []
    return [
        f"the rms slope is {slope:.2g}: linear elasticity is of small slopes, and the answer is "
        "that of its equations, not of a body so steep"
    ]


def seam_warning(hm: HeightMap) -> list[str]:
    """A cliff where the sides of a periodic map do not meet; empty without one.

    Notes
    -----
    The rms step across the seam is compared with the largest between two lines inside, which a
    grating has, too.
    """
    if not hm.periodic:
        return []
    worst = 0.0
    for axis, (slope, width) in enumerate(zip(hm.roughness.slope, hm.spacing, strict=True)):
        lines = hm.heights if axis == 0 else hm.heights.T
        seam = float(np.sqrt(np.mean((lines[0] - lines[-1]) ** 2)))
        if seam > CLIFF * slope * width > 0.0:
            inside = np.mean(np.diff(hm.heights, axis=axis) ** 2, axis=1 - axis)
            worst = max(worst, seam / float(np.sqrt(inside.max())))
    if worst < CLIFF:
        return []
    return [
        f"the sides of the map do not meet: the step across its seam is {worst:.0f} times the "
        "largest inside; make it periodic (--periodic taper or mirror), or take it as free"
    ]


def _spike_warning(hm: HeightMap) -> list[str]:
    heights, rms = hm.heights, hm.roughness.rms_height
    band, col = np.unravel_index(int(np.argmax(hm.roughness.tops)), hm.roughness.tops.shape)
    row = hm.roughness.rows[band, col]
    around = np.arange(-1, 2)
    places = (
        np.unique((at + around) % n if hm.periodic else np.clip(at + around, 0, n - 1))
        for at, n in zip((row, col), hm.shape, strict=True)
    )
    second, first = np.partition(heights[np.ix_(*places)], -2, axis=None)[-2:]
    above = float(first - second)
    if not above > SPIKE * rms:
        return []
    return [
        f"the highest point stands {above / rms:.0f} rms heights above its neighbors and holds up "
        "the flat: if it is a spike, take it out (outliers=8, --outliers 8)"
    ]


def straight_warning(hm: HeightMap) -> list[str]:
    """Highest points in line with their neighbors; empty where few are."""
    heights, straight = hm.heights, STRAIGHT_TO * hm.roughness.rms_height
    step = -(-len(heights) // LINES)
    above, line, below = (heights[at : len(heights) - 2 + at : step] for at in range(3))
    top = line >= np.quantile(line, 1.0 - HIGHEST)
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


def _lay_warning(ratio: float, longest: float) -> list[str]:
    if ratio < LONG_LAY:
        return []
    estimate = ", and its error is not estimated" if ratio >= longest else ""
    return [
        f"slopes across the lay are {ratio:.0f} times those along it: the microcontact model is "
        f"doubtful on such ridges{estimate}; use boundary elements"
    ]
