"""One contact by boundary elements, started from the pressure of the approximate solution."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.bem.single import BemIndentation, FirstGuess
from asperity.bem.single import indent_bem as solve_bem
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.indent import Indentation, indent, require_half_space
from surfaces.polar import PolarProfile, PowerSumProfile

from .errors import InputError, ModelRangeError

__all__ = ["first_guess", "indent_bem"]

Array = NDArray[np.float64]

_ANGLES, _RADII = 32, 12
"""Polar table of the first pressure."""

_INNERMOST, _OUTERMOST = 0.02, 0.98
"""Radii of the table over that of the contour."""


def indent_bem(
    profile: PowerSumProfile | PolarProfile,
    mat: HalfSpace,
    approach: ArrayLike | None = None,
    *,
    load: ArrayLike | None = None,
    grid: int = 256,
    tolerance: float = 1e-6,
) -> BemIndentation:
    """Indentation of a half-space by one rigid profile: force, area, contour and pressure.

    Parameters
    ----------
    profile
        Gap at first touch f(r, phi) [m], zero at the summit and growing on every ray.
    mat
        Elastic half-space, homogeneous or graded.
    approach
        Rigid-body approach d [m], positive, a number or shape (n,).
    load
        Normal force [N] in place of the approach; the approach is then part of the solution.
    grid
        Points per axis, 16 or more; the grid is fitted to the contact.
    tolerance
        Bound on each entry of the certificate [-].

    Raises
    ------
    InputError
        If neither or both of approach and load are given, one is not positive, the grid is too
        small, the profile never rises to the approach, or profile or material are something else.

    Notes
    -----
    The pressure of the approximate solution is the first iterate on the coarse grid that places
    the fine one; the answer depends on it within the tolerance only.
    """
    given = load if approach is None else approach
    try:
        values = np.atleast_1d(np.asarray(given, dtype=float))
    except (TypeError, ValueError):
        raise InputError("approach or load must be a positive number or several") from None
    if not callable(profile):
        raise InputError(f"profile must be a gap f(r, phi), got {type(profile).__name__}")
    require_half_space(mat)
    name = "load" if approach is None else "approach"
    usable = np.isfinite(values) & (values > 0)
    guesses: list[FirstGuess | None] = []
    if (approach is None) != (load is None) and np.all(usable):
        guesses = [first_guess(profile, mat, name, float(v)) for v in values.ravel()]
    return solve_bem(
        profile, mat, approach, load=load, grid=grid, tolerance=tolerance, guesses=guesses
    )


def first_guess(profile: Any, mat: HalfSpace, name: str, value: float) -> FirstGuess | None:
    """Approximate contact at an approach or a load, None where no law holds.

    Parameters
    ----------
    profile, mat
        As in `indent_bem`.
    name
        "approach" or "load".
    value
        Its value [m] or [N].
    """
    if not isinstance(profile, PolarProfile | PowerSumProfile):
        return None
    try:
        one = indent(profile, mat, law="paper", **{name: value})
    except ModelRangeError:
        return None
    return _guess_of(one) if one.valid else None


def _guess_of(one: Indentation) -> FirstGuess | None:
    """Pressure of a solution from a polar table in stretched radii, without its edge factor."""
    from scipy.ndimage import map_coordinates

    phi = 2 * np.pi * np.arange(_ANGLES + 1) / _ANGLES
    edge = one.contour(phi)
    if not np.all(np.isfinite(edge) & (edge > 0)):
        return None
    rho = np.linspace(_INNERMOST, _OUTERMOST, _RADII)[:, None]
    power = (1 + one.material.m) / 2
    r = rho * edge
    table = one.pressure(r * np.cos(phi), r * np.sin(phi)) / (1 - rho**2) ** power
    table = np.maximum(np.nan_to_num(table), 0.0)

    def pressure(x: Array, y: Array) -> Array:
        turn = np.mod(np.arctan2(y, x), 2 * np.pi)
        share = np.hypot(x, y) / np.interp(turn, phi, edge)
        row = (share - _INNERMOST) * (_RADII - 1) / (_OUTERMOST - _INNERMOST)
        column = turn * _ANGLES / (2 * np.pi)
        smooth = map_coordinates(table, [row, column], order=1, mode="nearest")
        return np.asarray(smooth * np.maximum(1 - share**2, 0.0) ** power)

    return FirstGuess(float(one.approach), pressure)
