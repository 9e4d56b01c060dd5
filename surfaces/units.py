"""Units of length and their conversion to metres."""

from __future__ import annotations

import math
import re
from pathlib import Path

from .errors import FileFormatError, InputError

__all__ = ["METRES", "chosen_unit", "metres_per"]

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

_QUANTITY = re.compile(r"(\d*\.?\d+(?:[eE][+-]?\d+)?|)\s*(.*)", re.DOTALL)
"""A number, if there is one, and a name."""


def chosen_unit(path: Path, stated: str | None, given: str | None) -> str:
    """The unit of the heights of a file: as it states, or as the caller says where it does not.

    Raises
    ------
    FileFormatError
        If neither says one, or they differ.
    """
    if not (stated or given):
        raise FileFormatError(f"{path}: states no unit; pass --unit (unit=...), such as --unit um")
    if stated and given and metres_per(stated) != metres_per(given):
        raise FileFormatError(f"{path}: states unit {stated!r}; leave out --unit {given}")
    return stated or str(given)


def metres_per(unit: str) -> float:
    """Length of one `unit` in metres.

    Parameters
    ----------
    unit
        Name of a length unit, such as m, mm, um, nm; case matters (mm is not Mm). A number may
        stand before it: 2.5nm.

    Raises
    ------
    InputError
        If the name is not a known unit of length.
    """
    number, name = _QUANTITY.findall(unit.strip())[0]
    name = _ALIASES.get(name, name)
    if name not in METRES and len(name) > 2:
        plain = name.lower().removesuffix("s")
        name = _ALIASES.get(plain, plain)
    factor = float(number or 1.0)
    if name not in METRES or not 0.0 < factor < math.inf:
        raise InputError(f"{unit[:30]!r} is not a unit of length; known are {', '.join(METRES)}")
    return factor * METRES[name]
