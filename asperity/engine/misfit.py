"""Misfit of a curve of the model, known at a few load points, and a bound on it at the others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["between", "halved"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def between(position: Array, anchors: Indices, misfit: Array, floor: Array) -> tuple[Array, Array]:
    """Misfit at all load points, interpolated between the anchors, and a bound on what that leaves.

    Parameters
    ----------
    position
        Logarithm of the load, rising, shape (n,).
    anchors
        Load points at which the misfit is known, rising, the first and the last among them, (k,).
    misfit
        Logarithm of the ratio of the model to boundary elements at the anchors, shape (k,).
    floor
        Least bound between anchors, shape (n,).

    Returns
    -------
    misfit, bound
        Shape (n,). The bound is zero at anchors. Elsewhere it is the largest of half the difference
        of the two anchors beside the point, of what the interpolation misses either of them by when
        that one is left out, and of the floor.
    """
    missed = np.zeros(len(anchors))
    for j in range(1, len(anchors) - 1):
        beside = anchors[[j - 1, j + 1]]
        told = np.interp(position[anchors[j]], position[beside], misfit[[j - 1, j + 1]])
        missed[j] = abs(misfit[j] - told)
    right = np.clip(np.searchsorted(anchors, np.arange(len(position))), 1, len(anchors) - 1)
    bound = np.maximum(missed[right - 1], missed[right])
    bound = np.maximum(np.maximum(bound, 0.5 * np.abs(np.diff(misfit))[right - 1]), floor)
    bound[anchors] = 0.0
    return np.interp(position, position[anchors], misfit), bound


def halved(anchors: Indices, need: Array) -> Indices:
    """The anchors and one more, in the middle of the interval of the point that needs it most.

    Parameters
    ----------
    anchors
        Load points, rising, the first and the last among them.
    need
        How much each load point needs an anchor near it, zero at anchors, shape (n,).
    """
    right = int(np.searchsorted(anchors, int(np.argmax(need))))
    return np.union1d(anchors, (anchors[right - 1] + anchors[right]) // 2)
