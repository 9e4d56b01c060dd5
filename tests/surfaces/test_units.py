"""Quantities with units: a number, its unit, and what is none."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from surfaces.errors import InputError
from surfaces.units import QUANTITIES, metres_per, quantities, quantity

POWERS = {
    "length": {"um": -6, "nm": -9, "mm": -3, "\N{MICRO SIGN}m": -6},
    "pressure": {"GPa": 9, "MPa": 6, "kPa": 3},
    "force": {"mN": -3, "uN": -6, "kN": 3},
    "share": {"%": -2},
}
UNITS = [(kind, unit) for kind, units in POWERS.items() for unit in units]


@given(st.floats(-1e6, 1e6), st.sampled_from(UNITS), st.sampled_from(["", " "]))
def test_a_unit_is_a_power_of_ten(number, of, space):
    """Rounded once: exactly what a plain number of that power would be."""
    kind, unit = of
    mantissa, _, power = f"{number:e}".partition("e")
    text = f"{mantissa}e{power}{space}{unit}"
    assert quantity(text, kind) == float(f"{mantissa}e{int(power) + POWERS[kind][unit]}")


@given(st.floats(allow_nan=False), st.sampled_from(list(QUANTITIES)))
def test_a_plain_number_is_itself(number, kind):
    assert quantity(repr(number), kind) == number


@pytest.mark.parametrize("kind", QUANTITIES)
def test_the_example_of_a_kind_is_one(kind):
    assert quantity(QUANTITIES[kind][1], kind) > 0


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("5um", "pressure", "um is a unit of length, and a pressure is needed, such as 210GPa"),
        ("5GPa", "length", "GPa is a unit of pressure, and a length is needed, such as 0.5um"),
        ("210mPa", "pressure", "'mPa' is no unit of a pressure; known are Pa, kPa, MPa"),
        ("3 furlong", "length", "'furlong' is no unit of a length; known are m, cm"),
        ("GPa", "pressure", "'GPa' is no pressure; write one such as 210GPa"),
        ("", "force", "'' is no force"),
        ("1e9e", "pressure", "'e' is no unit"),
        ("1_000", "length", "'_000' is no unit"),
        ("2 3nm", "length", "'2 3nm' is no length"),
        ("2 nms", "length", "'nms' is no unit of a length"),
        ("2 Mms", "length", "'Mms' is no unit of a length"),
        ("5x", "plain number", "'x' is no unit of a plain number; write one such as 0.3"),
    ],
)
def test_what_is_no_quantity(text, kind, message):
    with pytest.raises(InputError, match=message.replace("(", "\\(")):
        quantity(text, kind)


@pytest.mark.parametrize("unit", ["Micrometers", "microns", "um", "\N{GREEK SMALL LETTER MU}m"])
def test_words_may_be_plural_and_capital(unit):
    assert quantity(f"2 {unit}", "length") == 2e-6


def test_all_of_a_list_have_units_or_none():
    assert quantities(["0", "2um", "inf"], "length") == [0.0, 2e-6, math.inf]
    with pytest.raises(InputError, match="2 has no unit and others have one"):
        quantities(["2", "200MPa"], "pressure")


def test_numbers_beyond_any_exponent_are_infinite():
    assert quantity("1e99999999999999999999GPa", "pressure") == math.inf


@pytest.mark.parametrize(
    ("name", "metres"),
    [
        ("m", 1.0),
        ("mm", 1e-3),
        ("um", 1e-6),
        ("\N{MICRO SIGN}m", 1e-6),
        ("\N{GREEK SMALL LETTER MU}m", 1e-6),
        ("nm", 1e-9),
        ("\N{ANGSTROM SIGN}", 1e-10),
        ("micron", 1e-6),
        ("Micrometers", 1e-6),
        ("inch", 0.0254),
        (" mm ", 1e-3),
        ("2.5nm", 2.5e-9),
        ("1e-3 um", 1e-9),
    ],
)
def test_units(name: str, metres: float) -> None:
    assert metres_per(name) == metres


@pytest.mark.parametrize("name", ["", "parsec", "Mm", "s", "nm2", "None", "2.5", "0nm", "-1um"])
def test_unknown_units(name: str) -> None:
    with pytest.raises(InputError, match="is not a unit of length"):
        metres_per(name)
