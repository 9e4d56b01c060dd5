"""Height parameters of a map."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from surfaces.errors import SurfaceError
from surfaces.heightmap import HeightMap
from surfaces.roughness import Roughness

from .rows import over_present

__all__ = ["height_parameters", "some_roughness"]


def some_roughness(hm: HeightMap) -> Roughness:
    """Means and extremes of a map; a constant one is refused."""
    found = hm.roughness
    if found.lowest == found.highest:
        raise SurfaceError("the map is constant; it has no roughness")
    return found


def height_parameters(hm: HeightMap) -> dict[str, float]:
    """Sq, Sa, Sp, Sv, Sz [m], Ssk, Sku [-] about the mean (ISO 25178-2:2021, 4.2)."""
    found = some_roughness(hm)

    def powers(heights: NDArray[np.float64]) -> NDArray[np.float64]:
        z = heights - found.mean
        square = z * z
        return np.array(
            [np.abs(z).sum(), square.sum(), (square * z).sum(), (square * square).sum()]
        )

    sums = sum(over_present(powers, hm), np.zeros(4))
    count = hm.source.size - found.missing
    mean, variance, third, fourth = (sums / count).tolist()
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
