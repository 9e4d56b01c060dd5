"""Test bodies: pyramids and paraboloids of polygonal, rounded, irregular and changing section."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from surfaces.arrays import Array

from .errors import InputError, as_count, as_number
from .polar import PowerLawProfile, PowerSumProfile

__all__ = [
    "bent_body",
    "cosine_polygon",
    "deviation",
    "polygon",
    "random_polygon",
    "random_section",
    "rounded_polygon",
    "section",
]


MOST_SIDES = 1000
"""Sides of a polygon at most: integrals go from corner to corner, and more make a circle."""


def polygon(sides: int, k: float = 1.0, *, scale: float = 1.0) -> PowerLawProfile:
    """Body whose level lines are regular polygons: ``f = scale (r cos)^k``.

    Parameters
    ----------
    sides
        Number n of sides, at least 3; a face normal points along phi = 0.
    k
        Exponent: 1 is the pyramid.
    scale
        Gap [m^(1-k)] at r = 1 on a face normal.
    """
    sides = _sides(sides)
    return PowerLawProfile(
        k, lambda phi: scale * np.cos(_from_face(phi, sides)) ** k, corners=_corners(sides)
    )


def cosine_polygon(sides: int, k: float = 1.0) -> PowerLawProfile:
    """Body with the plain factor ``psi = cos`` for every k (the formula printed as 46, 47).

    Its level lines are polygons for k = 1 only; otherwise their sides are curved.
    """
    sides = _sides(sides)
    return PowerLawProfile(k, lambda phi: np.cos(_from_face(phi, sides)), corners=_corners(sides))


def rounded_polygon(sides: int, k: float = 1.0, *, corner: float = 0.3) -> PowerLawProfile:
    """Body whose level lines are regular polygons with round corners.

    Parameters
    ----------
    sides
        Number of sides, at least 3.
    k
        Exponent.
    corner
        Radius of the corners over the in-radius, 0 (sharp) to 1 (a circle).

    Raises
    ------
    InputError
        If `sides` is below 3, or `corner` not between 0 and 1.
    """
    sides = _sides(sides)
    if not 0 <= as_number("corner", corner) <= 1:
        raise InputError(f"corner must lie between 0 and 1, got {corner:g}")
    half = np.pi / sides
    straight = np.arctan((1 - corner) * np.tan(half))
    centre = (1 - corner) / np.cos(half)

    def radius(phi: Array) -> Array:
        t = np.abs(_from_face(phi, sides))
        u = half - t
        arc = centre * np.cos(u) + np.sqrt(np.maximum(corner**2 - (centre * np.sin(u)) ** 2, 0.0))
        return np.asarray(np.where(t <= straight, 1 / np.cos(t), arc))

    kinks = _corners(sides) if corner == 0 else ()
    return PowerLawProfile(k, lambda phi: radius(phi) ** -k, corners=kinks)


def section(radius: Callable[[Array], ArrayLike], k: float = 1.0) -> PowerLawProfile:
    """Body with the star-shaped section ``r = radius(phi)`` at unit gap: ``f = (r/radius)^k``."""
    return PowerLawProfile(k, lambda phi: np.asarray(radius(phi), dtype=float) ** -k)


def random_section(k: float = 1.0, *, deviation: float, seed: int = 0) -> PowerLawProfile:
    """Irregular section: ``psi = 1 + sum_n c_n cos(n phi + alpha_n)``, n = 2 to 12.

    Parameters
    ----------
    k
        Exponent of the body.
    deviation
        Wanted standard deviation of psi over its mean; amplitudes are normal numbers times n^-1.5.
    seed
        Seed of the random numbers.

    Raises
    ------
    InputError
        If psi would not stay positive.
    """
    rng = np.random.default_rng(as_count("seed", seed, 0))
    deviation = as_number("deviation", deviation)
    n = np.arange(2, 13)
    amplitude = rng.standard_normal(n.size) * n**-1.5
    amplitude *= deviation / np.sqrt(np.sum(amplitude**2) / 2)
    phase = rng.uniform(0, 2 * np.pi, n.size)

    def psi(phi: Array) -> Array:
        wave = np.cos(np.multiply.outer(np.asarray(phi, float), n) + phase)
        return np.asarray(1 + wave @ amplitude)

    lowest = float(np.min(psi(2 * np.pi * np.arange(720) / 720)))
    if not lowest > 0:
        raise InputError(f"a deviation of {deviation:g} makes psi negative; take a smaller one")
    return PowerLawProfile(k, psi)


def random_polygon(k: float = 1.0, *, sides: int = 7, seed: int = 0) -> PowerLawProfile:
    """Body whose level lines are a random convex polygon: ``psi = max_j cos(phi-phi_j)/l_j``."""
    from scipy.spatial import ConvexHull

    sides = _sides(sides)
    rng = np.random.default_rng(as_count("seed", seed, 0))
    most = 0.3 if sides > 3 else 0.2  # less than half a turn between two faces: it is closed
    normal = (np.arange(sides) + rng.uniform(-most, most, sides)) * 2 * np.pi / sides
    distance = rng.uniform(0.8, 1.2, sides)

    def psi(phi: Array) -> Array:
        faces = np.cos(np.subtract.outer(np.asarray(phi, float), normal)) / distance
        return np.asarray(faces.max(axis=-1) ** k)

    # lines that meet in a corner of the polygon are points on a side of the hull of all of them
    poles = np.stack([np.cos(normal), np.sin(normal)], axis=1) / distance[:, None]
    x, y = ConvexHull(poles).equations[:, :2].T
    return PowerLawProfile(k, psi, corners=tuple(np.arctan2(y, x)))


def bent_body(*, curvature: float = 1.0, size: float = 1.0) -> PowerSumProfile:
    """Body whose section changes with height: an ellipse at the summit, a triangle further out.

    Parameters
    ----------
    curvature
        Mean curvature [1/m] of the summit.
    size
        Length [m] at which the higher terms become comparable to the first.
    """
    return PowerSumProfile(
        [2.0, 3.0, 4.0],
        [
            lambda phi: curvature / 2 * (1 + 0.25 * np.cos(2 * phi)),
            lambda phi: curvature / (2 * size) * 0.25 * np.cos(3 * phi + 0.5),
            lambda phi: curvature / (2 * size**2) * (0.35 + 0.15 * np.cos(4 * phi - 0.3)),
        ],
    )


def deviation(profile: PowerLawProfile) -> float:
    """Standard deviation of psi over its mean, the measure of irregularity."""
    psi = profile.psi(2 * np.pi * np.arange(4096) / 4096)
    return float(np.std(psi) / np.mean(psi))


def _sides(sides: int) -> int:
    """The number of sides, checked."""
    count = as_count("sides", sides, 0)
    if not 3 <= count <= MOST_SIDES:
        raise InputError(f"a polygon has 3 to {MOST_SIDES} sides, got {sides}")
    return count


def _from_face(phi: ArrayLike, sides: int) -> Array:
    """Angle from the nearest face normal, in [-pi/n, pi/n]."""
    step = 2 * np.pi / sides
    angle = np.asarray(phi, dtype=float)
    return np.asarray(angle - step * np.round(angle / step))


def _corners(sides: int) -> tuple[float, ...]:
    return tuple((2 * np.arange(sides) + 1) * np.pi / sides)
