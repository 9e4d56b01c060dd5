"""Pressure by the full history integral: every earlier contact is a flat punch of its own contour.

Equations 28 and 51, with the published punches or with those of `pressure` for each harmonic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator, RectBivariateSpline

from asperity.halfspace.material import HalfSpace

from .basis import Basis
from .pressure import edge_rule, punch_factor

__all__ = ["HistoryPressure"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_HISTORY = 120
"""Earlier contacts between which the contour is interpolated."""

_RESOLVED = 96
"""Harmonics with a punch of their own."""

_RAYS, _RADII = 128, 40
"""Polar table of the pressure at many points."""

_FEW = 500
"""Points up to which each is integrated by itself."""


@dataclass(frozen=True, eq=False)
class HistoryPressure:
    """Pressure of one contact by the history integral.

    Parameters
    ----------
    basis
        Transforms of the profile.
    material
        Half-space.
    contour
        Function (radii, angles) -> boundary a*(phi) [m] of the earlier contacts.
    ratios
        Function radii -> amplitudes of their contours over the radius, for the harmonic-resolved
        punches; None for the published ones.

    Notes
    -----
    ``p = E/pi int (a*(phi)/a*)^(1-m) D'(a*) (a*(phi)^2 - r^2)^((m-1)/2) da*`` over the contacts
    that hold the point, by a Gauss-Jacobi rule in ``a*(phi)^2 - r^2``. More than 500 points are
    interpolated from a polar table (at its innermost radius where they lie further in).
    """

    basis: Basis
    material: HalfSpace
    contour: Callable[[Array, Array], Array]
    ratios: Callable[[Array], Complex] | None = None

    def __call__(self, a: float, r: Array, phi: Array) -> Array:
        """Pressure [Pa] at the points (r, phi), shape (p,), in the contact of radius `a` [m].

        NaN where the boundary has not only grown on the ray of the point.
        """
        if r.size <= _FEW:
            rays = self._rays(a, phi)
            return np.array([self._on_ray(a, rays, i, r[i : i + 1])[0] for i in range(r.size)])
        m = self.material.m
        u = np.linspace(0.08, 0.995, _RADII)
        angles = 2 * np.pi * np.arange(-4, _RAYS + 4) / _RAYS
        rays = self._rays(a, angles)
        rho = u * u
        table = np.stack(
            [self._on_ray(a, rays, i, rho * rays.edges[-1, i]) for i in range(angles.size)]
        )
        spline = RectBivariateSpline(angles, u, table / (1 - rho * rho) ** ((1 + m) / 2))
        edge = self.contour(np.array([a]), phi)[0]
        share = np.where(edge > r, r / np.where(edge > 0, edge, 1.0), 1.0)
        place = np.clip(np.sqrt(share), u[0], 1.0)
        smooth = spline(np.mod(phi, 2 * np.pi), place, grid=False)
        return np.asarray(smooth * (1 - share * share) ** ((1 + m) / 2))

    def _rays(self, a: float, phi: Array) -> _Rays:
        past = a * np.arange(1, _HISTORY + 1) / _HISTORY
        edges = np.vstack([np.zeros(phi.size), self.contour(past, phi)])
        shapes = None if self.ratios is None else self.ratios(past)[:, :_RESOLVED]
        return _Rays(phi, np.append(0.0, past), edges, shapes)

    def _on_ray(self, a: float, rays: _Rays, i: int, r: Array) -> Array:
        """Pressure at the radii `r` of ray i."""
        m = self.material.m
        s, w = edge_rule(m)
        line = rays.edges[:, i]
        if np.any(np.diff(line) <= 0):
            return np.full(r.shape, np.nan)
        span = np.maximum((line[-1] - r) * (line[-1] + r), 0.0)
        edge = np.sqrt(r[:, None] ** 2 + s * span[:, None])
        inverse = PchipInterpolator(line, rays.past)
        then = np.maximum(inverse(edge), 1e-300)
        slope = self.basis.depth(then.ravel(), 1).reshape(then.shape) / then
        rate = slope * inverse(edge, 1) / (2 * edge) * (edge / then) ** (1 - m)
        if rays.shapes is not None:
            rate *= 1 - (1 - m) * rays.punches(i, then / a, r[:, None] / edge)
        total = span ** ((1 + m) / 2) * (rate @ w)
        return np.asarray(self.material.modulus / np.pi * np.where(span > 0, total, 0.0))


@dataclass(frozen=True, eq=False)
class _Rays:
    """Earlier contours on some rays: a* (k,), a*(phi) (k, rays), amplitudes over a* (k-1, n)."""

    phi: Array
    past: Array
    edges: Array
    shapes: Complex | None

    def punches(self, i: int, share: Array, rho: Array) -> Array:
        """Sum over n of d_n cos(n phi) q_n(rho) at the moments ``share`` of the history."""
        assert self.shapes is not None
        n = np.arange(1, self.shapes.shape[1] + 1)
        wave = (self.shapes * np.exp(1j * n * self.phi[i])).real
        place = np.clip(share * _HISTORY - 1, 0.0, _HISTORY - 1)
        low = np.minimum(place.astype(int), _HISTORY - 2)
        part = place - low
        total = np.zeros_like(share)
        for column, order in zip(wave.T, n, strict=True):
            if np.any(column):
                ratio = column[low] * (1 - part) + column[low + 1] * part
                total += ratio * punch_factor(rho, order)
        return total
