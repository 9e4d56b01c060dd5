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
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator, RectBivariateSpline
from scipy.special import hyp2f1, roots_jacobi

from asperity.halfspace.material import HalfSpace
from asperity.halfspace.transforms import kappa
from surfaces.arrays import Array

from .basis import Basis, PowerBasis

__all__ = ["axisymmetric", "history", "of_harmonics", "of_unit_powers"]

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


def axisymmetric(basis: Basis, material: HalfSpace, r: Array, a: Array) -> Array:
    """Pressure [Pa] under the mean profile (equations 28, 51 of a round contact) at the radii `r`,
    shape (k, points), in contacts of radius `a` [m], shape (k,).

    Notes
    -----
    ``p(r) = E/pi int_r^a D'(x) (x^2 - r^2)^((m-1)/2) dx``. A power law is a hypergeometric
    function of 1 - (r/a)^2; at r = 0 it is infinite for k <= 1 - m. A table goes through
    ``x^2 = r^2 + s (a^2 - r^2)`` and a Gauss-Jacobi rule in s.
    """
    rho = np.minimum(r / a[:, None], 1.0)
    z = (1 - rho) * (1 + rho)
    shape = _of_powers(basis, z, a) if isinstance(basis, PowerBasis) else _of_table(basis, z, a)
    return np.asarray(material.modulus / np.pi * z ** ((1 + material.m) / 2) * shape)


def _of_powers(basis: PowerBasis, z: Array, a: Array) -> Array:
    """Shape of the pressure of a sum of powers at z = 1 - (r/a)^2, shape (k, points)."""
    m, total = basis.m, np.zeros_like(z)
    for mean, k in zip(basis.means, basis.powers.tolist(), strict=True):
        total += (mean * a ** (k + m - 1))[:, None] * _of_power(k, z, m)
    return total


def _of_power(k: float, z: Array, m: float) -> Array:
    """Shape of the pressure under r^k, over r^(k+m-1), at z = 1 - (r/a)^2."""
    return np.asarray(kappa(m, k) * k / (1 + m) * hyp2f1(1 - k / 2, 1.0, (3 + m) / 2, z))


def of_unit_powers(coefficients: Array, rho: Array, m: float) -> Array:
    """Pressure under ``sum_k c_k rho^k`` in a contact of radius 1, over the modulus, at radii."""
    z = (1 - rho) * (1 + rho)
    shapes = (c * _of_power(float(k), z, m) for k, c in enumerate(coefficients.tolist()) if k)
    return np.asarray(z ** ((1 + m) / 2) / np.pi * sum(shapes, np.zeros_like(z)))


def _of_table(basis: Basis, z: Array, a: Array) -> Array:
    """Shape of the pressure of a table at z = 1 - (r/a)^2, shape (k, points)."""
    s, w = _edge_rule(basis.m)
    grid = np.linspace(0.0, 1.0, _RADII) ** 2
    x = np.max(a) * (np.arange(1, _SLOPES + 1) / _SLOPES) ** 1.5
    slope = basis.depth(x, 1) / x
    first = np.maximum(slope[0] - x[0] * (slope[1] - slope[0]) / (x[1] - x[0]), 0.0)
    spline = PchipInterpolator(np.append(0.0, x), np.append(first, slope))
    total = np.empty_like(z)
    for row, (radius, where) in enumerate(zip(a, z, strict=True)):
        x = radius * np.sqrt(grid[::-1, None] * (1 - s) + s)
        values = np.sum(w * spline(x) / x, axis=1) / 2 * radius ** (1 + basis.m)
        total[row] = PchipInterpolator(1 - grid[::-1], values)(where)
    return total


def of_harmonics(
    basis: Basis, material: HalfSpace, r: Array, phi: Array, a: float, ratios: Complex
) -> Array:
    """What the exact punches of each harmonic add to `axisymmetric` at points (p,), stretched to
    the radius `a` [m].

    `ratios` are the amplitudes of the contour over `a`, harmonics n = 1, 2, ....
    """
    m = material.m
    rho = np.sin(np.pi / 2 * np.linspace(0.0, 1.0, _RADII))
    s, w = _edge_rule(m)
    x = a * np.sqrt(rho[:, None] ** 2 * (1 - s) + s)
    slope: Array = basis.depth(x.ravel(), 1).reshape(x.shape) / x * w / (2 * x)
    inner = a * rho[:, None] / x
    count = min(ratios.size, _RESOLVED)
    table = np.empty((rho.size, count))
    for i in range(count):
        table[:, i] = np.sum(slope * _punch_factor(inner, i + 1), axis=1)
    inside = np.minimum(r / a, 1.0)
    weight = a ** (1 + m) * ((1 - inside) * (1 + inside)) ** ((1 + m) / 2)
    order = np.arange(1, count + 1)
    wave = (ratios[:count] * np.exp(1j * np.multiply.outer(phi, order))).real
    total = np.sum(CubicSpline(rho, table)(inside) * wave, axis=1)
    return np.asarray(-(1 - m) * material.modulus / np.pi * weight * total)


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


def history(
    basis: Basis,
    material: HalfSpace,
    contour: Callable[[Array, Array], Array],
    ratios: Callable[[Array], Complex] | None,
    a: float,
    r: Array,
    phi: Array,
) -> Array:
    """Pressure [Pa] by the history integral at the points (r, phi), shape (p,), in the contact of
    radius `a` [m]; NaN where the boundary has not only grown on the ray of the point.

    Parameters
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
    m = material.m
    s, w = _edge_rule(m)
    past = a * np.arange(1, _HISTORY + 1) / _HISTORY
    shapes = None if ratios is None else ratios(past)[:, :_RESOLVED]

    def resolved(angle: float, then: Array, rho: Array) -> Array:
        """1 - (1 - m) times the sum over n of d_n cos(n phi) q_n(rho) at the radii a* `then`."""
        total = np.ones_like(then)
        if shapes is None:
            return total
        order = np.arange(1, shapes.shape[1] + 1)
        wave = (shapes * np.exp(1j * order * angle)).real
        for column, n in zip(wave.T, order, strict=True):
            if np.any(column):
                total -= (1 - m) * np.interp(then, past, column) * _punch_factor(rho, n)
        return total

    def on_ray(angle: float, earlier: Array, r: Array) -> Array:
        """Pressure at the radii `r` of a ray, of whose boundaries those at `past` are `earlier`."""
        line = np.append(0.0, earlier)
        if np.any(np.diff(line) <= 0):
            return np.full(r.shape, np.nan)
        span = np.maximum((line[-1] - r) * (line[-1] + r), 0.0)
        edge = np.sqrt(r[:, None] ** 2 + s * span[:, None])
        inverse = PchipInterpolator(line, np.append(0.0, past))
        then = np.maximum(inverse(edge), 1e-300)
        slope = basis.depth(then.ravel(), 1).reshape(then.shape) / then
        rate = slope * inverse(edge, 1) / (2 * edge) * (edge / then) ** (1 - m)
        total = span ** ((1 + m) / 2) * ((rate * resolved(angle, then, r[:, None] / edge)) @ w)
        return np.asarray(material.modulus / np.pi * np.where(span > 0, total, 0.0))

    if r.size <= _FEW:
        rays = zip(phi, contour(past, phi).T, r[:, None], strict=True)
        return np.concatenate([np.empty(0), *(on_ray(*ray) for ray in rays)])
    u = np.linspace(0.08, 0.995, _HISTORY_RADII)
    angles = 2 * np.pi * np.arange(-4, _HISTORY_RAYS + 4) / _HISTORY_RAYS
    rho = u * u
    boundaries = zip(angles, contour(past, angles).T, strict=True)
    table = np.stack([on_ray(angle, earlier, rho * earlier[-1]) for angle, earlier in boundaries])
    spline = RectBivariateSpline(angles, u, table / (1 - rho * rho) ** ((1 + m) / 2))
    edge = contour(np.array([a]), phi)[0]
    share = np.where(edge > r, r / np.where(edge > 0, edge, 1.0), 1.0)
    place = np.clip(np.sqrt(share), u[0], 1.0)
    smooth = spline(np.mod(phi, 2 * np.pi), place, grid=False)
    return np.asarray(smooth * (1 - share * share) ** ((1 + m) / 2))
