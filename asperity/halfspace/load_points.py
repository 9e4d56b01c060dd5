"""Boundary and load points of a curve, checked or by default; scales of pressure and slope."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import InputError
from surfaces.arrays import Array
from surfaces.errors import as_choice, as_number, as_numbers, shown
from surfaces.heightmap import HeightMap, require_map

from .material import HalfSpace, require_half_space

__all__ = [
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
    "known_boundary",
    "map_facts",
    "pressure_scale",
    "require_scene",
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
