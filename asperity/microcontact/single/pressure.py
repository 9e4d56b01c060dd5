"""Pressure of one contact: the field about the circle, and the full history integral.

The published field (Popov, Li & Willert 2023, equations 12, 29, 52) is a sequence of flat punches
whose pressure is stretched to their contour. That is exact to first order for the second angular
harmonic only. On a nearly round punch of contour ``a (1 + sum d_n cos n phi)`` the exact
first-order field has, for each n, the factor

    1 - (1-m) d_n cos(n phi) q_n(rho),   q_n(rho) = (rho^n - rho^2) / (1 - rho^2),

since ``rho^n (1-rho^2)^((m-3)/2) cos n phi`` leaves no displacement. The harmonic-resolved law
uses it. By the full history integral (equations 28, 51) every earlier contact is a flat punch of
its own contour, published or with those factors.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator, RectBivariateSpline
from scipy.special import hyp2f1, roots_jacobi

from asperity.halfspace.material import HalfSpace

from .basis import Basis, PowerBasis

__all__ = ["AxisymmetricPressure", "HistoryPressure"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_POINTS = 64
"""Nodes of the Gauss-Jacobi rule of the edge."""

_SLOPES = 400
"""Radii at which the slope of a tabulated approach is kept."""

_RADII = 160
"""Radii at which a field is tabulated."""

_RESOLVED = 96
"""Harmonics with a pressure of their own."""

_HISTORY = 120
"""Earlier contacts between which the contour is interpolated."""

_HISTORY_RAYS, _HISTORY_RADII = 128, 40
"""Polar table of the pressure at many points."""

_FEW = 500
"""Points up to which each is integrated by itself."""


@dataclass(frozen=True, eq=False)
class AxisymmetricPressure:
    """Pressure p(r) [Pa] under the mean profile (equations 28, 51 of a round contact).

    Notes
    -----
    ``p(r) = E/pi int_r^a D'(x) (x^2 - r^2)^((m-1)/2) dx``. A power law is a hypergeometric
    function of 1 - (r/a)^2; at r = 0 it is infinite for k <= 1 - m. A table goes through
    ``x^2 = r^2 + s (a^2 - r^2)`` and a Gauss-Jacobi rule in s.
    """

    basis: Basis
    material: HalfSpace

    def __call__(self, r: Array, a: Array) -> Array:
        """Pressure at the radii `r`, shape (k, points), in contacts of radius `a`, shape (k,)."""
        rho = np.minimum(r / a[:, None], 1.0)
        z = (1 - rho) * (1 + rho)
        m = self.material.m
        shape = self._power_law if isinstance(self.basis, PowerBasis) else self._table
        return np.asarray(self.material.modulus / np.pi * z ** ((1 + m) / 2) * shape(z, a))

    def resolved(self, r: Array, phi: Array, a: float, ratios: Complex) -> Array:
        """What the exact punches of each harmonic add at points (p,), stretched to the radius `a`.

        `ratios` are the amplitudes of the contour over `a`, harmonics n = 1, 2, ....
        """
        m = self.material.m
        rho = np.sin(np.pi / 2 * np.linspace(0.0, 1.0, _RADII))
        s, w = _edge_rule(m)
        x = a * np.sqrt(rho[:, None] ** 2 * (1 - s) + s)
        slope = np.asarray(self._slope_at(x, a) * w / (2 * x))
        count = min(ratios.size, _RESOLVED)
        table = np.empty((rho.size, count))
        inner = np.asarray(a * rho[:, None] / x)
        for i in range(count):
            table[:, i] = np.sum(slope * _punch_factor(inner, i + 1), axis=1)
        inside = np.minimum(r / a, 1.0)
        weight = a ** (1 + m) * ((1 - inside) * (1 + inside)) ** ((1 + m) / 2)
        order = np.arange(1, count + 1)
        wave = (ratios[:count] * np.exp(1j * np.multiply.outer(phi, order))).real
        total = np.sum(CubicSpline(rho, table)(inside) * wave, axis=1)
        return np.asarray(-(1 - m) * self.material.modulus / np.pi * weight * total)

    def _slope_at(self, x: Array, a: float) -> Array:
        """D'(x), closed for power laws, splined for tables."""
        if isinstance(self.basis, PowerBasis):
            return np.asarray((self.basis.depth(x.ravel(), 1) / x.ravel()).reshape(x.shape))
        return np.asarray(self._slope(a)(x))

    def _power_law(self, z: Array, a: Array) -> Array:
        basis, m = self.basis, self.material.m
        assert isinstance(basis, PowerBasis)
        total = np.zeros_like(z)
        for factor, k in zip(basis.depth_factors * basis.powers, basis.powers, strict=True):
            scale = factor * a ** (k + m - 1) / (1 + m)
            total += scale[:, None] * hyp2f1(1 - k / 2, 1.0, (3 + m) / 2, z)
        return total

    def _table(self, z: Array, a: Array) -> Array:
        m = self.material.m
        s, w = _edge_rule(m)
        grid = np.linspace(0.0, 1.0, _RADII) ** 2
        slope = self._slope(float(np.max(a)))
        total = np.empty_like(z)
        for row, (radius, where) in enumerate(zip(a, z, strict=True)):
            x = radius * np.sqrt(grid[::-1, None] * (1 - s) + s)
            values = np.sum(w * slope(x) / x, axis=1) / 2 * radius ** (1 + m)
            total[row] = PchipInterpolator(1 - grid[::-1], values)(where)
        return total

    def _slope(self, top: float) -> PchipInterpolator:
        """D'(x) up to the radius `top`."""
        x = top * (np.arange(1, _SLOPES + 1) / _SLOPES) ** 1.5
        slope = self.basis.depth(x, 1) / x
        first = np.maximum(slope[0] - x[0] * (slope[1] - slope[0]) / (x[1] - x[0]), 0.0)
        return PchipInterpolator(np.append(0.0, x), np.append(first, slope))


def _punch_factor(rho: Array, order: int) -> Array:
    """q_n(rho) = (rho^n - rho^2) / (1 - rho^2), with its limit 1 - n/2 at the edge."""
    square = (1 - rho) * (1 + rho)
    near = square < 1e-7
    return np.where(near, 1 - order / 2, (rho**order - rho**2) / np.where(near, 1.0, square))


@lru_cache(maxsize=8)
def _edge_rule(m: float) -> tuple[Array, Array]:
    """Nodes and weights of ``int_0^1 h(s) s^((m-1)/2) ds``."""
    q = (m - 1) / 2
    x, w = roots_jacobi(_POINTS, 0, q)
    return (1 + x) / 2, w * 2 ** (-q - 1)


@dataclass(frozen=True, eq=False)
class HistoryPressure:
    """Pressure of one contact by the history integral.

    Attributes
    ----------
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
        u = np.linspace(0.08, 0.995, _HISTORY_RADII)
        angles = 2 * np.pi * np.arange(-4, _HISTORY_RAYS + 4) / _HISTORY_RAYS
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
        s, w = _edge_rule(m)
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
        place, moments = share * _HISTORY - 1, np.arange(_HISTORY)
        total = np.zeros_like(share)
        for column, order in zip(wave.T, n, strict=True):
            if np.any(column):
                total += np.interp(place, moments, column) * _punch_factor(rho, order)
        return total
