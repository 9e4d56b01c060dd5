"""Polynomial fits of sampled summits on nested ellipses about them.

A summit of a broad spectrum is not one polynomial: it is fitted on several ellipses, each
smaller than the last, and the contact law uses the smallest that reaches beyond the contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from surfaces.errors import InputError

from .ellipse_tables import monomials

if TYPE_CHECKING:
    from surfaces import Profiles

__all__ = ["SummitFits", "fit_summits"]

Array = NDArray[np.float64]

_FRACTIONS = 0.66 ** np.arange(5)
"""Sizes of the nested fits relative to the largest."""

_RINGS = np.array([0.3, 0.53, 0.73, 0.88, 1.0])
"""Radii of the samples on one ellipse; with the rays they make the points of a fit."""

_SMALLEST_RATIO = 1 / 40


@dataclass(frozen=True, eq=False)
class SummitFits:
    """Polynomials of n summits in units of a length and a height of each.

    Parameters
    ----------
    coefs
        Coefficients of x**i y**j, x along the long axis, shape (n, fits, monomials).
    sizes
        Geometric-mean radius of the ellipse of each fit, (n, fits), falling.
    edge
        Ray lengths to the basin edge, (n, rays).
    stretch, offset
        The rays lie at equispaced angles atan2(stretch * y, x), the first at `offset` steps.
    ratio, angle
        Axis ratio of the base ellipse and direction of its long axis [rad], (n,).
    basin
        Area inside the edge, (n,).
    length, height
        Units [m], (n,).
    residual
        rms residual of each fit relative to the largest value of f on its ellipse.
    valid
        Profiles that could be fitted.
    """

    coefs: Array
    sizes: Array
    edge: Array
    stretch: Array
    offset: float
    ratio: Array
    angle: Array
    basin: Array
    length: Array
    height: Array
    residual: Array
    valid: NDArray[np.bool_]

    def __len__(self) -> int:
        return self.length.size


@lru_cache(maxsize=8)
def _classes(degree: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Monomials of degree >= 2 of each parity class, padded, and their number."""
    i, j = monomials(degree)
    kind = np.choose((i % 2) + 2 * (j % 2), [0, 2, 3, 1])
    rows = [np.flatnonzero((kind == c) & (i + j >= 2)) for c in range(4)]
    count = np.array([r.size for r in rows])
    members = np.zeros((4, count.max()), dtype=np.int64)
    for c, r in enumerate(rows):
        members[c, : r.size] = r
    return members, count


def _mirrors(rays: int, offset: float) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Rays of the first quadrant, their mirror images and their shares."""
    steps = np.arange(rays) + offset
    base = np.flatnonzero((steps <= rays / 4 + 1e-9) & (steps >= -1e-9))
    s = steps[base]
    images = np.stack([s, rays / 2 - s, rays / 2 + s, rays - s], axis=1) - offset
    index = np.rint(images).astype(np.int64)
    if rays % 4 or np.abs(images - index).max() > 1e-6:
        raise InputError(f"the rays must be mirror images in four quadrants, got {rays} rays")
    on_axis = (s < 1e-9) | (np.abs(s - rays / 4) < 1e-9)
    return base, index % rays, np.where(on_axis, 0.5, 1.0)


def fit_summits(profiles: Profiles, degree: int) -> SummitFits:
    """Fit polynomials of `degree` without constant and linear terms to all profiles.

    Parameters
    ----------
    profiles
        Batch of profiles (`surfaces.fit_profiles`).
    degree
        Even degree.

    Returns
    -------
    SummitFits
        The base ellipse has the axis ratio ``(k2/k1)**0.63`` of the Hertzian contact; the
        largest fit reaches 1.1 times the rms distance of the basin edge in units of it.
    """
    from ._fit_kernels import fit_rays

    rays = profiles.phi.shape[1]
    turned = profiles.phi - profiles.angle[:, None]
    direction = np.stack([np.cos(turned), np.sin(turned)], axis=-1)
    offset, stretch = _layout(turned)
    k1, k2 = profiles.curvature.T
    ratio = np.clip((k2 / np.where(k1 > 0, k1, 1.0)) ** 0.63, _SMALLEST_RATIO, 1.0)
    b0 = np.sqrt(ratio)
    unit = 1 / np.sqrt(
        (direction[..., 0] * b0[:, None]) ** 2 + (direction[..., 1] / b0[:, None]) ** 2
    )
    length = 1.1 * np.sqrt(np.mean((profiles.edge / unit) ** 2, axis=1))
    height = 2.0 * (profiles.q[:, :, -1] * profiles.edge**2).max(axis=1)
    valid = profiles.valid & (height > 0) & (length > 0)
    height = np.where(valid, height, 1.0)
    length = np.where(valid, length, 1.0)
    base, image, share = _mirrors(rays, offset)
    members, count = _classes(degree)
    i, j = monomials(degree)
    coefs = np.zeros((len(length), _FRACTIONS.size, i.size))
    residual = np.zeros(coefs.shape[:2])
    inputs = (
        direction,
        np.ascontiguousarray(profiles.edge),
        np.ascontiguousarray(profiles.q),
        ratio,
        length,
        height,
        _FRACTIONS,
        _RINGS,
        np.ones(_RINGS.size),
        base,
        image,
        share,
        members,
        count,
        i,
        j,
        coefs,
        residual,
    )
    fit_rays(0, len(length), *inputs)
    sizes = np.broadcast_to(_FRACTIONS, residual.shape).copy()
    valid = valid & np.isfinite(coefs).all(axis=(1, 2)) & (coefs[:, -1, 5] > 0)
    return SummitFits(
        coefs=np.where(valid[:, None, None], coefs, _paraboloid(i, j)),
        sizes=sizes,
        edge=profiles.edge / length[:, None],
        stretch=stretch,
        offset=offset,
        ratio=ratio,
        angle=profiles.angle,
        basin=0.5 * np.sum(profiles.weight * profiles.edge**2, axis=1) / length**2,
        length=length,
        height=height,
        residual=residual,
        valid=valid,
    )


def _layout(turned: Array) -> tuple[float, Array]:
    """Offset of the first ray in steps, and the stretch that makes the rays equispaced."""
    rays = turned.shape[1]
    first = np.mod(turned[:, 0] + 1e-9, 2 * np.pi)
    offset = 0.0 if np.all(first < 1e-6) else 0.5
    steps = (np.arange(rays) + offset) * 2 * np.pi / rays
    ray = int(np.argmin(np.abs(steps - np.pi / 4)))
    stretch = np.tan(steps[ray]) / np.tan(turned[:, ray])
    return offset, stretch


def _paraboloid(i: NDArray[np.int64], j: NDArray[np.int64]) -> Array:
    return np.where((i + j == 2) & (i != 1), 1.0, 0.0)
