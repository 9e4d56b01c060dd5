"""Law "ellipse" of one contact: expansion about the optimal ellipse."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from asperity.errors import Flag
from asperity.halfspace.footprint import Footprints
from asperity.halfspace.material import HalfSpace
from surfaces.polar import PolarProfile, PowerLawProfile, PowerSumProfile

from . import circle
from .basis import basis_of, radius_at
from .ellipse_search import Search
from .ellipse_state import EllipseState
from .indentation import Indentation, profile_flags

__all__ = ["indent"]

Array = NDArray[np.float64]

_ANGLES = 720
"""Angles at which the flags look at a contour."""

_POINTS = 2880
"""Points of a contour from which its radius is read."""

_LAST = 0.5
"""Share of the last order of the contour that is taken: its orders alternate, and half of the last
stands for it and those that follow (Euler)."""


def _state(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, approach: float, start: float
) -> EllipseState | None:
    """Contact at one approach [m], of a radius near `start` [m]; None if no ellipse was found, or
    it pulls.

    The expansion is made about the ellipse of the contour that the one about the best ellipse
    gives. The stiffness is that of a power law, or a difference of the force.
    """
    search = Search(profile, material.m, approach, start)
    best = search.optimum(search.first, approach)
    if best is None:
        return None
    ellipse, gap, one, widest = search.solved(best, approach)
    if not one.force > 0:
        return None
    if isinstance(profile, PowerLawProfile):
        power = 1 + (1 + material.m) / profile.k
    else:
        power = search.power(best, approach)
    unit = material.modulus
    coefs = -gap.polynomial
    coefs[0] += approach
    middle = float(profile(*ellipse.places(np.zeros(1), np.zeros(1)))[0])
    e1, e2, e3 = one.contour
    # logarithm of the squared contour; at a kink the higher orders ring and cut the corner
    kinked = len(getattr(profile, "corners", ())) > 0
    grown = e1 if kinked else e1 + e2 - e1**2 / 2 + _LAST * (e3 - e1 * e2 + e1**3 / 3)
    grown = np.exp(np.clip(grown, -3.0, 3.0))
    mean = float((1 + e1 + e2 + _LAST * e3).mean())
    if 0.5 < mean < 2:
        grown *= mean / grown.mean()
    waves = np.fft.rfft(np.sqrt(grown) - 1)
    waves[-1] /= 2
    return EllipseState(
        force=unit * one.force,
        stiffness=unit * one.force * power / approach,
        area=float(np.pi * ellipse.a * ellipse.b * grown.mean()),
        parts=tuple(
            unit * part for part in (one.lower, one.second, one.third, one.fourth, one.beyond)
        ),
        ellipse=ellipse,
        displacement=np.fft.irfft(waves, _POINTS) * (_POINTS / grown.size),
        widest=widest,
        coefs=coefs,
        misfit=gap.misfit / approach,
        residue=gap.residue / approach,
        centre=(1 + material.m) * abs(gap.centre - middle) / approach,
    )


def _states(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, depth: Array, start: Array
) -> list[EllipseState | None]:
    """Contacts at several approaches; those of a power law are all similar to the first."""
    states: list[EllipseState | None] = []
    first: tuple[float, EllipseState] | None = None
    for d, a in zip(depth, start, strict=True):
        if not (np.isfinite(a) and a > 0):
            states.append(None)
        elif first is not None and isinstance(profile, PowerLawProfile):
            states.append(first[1].scaled(float(d) / first[0], profile.k, material.m))
        else:
            one = _state(profile, material, float(d), float(a))
            first = None if one is None else (float(d), one)
            states.append(one)
    return states


def indent(
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    approach: Array,
    *,
    law: str = "ellipse",
) -> Indentation:
    """Solution by the law "ellipse"; see `asperity.indent`.

    The pressure of a sharp tip, which is no polynomial, is that of the law "harmonic".
    """
    start = radius_at(basis_of(profile, material.m), approach)
    states = _states(profile, material, approach, start)
    phi = 2 * np.pi * np.arange(_ANGLES) / _ANGLES

    def rows(told: Callable[[EllipseState], Array], size: int) -> Array:
        """What is told of each contact, shape (n, size): zero without one, NaN if not found."""
        out = np.repeat(np.where(approach > 0, np.nan, 0.0)[:, None], size, axis=1)
        for row, one in zip(out, states, strict=True):
            if one is not None:
                row[:] = told(one)
        return out

    def column(name: str) -> Array:
        return rows(attrgetter(name), 1)[:, 0]

    def contour(angle: Array) -> Array:
        return rows(lambda one: one.boundary(angle), angle.size)

    sharp = np.array([one is not None and one.sharp for one in states])

    def pressure(r: Array, angle: Array) -> Array:
        values = rows(lambda one: one.pressure(r, angle, material), angle.size)
        if np.any(sharp):
            tips = circle.indent(profile, material, approach[sharp], law="harmonic")
            values[sharp] = tips.pressure_function(r, angle)
        return values

    force, stiffness = column("force"), column("stiffness")
    flags = profile_flags(profile, approach, phi, contour(phi))
    doubtful = np.array([one is not None and one.doubtful for one in states])
    flags[doubtful] |= np.uint8(Flag.CONTOUR_DOUBTFUL)
    flags[~np.isfinite(force)] |= np.uint8(Flag.TURNING)
    return Indentation(
        law=law,
        material=material,
        approach=approach,
        force=force,
        contact_area=column("area"),
        radius=Footprints(material.modulus, material.m).radius(np.maximum(stiffness, 0.0)),
        stiffness=stiffness,
        flags=flags,
        error_estimate=column("expected_error"),
        contour_function=contour,
        pressure_function=pressure,
    )
