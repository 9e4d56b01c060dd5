"""Exact Hertz contact of an elliptic paraboloid on a homogeneous or graded half-space."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import Flag, InputError
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.transforms import moment_weights
from surfaces.numerics import parallel

from .law_table import LawTable

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

    from surfaces.peaks.profiles import Profiles

__all__ = ["ASPECT_EXPONENT", "EllipticContact", "elliptic_contact", "tabulate"]

Array = NDArray[np.float64]

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


def tabulate(profiles: Profiles, material: HalfSpace) -> LawTable:
    """Law table of the summits' curvatures; it ends where the ellipse has the basin's area."""
    k1, k2 = profiles.curvature[:, 0], profiles.curvature[:, 1]
    valid = np.isfinite(k1) & (k2 > 0) & np.all(profiles.edge > 0, axis=1)
    k1, k2 = np.where(valid, k1, 1.0), np.where(valid, k2, 1.0)
    p, g = 3 + material.m, np.sqrt(k1 * k2)
    log_force, log_minor, log_major = _unit_curve(material.m)(_log_ratio(k1 / k2, material.m)).T
    minor, major = np.exp(log_minor) / np.sqrt(g), np.exp(log_major) / np.sqrt(g)
    basin = 0.5 * np.sum(profiles.weight * profiles.edge**2, axis=1)
    reach = np.where(valid, basin / (np.pi * minor * major), 0.0)
    unit = material.modulus * np.exp(log_force) * g ** (-(1 + material.m) / 2)
    u = np.linspace(0.0, 1.0, _INTERVALS + 1)
    area = np.where(valid, basin, 0.0)[:, None] * u**2
    force = (unit * reach ** (p / 2))[:, None] * u**p
    stiffness = (unit * p / 2 * reach ** (p / 2 - 1))[:, None] * u ** (p - 2)
    flags = np.zeros(force.shape, dtype=np.uint8)
    flags[valid, -1] = Flag.FILLED
    axes = np.stack([minor, major], axis=1) * np.sqrt(reach)[:, None]
    spread = _spread(profiles, material.m, u, reach, axes)
    return LawTable(reach, force, stiffness, area, flags, spread, p)


def _spread(profiles: Profiles, m: float, u: Array, reach: Array, axes: Array) -> Array:
    """Relative change of the force by the rest of the profile, to first order.

    The punch functional k (d - <f>) is stationary in the ellipse, so that the change is -k times
    the mean of the rest of f under the flat punch.
    """
    out = np.zeros((reach.size, u.size))
    weights = moment_weights(m, profiles.t.size).T

    def part(begin: int, end: int) -> None:
        rows = begin + np.flatnonzero(reach[begin:end] > 0)
        out[rows] = _mean_excess(profiles, rows, axes[rows], weights, m, u)

    parallel.run(part, parallel.blocks(reach.size, 64))
    return np.asarray((3 + m) / 2 * np.abs(out) / np.where(reach > 0, reach, 1.0)[:, None])


def _mean_excess(
    profiles: Profiles, rows: NDArray[np.int64], axes: Array, weights: Array, m: float, u: Array
) -> Array:
    """Mean of f minus the paraboloid under elliptic punches of semi-axes `axes` times u, over u^2.

    `weights` make the moments h of a ray at equispaced fractions of it; the mean is
    (1 + m) sum w a^4 h / sum w a^2. Beyond its edge a ray keeps its last moment.
    """
    q, weight, (k1, k2) = profiles.q[rows], profiles.weight[rows], profiles.curvature[rows].T
    moment, bend = q @ weights, k1 - k2
    turned = np.where(bend > 1e-9 * k1, bend, np.inf)[:, None]
    along = np.clip((k1[:, None] - 2 * q[:, :, 0]) / turned, 0.0, 1.0)
    along[np.isinf(turned[:, 0])] = 0.5
    minor, major = axes.T[:, :, None] ** 2
    square = 1 / (along / major + (1 - along) / minor)
    last = moment.shape[2] - 1
    place = np.minimum(
        np.sqrt(square)[:, :, None] / profiles.edge[rows][:, :, None] * last * u, last
    )
    low = np.minimum(place.astype(np.int64), last - 1)
    below, above = (np.take_along_axis(moment, low + k, axis=2) for k in (0, 1))
    excess = below + (place - low) * (above - below) - moment[:, :, :1]
    total = np.einsum("np,npj->nj", weight * square**2, excess)
    return np.asarray((1 + m) * total / np.sum(weight * square, axis=1)[:, None])


@lru_cache(maxsize=16)
def _aspect_curve(m: float) -> CubicSpline:
    """ln(b/a) as a function of the logarithm of the curvature ratio."""
    from scipy.interpolate import CubicSpline

    log_beta = np.linspace(np.log(1e-5), 0.0, 400)
    _, along, across = _integrals(np.exp(log_beta), m)
    return CubicSpline(-np.log(across / along), log_beta)


@lru_cache(maxsize=16)
def _unit_curve(m: float) -> CubicSpline:
    """Logarithms of force and semi-axes over that of the curvature ratio, for k1 k2 = d = E = 1."""
    from scipy.interpolate import CubicSpline

    ratio = np.linspace(0.0, -_aspect_curve(m).x[0], 600)
    root = np.exp(ratio / 2)
    contact = elliptic_contact(root, 1 / root, 1.0, HalfSpace.from_modulus(1.0, m))
    values = [contact.force, contact.semi_minor, contact.semi_major]
    return CubicSpline(ratio, np.log(np.stack(values, axis=1)))


def _log_ratio(ratio: Array, m: float) -> Array:
    """Logarithm of a curvature ratio >= 1, refused where it is that of a line."""
    if np.any(-np.log(ratio) < _aspect_curve(m).x[0]):
        raise InputError(
            f"the curvature ratio {np.max(ratio):.3g} is too large for a point contact"
        )
    return np.asarray(np.log(ratio))


def _aspect(ratio: Array, m: float) -> Array:
    """Aspect b/a in (0, 1] of the contact whose curvature ratio is `ratio` >= 1."""
    curve = _aspect_curve(m)
    target = -_log_ratio(ratio, m)
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
    start = np.log(ratio.min()) - _TAIL
    x = start + _STEP * np.arange(int((_TAIL - start) / _STEP) + 1)
    cosine = 1 / (1 + np.exp(2 * x))
    sine = 1 / (1 + np.exp(-2 * x))
    square = 1 / (cosine + sine / ratio**2)
    weight = _STEP / np.cosh(x) * square ** ((1 - m) / 2)
    along_x = np.sum(weight * square * cosine, axis=-1)
    along_y = np.sum(weight * square * sine / ratio**2, axis=-1)
    beta = ratio[..., 0]
    return along_x + along_y, along_y + m * along_x, (along_x + m * along_y) / beta**2
