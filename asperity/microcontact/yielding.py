"""Law of a contact whose pressure is bounded by a hardness, from its elastic law.

One contact at a time, row by row: the capped contact has the area of an elastic one, which is taken
for that of the power-law body r^k with the same approach, force and stiffness. Its load and its
approach join both limits, first yield and full plasticity, in value and in slope; nothing is
fitted (docs/development/laws.md).
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gamma, hyp2f1

from asperity.halfspace.footprint import Footprints
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.transforms import kappa
from surfaces.arrays import Array
from surfaces.numerics.compiled import compiled

__all__ = ["Capped", "capped"]


_NEARLY_HOMOGENEOUS = 1e-6
"""Grading below which the limits of its formulas for m = 0 are taken at this m."""

_SHARPEST = 0.25
"""Least exponent of a body."""

_EXPONENTS, _DEPTHS = 120, 400
"""Exponents and depths z = 1 - (r/a)^2 at which the elastic pressure of power laws is looked at."""

_THINNEST = 1e-16
"""Least deficit of the load of a contact that is not fully plastic."""

_STEPS, _CLOSE = 60, 1e-8
"""Newton steps for the logarithm of a deficit, at most, and the step that is the last of one."""

_LIGHT = 1e-6
"""Mean pressure over the hardness below which a tip that yields changes nothing."""


class Capped(NamedTuple):
    """Capped contacts, each of the area of its elastic one; arrays of one shape.

    Attributes
    ----------
    approach
        Approach [m].
    force
        Normal force [N], at most H A.
    saturated
        Estimate of the share of the area at the hardness; zero before first yield.
    yielding
        Peak pressure of the elastic contact over the hardness; above one the contact yields.
    """

    approach: Array
    force: Array
    saturated: Array
    yielding: Array


def capped(
    approach: ArrayLike,
    force: ArrayLike,
    area: ArrayLike,
    stiffness: ArrayLike,
    material: HalfSpace,
    *,
    level: ArrayLike | None = None,
) -> Capped:
    """Approach and force of contacts under a hardness H [Pa] that have the areas of elastic ones,
    of approach d [m], force F [N], contact area A [m^2] and stiffness dF/dd [N/m].

    `level` is the gap [m] of the level line of the profile that encloses the area: the outline of a
    soft contact. None where the level lines are circles. All broadcast.

    Notes
    -----
    The exponent k of the body follows from d dF/dd / F = 1 + (1+m)/k. With a the radius of the
    area, the share phi = F/(H A) and the deficit x = 1 - phi obey, in a body that has yielded,

        f'(a) a^m E/H = S(x) - c0 x - c1 x^2,   d - f(a) = [T(x) + e0 x^2 + e1 x^3] H A / k,

    where f'(a) is the slope of the profile at the edge. S and T are exact for a thin elastic rim
    about a saturated disc, where the pressure falls from H to zero over the width x a: at m = 0,
    S = (2/pi) ln(32/(e^2 x)) and T = 8/pi^2 - (2/pi^2) x ln(32/x). The four coefficients make
    load and approach go on from first yield, where the largest elastic pressure of the body is H,
    in value and in slope.

    The outline of a contact that is not round goes over from that of the elastic contact to the
    level line, as the same body makes its edge sink; the displacement then belongs to a punch
    between the elastic one and the disc.

    Examples
    --------
    >>> import asperity
    >>> ball = asperity.HalfSpace.from_modulus(1.0, hardness=0.04)  # d = 0.01, R = 1, a = 0.1
    >>> found = capped(0.01, 4 / 3 * 0.1**3, 3.14159e-2, 0.2, ball)
    >>> f"{found.force / (0.04 * 3.14159e-2):.4f} {found.approach:.6f} {found.saturated:.2f}"
    '0.9146 0.009449 0.81'
    """
    outline = np.nan if level is None else level
    parts = np.broadcast_arrays(approach, force, area, stiffness, outline)
    shape = parts[0].shape
    d, f, a, k, line = (np.array(part, dtype=float).ravel() for part in parts)
    saturated, peak = np.zeros((2, d.size))
    known = np.flatnonzero((d > 0) & (f > 0) & (a > 0) & (k > 0) & np.isfinite(material.hardness))
    if np.isfinite(material.hardness):
        f[np.isnan(d + f + a + k)] = np.nan
    full = material.hardness * a[known]
    growth = d[known] * k[known] / f[known] - 1
    exponent, largest = _exponents(material.m, growth)
    mean = f[known] / full
    peak[known] = mean * largest
    some = np.flatnonzero((peak[known] > 1) & (mean > _LIGHT))
    late, mean, full = known[some], mean[some], full[some]
    body = _PowerBody(material.m, exponent[some], largest[some])
    deficit = body.deficit(mean)
    f[late] = np.minimum(f[late], full * (1 - deficit))
    edge = d[late] - full * body.edge * mean / k[late]
    sunk = full * body.displacement(deficit) / k[late]
    if level is not None:
        soft = body.softness(deficit)
        edge += (line[late] - edge) * soft
        disc = Footprints(material.modulus, material.m).punch(np.sqrt(a[late] / np.pi))
        sunk *= (k[late] / disc) ** (soft / 2)
    d[late] = edge + sunk
    saturated[late] = body.saturated(deficit)
    return Capped(*(part.reshape(shape) for part in (d, f, saturated, peak)))


class _PowerBody:
    """Bodies r^k pressed into a half-space of grading m, one per row; `peak` is their largest
    elastic pressure over the mean one, infinite at k <= 1 - m."""

    def __init__(self, m: float, k: Array, peak: Array) -> None:
        depth = kappa(m, k)
        self.rim = _Rim(m)
        # deficit at first yield; E a^m f'(a) over the mean elastic pressure; elastic displacement
        # of the edge over F / (dF/dd)
        self.first = 1 - 1 / peak
        self.slope = np.pi / 2 * (1 + m) * (k + 1 + m) / depth
        self.edge = (1 - 1 / depth) * (1 + (1 + m) / k)

    def deficit(self, mean: Array) -> Array:
        """Deficit 1 - F/(H A) of bodies that have yielded, by the mean elastic pressure over H.

        At least that of the elastic contact of the same area.
        """
        found = np.empty(mean.shape)
        _deficits(mean, self.slope, self.first, self.rim.law, found)
        return found

    def displacement(self, deficit: Array) -> Array:
        """Displacement of the edge over H A / (dF/dd) of bodies that have yielded."""
        rim, first = self.rim, self.first
        value = self.edge * (1 - first) - rim.displacement(first)
        change = -self.edge * first - rim.displacement_change(first)
        cubic, quadratic = change - 2 * value, 3 * value - change
        deficit = np.maximum(deficit, _THINNEST)
        share = deficit / first
        added = share**2 * (quadratic + cubic * share)
        return np.asarray(rim.displacement(deficit) + added)

    def softness(self, deficit: Array) -> Array:
        """Share of the way from the outline of the elastic contact to the level line: estimate."""
        share = deficit / self.first
        return np.asarray(1 - share + share * np.log(np.maximum(share, _THINNEST)))

    def saturated(self, deficit: Array) -> Array:
        """Share of the area at the hardness: a rim of width x a about the rest, none at yield."""
        share = deficit / self.first
        return np.asarray(np.clip(1 - 2 * deficit - (1 - 2 * self.first) * share**2, 0.0, 1.0))


@compiled()
def _deficits(mean: Array, slope: Array, first: Array, law: Array, out: Array) -> None:
    """Fill `out` with the deficits x of bodies: the root of S(x) - c0 x - c1 x^2 = slope mean, or
    zero below `_THINNEST`, by Newton steps for its logarithm within an interval that holds it.

    `law` is that of the rim: S = s + r (x^-m - 1).
    """
    s, r, m = law
    for i in range(mean.size):
        goal = slope[i] * mean[i]
        if not goal < s + r * math.expm1(-m * math.log(_THINNEST)):
            out[i] = max(0.0, 1.0 - mean[i])
            continue
        low, high = math.log(_THINNEST), math.log(first[i])
        power = math.expm1(-m * high)
        value = s + r * power - slope[i] * (1.0 - first[i])
        change = slope[i] * first[i] - m * r * (1.0 + power)
        y = high
        for _ in range(_STEPS):
            power, share = math.expm1(-m * y), math.exp(y) / first[i]
            linear, quadratic = 2.0 * value - change, (change - value) * share
            error = s + r * power - share * (linear + quadratic) - goal
            rate = -m * r * (1.0 + power) - share * (linear + 2.0 * quadratic)
            if error > 0.0:
                low = y
            else:
                high = y
            step = -error / rate if rate < 0.0 else math.inf
            if abs(step) <= _CLOSE:
                y += step
                break
            y = y + step if low < y + step < high else 0.5 * (low + high)
        out[i] = max(math.exp(y), 1.0 - mean[i])


class _Rim:
    """Disc at the hardness with a thin elastic rim, whose pressure lacks the share x of the load.

    In the rim the slope of the surface is constant, hence the pressure falls as the integral of
    (t (1-t))^((m-1)/2) over its width x a.
    """

    def __init__(self, m: float) -> None:
        self._m = m = m if abs(m) > _NEARLY_HOMOGENEOUS else _NEARLY_HOMOGENEOUS
        half, cosine = (1 + m) / 2, np.cos(m * np.pi / 2)
        middle = gamma((3 - m) / 2)
        spread = gamma((1 - m) / 2) * gamma(1 + m / 2) / np.sqrt(np.pi)
        rise = 2 * half * cosine * spread * gamma(m) / (gamma(half) * gamma(1 + half))
        flat = 2 * half * cosine * gamma(-m) / (middle * gamma((1 - m) / 2))
        self.law = np.array([flat + rise, rise, m])
        disc = cosine / (np.pi * half)
        self._full = disc * gamma(1 - m) / middle**2
        self._bend = disc * 2 ** (1 - m) * gamma(m - 1) / gamma(half) ** 2
        self._bend *= middle * gamma(1 + m) / gamma(half)
        self._linear = self._full * (half**2 / m - 1) + self._bend

    def displacement(self, x: Array) -> Array:
        """Displacement of the edge over H A / (dF/dd)."""
        return np.asarray(self._full + x * (self._linear + self._bend * self._power(x)))

    def displacement_change(self, x: Array) -> Array:
        """x times the derivative of `displacement`."""
        power, m = self._power(x), self._m
        return np.asarray(x * (self._linear + self._bend * (power - m * (1 + power))))

    def _power(self, x: Array) -> Array:
        """x^-m - 1."""
        return np.asarray(np.expm1(-self._m * np.log(x)))


def _exponents(m: float, growth: Array) -> tuple[Array, Array]:
    """Exponents k of bodies r^k by the growth (1+m)/k of their stiffness, and their largest elastic
    pressure over the mean one; infinite at k <= 1 - m.

    Bodies steeper than the one of the most even pressure yield at their edge and then inwards;
    they are taken for that one: their area hardly changes with their load.
    """
    exponents, ratios = _peaks(m)
    steepest = exponents[np.argmin(ratios * _centre(m, exponents))]
    k = np.clip((1 + m) / np.maximum(growth, 1e-12), _SHARPEST, steepest)
    peak = _centre(m, k) * np.interp(k, exponents, ratios)
    return k, np.where(k > 1 - m, peak, np.inf)


def _centre(m: float, k: Array) -> Array:
    """Elastic pressure of r^k at its centre over the mean one, for k > 1 - m."""
    return np.asarray((1 + m) / 2 * (k + 1 + m) / np.maximum(k - 1 + m, 1e-300))


@lru_cache(maxsize=64)
def _peaks(m: float) -> tuple[Array, Array]:
    """Exponents k > 1 - m, and the largest elastic pressure of r^k over that at the centre.

    Beyond k = 2, one of the exponents, they differ.
    """
    k = np.sort(np.append(1 - m + np.geomspace(0.02, 40.0, _EXPONENTS), 2.0))
    z = np.linspace(0.0, 1.0, _DEPTHS + 1)
    shape = z ** ((1 + m) / 2) * hyp2f1(1 - k[:, None] / 2, 1.0, (3 + m) / 2, z)
    return k, np.max(shape, axis=1) / shape[:, -1]
