"""Indentation of the half-space by one profile."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import InputError, ModelRangeError
from asperity.halfspace.material import HalfSpace, require_half_space
from asperity.microcontact.laws import require_law
from surfaces.polar import PolarProfile, PowerSumProfile

from . import auto, circle, ellipse, hertz, ritz
from .indentation import Indentation

__all__ = ["indent"]

Array = NDArray[np.float64]
Solver = Callable[..., Indentation]

SOLVERS: dict[str, Solver] = {
    "auto": auto.indent,
    "hertz": hertz.indent,
    "paper": circle.indent,
    "harmonic": circle.indent,
    "ellipse": ellipse.indent,
    "ritz": ritz.indent,
}
"""Solution of one contact by each law."""

_STEPS = 60
"""Newton steps towards a load."""


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
        Half-space, homogeneous or graded.
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
    if (approach is None) == (load is None):
        raise InputError("give either approach or load")
    solve = _solver(law)
    if load is None:
        return solve(profile, material, _finite(approach, "approach"), law=law)
    force = _finite(load, "load")
    if np.any(force <= 0):
        raise InputError("load must be positive; give approach for a body that does not touch")
    return _by_load(solve, profile, material, force, law)


def _solver(law: str) -> Solver:
    require_law(law)
    if law not in SOLVERS:
        raise ModelRangeError(f"the law {law!r} works on batches of peaks only")
    return SOLVERS[law]


def _by_load(
    solve: Solver,
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    force: Array,
    law: str,
) -> Indentation:
    """Newton steps in log F over log d, halved towards the last depth that has a solution."""
    radius = profile.radius if np.isfinite(profile.radius) else 1.0
    turn = 2 * np.pi * np.arange(16) / 16
    depth = np.full(force.shape, np.mean(profile(radius / 4, turn)))
    known = np.zeros(force.shape)
    for _ in range(_STEPS):
        state = solve(profile, material, depth, law=law)
        lost = ~np.isfinite(state.force)
        known = np.where(lost, known, depth)
        with np.errstate(invalid="ignore"):
            step = np.log(force / state.force) * state.force / (depth * state.stiffness)
        newton = depth * np.exp(np.clip(np.where(lost, 0.0, step), -3.0, 3.0))
        if not np.any(lost) and np.all(np.abs(step) < 1e-13):
            return state
        depth = np.where(lost, np.where(known > 0, (depth + known) / 2, depth / 8), newton)
        if not np.any(lost) and np.all(np.abs(step) < 1e-11):
            return solve(profile, material, depth, law=law)
    raise ModelRangeError(f"the law {law!r} reaches no load of {float(np.max(force)):.4g} N")


def _finite(values: ArrayLike | None, name: str) -> Array:
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        array = np.full(1, np.nan)
    if array.ndim > 1 or not np.all(np.isfinite(array)):
        raise InputError(f"{name} must be a finite number or a one-dimensional array of them")
    return array


def _require_profile(profile: object) -> None:
    if not isinstance(profile, PolarProfile | PowerSumProfile):
        kinds = "PowerLawProfile, PolynomialProfile, PolarProfile, or of surfaces.shapes"
        raise InputError(f"profile must be one of surfaces ({kinds}), got {type(profile).__name__}")
