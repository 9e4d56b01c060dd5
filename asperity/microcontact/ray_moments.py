"""Radial moments of sampled rays as fixed weights of their samples."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.transforms import gauss_jacobi

__all__ = ["edge_weights", "moment_weights"]

Array = NDArray[np.float64]

MOMENT_RADII, EDGE_RADII = 13, 25
"""Radii of a ray, from 0 to 1 of its length, at which moments and edge operator are given."""


@lru_cache(maxsize=8)
def moment_weights(m: float, nodes: int, order: int) -> Array:
    """Weights (`MOMENT_RADII`, nodes) of ``h(a) = int t**(order+3) q(a t) (1-t*t)**((m-1)/2) dt``.

    ``a`` runs over equispaced fractions of the ray from 0 to 1, ``q`` over equispaced nodes with
    local cubics between them.
    """
    return _weights(m, nodes, order, MOMENT_RADII)[0]


@lru_cache(maxsize=8)
def edge_weights(m: float, nodes: int, order: int) -> Array:
    """Weights (`EDGE_RADII`, nodes) of ``(order + 3 + m) h + a h'`` with h as in `moment_weights`.

    Times ``a**2`` this is the edge operator of harmonic `order` of one ray
    (docs/development/laws.md).
    """
    value, slope = _weights(m, nodes, order, EDGE_RADII)
    return (order + 3 + m) * value + slope


def _weights(m: float, nodes: int, order: int, radii: int) -> tuple[Array, Array]:
    """Weights of h and of a h'."""
    t, w = gauss_jacobi(m, 24)
    value, slope = np.zeros((2, radii, nodes))
    last = nodes - 1
    for n, a in enumerate(np.linspace(0, 1, radii)):
        position = a * t * last
        i = np.clip(position.astype(int), 1, last - 2)
        u = position - i
        cubic = (
            (-u * (u - 1) * (u - 2) / 6, -(3 * u * u - 6 * u + 2) / 6),
            ((u + 1) * (u - 1) * (u - 2) / 2, (3 * u * u - 4 * u - 1) / 2),
            (-(u + 1) * u * (u - 2) / 2, -(3 * u * u - 2 * u - 2) / 2),
            ((u + 1) * u * (u - 1) / 6, (3 * u * u - 1) / 6),
        )
        for k, (share, change) in enumerate(cubic):
            np.add.at(value[n], i + k - 1, share * w * t ** (order + 3))
            np.add.at(slope[n], i + k - 1, change * position * w * t ** (order + 3))
    return value, slope
