"""A profile f(r, phi) as a height map about its summit, and fields of such a map at any place."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surfaces.arrays import Array
from surfaces.errors import InputError, as_numbers, as_places
from surfaces.heightmap import HeightMap

__all__ = ["Profile", "gap", "map_of", "sampled", "section_box"]

Profile = Callable[[Any, Any], Any]
"""Gap f(r, phi) [m] between a body and the tangent plane at its summit."""

_SECTION_RAYS = 256
"""Rays on which the section is looked for."""

_MAX_RADIUS_RATIO = 1e9
"""Ratio of radii beyond which a ray is taken never to reach the approach."""

_CUT_DEPTH = 10.0
"""Depth below the summit, over the approach, at which a body is cut off: four times what the grid
around the contact of a paraboloid shows."""


def sampled(
    values: Array,
    spacing: tuple[float, float],
    summit: tuple[float, float],
    x: ArrayLike,
    y: ArrayLike,
) -> Array:
    """A field of a map at places (x, y) [m] from the summit, bilinear between the pixels."""
    from scipy.ndimage import map_coordinates

    px, py = as_places(x, y)
    place = np.stack([(py + summit[1]) / spacing[0] - 0.5, (px + summit[0]) / spacing[1] - 0.5])
    return np.asarray(map_coordinates(values, place.reshape(2, -1), order=1)).reshape(px.shape)


def gap(profile: Profile, r: Array, phi: Any) -> Array:
    """Gap [m] of a profile at places (r, phi) [m, rad].

    Raises
    ------
    InputError
        If it is no real number at one of them.
    """
    what = "the gap f(r, phi) of the profile"
    found = as_numbers(what, profile(r, phi), finite=False)
    if found.shape != r.shape:
        raise InputError(f"{what} has shape {found.shape} at places of shape {r.shape}")
    if np.isnan(found).any():
        radius, angle = (np.broadcast_to(at, r.shape)[np.isnan(found)][0] for at in (r, phi))
        raise InputError(f"{what} is NaN at ({radius:.4g} m, {angle:.4g}); give one at every place")
    return found


def section_box(profile: Profile, approach: float) -> tuple[float, float, float, float]:
    """Edges (x0, x1, y0, y1) [m] of a box around the section {f < d}, which holds the contact.

    Raises
    ------
    InputError
        If the profile does not rise to the approach on every ray.
    """
    phi = np.linspace(0.0, 2.0 * np.pi, _SECTION_RAYS, endpoint=False)
    radius = getattr(profile, "radius", np.inf)
    low = np.zeros(_SECTION_RAYS)
    high = np.full(_SECTION_RAYS, radius if np.isfinite(radius) else 1e-30)
    for _ in range(400):
        short = gap(profile, high, phi) < approach
        if not short.any():
            break
        high = np.where(short, 2.0 * high, high)
        if np.isfinite(radius) and high.max() > 8.0 * radius:
            break
        if not short.all() and high.max() > _MAX_RADIUS_RATIO * high.min():
            break
    if short.all() or high.max() > _MAX_RADIUS_RATIO * high.min():
        raise InputError(
            f"the profile does not rise to the approach {approach:g} m on every ray; "
            "give a profile that grows outwards"
        )
    for _ in range(60):
        middle = 0.5 * (low + high)
        short = gap(profile, middle, phi) < approach
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    x, y = high * np.cos(phi), high * np.sin(phi)
    return float(x.min()), float(x.max()), float(y.min()), float(y.max())


def map_of(
    profile: Profile, box: tuple[float, ...], grid: int, approach: float
) -> tuple[HeightMap, tuple[float, float]]:
    """Height map of the profile in a box, and where its summit lies on it.

    What lies deeper than ten approaches [m] is cut off there: it never touches, and the rms height,
    which the certificate is relative to, would be that of the depth.
    """
    x0, x1, y0, y1 = box
    spacing, summit = ((y1 - y0) / grid, (x1 - x0) / grid), (-x0, -y0)
    place = np.arange(0.5, grid)
    px, py = np.meshgrid(spacing[1] * place + x0, spacing[0] * place + y0)
    below = gap(profile, np.hypot(px, py), np.arctan2(py, px))
    heights = -np.minimum(below, _CUT_DEPTH * approach)
    return HeightMap(heights, spacing, name="profile"), summit
