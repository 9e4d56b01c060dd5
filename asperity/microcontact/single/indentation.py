"""Solution of one contact: force, area, boundary and pressure, and the flags of its validity."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import minimum_filter

from asperity.errors import INVALID, Flag, InputError
from asperity.halfspace.material import HalfSpace
from surfaces.arrays import Array, Mask
from surfaces.errors import as_numbers, as_places
from surfaces.polar import PolarProfile, PowerSumProfile

__all__ = ["Indentation", "contour_flags", "profile_flags"]


_RAYS = 96
"""Rays, at most, on which a profile is looked at."""

_RADII = 160
"""Radii on each."""

_FARTHEST = 4.0
"""How far a profile without a last radius is looked at, over the reach of the contact."""


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
        Relative error of the force expected from the difference of neighboring laws; NaN where it
        is not known.
    saturated
        Estimate of the share of the area at the hardness; zero without one.

    Examples
    --------
    >>> import asperity, surfaces
    >>> ball = surfaces.PowerLawProfile(2.0, 0.5)
    >>> one = asperity.indent(ball, asperity.HalfSpace.from_modulus(1.0), 0.01)
    >>> f"{one.radius:.3f}, {one.contour(0.0):.3f}"
    '0.100, 0.100'
    >>> f"{one.pressure(0.0, 0.0) / one.mean_pressure:.3f}"
    '1.500'
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
    saturated: Array | float = 0.0
    first_yield_function: Callable[[], tuple[float, float]] | None = field(default=None, repr=False)
    fully_plastic_function: Callable[[], tuple[float, float]] | None = field(
        default=None, repr=False
    )

    @property
    def valid(self) -> Mask:
        """Where no flag says that the answer is meaningless."""
        return np.asarray((self.flags & np.uint8(INVALID)) == 0)

    @property
    def mean_pressure(self) -> Array:
        """Force over contact area [Pa]; zero without contact."""
        touching = self.contact_area > 0
        return np.asarray(
            np.where(touching, self.force, 0.0) / np.where(touching, self.contact_area, 1.0)
        )

    @cached_property
    def first_yield(self) -> tuple[float, float]:
        """Approach [m] and force [N] at which the pressure first reaches the hardness.

        Both are zero if a sharp tip yields when it touches, infinite if nothing yields.
        """
        told = self.first_yield_function
        return (np.inf, np.inf) if told is None else told()

    @cached_property
    def fully_plastic(self) -> tuple[float, float]:
        """Approach [m] and force [N] at which the mean pressure reaches 0.975 of the hardness.

        There about 0.95 of the area are at the hardness. Zero and infinite as in `first_yield`.
        """
        told = self.fully_plastic_function
        return (np.inf, np.inf) if told is None else told()

    def flag_names(self) -> str:
        """Names of the flags set anywhere, joined by `|`; empty if there are none."""
        return Flag(int(np.bitwise_or.reduce(np.ravel(self.flags), initial=0))).name or ""

    def contour(self, phi: ArrayLike) -> Array:
        """Boundary a(phi) [m] of the contact, shape `(*approach.shape, *phi.shape)`."""
        angle = as_numbers("phi", phi)
        values = self.contour_function(angle.ravel())
        return values.reshape(self.approach.shape + angle.shape)

    def pressure(self, x: ArrayLike, y: ArrayLike, *, history: bool = False) -> Array:
        """Pressure [Pa] at the points (x, y) [m], shape `(*approach.shape, *points.shape)`.

        The law "ritz" has none: it gives NaN.

        Parameters
        ----------
        x, y
            Coordinates relative to the summit (broadcast).
        history
            Integrate over all earlier contacts (Popov, Li & Willert 2023, equations 28, 51) instead
            of stretching the axisymmetric field to the contour (equations 29, 52): slower, equal
            for power laws. The law "harmonic" always does so if the shape of the contact changes
            with load.

        Raises
        ------
        InputError
            If the law has no history integral.
        """
        x, y = as_places(x, y)
        law = self.history_function if history else self.pressure_function
        if law is None:
            raise InputError(f"the law {self.law!r} has no history integral of the pressure")
        values = law(np.hypot(x, y).ravel(), np.arctan2(y, x).ravel())
        return values.reshape(self.approach.shape + x.shape)

    def __str__(self) -> str:
        columns = ["approach", "force", "contact_area", "radius", "stiffness", "error_estimate"]
        body = f"E* = {self.material.modulus:.4g}, m = {self.material.m:g}"
        if np.isfinite(self.material.hardness):
            columns.append("saturated")
            body += f", hardness {self.material.hardness:.4g}"
        lines = [f"contact by the law {self.law!r}, {body}"]
        lines.append(" ".join(f"{name:>14}" for name in columns) + "  flags")
        values = [np.atleast_1d(getattr(self, name)) for name in columns]
        for *row, bits in zip(*values, np.atleast_1d(self.flags), strict=True):
            names = Flag(int(bits)).name or "-"
            lines.append(" ".join(f"{value:14.5e}" for value in row) + f"  {names}")
        return "\n".join(lines)

    __repr__ = __str__


def contour_flags(a: Array, contour: Array) -> NDArray[np.uint8]:
    """Flags of the contour itself: `a` of shape (k,), `contour` of shape (k, angles)."""
    flags = np.zeros(a.shape, dtype=np.uint8)
    known = np.isfinite(a) & (a > 0)
    ratio = np.where(known[:, None], contour, 1.0) / np.where(known, a, 1.0)[:, None]
    flags[(ratio.min(axis=1) < 0.5) | (ratio.max(axis=1) > 1.5)] |= np.uint8(Flag.CONTOUR_DOUBTFUL)
    flags[ratio.min(axis=1) <= 0] |= np.uint8(Flag.CONTOUR_NEGATIVE)
    return flags


def profile_flags(
    profile: PowerSumProfile | PolarProfile, approach: Array, phi: Array, contour: Array
) -> NDArray[np.uint8]:
    """Flags of the profile inside contacts at approaches [m], (k,), from one polar scan; `contour`
    (k, phi.size) holds their a(phi) [m]."""
    flags = np.zeros(approach.shape, dtype=np.uint8)
    reach = np.max(np.nan_to_num(contour), axis=1)
    beyond = reach > profile.radius
    if isinstance(profile, PolarProfile):
        beyond |= (reach > 0) & (reach < profile.r[1])  # the table does not tell how f begins
        if profile.edge is not None:
            end = np.interp(phi, profile.phi, profile.edge, period=2 * np.pi)
            beyond |= np.any(contour > end, axis=1)
            saddle = np.min(profile(profile.edge, profile.phi))
            flags[approach > saddle] |= np.uint8(Flag.SECOND_SUMMIT)
    flags[beyond] |= np.uint8(Flag.BEYOND_RADIUS)
    if not np.max(reach, initial=0.0) > 0:
        return flags
    last = profile.radius if np.isfinite(profile.radius) else _FARTHEST * float(np.max(reach))
    r = last * (np.arange(1, _RADII + 1) / _RADII) ** 1.5
    every = max(1, phi.size // _RAYS)
    with np.errstate(over="ignore"):
        f = np.minimum(profile(r[:, None], phi[::every]), np.finfo(float).max)
    edge = contour[:, ::every]
    below = _first(f < 0, r)
    scale = np.maximum.accumulate(np.abs(f), axis=0)
    falling = _first(np.diff(f, axis=0, prepend=0.0) < -1e-9 * scale, r)
    flags[np.any(edge > below, axis=1)] |= np.uint8(Flag.NEGATIVE_GAP)
    flags[np.any(edge > falling, axis=1)] |= np.uint8(Flag.RAY_TURNS)
    again = (approach > _second_summit(f)) | [_reenters(f, float(d)) for d in approach]
    flags[(approach > 0) & again] |= np.uint8(Flag.SECOND_SUMMIT)
    return flags


def _reenters(f: Array, approach: float) -> bool:
    """Whether a ray enters {f < d} again: another part of the body, or a higher one, stands in."""
    outside = np.maximum.accumulate(f >= approach, axis=0)
    return bool(np.any(outside & (f < approach)))


def _first(where: Mask, r: Array) -> Array:
    """Smallest radius of each ray at which `where` holds, infinite if nowhere."""
    return np.asarray(np.where(where.any(axis=0), r[np.argmax(where, axis=0)], np.inf))


def _second_summit(f: Array) -> float:
    """Lowest gap over a summit other than the origin, on the polar grid `f`; infinite if none."""
    around = np.ones((3, 3))
    around[1, 1] = 0.0
    lowest = minimum_filter(f, footprint=around, mode="wrap")
    inner = f[1:-1]
    return float(np.min(inner[inner < lowest[1:-1]], initial=np.inf))
