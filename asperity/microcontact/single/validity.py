"""Checks of a contour and of a profile that set validity flags."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.flags import Flag
from surfaces.polar import PolarProfile, PowerSumProfile

__all__ = ["contour_flags", "profile_flags"]

Array = NDArray[np.float64]

_RAYS = 96
"""Rays, at most, on which a profile is looked at."""

_RADII = 160
"""Radii on each."""
_FARTHEST = 4.0
"""How far a profile without a last radius is looked at, over the reach of the contact."""


def contour_flags(a: Array, contour: Array) -> NDArray[np.uint8]:
    """Flags of the contour itself: `a` of shape (k,), `contour` of shape (k, angles)."""
    flags = np.zeros(a.shape, dtype=np.uint8)
    known = np.isfinite(a) & (a > 0)
    ratio = np.where(known[:, None], contour, 1.0) / np.where(known, a, 1.0)[:, None]
    flags[(ratio.min(axis=1) < 0.5) | (ratio.max(axis=1) > 1.5)] |= np.uint8(Flag.CONTOUR_DOUBTFUL)
    flags[ratio.min(axis=1) <= 0] |= np.uint8(Flag.CONTOUR_NEGATIVE)
    return flags


def profile_flags(
    profile: PowerSumProfile | PolarProfile, approach: Array, phi: Array, contour: Array
) -> NDArray[np.uint8]:
    """Flags of the profile inside the contact, from one polar scan.

    Parameters
    ----------
    profile
        The profile.
    approach
        Approaches [m], shape (k,).
    phi, contour
        Angles [rad] and the contours a(phi) [m] at them, shape (k, phi.size).
    """
    flags = np.zeros(approach.shape, dtype=np.uint8)
    reach = np.max(np.nan_to_num(contour), axis=1)
    flags[reach > profile.radius] |= np.uint8(Flag.BEYOND_RADIUS)
    if isinstance(profile, PolarProfile) and profile.edge is not None:
        end = np.interp(phi, profile.phi, profile.edge, period=2 * np.pi)
        flags[np.any(contour > end, axis=1)] |= np.uint8(Flag.BEYOND_RADIUS)
        saddle = np.min(profile(profile.edge, profile.phi))
        flags[approach > saddle] |= np.uint8(Flag.SECOND_SUMMIT)
    if not np.max(reach, initial=0.0) > 0:
        return flags
    last = profile.radius if np.isfinite(profile.radius) else _FARTHEST * float(np.max(reach))
    r = last * (np.arange(1, _RADII + 1) / _RADII) ** 1.5
    every = max(1, phi.size // _RAYS)
    with np.errstate(over="ignore"):
        f = profile(r[:, None], phi[::every])
    edge = contour[:, ::every]
    below = _first(f < 0, r)
    scale = np.maximum.accumulate(np.abs(f), axis=0)
    falling = _first(np.diff(f, axis=0, prepend=0.0) < -1e-9 * scale, r)
    flags[np.any(edge > below, axis=1)] |= np.uint8(Flag.NEGATIVE_GAP)
    flags[np.any(edge > falling, axis=1)] |= np.uint8(Flag.RAY_TURNS)
    again = (approach > _second_summit(f)) | [_reenters(f, float(d)) for d in approach]
    flags[(approach > 0) & again] |= np.uint8(Flag.SECOND_SUMMIT)
    return flags


def _reenters(f: Array, approach: float) -> bool:
    """Whether a ray enters {f < d} again: another part of the body, or a higher one, stands in."""
    outside = np.maximum.accumulate(f >= approach, axis=0)
    return bool(np.any(outside & (f < approach)))


def _first(where: NDArray[np.bool_], r: Array) -> Array:
    """Smallest radius of each ray at which `where` holds, infinite if nowhere."""
    return np.asarray(np.where(where.any(axis=0), r[np.argmax(where, axis=0)], np.inf))


def _second_summit(f: Array) -> float:
    """Lowest gap over a summit other than the origin, on the polar grid `f`; infinite if none."""
    inner = f[1:-1]
    lowest = np.ones(inner.shape, dtype=bool)
    for down in (-1, 0, 1):
        ring = f[1 + down : f.shape[0] - 1 + down]
        for turn in (-1, 0, 1):
            if down or turn:
                lowest &= inner < np.roll(ring, turn, axis=1)
    return float(np.min(inner[lowest], initial=np.inf))
