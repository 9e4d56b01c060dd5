"""One contact under a hardness: from the elastic contact of the same area, by any law."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

from asperity.errors import Flag
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.yielding import capped
from surfaces.polar import PolarProfile, PowerSumProfile

from .indentation import Indentation, profile_flags

__all__ = ["CappedLaw", "LevelLines"]

Array = NDArray[np.float64]
Field = Callable[[Array, Array], Array]

_STEP = 1e-3
"""Relative step of the elastic approach for derivatives."""

_RAYS, _RADII = 97, 64
"""Rays, an odd number since sections with corners are symmetric, and radii on each, at which the
pressure of a contact is looked at."""

_SMALLEST, _LARGEST, _LINES = 1e-6, 1e2, 640
"""Level lines: their radii over that of a contact, and their number."""

_EXPECTED = 0.02
"""Relative error of the force of a saturated contact, beside that of the elastic law."""

_STEEPEST = 1e12
"""Largest factor of a pressure field that is cut."""


class CappedLaw:
    """A law of elastic contacts, made one of contacts under a hardness.

    Parameters
    ----------
    solve
        The elastic law: approaches [m], shape (n,) -> contacts.
    profile
        The profile.
    material
        Half-space with its hardness.
    """

    def __init__(
        self,
        solve: Callable[[Array], Indentation],
        profile: PowerSumProfile | PolarProfile,
        material: HalfSpace,
    ) -> None:
        self._solve = solve
        self._profile = profile
        self._material = material
        self._lines: LevelLines | None = None

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
        if self._lines is None and np.any(area > 0):
            self._lines = LevelLines(self._profile, float(np.sqrt(np.nanmax(area) / np.pi)))
        level = None if self._lines is None else self._lines.gap(area)
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
        values, changes = self.at(depth.ravel())
        shaped = {name: value.reshape(depth.shape) for name, value in values.items()}
        moved = changes["approach"].reshape(depth.shape)
        slope = np.divide(
            changes["force"].reshape(depth.shape), moved, out=np.zeros(depth.shape), where=moved > 0
        )
        yielded = shaped["yielding"] > 1
        cut = _Cut(elastic, np.where(yielded, shaped["force"], np.nan), self._material.hardness)
        history = elastic.history_function
        return replace(
            elastic,
            material=self._material,
            approach=shaped["approach"],
            force=shaped["force"],
            stiffness=np.where(yielded, slope, elastic.stiffness),
            flags=self._flags(elastic, values["approach"]),
            error_estimate=elastic.error_estimate + _EXPECTED * shaped["saturated"],
            saturated=shaped["saturated"],
            pressure_function=cut.field(elastic.pressure_function),
            history_function=None if history is None else cut.field(history),
        )

    def _flags(self, elastic: Indentation, approach: Array) -> NDArray[np.uint8]:
        """Flags of the elastic contact; another summit is one below the approach itself."""
        phi = 2 * np.pi * np.arange(_RAYS) / _RAYS
        own = profile_flags(self._profile, approach, phi, elastic.contour_function(phi))
        second = np.uint8(Flag.SECOND_SUMMIT)
        kept = elastic.flags & ~second
        return np.asarray(kept | (own & second).reshape(kept.shape))


class LevelLines:
    """Gaps of the level lines of a profile, by the areas that they enclose.

    Parameters
    ----------
    profile
        The profile.
    radius
        Radius [m] of a contact; level lines of 1e-6 to 100 times this radius are known.
    """

    def __init__(self, profile: PowerSumProfile | PolarProfile, radius: float) -> None:
        phi = 2 * np.pi * np.arange(_RAYS) / _RAYS
        r = radius * np.geomspace(_SMALLEST, _LARGEST, _LINES)
        with np.errstate(over="ignore"):
            gap = np.nan_to_num(profile(r[:, None], phi), nan=0.0, posinf=1e300)
        gap = np.log(np.maximum.accumulate(np.maximum(gap, 1e-300), axis=0))
        gap += 1e-12 * np.arange(_LINES)[:, None]
        z = np.linspace(gap[0].max(), gap[-1].min(), _LINES)
        lines = np.exp([PchipInterpolator(ray, np.log(r))(z) for ray in gap.T])
        self._spline = CubicSpline(np.log(np.pi * np.mean(lines**2, axis=0)), z)

    def gap(self, area: Array) -> Array:
        """Gaps [m] of the lines that enclose the areas [m^2]; NaN where there is no area."""
        known = area > 0
        return np.where(known, np.exp(self._spline(np.log(np.where(known, area, 1.0)))), np.nan)


class _Cut:
    """Pressure fields of elastic contacts, raised and cut at the hardness where contacts yielded.

    Parameters
    ----------
    elastic
        The elastic contacts.
    force
        Force [N] that each pressure carries when it is cut; NaN where none is.
    hardness
        Largest pressure [Pa].
    """

    def __init__(self, elastic: Indentation, force: Array, hardness: float) -> None:
        self._elastic = elastic
        self._force = force.ravel()
        self._hardness = hardness

    def field(self, pressure: Field) -> Field:
        """The field `pressure` (r, phi) of the elastic contacts, cut."""

        def cut(r: Array, phi: Array) -> Array:
            values = pressure(r, phi)
            for row, force in enumerate(self._force):
                if np.isfinite(force):
                    factor = self._factor(pressure, row)
                    values[row] = np.minimum(values[row] * factor, self._hardness)
            return values

        return cut

    def _factor(self, pressure: Field, row: int) -> float:
        """Factor of a field that makes it carry the force when it is cut."""
        phi = np.repeat(2 * np.pi * np.arange(_RAYS) / _RAYS, _RADII)
        edge = self._elastic.contour_function(phi)[row]
        inside = np.tile((np.arange(_RADII) + 0.5) / _RADII, _RAYS)
        share = pressure(edge * np.sqrt(inside), phi)[row] / self._hardness
        weight = np.pi * edge**2 / edge.size
        goal = self._force[row] / self._hardness
        low, high = 0.0, np.log(_STEEPEST)
        for _ in range(60):
            middle = (low + high) / 2
            carried = weight @ np.minimum(share * np.exp(middle), 1.0)
            low, high = (middle, high) if carried < goal else (low, middle)
        return float(np.exp(high))
