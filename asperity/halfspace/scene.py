"""The scene of a run: map, body, boundary and load points. Defaults, scales, checks, and reasons to
doubt any solution of a contact, or the laws of summits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import InputError
from asperity.parameters import DEFAULTS
from surfaces.arrays import Array
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
from surfaces.errors import as_choice, as_number, as_numbers, shown
from surfaces.heightmap import HeightMap, require_map

from .material import HalfSpace, require_half_space

__all__ = [
    "COARSE",
    "MOST_LOADS",
    "Boundary",
    "area_over_pressure",
    "as_pressed",
    "checked_load",
    "checked_loads",
    "chosen_boundary",
    "closed_share",
    "default_pressures",
    "expected_area_fraction",
    "hardness_needed",
    "known_boundary",
    "map_facts",
    "model_warnings",
    "modulus_warning",
    "pressure_scale",
    "require_scene",
    "scene_warnings",
    "slope_scale",
]


Boundary = Literal["periodic", "free"]

AREA_OVER_LOAD = 2.0
"""Contact area fraction over p/(E* h') at light load (about 2 for random roughness: Hyun, Pei,
Molinari & Robbins 2004; Putignano, Afferrante, Carbone & Demelio 2012)."""

_LARGEST_LOAD = 1e40
"""Largest load point [Pa or m], and inverse of the smallest: their squares do not overflow."""

MOST_LOADS = 10_000
"""Most load points of a curve; values between so many can be interpolated."""

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


def chosen_boundary(hm: HeightMap, asked: str | None) -> Boundary:
    """The boundary asked for, or the one that the map states."""
    return known_boundary(("periodic" if hm.periodic else "free") if asked is None else asked)


def as_pressed(hm: HeightMap, boundary: Boundary) -> HeightMap:
    """The map, periodic if it is pressed as a periodic cell."""
    cell = boundary == "periodic"
    return hm if hm.periodic == cell else hm.replace(periodic=cell)


def known_boundary(name: str) -> Boundary:
    """The name, if it is that of a boundary; else refused."""
    return cast(Boundary, as_choice("boundary", name, get_args(Boundary)))


def require_scene(hm: object, material: object) -> None:
    """Refuse a map that is no `HeightMap`, or a material that is no `HalfSpace`."""
    require_map(hm)
    require_half_space(material)


def slope_scale(hm: HeightMap) -> tuple[float, float]:
    """Rms slope [-], and the length [m] over which it turns (`Roughness.length`)."""
    found = hm.roughness
    return found.rms_slope, min(found.length, max(hm.size))


def map_facts(hm: HeightMap) -> dict[str, Any]:
    """Facts about the map that a result stores: name, shape, spacing [m], whether it is periodic,
    rms height [m] and rms slope [-]."""
    found = hm.roughness
    return {
        "name": hm.name,
        "shape": list(hm.shape),
        "spacing": list(hm.spacing),
        "periodic": hm.periodic,
        "rms_height": found.rms_height,
        "rms_slope": found.rms_slope,
    }


def pressure_scale(hm: HeightMap, material: HalfSpace) -> float:
    """Pressure E* h' [Pa] that flattens the roughness.

    A graded half-space responds to a wave of number q like a homogeneous one of modulus ~ E_m* q^-m
    (docs/development/half_space.md): E* is taken at the length l of `slope_scale`, E_m* l^m.
    """
    slope, length = slope_scale(hm)
    return float(material.modulus * length**material.m * slope)


def default_pressures(hm: HeightMap, material: HalfSpace, count: int = 10) -> Array:
    """Mean pressures [Pa] in geometric progression, for about 0.1 % to 10 % of contact, below the
    hardness. A map without slope is refused."""
    if pressure_scale(hm, material) == 0.0:
        raise InputError("the rms slope of the map gives no scale of pressure; name the loads")
    low, high = np.array([1e-3, 1e-1]) / area_over_pressure(hm, material)
    return np.geomspace(low, high, count)


def area_over_pressure(hm: HeightMap, material: HalfSpace) -> float:
    """Forecast of the contact area fraction over the mean pressure [1/Pa] at light load.

    Notes
    -----
    The contact area of elastic random roughness, 2 p/(E* h'), and that at the hardness, p/H, of
    which the cubes add up (within 8 % of boundary elements for H/(E* h') of 0.05 to 1).
    """
    elastic = AREA_OVER_LOAD / pressure_scale(hm, material)
    return float(np.cbrt(elastic**3 + material.hardness**-3))


def expected_area_fraction(hm: HeightMap, material: HalfSpace, pressure: float) -> float:
    """Forecast of the area fraction at a mean pressure [Pa], at most 1: that of light loads
    (`area_over_pressure`), extrapolated to this pressure; at least p/H."""
    if pressure_scale(hm, material) == 0.0:
        return 1.0
    light = area_over_pressure(hm, material) * pressure
    return max(closed_share(light / AREA_OVER_LOAD), min(pressure / material.hardness, 1.0))


def closed_share(pressure: float) -> float:
    """Forecast of the area fraction of elastic random roughness at a mean pressure over E* h':
    erf(sqrt(pi)/2 x), where x is that by the proportionality of light loads (Persson 2001)."""
    return math.erf(0.5 * math.sqrt(math.pi) * AREA_OVER_LOAD * pressure)


def checked_load(
    pressure: object, separation: object, hardness: float = math.inf
) -> tuple[str, float]:
    """Kind ("pressure" or "separation") and value of the one load point that is given.

    Both, neither or several are refused, values that are not finite, negative pressures, and those
    above a hardness [Pa].
    """
    if (pressure is None) == (separation is None):
        raise InputError("give exactly one of pressure and separation")
    kind, given = ("pressure", pressure) if separation is None else ("separation", separation)
    if isinstance(given, Sequence | np.ndarray) and not isinstance(given, str):
        raise InputError(
            f"{kind} is {shown(given)}; give one number, or all of them to bem_curve or "
            "contact_curve"
        )
    value = as_number(kind, given)
    if not math.isfinite(value):
        what = "mean pressure" if kind == "pressure" else "distance"
        raise InputError(f"{kind} is {given!r}; give a finite {what}")
    _require_calculable(kind, np.array([value]), hardness)
    return kind, value


def _require_calculable(kind: str, values: Array, hardness: float) -> None:
    """Refuse mean pressures [Pa] of which the largest is above the hardness, or one is negative,
    and load points [Pa or m] whose squares overflow."""
    if kind == "pressure":
        least, largest = values.min(), values.max()
        if largest > hardness:
            raise InputError(
                f"mean pressure {largest:.4g} Pa is above the hardness of {hardness:.4g} Pa, which "
                "no surface carries; take a smaller load or a larger hardness"
            )
        if least < 0.0:
            raise InputError(f"mean pressure {least:.4g} Pa is negative; compression is positive")
    strange = (abs(values) > _LARGEST_LOAD) | ((abs(values) < 1 / _LARGEST_LOAD) & (values != 0))
    if strange.any():
        unit = "Pa" if kind == "pressure" else "m"
        raise InputError(
            f"the {kind} {values[strange][0]:.4g} {unit} is beyond what can be calculated "
            f"({1 / _LARGEST_LOAD:g} to {_LARGEST_LOAD:g} {unit}, or zero)"
        )


def checked_loads(
    hm: HeightMap,
    material: HalfSpace,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
) -> tuple[str, Array]:
    """Kind ("pressure" or "separation") and values of the load points, by default those of
    `default_pressures`. Values that are not finite, negative pressures and the like are refused."""
    require_scene(hm, material)
    if pressures is not None and separations is not None:
        raise InputError("give either pressures or separations, not both")
    kind, chosen = "pressure", pressures
    if separations is not None:
        kind, chosen = "separation", separations
    elif pressures is None:
        chosen = default_pressures(hm, material)
    values = as_numbers(f"{kind}s", chosen).ravel()
    if not values.size:
        raise InputError(f"{kind}s is empty; give at least one load point")
    if values.size > MOST_LOADS:
        raise InputError(f"{kind}s holds {values.size} load points; give at most {MOST_LOADS}")
    _require_calculable(kind, values, material.hardness)
    return kind, values


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
