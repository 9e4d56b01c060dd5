"""Indentation of the half-space by one profile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import InputError, ModelRangeError
from asperity.halfspace.flags import INVALID, Flag
from asperity.halfspace.material import HalfSpace
from surfaces.polar import PolarProfile, PowerSumProfile

from .laws import law_module

__all__ = ["Indentation", "indent", "require_half_space"]

Array = NDArray[np.float64]

_STEPS = 60
"""Newton steps towards a load."""


@dataclass(frozen=True, eq=False)
class Indentation:
    """Solution of one contact at one or several approaches; all arrays have that shape.

    Attributes
    ----------
    law
        Name of the law.
    material
        The half-space.
    approach
        Approach d [m].
    force
        Normal force [N], compression positive; NaN where there is no solution (`flags`).
    contact_area
        Area [m^2] inside the contact boundary.
    radius
        Effective contact radius a [m].
    stiffness
        dF/dd [N/m].
    flags
        Bits of `asperity.microcontact.Flag`.
    error_estimate
        Relative error of the force expected from the difference of neighbouring laws.
    """

    law: str
    material: HalfSpace
    approach: Array
    force: Array
    contact_area: Array
    radius: Array
    stiffness: Array
    flags: NDArray[np.uint8]
    error_estimate: Array
    contour_function: Callable[[Array], Array] = field(repr=False)
    pressure_function: Callable[[Array, Array], Array] = field(repr=False)
    history_function: Callable[[Array, Array], Array] | None = field(default=None, repr=False)

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Where no flag says that the answer is meaningless."""
        return np.asarray((self.flags & np.uint8(INVALID)) == 0)

    @property
    def mean_pressure(self) -> Array:
        """Force over contact area [Pa]; zero without contact."""
        touching = self.contact_area > 0
        return np.asarray(
            np.where(touching, self.force, 0.0) / np.where(touching, self.contact_area, 1.0)
        )

    def flag_names(self) -> str:
        """Names of the flags set anywhere, joined by |; empty if there are none."""
        return Flag(int(np.bitwise_or.reduce(np.ravel(self.flags), initial=0))).name or ""

    def contour(self, phi: ArrayLike) -> Array:
        """Boundary a(phi) [m] of the contact, shape (*approach.shape, *phi.shape)."""
        angle = np.asarray(phi, dtype=float)
        values = self.contour_function(angle.ravel())
        return values.reshape(self.approach.shape + angle.shape)

    def pressure(
        self, x: ArrayLike, y: ArrayLike, *, balanced: bool = False, history: bool = False
    ) -> Array:
        """Pressure [Pa] at the points (x, y) [m], shape (*approach.shape, *points.shape).

        Parameters
        ----------
        x, y
            Coordinates relative to the summit (broadcast).
        balanced
            Scale the field so that it integrates to the force over the contact area: the
            published field does so over the circle, a second-order mismatch.
        history
            Integrate over all earlier contacts (equations 28, 51) in place of stretching the
            axisymmetric field to the contour (29, 52); slower, equal for power laws. The law
            "harmonic" does so in any case where the shape of the contact changes with load.

        Raises
        ------
        InputError
            If the law has no history integral.
        """
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        law = self.history_function if history else self.pressure_function
        if law is None:
            raise InputError(f"the law {self.law!r} has no history integral of the pressure")
        values = law(np.hypot(x, y).ravel(), np.arctan2(y, x).ravel())
        if balanced:
            values = values * self._balance().reshape(-1, 1)
        return values.reshape(self.approach.shape + x.shape)

    def _balance(self) -> Array:
        """Force over the integral of the pressure field, by rays and a rule for its edge."""
        x, w = np.polynomial.legendre.leggauss(24)
        root = (1 - x) / 2
        rho, share = 1 - root**2, w * root * (1 - root**2)
        phi = 2 * np.pi * np.arange(64) / 64
        edge = self.contour(phi).reshape(-1, phi.size)
        total = np.zeros(self.approach.size)
        for i in np.flatnonzero(self.force.ravel() > 0):
            r = rho[:, None] * edge[i]
            values = self.pressure_function(r.ravel(), np.tile(phi, rho.size))[i]
            inside = values.reshape(r.shape) * edge[i] ** 2
            total[i] = share @ inside.mean(axis=1) * 2 * np.pi
        force = self.force.reshape(-1)
        return np.asarray(np.where(total > 0, force / np.where(total > 0, total, 1.0), 1.0))

    def __str__(self) -> str:
        columns = ("approach", "force", "contact_area", "radius", "stiffness", "error_estimate")
        body = f"E* = {self.material.modulus:.4g}, m = {self.material.m:g}"
        lines = [f"contact by the law {self.law!r}, {body}"]
        lines.append(" ".join(f"{name:>14}" for name in columns) + "  flags")
        values = [np.atleast_1d(getattr(self, name)) for name in columns]
        for *row, bits in zip(*values, np.atleast_1d(self.flags), strict=True):
            names = Flag(int(bits)).name or "-"
            lines.append(" ".join(f"{value:14.5e}" for value in row) + f"  {names}")
        return "\n".join(lines)

    __repr__ = __str__


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
    solve: Callable[..., Indentation] | None = getattr(law_module(law), "indent", None)
    if solve is None:
        raise ModelRangeError(f"the law {law!r} works on batches of peaks only")
    if load is None:
        return solve(profile, material, _finite(approach, "approach"), law=law)
    force = _finite(load, "load")
    if np.any(force <= 0):
        raise InputError("load must be positive; give approach for a body that does not touch")
    return _by_load(solve, profile, material, force, law)


def _by_load(
    solve: Callable[..., Indentation],
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


def require_half_space(material: object) -> None:
    """Refuse what is no half-space, such as a bare modulus."""
    if not isinstance(material, HalfSpace):
        raise InputError(
            f"the material must be a half-space, got {type(material).__name__}: "
            "give asperity.HalfSpace(E, nu) or HalfSpace.from_modulus(E*)"
        )


def _require_profile(profile: object) -> None:
    if not isinstance(profile, PolarProfile | PowerSumProfile):
        kinds = "PowerLawProfile, PolynomialProfile, PolarProfile, or of surfaces.shapes"
        raise InputError(f"profile must be one of surfaces ({kinds}), got {type(profile).__name__}")
