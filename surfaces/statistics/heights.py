"""Height parameters of a map, and the means of its lines."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surfaces.errors import SurfaceError

from .rows import Source, present_in, rows_of

__all__ = ["Extent", "extent", "height_parameters", "line_means"]


@dataclass(frozen=True)
class Extent:
    """Number of the points present, and their mean, lowest and highest height [m]."""

    count: int
    mean: float
    lowest: float
    highest: float


def extent(source: Source) -> Extent:
    """Extent of a map that is not constant.

    Raises
    ------
    SurfaceError
        If the map is constant, or no point is present.
    """
    count, total, low, high = 0, 0.0, math.inf, -math.inf
    for z in present_in(source):
        if z.size:
            count, total = count + z.size, total + float(z.sum())
            low, high = min(low, float(z.min())), max(high, float(z.max()))
    if not count:
        raise SurfaceError("every point of the height map is missing (NaN)")
    if low == high:
        raise SurfaceError("the map is constant; it has no roughness")
    return Extent(count, total / count, low, high)


def height_parameters(source: Source, found: Extent) -> dict[str, float]:
    """Sq, Sa, Sp, Sv, Sz [m], Ssk, Sku [-] about the mean (ISO 25178-2:2021, 4.2)."""
    sums = np.zeros(4)
    for heights in present_in(source):
        z = heights - found.mean
        square = z * z
        sums += [np.abs(z).sum(), square.sum(), (square * z).sum(), (square * square).sum()]
    mean, variance, third, fourth = (sums / found.count).tolist()
    sq = math.sqrt(variance)
    return {
        "Sq": sq,
        "Sa": mean,
        "Ssk": third / sq**3,
        "Sku": fourth / sq**4,
        "Sp": found.highest - found.mean,
        "Sv": found.mean - found.lowest,
        "Sz": found.highest - found.lowest,
    }


def line_means(source: Source) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean heights [m] of the points present in each row and in each column; NaN if none is."""
    rows, counts = [], []
    columns, numbers = np.zeros(source.shape[1]), np.zeros(source.shape[1])
    for block in rows_of(source):
        present = np.isfinite(block)
        z = np.where(present, block, 0.0)
        rows.append(z.sum(axis=1))
        counts.append(np.count_nonzero(present, axis=1))
        columns += z.sum(axis=0)
        numbers += np.count_nonzero(present, axis=0)
    with np.errstate(invalid="ignore"):
        return np.concatenate(rows) / np.concatenate(counts), columns / numbers
