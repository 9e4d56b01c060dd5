"""Units of lengths, and of the quantities that a user types, and their conversion to SI."""

from __future__ import annotations

import math
import re
from decimal import Decimal, DecimalException

from .errors import InputError, shown

__all__ = ["METRES", "QUANTITIES", "chosen_unit", "metres_per", "quantities", "quantity"]

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


QUANTITIES = {
    "length": (METRES, "0.5um"),
    "pressure": (
        {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12}
        | {"bar": 1e5, "psi": 6894.757293168361, "N/mm2": 1e6},
        "210GPa",
    ),
    "force": (
        {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "uN": 1e-6, "nN": 1e-9, "pN": 1e-12}
        | {"lbf": 4.4482216152605, "kgf": 9.80665},
        "5mN",
    ),
    "share": ({"%": 0.01}, "5%"),
    "percentage": ({"%": 1.0}, "5%"),
    "angle": ({"deg": 1.0, "rad": 57.29577951308232}, "30deg"),
    "memory": (
        {"B": 1.0, "kB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12}
        | {"KiB": 2.0**10, "MiB": 2.0**20, "GiB": 2.0**30, "TiB": 2.0**40},
        "2GiB",
    ),
    "plain number": ({}, "0.3"),
}
"""Units of each kind of quantity, in that of a plain number (SI; degrees for an angle, bytes
for memory), and an example. Length units have more spellings (`metres_per`)."""

_WRITTEN = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:inf|nan))\s*([^\d\s].*?)?\s*", re.DOTALL
)


def quantity(text: str, kind: str) -> float:
    """Number of a text such as ``210GPa``, ``0.5 um`` or ``2e-6``; without unit it is in SI.

    Parameters
    ----------
    text
        A number, and perhaps a unit; case matters (mPa is not MPa).
    kind
        Key of `QUANTITIES`.

    Raises
    ------
    InputError
        If the text is no number, or its unit is unknown or of another kind.

    Examples
    --------
    >>> from surfaces.units import quantity
    >>> quantity("210GPa", "pressure"), quantity("0.5um", "length"), quantity("5%", "share")
    (210000000000.0, 5e-07, 0.05)
    """
    return quantities([text], kind)[0]


def quantities(texts: list[str], kind: str) -> list[float]:
    """Numbers of several texts of one kind, of which all have a unit or none.

    Raises
    ------
    InputError
        As `quantity`; and if some have a unit and others, not being 0 or infinite, have none.
    """
    found = [_WRITTEN.fullmatch(text) for text in texts]
    example = QUANTITIES[kind][1]
    for text, parts in zip(texts, found, strict=True):
        if parts is None:
            raise InputError(f"{text[:30]!r} is no {kind}; write one such as {example}")
    pairs = [(parts[1], parts[2] or "") for parts in found if parts is not None]
    exempt = 0.0, math.inf, -math.inf
    bare = [number for number, unit in pairs if not unit and float(number) not in exempt]
    if bare and any(unit for _, unit in pairs):
        raise InputError(f"{bare[0]} has no unit and others have one; write one with each number")
    return [_scaled(number, unit, kind) if unit else float(number) for number, unit in pairs]


def _scaled(number: str, unit: str, kind: str) -> float:
    """A number times its unit, rounded once: 0.3um is 3e-7."""
    factor = _factor(unit, kind)
    if factor is not None:
        try:
            return float(Decimal(number) * Decimal(str(factor)))
        except DecimalException:  # beyond any exponent
            return float(number) * factor
    known, example = QUANTITIES[kind]
    other = next((name for name in QUANTITIES if _factor(unit, name) is not None), None)
    if other is not None:
        raise InputError(f"{unit} is a unit of {other}, and a {kind} is needed, such as {example}")
    known_ones = f"; known are {', '.join(known)}" if known else f"; write one such as {example}"
    raise InputError(f"{unit[:30]!r} is no unit of a {kind}{known_ones}")


def _factor(unit: str, kind: str) -> float | None:
    """What a unit is worth, or None if it is not of this kind."""
    if kind == "length":
        try:
            return metres_per(unit)
        except InputError:
            return None
    plain = unit.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")
    return QUANTITIES[kind][0].get(plain)


def chosen_unit(stated: str | None, given: str | None) -> str:
    """The unit of the heights of a file: as it states, or as the caller says where it does not;
    refused if neither says one, or they differ."""
    unit = stated or given if isinstance(stated, str | None) else stated  # refused below
    if isinstance(unit, str | None) and not unit:
        raise InputError("states no unit; pass --unit (unit=...), such as --unit um")
    if metres_per(unit) != metres_per(given or unit):
        raise InputError(f"states unit {shown(stated)}; leave out --unit {given}")
    return unit


def metres_per(unit: str) -> float:
    """Length in metres of one unit, such as m, mm, um, nm; case matters (mm is not Mm).

    A number may stand before its name: 2.5nm.

    Raises
    ------
    InputError
        If the name is not a known unit of length.
    """
    number, name = _QUANTITY.findall(unit.strip())[0] if isinstance(unit, str) else ("", "")
    name = _ALIASES.get(name, name)
    plain = name.lower().removesuffix("s")
    if name not in METRES and len(plain) > 2:  # a word, not a symbol, of which the case matters
        name = _ALIASES.get(plain, plain)
    factor = float(number or 1.0)
    if name not in METRES or not 0.0 < factor < math.inf:
        raise InputError(f"{shown(unit)} is not a unit of length; known are {', '.join(METRES)}")
    return factor * METRES[name]
