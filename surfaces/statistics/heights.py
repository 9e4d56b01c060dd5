"""Height parameters of a map, and its heights by blocks: one in memory, many from disk."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np

from surfaces.arrays import Array
from surfaces.errors import SurfaceError
from surfaces.heightmap import HeightMap
from surfaces.numerics import parallel
from surfaces.numerics.stored_array import windows
from surfaces.roughness import Roughness

__all__ = ["height_parameters", "over_present", "some_roughness"]

Result = TypeVar("Result")


def over_present(function: Callable[[Array], Result], hm: HeightMap) -> Iterator[Result]:
    """What a function finds in the heights of the points present, of blocks of whole rows in order;
    in threads if the map is on disk."""
    parts = 1 if isinstance(hm.source, np.ndarray) else parallel.threads()
    for _, _, block in windows(hm.source):
        yield from parallel.each(
            lambda rows: function(rows[np.isfinite(rows)]),
            np.array_split(block, min(parts, len(block))),
        )


def some_roughness(hm: HeightMap) -> Roughness:
    """Means and extremes of a map; a constant one is refused."""
    found = hm.roughness
    if found.lowest == found.highest:
        raise SurfaceError("the map is constant; it has no roughness")
    return found


def height_parameters(hm: HeightMap) -> dict[str, float]:
    """Sq, Sa, Sp, Sv, Sz [m], Ssk, Sku [-] about the mean (ISO 25178-2:2021, 4.2)."""
    found = some_roughness(hm)

    def powers(heights: Array) -> Array:
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
