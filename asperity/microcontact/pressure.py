"""Pressure inside one contact: the field of the mean profile, and the full history integral."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.special import hyp2f1, roots_jacobi

from asperity.material import HalfSpace

from .basis import Basis, PowerBasis

__all__ = ["AxisymmetricPressure", "history_pressure"]

Array = NDArray[np.float64]

_POINTS = 64
_SLOPES = 400
_RADII = 160
_HISTORY = 120


class AxisymmetricPressure:
    """Pressure p(r) [Pa] under the mean profile (equations 28, 51 without the history).

    Parameters
    ----------
    basis
        Transforms of the profile.
    material
        Half-space.

    Notes
    -----
    ``p(r) = E/pi int_r^a D'(x) (x^2 - r^2)^((m-1)/2) dx``. A power law is a hypergeometric
    function of 1 - (r/a)^2; at r = 0 it is infinite for k <= 1 - m. A table goes through
    ``x^2 = r^2 + s (a^2 - r^2)`` and a Gauss-Jacobi rule in s.
    """

    def __init__(self, basis: Basis, material: HalfSpace) -> None:
        self._basis = basis
        self._material = material

    def __call__(self, r: Array, a: Array) -> Array:
        """Pressure at the radii `r`, shape (k, points), in contacts of radius `a`, shape (k,)."""
        rho = np.minimum(r / a[:, None], 1.0)
        z = (1 - rho) * (1 + rho)
        m = self._material.m
        shape = self._power_law if isinstance(self._basis, PowerBasis) else self._table
        return np.asarray(self._material.modulus / np.pi * z ** ((1 + m) / 2) * shape(z, a))

    def _power_law(self, z: Array, a: Array) -> Array:
        basis, m = self._basis, self._material.m
        assert isinstance(basis, PowerBasis)
        total = np.zeros_like(z)
        for factor, k in zip(basis.depth_factors * basis.powers, basis.powers, strict=True):
            scale = factor * a ** (k + m - 1) / (1 + m)
            total += scale[:, None] * hyp2f1(1 - k / 2, 1.0, (3 + m) / 2, z)
        return total

    def _table(self, z: Array, a: Array) -> Array:
        m = self._material.m
        s, w = self._rule
        grid = np.linspace(0.0, 1.0, _RADII) ** 2
        slope = self._slope(float(np.max(a)))
        total = np.empty_like(z)
        for row, (radius, where) in enumerate(zip(a, z, strict=True)):
            x = radius * np.sqrt(grid[::-1, None] * (1 - s) + s)
            values = np.sum(w * slope(x) / x, axis=1) / 2 * radius ** (1 + m)
            total[row] = PchipInterpolator(1 - grid[::-1], values)(where)
        return total

    @cached_property
    def _rule(self) -> tuple[Array, Array]:
        return _edge_rule(self._material.m)

    def _slope(self, top: float) -> PchipInterpolator:
        """D'(x) up to the radius `top`."""
        x = top * (np.arange(1, _SLOPES + 1) / _SLOPES) ** 1.5
        slope = self._basis.depth(x, 1) / x
        first = np.maximum(slope[0] - x[0] * (slope[1] - slope[0]) / (x[1] - x[0]), 0.0)
        return PchipInterpolator(np.append(0.0, x), np.append(first, slope))


def history_pressure(
    basis: Basis,
    material: HalfSpace,
    contour: Callable[[Array, Array], Array],
    a: float,
    r: Array,
    phi: Array,
) -> Array:
    """Pressure by the full history integral (equations 28, 51) in a contact of radius `a`.

    Parameters
    ----------
    basis
        Transforms of the profile.
    material
        Half-space.
    contour
        Function (radii, angles) -> boundary a*(phi) [m] of the earlier contacts.
    a
        Present effective radius [m].
    r, phi
        Points, shape (p,).

    Returns
    -------
    pressure
        [Pa], shape (p,); NaN where the boundary has not only grown on the ray of the point.

    Notes
    -----
    ``p = E/pi int (a*(phi)/a*)^(1-m) D'(a*) (a*(phi)^2 - r^2)^((m-1)/2) da*`` over the contacts
    that hold the point, by a Gauss-Jacobi rule in ``a*(phi)^2 - r^2``.
    """
    m = material.m
    s, w = _edge_rule(m)
    past = a * np.arange(1, _HISTORY + 1) / _HISTORY
    edges = np.vstack([np.zeros(phi.size), contour(past, phi)])
    past = np.append(0.0, past)
    out = np.zeros(phi.size)
    growing = np.all(np.diff(edges, axis=0) > 0, axis=0)
    out[~growing] = np.nan
    for i in np.flatnonzero(growing & (edges[-1] > r)):
        span = (edges[-1, i] - r[i]) * (edges[-1, i] + r[i])
        edge = np.sqrt(r[i] ** 2 + s * span)
        inverse = PchipInterpolator(edges[:, i], past)
        then = inverse(edge)
        slope = basis.depth(then, 1) / then
        rate = slope * inverse(edge, 1) / (2 * edge)
        out[i] = span ** ((1 + m) / 2) * np.sum(w * (edge / then) ** (1 - m) * rate)
    return np.asarray(material.modulus / np.pi * out)


def _edge_rule(m: float) -> tuple[Array, Array]:
    """Nodes and weights of ``int_0^1 h(s) s^((m-1)/2) ds``."""
    q = (m - 1) / 2
    x, w = roots_jacobi(_POINTS, 0, q)
    return (1 + x) / 2, w * 2 ** (-q - 1)
