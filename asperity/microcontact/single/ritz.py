"""Law "ritz" of one contact: direct maximization of the Barber-Fabrikant functional.

F[a] = 2 E / J int [d a^2 / (1+m) - a^2 G~(a, phi)] dphi with J = int a^(1-m) dphi (Popov, Li &
Willert 2023, equations 10, 15) is maximized first over ellipses with a shift, then over every ray.
The functional is exact for ellipses about their centre only: over free rays its maximum is too
large where contacts are elongated (+2.6 % in force at a curvature ratio of 10, +8.5 % at 30), and
its value depends on the origin. Where the free rays of a narrow contact do not converge, the best
ellipse is taken if it is nearly as good.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial.polynomial import polyval
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize

from asperity.errors import Flag
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.transforms import gauss_jacobi
from surfaces.arrays import Array
from surfaces.polar import PolarProfile, PowerSumProfile

from .basis import basis_of, radius_at
from .indentation import Indentation, contour_flags, profile_flags

__all__ = ["indent"]


_RAYS = 180
"""Free rays of a planform."""

_RADII, _DENSE = 120, 1.6
"""Radii of the tables up to `_DENSE` times that of the first-order contact; a third beyond."""

_STEPS = 200
"""Iterations of the free rays."""

_REACH = 7.0
"""Radius of the tables of a profile over that of the first-order contact."""

_WIDEST = 2.0
"""Logarithm of the root of the largest aspect of an ellipse: longer ones lie between two rays."""

_FARTHEST = 1.0
"""Logarithm of the root of the largest ratio of the distances from the origin to both sides of an
ellipse: the functional grows without bound as the origin leaves it."""

_SPREAD, _OFFSET = 1.5, 0.25
"""Factors of the expected error: of what the free rays add to the ellipse, and of the square of
the distance between the contact's centre and the origin over its radius."""

_NEAR, _NARROW = 0.9, 0.35
"""Value of the best ellipse over that of the free rays, and half the logarithm of its axis ratio,
from which on it stands for rays that do not settle; below, the contact is no narrow ellipse."""

_LOST = 1.001
"""Value of the best ellipse over that of the free rays, above which the search for the rays has
failed: an ellipse is one choice of rays. The error is then NaN, as where the tables end."""

_SMALLEST = 8.0
"""Logarithm of the limit over the smallest ellipse."""

_DEEPEST = 1e3
"""Gap over the approach at which a profile is cut off: no contact reaches so far, and a spline
through larger ones swings in front of them."""


class _Functional:
    """The functional of one profile on equispaced rays.

    Lengths are those of the first-order contact, heights those of the approach, the modulus is 1: a
    search takes the same way in every unit.
    """

    def __init__(
        self, profile: PowerSumProfile | PolarProfile, m: float, depth: float, radius: float
    ) -> None:
        self.m, self.phi = m, 2 * np.pi * np.arange(_RAYS) / _RAYS
        self.limit = min(_REACH, profile.radius / radius)
        self._profile, self._depth, self._radius = profile, depth, radius
        dense = min(_DENSE, self.limit)
        a = np.linspace(0, dense, _RADII + 1)
        if dense < self.limit:
            a = np.append(a, np.geomspace(dense, self.limit, _RADII // 3)[1:])
        gap = self._exact(np.broadcast_to(a[1:, None], (a.size - 1, _RAYS)))
        spline = CubicSpline(a, np.vstack([np.zeros(_RAYS), gap]))
        self._ends = a[:-1]
        self._cubics = [spline.derivative(order).c for order in range(3)]

    def gap(self, a: Array, order: int = 0) -> Array:
        """Tabulated a^2 G~ or a derivative of it, each ray at its own radius `a`, shape (rays,)."""
        cell = np.maximum(np.searchsorted(self._ends, a, side="right") - 1, 0)
        cubic = self._cubics[order][:, cell, np.arange(_RAYS)]
        return np.asarray(polyval(a - self._ends[cell], cubic[::-1], tensor=False))

    def _exact(self, a: Array) -> Array:
        """What the table of the gap holds, at rays `a`, shape (..., rays)."""
        t, weights = gauss_jacobi(self.m, 32)
        with np.errstate(over="ignore"):
            places = self._radius * a[..., None, :] * t[:, None]
            f = np.minimum(self._profile(places, self.phi) / self._depth, _DEEPEST)
        return np.asarray(np.einsum("t,...tp->...p", weights * t, f) * a**2)

    def missed(self, a: Array) -> float:
        """Relative error of the value at the rays `a`, shape (rays,), by the table of the gap."""
        table, exact = self.gap(a), self._exact(a)
        work = np.sum(a**2 / (1 + self.m) - exact)
        return float(abs(np.sum(table - exact)) / max(abs(work), 1e-300))

    def __call__(self, a: Array) -> tuple[float, Array]:
        """Value and gradient at the rays `a`, shape (rays,)."""
        m, weight = self.m, 2 * np.pi / _RAYS
        work = weight * (a**2 / (1 + m) - self.gap(a))
        around = weight * np.sum(a ** (1 - m))
        value = 2 * np.sum(work) / around
        rate = weight * (2 * a / (1 + m) - self.gap(a, 1))
        return float(value), (2 * rate - value * weight * (1 - m) * a ** (-m)) / around

    def ellipse(self, p: Array) -> Array:
        """Rays of an ellipse: log size, log root of the aspect by its two parts, any shift."""
        p = np.append(p, np.zeros(5 - p.size))
        swell = p[1] * np.cos(2 * self.phi) + p[2] * np.sin(2 * self.phi)
        aspect = min(float(np.hypot(p[1], p[2])), _WIDEST)
        swell = swell / max(float(np.hypot(p[1], p[2])), 1e-300)
        shape = np.cosh(2 * aspect) - np.sinh(2 * aspect) * swell
        shift = p[3] * np.cos(self.phi) + p[4] * np.sin(self.phi)
        shift *= min(1.0, _FARTHEST / max(float(np.hypot(p[3], p[4])), 1e-300))
        size = np.exp(np.clip(p[0] + shift, np.log(self.limit) - _SMALLEST, np.log(self.limit)))
        return np.asarray(np.minimum(size / np.sqrt(shape), self.limit))

    def best_ellipse(self) -> tuple[float, Array]:
        """Largest value over {size, aspect, turn, shift} and those parameters."""
        _, centred = self._best(np.zeros(3), 0.1, 1e-3, 1e-6)
        return self._best(np.append(centred, [0.0, 0.0]), 1e-2, 1e-5, 1e-10)

    def refined_ellipse(self, found: Array) -> tuple[float, Array]:
        """Largest value to all digits, and its parameters, from parameters found before."""
        return self._best(found, 1e-4, 1e-8, 1e-14)

    def _best(self, start: Array, step: float, width: float, rise: float) -> tuple[float, Array]:
        options = {
            "xatol": width,
            "fatol": rise * self(self.ellipse(start))[0],
            "maxiter": 2000,
            "initial_simplex": start + step * np.eye(start.size + 1, start.size),
        }
        found = minimize(
            lambda p: -self(self.ellipse(p))[0], start, method="Nelder-Mead", options=options
        )
        return -float(found.fun), found.x

    def best_rays(self, start: Array) -> tuple[float, Array, bool]:
        """Stationary value over free rays near a start, every ray on its outer branch, the rays,
        and whether they settled: on narrow contacts they change branches for ever."""
        m, a = self.m, start.copy()
        value = self(a)[0]
        for _ in range(_STEPS):
            tail = value * (1 - m) * a ** (-m)
            rate = 2 / (1 + m) * a - self.gap(a, 1)
            slope = 2 / (1 + m) - self.gap(a, 2)
            slope = 2 * slope + m * tail / a
            rising = slope > -0.1
            step = np.where(rising, 0.1 * a, -(2 * rate - tail) / np.where(rising, -1.0, slope))
            step = np.clip(step, -0.2 * a, 0.2 * a)
            before, a = a, np.clip(a + step, 1e-9 * self.limit, self.limit)
            change = self(a)[0] - value
            value += 0.7 * change
            if abs(change) < 1e-12 * value and np.abs(a - before).max() < 1e-7 * a.max():
                return self(a)[0], a, True
        return self(a)[0], a, False


def indent(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, approach: Array
) -> Indentation:
    """Solution by the law "ritz"; see `asperity.indent`. It has no pressure field."""
    m, depth = material.m, approach
    start = radius_at(basis_of(profile, m), depth)
    rays = np.full((depth.size, _RAYS), np.nan)
    rays[depth <= 0] = 0.0
    force, lower, free = np.where(depth > 0, np.nan, np.zeros((3, depth.size)))
    missed = np.zeros(depth.size)
    stopped = np.zeros(depth.size, dtype=bool)
    for i in np.flatnonzero(np.isfinite(start) & (start > 0)):
        functional = _Functional(profile, m, float(depth[i]), float(start[i]))
        lower[i], found = functional.best_ellipse()
        free[i], rays[i], settled = functional.best_rays(functional.ellipse(found))
        force[i] = free[i]
        narrow = np.hypot(found[1], found[2]) > _NARROW
        lost = lower[i] > _LOST * free[i]
        if lost or (not settled and narrow and lower[i] > _NEAR * free[i]):
            force[i], found = functional.refined_ellipse(found)
            rays[i] = functional.ellipse(found)
        missed[i] = functional.missed(rays[i])
        stopped[i] = np.max(rays[i]) >= functional.limit
        if lost or stopped[i]:
            free[i] = np.nan
    unit = np.where(np.isfinite(start) & (start > 0), start, 1.0)
    rays *= unit[:, None]
    scale = np.maximum(depth, 0.0) * unit ** (1 + m)
    force, lower, free = (part * scale for part in (force, lower, free))
    phi = 2 * np.pi * np.arange(_RAYS) / _RAYS
    area = np.pi * np.mean(rays**2, axis=1)
    around = 2 * np.pi * np.mean(np.abs(rays) ** (1 - m), axis=1)
    stiffness = np.divide(
        4 * material.modulus * area, (1 + m) * around, out=np.zeros_like(area), where=around != 0
    )
    flags = contour_flags(np.sqrt(area / np.pi), rays) | profile_flags(profile, depth, phi, rays)
    flags[stopped] |= np.uint8(Flag.BEYOND_RADIUS)
    flags[~np.isfinite(force)] |= np.uint8(Flag.TURNING)
    touching = force > 0
    spread = np.where(touching, (free - lower) / np.where(touching, force, 1.0), 0.0)
    centre = np.mean(rays**3 * np.exp(1j * phi), axis=1) * 2 * np.pi / 3
    held = np.where(touching, area, 1.0)
    offset = np.abs(centre) / held / np.sqrt(held / np.pi)
    error = _SPREAD * np.abs(spread) + _OFFSET * offset**2 + missed

    def contour(angle: Array) -> Array:
        return np.stack([np.interp(angle, phi, row, period=2 * np.pi) for row in rays])

    def pressure(r: Array, angle: Array) -> Array:
        return np.full((depth.size, r.size), np.nan)

    return Indentation(
        law="ritz",
        material=material,
        approach=approach,
        force=material.modulus * force,
        contact_area=area,
        radius=np.sqrt(area / np.pi),
        stiffness=stiffness,
        flags=flags,
        error_estimate=error,
        contour_function=contour,
        pressure_function=pressure,
    )
