"""Cubics through four neighboring nodes, anywhere in a table."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surfaces.arrays import Array, Index

__all__ = ["count_below", "lagrange"]


_OTHERS = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])


def lagrange(nodes: ArrayLike, x: ArrayLike) -> tuple[Array, Array]:
    """Weights, shape (..., 4), of the values at four `nodes`, (..., 4), in the value and in the
    slope at `x`, (...), of the cubic through them.

    Examples
    --------
    >>> value, slope = lagrange([0.0, 1.0, 2.0, 3.0], 1.5)
    >>> (value * 16).tolist(), (slope * 24).tolist()
    ([-1.0, 9.0, 9.0, -1.0], [1.0, -27.0, 27.0, -1.0])
    """
    node, at = np.asarray(nodes, dtype=float), np.asarray(x, dtype=float)
    others = node[..., _OTHERS]
    a, b, c = np.moveaxis(at[..., None, None] - others, -1, 0)
    below = np.prod(node[..., None] - others, axis=-1)
    return a * b * c / below, (a * b + b * c + c * a) / below


def count_below(places: Array, at: Array) -> Index:
    """Number of the `places` of a row, (n, k), that are below each of `at`, (n, l), shape (n, l).

    Examples
    --------
    >>> count_below(np.array([[0.0, 1.0, 2.0]]), np.array([[0.5, 2.0]])).tolist()
    [[1, 2]]
    """
    return np.asarray(np.count_nonzero(places[:, :, None] < at[:, None], axis=1))
