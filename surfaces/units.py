"""Units of length and their conversion to metres."""

from __future__ import annotations

import math

from .errors import InputError

__all__ = ["METRES", "digits_warning", "metres_per", "unit_warning"]

_SLOPES = (1e-6, 10.0)  # rms slopes outside which the units may be wrong
_ROUNDED = 1e-3  # rounding of heights over their rms value from which on it is warned of

METRES = {
    "m": 1.0,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "nm": 1e-9,
    "pm": 1e-12,
    "angstrom": 1e-10,
    "inch": 0.0254,
    "mil": 0.0254e-3,
}
"""Metres in one unit, by the unit's plain name."""

_ALIASES = {
    "meter": "m",
    "metre": "m",
    "millimeter": "mm",
    "millimetre": "mm",
    "micron": "um",
    "micrometer": "um",
    "micrometre": "um",
    "\N{MICRO SIGN}m": "um",
    "\N{GREEK SMALL LETTER MU}m": "um",
    "nanometer": "nm",
    "nanometre": "nm",
    "\N{LATIN CAPITAL LETTER A WITH RING ABOVE}": "angstrom",
    "\N{ANGSTROM SIGN}": "angstrom",
    "A": "angstrom",
    "in": "inch",
}


def metres_per(unit: str) -> float:
    """Length of one `unit` in metres.

    Parameters
    ----------
    unit
        Name of a length unit, such as m, mm, um, nm; case matters (mm is not Mm).

    Raises
    ------
    InputError
        If the name is not a known unit of length.
    """
    name = unit.strip()
    name = _ALIASES.get(name, name)
    if name not in METRES and len(name) > 2:
        plain = name.lower().removesuffix("s")
        name = _ALIASES.get(plain, plain)
    if name not in METRES:
        raise InputError(f"{unit[:30]!r} is not a unit of length; known are {', '.join(METRES)}")
    return METRES[name]


def digits_warning(largest: float, rms_height: float) -> list[str]:
    """Heights [m] with an offset so large that their rounding is part of the roughness."""
    rounding = math.ulp(largest)
    if not 0.0 < rms_height < rounding / _ROUNDED:
        return []
    return [
        f"heights of {largest:.3g} m are rounded to {rounding:.2g} m, "
        f"{100 * rounding / rms_height:.2g} % of the rms height: subtract their mean before they "
        "are rounded"
    ]


def unit_warning(slope: float) -> list[str]:
    """A slope that no measured surface has: heights or pixels in another unit than stated."""
    if _SLOPES[0] < slope < _SLOPES[1]:
        return []
    return [f"the rms slope is {slope:.2g}: check the unit of the heights and the pixel size"]
