"""Height parameters of a map, and the means of its lines."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surfaces.errors import SurfaceError
from surfaces.heightmap import HeightMap

from .rows import over_present

__all__ = ["Extent", "extent", "height_parameters"]


@dataclass(frozen=True)
class Extent:
    """Number of the points present, and their mean, lowest and highest height [m]."""

    count: int
    mean: float
    lowest: float
    highest: float


def extent(hm: HeightMap) -> Extent:
    """Extent of a map that is not constant.

    Raises
    ------
    SurfaceError
        If the map is constant, or no point is present.
    """
    count, total, low, high = 0, 0.0, math.inf, -math.inf
    for more, part, least, most in over_present(_summed, hm):
        count, total, low, high = count + more, total + part, min(low, least), max(high, most)
    if not count:
        raise SurfaceError("every point of the height map is missing (NaN)")
    if low == high:
        raise SurfaceError("the map is constant; it has no roughness")
    return Extent(count, total / count, low, high)


def _summed(z: NDArray[np.float64]) -> tuple[int, float, float, float]:
    """Number, sum, lowest and highest of some heights."""
    if not z.size:
        return 0, 0.0, math.inf, -math.inf
    return z.size, float(z.sum()), float(z.min()), float(z.max())


def height_parameters(hm: HeightMap, found: Extent) -> dict[str, float]:
    """Sq, Sa, Sp, Sv, Sz [m], Ssk, Sku [-] about the mean (ISO 25178-2:2021, 4.2)."""

    def powers(heights: NDArray[np.float64]) -> NDArray[np.float64]:
        z = heights - found.mean
        square = z * z
        return np.array(
            [np.abs(z).sum(), square.sum(), (square * z).sum(), (square * square).sum()]
        )

    sums = sum(over_present(powers, hm), np.zeros(4))
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
