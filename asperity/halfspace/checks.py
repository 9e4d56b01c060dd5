"""Map checks before a run: reasons to doubt any solution of a contact, or the laws of summits."""

from __future__ import annotations

import math

from asperity.parameters import DEFAULTS
from surfaces.checks import (
    digits_warning,
    lay,
    resolution_warning,
    seam_warning,
    spike_warning,
    straight_warning,
    tilt_warning,
    unit_warning,
)
from surfaces.heightmap import HeightMap

from .load_points import AREA_OVER_LOAD, pressure_scale, slope_scale
from .material import HalfSpace

__all__ = ["COARSE", "hardness_needed", "model_warnings", "modulus_warning", "scene_warnings"]

COARSE = DEFAULTS.pixel_waves.to_the_pixel
"""Least `fineness` [-] of a map that is called too coarse, by every engine and for every plan."""

STEEP_SLOPE = 0.5
"""Rms slope above which elasticity for small slopes is doubtful."""

METAL_MODULI = 1e10, 1e12
"""Moduli E* [Pa] between which a body may be a metal."""

HARDEST_METAL = 0.035
"""Largest hardness over E* of a metal, that of hardened steel of 8 GPa."""

SOFTEST_SOLID = 1e3
"""Least modulus [Pa] of a solid; a soft gel has more."""

TILTED_SHARE = 0.9
"""Least share of a plane in the variance of the heights that counts as a tilt: parts of rough
surfaces without a longest wave have up to 0.82."""


def scene_warnings(hm: HeightMap, material: HalfSpace) -> list[str]:
    """One sentence for each reason why any answer about a contact may be wrong."""
    found = hm.roughness
    if found.rms_height == 0.0:
        return [*digits_warning(hm), *modulus_warning(material)]
    return [
        *digits_warning(hm),
        *unit_warning(found.rms_slope),
        *modulus_warning(material),
        *_steep_warning(found.rms_slope),
        *tilt_warning(hm, TILTED_SHARE),
        *resolution_warning(hm, COARSE),
        *spike_warning(hm),
        *seam_warning(hm),
        *hardness_needed(hm, material)[1],
    ]


def model_warnings(hm: HeightMap, longest_lay: float) -> list[str]:
    """One sentence for each reason why no law of a summit describes the contacts of a map: slopes
    across over those along a lay from `longest_lay` on are one."""
    return [*straight_warning(hm), *_lay_warning(lay(hm), longest_lay)]


def modulus_warning(material: HalfSpace) -> list[str]:
    """A modulus that seems to be given in GPa; empty for one that a solid may have.

    A modulus of one is the unit of dimensionless work.
    """
    if material.m != 0.0 or material.modulus >= SOFTEST_SOLID or material.modulus == 1.0:
        return []
    return [
        f"a modulus E* of {material.modulus:.3g} Pa is that of no solid: moduli are in Pa "
        "(210e9, or 210GPa on the command line)"
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
    metal = material.m == 0.0 and METAL_MODULI[0] < material.modulus < METAL_MODULI[1]
    doubt = (
        f"{told}: metals yield at 0.3 to 3 % of it, and then touch on more area; give the hardness "
        "of the softer body (hardness=, --hardness) if it is one"
    )
    return f"hardness: none, {told}", [doubt] if metal and share > HARDEST_METAL else []


def _steep_warning(slope: float) -> list[str]:
    if slope < STEEP_SLOPE:
        return []
    return [
        f"the rms slope is {slope:.2g}: linear elasticity is of small slopes, and the answer is "
        "that of its equations, not of a body so steep"
    ]


def _lay_warning(ratio: float, longest: float) -> list[str]:
    if ratio < longest:
        return []
    return [
        f"slopes across the lay are {ratio:.0f} times those along it: the microcontact model is "
        "doubtful on such ridges, and its error is not estimated; use boundary elements"
    ]
