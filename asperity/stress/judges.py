"""What an answer is judged against; each judge gives the error over what is allowed.

An answer that its engine marks as not converged, with a reason, is a refusal (`Refused`). One that
is marked without a reason, or is no number, is wrong without limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from asperity.bem.curve import bem_curve
from asperity.bem.solution import BemSolution
from asperity.bem.solve import bem_solve
from asperity.curve import contact_curve
from asperity.engine.solve import solve
from asperity.errors import AsperityError
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import pressure_scale
from asperity.results.curve import ContactCurve
from surfaces.arrays import Array
from surfaces.heightmap import HeightMap

from .case import BEM
from .closed_forms import free_displacement, periodic_displacement

__all__ = [
    "ENGINES",
    "Doubted",
    "Question",
    "Refused",
    "alike",
    "bounded",
    "certified",
    "close",
    "refuse",
]


AS_A_RULE = 1e-3
"""Difference allowed between answers to questions that are the same [-]."""

SHARE_OF_STATED = 0.1
"""Difference allowed between such answers, over the error that they state [-]."""

TOLERANCE = 1e-6
"""Tolerance of boundary elements where their certificate is judged."""

EXACT = 1e-8
"""Tolerance of boundary elements that judge."""


class Refused(AsperityError):
    """An engine says in one sentence why it has no answer."""


class Doubted(AsperityError):
    """An answer is farther off than it states, and its engine warns of the reason."""


ENGINES: Mapping[str, Callable[..., ContactCurve]] = {
    "model": contact_curve,
    BEM: bem_curve,
    "solve": solve,
    "solve, anchored": partial(solve, engine="anchored"),
}
"""Engines that give a contact curve, by name."""


@dataclass(frozen=True, eq=False)
class Question:
    """A map, a half-space and mean pressures [Pa], shape (n,)."""

    hm: HeightMap
    material: HalfSpace
    pressures: Array

    @classmethod
    def of(
        cls,
        hm: HeightMap,
        material: HalfSpace | None = None,
        *,
        lightest: float = 1e-3,
        heaviest: float = 0.1,
    ) -> Question:
        """Five loads between two shares of the pressure that flattens the roughness."""
        body = material or HalfSpace.from_modulus(1e9)
        loads = pressure_scale(hm, body) * np.geomspace(lightest, heaviest, 5)
        return cls(hm, body, loads)

    def on(self, hm: HeightMap) -> Question:
        """The question about another map."""
        return replace(self, hm=hm)

    def answer(self, engine: str) -> ContactCurve:
        """The contact curve of an engine; `Refused` where it has no load point."""
        curve = ENGINES[engine](self.hm, self.material, pressures=self.pressures)
        if not curve.converged.any():
            refuse(curve.reasons[0])
        return curve


def refuse(reason: str) -> None:
    """Raise a refusal, if there is a reason."""
    if reason:
        raise Refused(reason)


def _unexplained(curve: ContactCurve) -> bool:
    """Whether a load point is marked as not converged without a reason."""
    return any(
        not good and not why for good, why in zip(curve.converged, curve.reasons, strict=True)
    )


def _apart(first: ContactCurve, second: ContactCurve, length: float = 1.0) -> tuple[Array, Array]:
    """Differences of the load at equal separation and of the area at equal load [-], of the points
    that both have; lengths of the second curve are `length` times those of the first."""
    both = first.converged & second.converged & (first.mean_pressure > 0.0)
    fall = np.abs(second.separation / length - first.separation)[both]
    # a separation tells no load in full contact, nor where loads differ by less than its rounding
    told = first.area_fraction[both] < 1.0 - 1e-9
    told &= fall > 1e-14 * np.abs(first.separation).max()
    slope = np.where(told, (first.stiffness / first.mean_pressure)[both], 0.0)
    load = fall * slope
    area = np.abs(np.log(second.area_fraction[both] / first.area_fraction[both]))
    return load, area


def _worst(error: Array, allowed: Array) -> float:
    """Largest error over what is allowed; infinite if one of them is no number."""
    ratio = np.asarray(error / allowed)
    return math.inf if np.isnan(ratio).any() else float(ratio.max(initial=0.0))


def alike(
    engine: str, first: Question, second: Question, *, length: float = 1.0, pressure: float = 1.0
) -> float:
    """Two questions that have the same answer but for the units of length and of pressure."""
    one, other = first.answer(engine), second.answer(engine)
    if _unexplained(one) or (one.converged != other.converged).any():
        return math.inf
    load, area = _apart(one, other, length)
    asked = np.abs(other.mean_pressure / (pressure * one.mean_pressure) - 1.0)[one.converged]
    stated = one.error_estimate, one.extra["area_error_estimate"]
    used = one.converged & (one.mean_pressure > 0.0)
    limits = [np.fmax(AS_A_RULE, SHARE_OF_STATED * value[used]) for value in stated]
    return max(
        _worst(load, limits[0]), _worst(area, limits[1]), _worst(asked, np.full(1, AS_A_RULE))
    )


def bounded(engine: str, question: Question, finer: HeightMap | None = None) -> float:
    """Errors that an answer states, against boundary elements at a tolerance of 1e-8 on the grid of
    the map, or on a finer one."""
    curve = question.answer(engine)
    if _unexplained(curve):
        return math.inf
    stated = curve.error_estimate, curve.extra["area_error_estimate"]
    used = curve.converged & (curve.mean_pressure > 0.0)
    if np.isnan(stated[0][used]).any():
        refuse("; ".join(curve.settings.get("warnings", ())))
    exact = bem_curve(
        finer or question.hm,
        question.material,
        pressures=question.pressures,
        tolerance=EXACT,
    )
    if not exact.converged.all():
        raise Refused(f"no reference: {next(filter(None, exact.reasons))}")
    load, area = _apart(exact, curve)
    own = exact.error_estimate, exact.extra["area_error_estimate"] + _grain(exact)
    limits = [(a + b)[used] for a, b in zip(stated, own, strict=True)]
    ratio = max(_worst(load, limits[0]), _worst(area, limits[1]))
    warnings = curve.settings.get("warnings", ())
    if ratio > 1.0 and warnings:
        raise Doubted(f"{ratio:.3g} times the error that is stated; {'; '.join(warnings)}")
    return ratio


def _grain(curve: ContactCurve) -> Array:
    """Relative error of an area that is counted in pixels: (n N / pi)^(1/4) / N of N in n spots."""
    pixels = np.maximum(curve.extra["contact_area_raw"] / np.prod(curve.settings["spacing"]), 1.0)
    return np.asarray((np.maximum(curve.contacts, 1) * pixels / np.pi) ** 0.25 / pixels)


def certified(question: Question) -> float:
    """Boundary elements at each load, by displacements that are not those of the solver."""
    return max(
        certificate(
            bem_solve(question.hm, question.material, pressure=float(load), tolerance=TOLERANCE),
            question,
            float(load),
        )
        / TOLERANCE
        for load in question.pressures
    )


def certificate(found: BemSolution, question: Question, load: float) -> float:
    """Largest of the errors of load, of pressure where there is a gap, and of penetration."""
    if not found.converged:
        refuse(found.reason)
        return math.inf
    pressure, material = found.pressure, question.material
    if found.boundary == "periodic":
        moved = periodic_displacement(pressure, found.spacing, material.modulus, material.m)
    else:
        moved = free_displacement(pressure, found.spacing, material.modulus)
    heights = question.hm.heights - question.hm.heights.mean()
    gap = moved - heights
    gap -= gap[pressure > 0.0].mean()
    flat = 1e-6 * max(float(np.abs(moved).max()), load / material.modulus * found.spacing[0])
    scale = max(float(heights.std()), flat, 1e-15 * float(np.abs(question.hm.heights).max()))
    work = float((pressure * (gap - gap.min())).sum() / pressure.sum()) / scale
    errors = abs(pressure.mean() / load - 1.0), work, float(-gap.min()) / scale
    return math.inf if np.isnan(errors).any() or pressure.min() < 0.0 else max(errors)


def close(found: tuple[Any, ...], exact: tuple[float, ...], allowed: tuple[float, ...]) -> float:
    """Numbers against those of a closed form, by relative errors allowed."""
    error = np.abs(np.array(found, float) / np.array(exact) - 1.0)
    return _worst(error, np.array(allowed))
