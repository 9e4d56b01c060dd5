"""Polynomial fits of sampled summits on nested ellipses about them.

A summit of a broad spectrum is not one polynomial: it is fitted on several ellipses, each
smaller than the last, and the contact law uses the smallest that reaches beyond the contact.
The ellipses share their samples, and their axis ratio is rounded to one of a few, so that a fit
is the product with a matrix made beforehand.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from surfaces.errors import InputError

from .ellipse_operator import DEGREE, monomials

__all__ = ["FitRules", "fit_rules"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SHRINK = 0.66
"""Size of each fit relative to the last."""

_RINGS = (0, 1, 2, 4, 6)
"""Radii of the samples of one fit, as powers of the root of `SHRINK`."""

_SKEW = np.exp(np.linspace(np.log(0.5), np.log(16.0), 36))
"""Axis ratios of the base ellipse over that of the rays, to one of which a summit is rounded."""


@dataclass(frozen=True, eq=False)
class FitRules:
    """What the fits of all summits share.

    Parameters
    ----------
    radii
        Radii of the samples relative to the largest ellipse.
    rings
        The radii of each fit, shape (fits, rings).
    image
        The rays at (+,+), (-,+), (-,-), (+,-) of each ray in the first quadrant.
    skew
        Axis ratios of the base ellipse over that of the rays.
    matrices
        Coefficients from the means of a parity class at the points (ray, ring), shape
        (skew, class, monomials of the class, points), padded.
    members, count
        Number, i and j of the monomials of each class, and how many they are.
    logs
        Logarithms of the sizes of the fits.
    """

    radii: Array
    rings: Index
    image: Index
    skew: Array
    matrices: Array
    members: Index
    count: Index
    logs: Array


@lru_cache(maxsize=4)
def fit_rules(rays: int) -> FitRules:
    """Rules for summits on `rays` rays, a multiple of four, the first along the long axis."""
    from ._fit_kernels import FITS

    if rays % 4:
        raise InputError(f"the rays must be mirror images in four quadrants, got {rays} rays")
    rings = 2 * np.arange(FITS)[:, None] + np.array(_RINGS)
    root = np.sqrt(SHRINK)
    used, rings = np.unique(rings, return_inverse=True)
    rings = rings.reshape(FITS, len(_RINGS))
    base = np.arange(rays // 4 + 1)
    image = np.stack([base, rays // 2 - base, rays // 2 + base, rays - base], axis=1) % rays
    share = np.where((base == 0) | (base == rays // 4), 0.5, 1.0)
    weight = np.repeat(share, len(_RINGS))
    i, j = monomials(DEGREE)
    kind = np.choose((i % 2) + 2 * (j % 2), [0, 2, 3, 1])
    classes = [np.flatnonzero((kind == c) & (i + j >= 2)) for c in range(4)]
    count = np.array([len(c) for c in classes])
    members = np.zeros((4, count.max(), 3), dtype=np.int64)
    matrices = np.zeros((_SKEW.size, 4, count.max(), weight.size))
    turn = 2 * np.pi * base / rays
    for n, skew in enumerate(_SKEW):
        x, y = np.cos(turn), skew * np.sin(turn)
        unit = np.stack([x, y]) / np.hypot(x, y)
        x, y = (np.multiply.outer(v, root ** np.array(_RINGS)).ravel() for v in unit)
        for c, rows in enumerate(classes):
            values = x[:, None] ** i[rows] * y[:, None] ** j[rows]
            normal = values.T @ (weight[:, None] * values)
            matrices[n, c, : rows.size] = np.linalg.solve(normal, values.T * weight)
            members[c, : rows.size] = np.stack([rows, i[rows], j[rows]], axis=1)
    return FitRules(
        radii=root ** used.astype(float),
        rings=rings,
        image=image,
        skew=_SKEW,
        matrices=matrices,
        members=members,
        count=count,
        logs=np.log(SHRINK) * np.arange(FITS),
    )
