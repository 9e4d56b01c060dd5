"""Units of length and their conversion to metres; quantities as a reader likes them."""

from __future__ import annotations

import math
from pathlib import Path

from .errors import FileFormatError, InputError

__all__ = ["METRES", "chosen_unit", "metres_per", "suited", "told"]

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


_PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


def suited(largest: float, unit: str, power: int = 1) -> tuple[float, str]:
    """SI units in the unit with the prefix that suits a quantity, and its name.

    Parameters
    ----------
    largest
        Largest magnitude of the quantity, in the SI unit to its power.
    unit
        Symbol of the SI unit.
    power
        2 for an area, 3 for a volume.

    Examples
    --------
    >>> from surfaces.units import suited
    >>> suited(3.2e-6, "m"), suited(5e7, "Pa"), suited(4e-11, "m", 2)
    ((1e-06, 'µm'), (1000000.0, 'MPa'), (1e-12, 'µm²'))
    """
    usable = math.isfinite(largest) and largest != 0.0
    exponent = 3 * math.floor(math.log10(abs(largest)) / (3 * power) + 1e-9) if usable else 0
    exponent = min(max(exponent, min(_PREFIXES)), 0 if unit == "m" else max(_PREFIXES))
    return 10.0 ** (exponent * power), _PREFIXES[exponent] + unit + {2: "²", 3: "³"}.get(power, "")


def told(value: float, unit: str, power: int = 1, digits: int = 3) -> str:
    """A quantity with the prefix that suits it; a dash where it is no number.

    Examples
    --------
    >>> from surfaces.units import told
    >>> told(5.04e7, "Pa"), told(2.2e-6, "m"), told(float("nan"), "Pa")
    ('50.4 MPa', '2.2 µm', '–')
    """
    if not math.isfinite(value):
        return "–"
    rounded = float(f"{value:.{digits}g}")
    factor, name = suited(rounded, unit, power)
    return f"{rounded / factor:.{digits}g} {name}"
