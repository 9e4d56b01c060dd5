"""Exact Hertz contact of an elliptic paraboloid on a homogeneous or graded half-space."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import Flag, InputError
from asperity.halfspace.material import HalfSpace
from surfaces.arrays import Array

from .law_table import LawTable

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

    from surfaces.peaks.profiles import Profiles

__all__ = [
    "ASPECT_EXPONENT",
    "EllipticContact",
    "axis_ratios",
    "curvature_ratios",
    "elliptic_contact",
    "tabulate",
]


_INTERVALS = 16
"""Intervals of a table; force and area are exact on any number."""

ASPECT_EXPONENT = 0.63
"""Exponent of the axis ratio of an elliptic contact, b/a = (k2/k1)^0.63, with k1 > k2 the principal
curvatures: within 3 % of Hertz's elliptic integrals up to a curvature ratio of 30."""

_STEP, _TAIL = 0.32, 32.0
"""Step and half-width of the trapezoidal rule of `_integrals`."""


class EllipticContact(NamedTuple):
    """Contact of ``f = (k1 X^2 + k2 Y^2) / 2``, k1 >= k2, at the approach d.

    Attributes
    ----------
    semi_minor, semi_major
        Half-axes [m] along X (the larger curvature) and Y.
    force
        Normal force [N].
    stiffness
        dF/dd [N/m].
    peak_pressure
        Pressure [Pa] at the centre; it falls as (1 - rho^2)^((1+m)/2).
    """

    semi_minor: Array
    semi_major: Array
    force: Array
    stiffness: Array
    peak_pressure: Array


def elliptic_contact(
    k1: ArrayLike, k2: ArrayLike, approach: ArrayLike, material: HalfSpace
) -> EllipticContact:
    """Exact contact of an elliptic paraboloid of positive principal curvatures [1/m] of the gap, in
    any order, at a non-negative approach [m], any m (broadcast over all arguments).

    Raises
    ------
    InputError
        If a curvature is not positive.

    Notes
    -----
    A pressure ``p0 (1 - x^2/a^2 - y^2/b^2)^((1+m)/2)`` leaves a paraboloidal displacement; its
    coefficients are integrals of ``alpha^(1-m)``, ``alpha^(3-m)`` over the directions. The aspect
    b/a follows from the ratio of the curvatures by Newton steps from a tabulated inverse.
    """
    first, second, d = (np.asarray(v, dtype=float) for v in (k1, k2, approach))
    if np.any(~(first > 0)) or np.any(~(second > 0)):
        raise InputError("both principal curvatures must be positive")
    m = material.m
    high, low = np.maximum(first, second) / 2, np.minimum(first, second) / 2
    beta = _aspect(high / low, m)
    depth, along, _across = _integrals(beta, m)
    # With b = beta a, per unit c a^(1-m): d = depth, A = along / a^2.
    major = np.sqrt(d * along / (depth * low))
    c = np.where(d > 0, d, 0.0) / (depth * np.where(d > 0, major, 1.0) ** (1 - m))
    peak = 2 * material.modulus * c / (1 + m)
    force = 2 * np.pi * beta * major**2 * peak / (3 + m)
    stiffness = (3 + m) / 2 * force / np.where(d > 0, d, 1.0)
    return EllipticContact(beta * major, major, force, stiffness, peak)


def axis_ratios(curvature: Array, m: float) -> Array:
    """Short over long axis of contacts on summits with principal curvatures [1/m], shape (n, 2),
    the larger first."""
    steep, shallow = curvature.T
    flatness = np.divide(shallow, steep, out=np.ones(len(steep)), where=steep > 0)
    curve = _aspect_curve(m)
    place = np.maximum(np.log(np.clip(flatness, 1e-6, 1.0)), curve.x[0])
    return np.asarray(np.exp(np.minimum(curve(place), 0.0)))


def curvature_ratios(axes: Array, m: float) -> Array:
    """Larger over smaller principal curvature of summits whose contacts have half-axes of the
    ratio `axes`, short over long."""
    _, along, across = _integrals(axes, m)
    return across / along


def tabulate(profiles: Profiles, material: HalfSpace) -> LawTable:
    """Law table of the summits' curvatures; it ends where the ellipse has the basin's area."""
    k1, k2 = profiles.curvature[:, 0], profiles.curvature[:, 1]
    valid = np.isfinite(k1) & (k2 > 0) & np.all(profiles.edge > 0, axis=1)
    k1, k2 = np.where(valid, k1, 1.0), np.where(valid, k2, 1.0)
    p, one = 3 + material.m, elliptic_contact(k1, k2, 1.0, material)  # axes grow as u, force as u^p
    basin = 0.5 * np.sum(profiles.weight * profiles.edge**2, axis=1)
    reach = np.where(valid, basin / (np.pi * one.semi_minor * one.semi_major), 0.0)
    u = np.linspace(0.0, 1.0, _INTERVALS + 1)
    area = np.where(valid, basin, 0.0)[:, None] * u**2
    force = (one.force * reach ** (p / 2))[:, None] * u**p
    stiffness = (one.force * p / 2 * reach ** (p / 2 - 1))[:, None] * u ** (p - 2)
    flags = np.zeros(force.shape, dtype=np.uint8)
    flags[valid, -1] = Flag.FILLED
    return LawTable(reach, force, stiffness, area, flags, np.full(force.shape, np.nan), p)


@lru_cache(maxsize=16)
def _aspect_curve(m: float) -> CubicSpline:
    """ln(b/a) as a function of the logarithm of the curvature ratio."""
    from scipy.interpolate import CubicSpline

    log_beta = np.linspace(np.log(1e-5), 0.0, 400)
    _, along, across = _integrals(np.exp(log_beta), m)
    return CubicSpline(-np.log(across / along), log_beta)


def _aspect(ratio: Array, m: float) -> Array:
    """Aspect b/a in (0, 1] of the contact whose curvature ratio is `ratio` >= 1, refused where it
    is that of a line."""
    curve, target = _aspect_curve(m), -np.log(ratio)
    if np.any(target < curve.x[0]):
        raise InputError(
            f"the curvature ratio {np.max(ratio):.3g} is too large for a point contact"
        )
    log_beta = np.minimum(curve(target), 0.0)
    slope = curve(target, 1)
    for _ in range(2):
        _, along, across = _integrals(np.exp(log_beta), m)
        log_beta = np.minimum(log_beta + slope * (target + np.log(across / along)), 0.0)
    return np.asarray(np.exp(log_beta))


def _integrals(beta: Array, m: float) -> tuple[Array, Array, Array]:
    """d, A a^2, B a^2 per c a^(1-m) of the ellipse with half-axes a and b = beta a.

    Integrals over the direction theta with ``tan theta = e^x``: the poles lie a quarter turn from
    the real axis for every aspect, so the trapezoidal rule errs by e^(-pi^2/step).
    """
    ratio = np.asarray(beta, dtype=float)[..., None]
    start = np.log(ratio.min(initial=1.0)) - _TAIL
    x = start + _STEP * np.arange(int((_TAIL - start) / _STEP) + 1)
    cosine = 1 / (1 + np.exp(2 * x))
    sine = 1 / (1 + np.exp(-2 * x))
    square = 1 / (cosine + sine / ratio**2)
    weight = _STEP / np.cosh(x) * square ** ((1 - m) / 2)
    along_x = np.sum(weight * square * cosine, axis=-1)
    along_y = np.sum(weight * square * sine / ratio**2, axis=-1)
    beta = ratio[..., 0]
    return along_x + along_y, along_y + m * along_x, (along_x + m * along_y) / beta**2
