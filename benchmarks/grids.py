"""Coordinates, distances and smoothing on the grid of a periodic map."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

__all__ = ["Heights", "axes", "smoothed", "squared_distance", "wrapped"]

Heights = NDArray[np.float64]


def axes(shape: tuple[int, int]) -> tuple[Heights, Heights]:
    """Coordinates y, a column, and x, a row, of the pixels: from 0 to 1 along each side."""
    y, x = ((np.arange(n) + 0.5) / n for n in shape)
    return y[:, None], x


def wrapped(offset: Heights, period: float) -> Heights:
    """Offsets to the nearest of all periodic copies."""
    return (offset + period / 2) % period - period / 2


def squared_distance(
    shape: tuple[int, int], centre: ArrayLike, spacing: tuple[float, float] = (1.0, 1.0)
) -> Heights:
    """Squared distance from a point (y, x), in units of the spacing."""
    grid = zip(shape, spacing, np.asarray(centre), strict=True)
    dy, dx = (wrapped((np.arange(n) + 0.5) * d - c, n * d) for n, d, c in grid)
    return dy[:, None] ** 2 + dx**2


def smoothed(heights: Heights, pixels: float) -> Heights:
    """Heights averaged with Gaussian weights of this standard deviation, across the borders."""
    return ndimage.gaussian_filter(heights, pixels, mode="wrap")
