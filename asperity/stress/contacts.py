"""Stress cases of one contact: laws and boundary elements against closed forms."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from functools import partial

import numpy as np

from asperity.bem.single import indent_bem
from asperity.curve import contact_curve
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.laws import LAWS
from asperity.microcontact.single.indent import indent
from asperity.microcontact.single.punch import flat_punch
from surfaces.heightmap import HeightMap
from surfaces.polar import PolynomialProfile, PowerLawProfile, PowerSumProfile

from .case import BEM, Case
from .closed_forms import elliptic_contact, power_law_contact
from .judges import Refused, close, refuse

__all__ = ["contact_cases"]

OF_ANY_POWER = tuple(law for law in LAWS if law != "hertz")
"""Laws that take a body of any power: all but that of paraboloids."""

LAW_FORCE, LAW_AREA = 2e-3, 5e-3
"""Errors allowed to a law beside the one it states [-]."""

GRID, BEM_FORCE, BEM_AREA = 128, 0.02, 0.04
"""Points per axis of boundary elements, and errors allowed: the grid resolves the contact by 116
pixels."""

POWERS = 0.05, 0.1, 0.2, 0.5, 0.9, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 50.0, 200.0
RATIOS = 1.0, 1.01, 2.0, 5.0, 10.0, 30.0, 100.0
MODULI = 1e-3, 1.0, 1e6, 1e12, 1e15
LENGTHS = 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3
GRADINGS = -0.99, -0.9, -0.5, -0.1, 0.1, 0.5, 0.9, 0.99
POISSON_RATIOS = -0.9, -0.5, 0.0, 0.3, 0.5
DEPTHS = 1e-45, 1e-30, 1e-15, 1e-6, 1e-2, 1.0, 1e6, 1e15


def contact_cases() -> Iterator[Case]:
    """Cases of one contact, by theme."""
    yield from _tips()
    yield from _aspect_ratios()
    yield from _units()
    yield from _materials()
    yield from _depths()
    yield from _of_a_map()
    for m in (-0.99, -0.5, 0.0, 0.5, 0.99):
        yield Case("grading", f"m = {m}", "flat punch", "closed form", partial(_punch, m))


def _tips() -> Iterator[Case]:
    for k in POWERS:
        exact = partial(power_law_contact, k, 1.0, 1e-2, 1.0)
        for engine in (*OF_ANY_POWER, BEM):
            yield _round("powers of a tip", f"k = {k}", engine, PowerLawProfile(k, 1.0), exact)


def _aspect_ratios() -> Iterator[Case]:
    for ratio in RATIOS:
        body = PolynomialProfile({(2, 0): 0.5, (0, 2): 0.5 * ratio})
        exact = partial(elliptic_contact, ratio, 1e-2, 1.0)
        for engine in (*LAWS, BEM):
            yield _round("aspect ratios", f"1:{ratio:g}", engine, body, exact)


def _units() -> Iterator[Case]:
    ball = PowerLawProfile(2.0, 0.5)
    for modulus in MODULI:
        exact = partial(power_law_contact, 2.0, 0.5, 1e-2, modulus)
        for engine in ("hertz", "auto", BEM):
            material = HalfSpace.from_modulus(modulus)
            yield _round("moduli", f"{modulus:g} Pa", engine, ball, exact, material)
    for length in LENGTHS:
        exact = partial(power_law_contact, 2.0, 0.5 / length, 1e-2 * length, 1.0)
        for engine in ("hertz", "auto", BEM):
            body = PowerLawProfile(2.0, 0.5 / length)
            name, depth = f"{length:g} m", 1e-2 * length
            yield _round("lengths", name, engine, body, exact, HalfSpace.from_modulus(1.0), depth)


def _materials() -> Iterator[Case]:
    ball = PowerLawProfile(2.0, 0.5)
    for m in GRADINGS:
        exact = partial(power_law_contact, 2.0, 0.5, 1e-2, 1.0, m)
        for engine in (*LAWS, BEM):
            material = HalfSpace.from_modulus(1.0, m)
            yield _round("grading", f"m = {m}", engine, ball, exact, material)
    for nu in POISSON_RATIOS:
        exact = partial(power_law_contact, 2.0, 0.5, 1e-2, 1.0 / (1.0 - nu**2))
        for engine in ("auto", BEM):
            for m in (-1e-9, 0.0, 1e-9):
                name, material = f"nu = {nu}, m = {m:g}", HalfSpace(1.0, nu, m)
                yield _round("Poisson ratios", name, engine, ball, exact, material)


def _depths() -> Iterator[Case]:
    ball = PowerLawProfile(2.0, 0.5)
    for depth in DEPTHS:
        exact = partial(power_law_contact, 2.0, 0.5, depth, 1.0)
        for engine in ("hertz", "auto", BEM):
            body = HalfSpace.from_modulus(1.0)
            yield _round("loads", f"approach of {depth:g} radii", engine, ball, exact, body, depth)


def _of_a_map() -> Iterator[Case]:
    """Laws of the contacts of a map are tables: light contacts stand at their begin."""
    for m in (-0.99, -0.9, -0.5, 0.0, 0.5, 0.99):
        for depth in (1e-8, 1e-5, 1e-2):
            for law in LAWS:
                name = f"m = {m}, approach of {depth:g} radii"
                judge = partial(_by_table, m, depth, law)
                yield Case("ball on a map", name, f"law {law}", "closed form", judge)


def _round(
    theme: str,
    name: str,
    engine: str,
    body: PowerSumProfile,
    exact: partial[tuple[float, float]],
    material: HalfSpace | None = None,
    depth: float = 1e-2,
) -> Case:
    """A body whose force and area are known in closed form."""
    half_space = material or HalfSpace.from_modulus(1.0)
    judge = partial(_by_law, body, half_space, depth, exact, engine)
    if engine == BEM:
        judge = partial(_by_elements, body, half_space, depth, exact)
    return Case(theme, name, engine if engine == BEM else f"law {engine}", "closed form", judge)


def _by_law(
    body: PowerSumProfile,
    material: HalfSpace,
    depth: float,
    exact: partial[tuple[float, float]],
    law: str,
) -> float:
    one = indent(body, material, depth, law=law)
    if one.flag_names():
        raise Refused(f"marked as {one.flag_names()}")
    stated = float(one.error_estimate)
    return close((one.force, one.contact_area), exact(), (LAW_FORCE + stated, LAW_AREA + stated))


@functools.cache
def _ball() -> HeightMap:
    """A ball of unit radius, on 64 x 64 pixels of a hundredth of it."""
    place = (np.arange(64) - 32) * 0.01
    return HeightMap(-0.5 * np.add.outer(place**2, place**2), (0.01, 0.01), periodic=False)


def _by_table(m: float, depth: float, law: str) -> float:
    hm = _ball()
    separation = -float(hm.heights.mean()) - depth
    curve = contact_curve(
        hm,
        HalfSpace.from_modulus(1.0, m),
        separations=separation,
        law=law,
        interaction=False,
        scales="all",
    )
    found = float(curve.load[0]), float(curve.contact_area[0])
    return close(found, power_law_contact(2.0, 0.5, depth, 1.0, m), (LAW_FORCE, LAW_AREA))


def _by_elements(
    body: PowerSumProfile, material: HalfSpace, depth: float, exact: partial[tuple[float, float]]
) -> float:
    one = indent_bem(body, material, depth, grid=GRID)
    refuse(one.solutions[0].reason)
    return close((one.force, one.contact_area), exact(), (BEM_FORCE, BEM_AREA))


def _punch(m: float) -> float:
    """Stiffness of the round punch, 2 E_m* a^(1+m) / (1+m)."""
    punch = flat_punch(1e-3, HalfSpace.from_modulus(1e9, m))
    exact = 2e9 * 1e-3 ** (1.0 + m) / (1.0 + m)
    return close((punch.stiffness,), (exact,), (1e-9,))
