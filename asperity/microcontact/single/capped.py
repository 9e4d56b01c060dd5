"""One contact under a hardness: from the elastic contact of the same area, by any law."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

from asperity.errors import Flag
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.yielding import capped
from surfaces.arrays import Array
from surfaces.polar import PolarProfile, PowerSumProfile

from .indentation import Indentation, profile_flags

__all__ = ["CappedLaw"]

Field = Callable[[Array, Array], Array]

_STEP = 1e-3
"""Relative step of the elastic approach for derivatives."""

_RAYS, _RADII = 97, 64
"""Rays, an odd number since sections with corners are symmetric, and radii on each, at which the
pressure of a contact is looked at."""

_SMALLEST, _LARGEST, _LINES = 1e-6, 1e2, 640
"""Level lines: their radii over that of a contact, and their number."""

_MOVED = 30.0
"""Factor of the radius of the largest contact within which its level lines are those known."""

_EXPECTED = 0.02
"""Relative error of the force of a saturated contact, beside that of the elastic law."""

_STEEPEST = 1e12
"""Largest factor of a pressure field that is cut."""


class CappedLaw:
    """A law `solve` of elastic contacts of a profile by their approaches [m], (n,), made one of
    contacts under the hardness of a half-space."""

    def __init__(
        self,
        solve: Callable[[Array], Indentation],
        profile: PowerSumProfile | PolarProfile,
        material: HalfSpace,
    ) -> None:
        self._solve = solve
        self._profile = profile
        self._material = material
        self._lines: CubicSpline | None = None
        self._size = 0.0

    def at(self, depth: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        """Contacts of the areas of the elastic ones at the approaches `depth` [m], shape (n,).

        Returns
        -------
        values, changes
            "approach", "force", "saturated", "yielding" (as of `capped`) and "filling", the mean
            pressure over the hardness; and their derivatives d/d ln(depth).
        """
        steps = depth * (1 + _STEP * np.arange(-1.0, 2.0)[:, None])
        one = self._solve(steps.ravel())
        area = one.contact_area
        size = float(np.sqrt(np.max(area, where=area > 0, initial=0.0) / np.pi))
        if size > 0 and not self._size / _MOVED <= size <= self._size * _MOVED:
            self._lines, self._size = _level_lines(self._profile, size), size
        level = None
        if self._lines is not None:
            level = np.exp(self._lines(np.log(np.where(area > 0, area, np.nan))))
        growth = np.gradient(one.force.reshape(steps.shape), _STEP, axis=0)[1]
        rise = np.tile(np.divide(growth, depth, out=np.zeros_like(depth), where=depth > 0), 3)
        stiffness = np.where(np.isnan(one.stiffness), rise, one.stiffness)
        found = capped(one.approach, one.force, area, stiffness, self._material, level=level)
        parts = found._asdict()
        full = self._material.hardness * np.where(area > 0, area, 1.0)
        parts["filling"] = found.force / full
        rows = {name: part.reshape(steps.shape) for name, part in parts.items()}
        values = {name: row[1] for name, row in rows.items()}
        with np.errstate(invalid="ignore"):
            changes = {name: (row[2] - row[0]) / (2 * _STEP) for name, row in rows.items()}
        return values, changes

    def contact(self, depth: Array) -> Indentation:
        """The contacts that have the areas of the elastic ones at the approaches `depth` [m]."""
        elastic = self._solve(depth)
        values, changes = self.at(depth)
        moved = changes["approach"]
        slope = np.divide(changes["force"], moved, out=np.zeros(depth.shape), where=moved > 0)
        yielded = values["yielding"] > 1
        force, hardness = np.where(yielded, values["force"], np.nan), self._material.hardness

        def cut(name: str) -> Field:
            """A pressure of the elastic contacts, raised and cut at the hardness where they yield;
            each alone tells its factor."""
            pressure: Field = getattr(elastic, name)

            @lru_cache(maxsize=depth.size)
            def factor(row: int) -> float:
                one = self._solve(depth[row : row + 1])
                return _factor(getattr(one, name), one.contour_function, force[row], hardness)

            def bounded(r: Array, phi: Array) -> Array:
                rows = pressure(r, phi)
                for row in np.flatnonzero(np.isfinite(force)):
                    rows[row] *= factor(int(row))
                return np.clip(rows, 0.0, hardness)

            return bounded

        return replace(
            elastic,
            material=self._material,
            approach=values["approach"],
            force=values["force"],
            stiffness=np.where(yielded, slope, elastic.stiffness),
            flags=self._flags(elastic, values["approach"]),
            error_estimate=elastic.error_estimate + _EXPECTED * values["saturated"],
            saturated=values["saturated"],
            pressure_function=cut("pressure_function"),
            history_function=elastic.history_function and cut("history_function"),
        )

    def _flags(self, elastic: Indentation, approach: Array) -> NDArray[np.uint8]:
        """Flags of the elastic contact; another summit is one below the approach itself."""
        phi = 2 * np.pi * np.arange(_RAYS) / _RAYS
        own = profile_flags(self._profile, approach, phi, elastic.contour_function(phi))
        second = np.uint8(Flag.SECOND_SUMMIT)
        return np.asarray((elastic.flags & ~second) | (own & second))


def _level_lines(profile: PowerSumProfile | PolarProfile, radius: float) -> CubicSpline:
    """Logarithm of the gap [m] of the level lines of a profile, by that of the area [m^2] that
    each encloses, for those of 1e-6 to 100 times the radius [m] of a contact."""
    phi = 2 * np.pi * np.arange(_RAYS) / _RAYS
    r = radius * np.geomspace(_SMALLEST, _LARGEST, _LINES)
    with np.errstate(over="ignore"):
        gap = np.nan_to_num(profile(r[:, None], phi), nan=0.0, posinf=1e300)
    gap = np.log(np.maximum.accumulate(np.maximum(gap, 1e-300), axis=0))
    gap += 1e-12 * np.arange(_LINES)[:, None]
    z = np.linspace(gap[0].max(), gap[-1].min(), _LINES)
    lines = np.exp([PchipInterpolator(ray, np.log(r))(z) for ray in gap.T])
    return CubicSpline(np.log(np.pi * np.mean(lines**2, axis=0)), z)


def _factor(
    pressure: Field, contour: Callable[[Array], Array], force: float, hardness: float
) -> float:
    """Factor of the pressure (r, phi) of one elastic contact at which, cut at the hardness [Pa],
    it carries the force [N] within the contour (phi)."""
    phi = np.repeat(2 * np.pi * np.arange(_RAYS) / _RAYS, _RADII)
    inside = np.tile((np.arange(_RADII) + 0.5) / _RADII, _RAYS)
    edge = contour(phi)[0]
    share = np.maximum(pressure(edge * np.sqrt(inside), phi)[0], 0.0) / hardness
    weight = np.pi * edge**2 / edge.size
    goal = force / hardness
    low, high = 0.0, np.log(_STEEPEST)
    for _ in range(60):
        middle = (low + high) / 2
        carried = weight @ np.minimum(share * np.exp(middle), 1.0)
        low, high = (middle, high) if carried < goal else (low, middle)
    return float(np.exp(high))
