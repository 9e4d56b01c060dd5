"""Indentation of the half-space by one profile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import Flag, InputError, ModelRangeError, cautious, warn_once
from asperity.halfspace.material import HalfSpace, require_half_space
from asperity.halfspace.scene import modulus_warning
from surfaces.arrays import Array
from surfaces.errors import as_choice, as_sizes
from surfaces.polar import PolarProfile, PowerSumProfile

from . import circle, ellipse, hertz, ritz
from .basis import basis_of, turning_radius
from .capped import CappedLaw
from .indentation import Indentation

__all__ = ["indent"]

Solver = Callable[[PowerSumProfile | PolarProfile, HalfSpace, Array], Indentation]
Measure = Callable[[Array], tuple[Array, Array]]

_STEPS = 60
"""Newton steps towards a load."""

_SETTLED, _NOISE = 12, 1e-4
"""Steps after which those that only follow the noise of a law are the last; relative error of the
best: laws of sharp tips under a hardness are noisy by 2e-5."""

_FLAT = 1e-6
"""Exponent of a quantity that does not grow with the load."""

_FULL = 0.975
"""Mean pressure over the hardness of a fully plastic contact: 0.95 of its area is saturated."""

_TINY = 1e-6
"""Approach of a contact just touched, over that of another."""

_MEANINGLESS = 0.3
"""Relative error of the law "harmonic" from which on no answer is better: long contacts."""


def _auto(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, approach: Array
) -> Indentation:
    """Solution by the law "auto": at every approach by that of the smaller expected error.

    On a sharp tip (a cone, a pyramid), which is no polynomial, this is "harmonic".
    """
    first = ellipse.indent(profile, material, approach)
    second = circle.indent(profile, material, approach, law="harmonic")
    own = np.where(np.isfinite(first.force), first.error_estimate, np.inf)
    other = np.where(np.isfinite(second.force), second.error_estimate, np.inf)
    take = np.nan_to_num(own, nan=np.inf) <= np.nan_to_num(other, nan=np.inf)
    take |= other > _MEANINGLESS
    # a contact longer than the law "ellipse" reaches: near m = -1 errors seem small
    doubtful = (second.flags & np.uint8(Flag.CONTOUR_DOUBTFUL)) > 0
    take |= ~np.isfinite(first.force) & doubtful
    # a flat part farther out bears, which the law "ellipse" does not see
    take &= ~(np.isnan(second.error_estimate) & np.isfinite(second.force))
    names = ("force", "contact_area", "radius", "stiffness", "flags", "error_estimate")
    columns = {name: np.where(take, getattr(first, name), getattr(second, name)) for name in names}
    return replace(
        first,
        law="auto",
        **columns,
        contour_function=lambda phi: np.where(
            take[:, None], first.contour_function(phi), second.contour_function(phi)
        ),
        pressure_function=lambda r, phi: np.where(
            take[:, None], first.pressure_function(r, phi), second.pressure_function(r, phi)
        ),
        history_function=None,
    )


SOLVERS: dict[str, Solver] = {
    "auto": _auto,
    "hertz": hertz.indent,
    "paper": partial(circle.indent, law="paper"),
    "harmonic": partial(circle.indent, law="harmonic"),
    "ellipse": ellipse.indent,
    "ritz": ritz.indent,
}
"""Solution of one contact by each law."""


@cautious
def indent(
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    approach: ArrayLike | None = None,
    *,
    load: ArrayLike | None = None,
    law: str = "harmonic",
) -> Indentation:
    """Press one profile by an approach, or by a load.

    Parameters
    ----------
    profile
        The gap f(r, phi) at first touch, about the summit.
    material
        Half-space, homogeneous or graded. Its hardness bounds the pressure.
    approach
        Approach d [m], a number or an array; nothing touches at d <= 0.
    load
        Normal force [N] in place of the approach, positive.
    law
        "hertz" (curvature of the summit), "paper" (the published first-order solution),
        "harmonic" (resolved by angular harmonics, second order), or another of
        `asperity.microcontact.LAWS`.

    Raises
    ------
    InputError
        If neither or both of approach and load are given, one is not finite, or profile or
        material are something else.
    ModelRangeError
        If the law has no solution for the load.

    Examples
    --------
    >>> from surfaces import PowerLawProfile
    >>> one = indent(PowerLawProfile(2, 0.5), HalfSpace.from_modulus(1.0), 0.01)
    >>> bool(abs(one.force - 4 / 3 * 0.01**1.5) < 1e-12)
    True
    """
    _require_profile(profile)
    require_half_space(material)
    as_choice("law", law, SOLVERS)
    warn_once(modulus_warning(material))
    if (approach is None) == (load is None):
        raise InputError("give either approach or load")
    given = _finite(approach if load is None else load, "approach" if load is None else "load")
    if load is not None and np.any(given <= 0):
        raise InputError("load must be positive; give approach for a body that does not touch")
    elastic = partial(SOLVERS[law], profile, material.elastic)
    goal = given.ravel()
    refusal = f"the law {law!r} reaches no {'approach' if load is None else 'load'}"
    if np.isfinite(material.hardness):
        if load is not None:
            _require_carried(profile, material, goal)
        capped = CappedLaw(elastic, profile, material)
        one = _yielding(capped, goal, _first(profile, material.m, goal), load is not None, refusal)
    elif load is None:
        one = elastic(goal)
    else:
        one = elastic(_depth(_forces(elastic), _first(profile, material.m, goal), goal, refusal))
    shaped: dict[str, Any] = {
        name: values.reshape(given.shape)
        for name, values in vars(one).items()
        if isinstance(values, np.ndarray)
    }
    return replace(one, **shaped)


def _yielding(
    capped: CappedLaw, goal: Array, first: Array, loaded: bool, refusal: str
) -> Indentation:
    """Contacts under a hardness at the approaches or, if `loaded`, the loads `goal`."""
    if loaded:
        one = capped.contact(_depth(_values(capped, "force"), first, goal, refusal))
    else:
        one = capped.contact(_depth(_values(capped, "approach"), goal, goal, refusal))
        force = one.force + one.stiffness * (goal - one.approach)
        one = replace(one, approach=goal, force=force)
    yields = lru_cache(partial(_limit, capped, "yielding", 1.0, first))
    return replace(
        one,
        first_yield_function=yields,
        fully_plastic_function=partial(_full, capped, first, yields),
    )


def _forces(elastic: Callable[[Array], Indentation]) -> Measure:
    """Force of elastic contacts, and its change with the logarithm of their approach."""

    def measure(depth: Array) -> tuple[Array, Array]:
        state = elastic(depth)
        return state.force, depth * state.stiffness

    return measure


def _values(capped: CappedLaw, name: str) -> Measure:
    """A quantity of capped contacts, and its change with the logarithm of the elastic approach."""

    def measure(depth: Array) -> tuple[Array, Array]:
        values, changes = capped.at(depth)
        return values[name], changes[name]

    return measure


def _first(profile: PowerSumProfile | PolarProfile, m: float, goal: Array) -> Array:
    """Approaches to begin with: the gap [m] at a quarter of the radius of a profile; of a body of
    powers D(a) at a quarter of the radius at which it turns over, or of 1 m."""
    if isinstance(profile, PolarProfile):
        turn = 2 * np.pi * np.arange(16) / 16
        return np.full(goal.shape, np.mean(profile(profile.radius / 4, turn)))
    basis = basis_of(profile, m)
    radius = min(turning_radius(basis), 1.0)
    return np.full(goal.shape, basis.depth(np.array([radius / 4]))[0])


def _depth(measure: Measure, start: Array, goal: Array, refusal: str) -> Array:
    """Elastic approach at which a quantity has the values `goal`; its start where they are none.

    Newton steps in its logarithm over log d, halved towards the last depth that has a solution.
    """
    touching = goal > 0
    depth, known = start, np.zeros(goal.shape)
    best, miss, last = start, np.where(touching, np.inf, 0.0), np.inf
    for count in range(_STEPS):
        value, change = measure(depth)
        lost = touching & ~np.isfinite(value * change)
        known = np.where(lost, known, depth)
        with np.errstate(invalid="ignore", divide="ignore"):
            off = np.where(touching, np.log(goal / value), 0.0)
            step = np.where(touching, off * value / change, 0.0)
            better = np.abs(off) < miss
        best, miss = np.where(better, depth, best), np.where(better, np.abs(off), miss)
        newton = depth * np.exp(np.clip(np.where(lost, 0.0, step), -3.0, 3.0))
        left = np.inf if np.any(lost) else np.max(np.abs(step), initial=0.0)
        if left < 1e-13:
            return depth
        depth = np.where(lost, np.where(known > 0, (depth + known) / 2, depth / 8), newton)
        if left < 1e-11:
            return depth
        if count >= _SETTLED and np.max(miss) < _NOISE and left > 0.5 * last:
            return best
        last = left
    raise ModelRangeError(f"{refusal} of {float(np.max(goal)):.4g}")


def _limit(capped: CappedLaw, name: str, goal: float, start: Array) -> tuple[float, float]:
    """Approach and force at which a quantity reaches `goal`; zero or infinite where it does not
    grow with the load, or reaches it where there is no contact to be found."""
    middle = start[:1]
    values, changes = capped.at(np.append(_TINY * middle, middle))
    none = (np.inf, np.inf) if values[name][0] < goal else (0.0, 0.0)
    if not changes[name][0] > _FLAT * values[name][0]:
        return none
    try:
        depth = _depth(_values(capped, name), middle, np.array([goal]), name)
    except ModelRangeError:
        return none
    found, _ = capped.at(depth)
    return float(found["approach"][0]), float(found["force"][0])


def _full(
    capped: CappedLaw, first: Array, yields: Callable[[], tuple[float, float]]
) -> tuple[float, float]:
    """Approach and force of full plasticity; what grows towards it does so below first yield."""
    begun, _ = yields()
    start = np.array([begun]) if 0.0 < begun < np.inf else first
    return _limit(capped, "filling", _FULL, start)


def _require_carried(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, force: Array
) -> None:
    """Refuse a load that the area on which the profile is known cannot carry."""
    edge = getattr(profile, "edge", None)
    area = np.pi * (profile.radius**2 if edge is None else np.mean(edge**2))
    most = area * material.hardness
    if np.any(force > most):
        raise ModelRangeError(
            f"a load of {float(np.max(force)):.4g} N is more than the area of the profile carries "
            f"at the hardness, {most:.4g} N"
        )


def _finite(values: ArrayLike | None, name: str) -> Array:
    array = as_sizes(name, values)
    if array.ndim > 1 or not array.size:
        raise InputError(f"{name} has the shape {array.shape}; give a number or one axis of them")
    return array


def _require_profile(profile: object) -> None:
    if not isinstance(profile, PolarProfile | PowerSumProfile):
        kinds = "PowerLawProfile, PolynomialProfile, PolarProfile, or of surfaces.shapes"
        raise InputError(f"profile must be one of surfaces ({kinds}), got {type(profile).__name__}")
