"""A map by blocks of whole rows: one block in memory, many from disk."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from surfaces.heightmap import HeightMap
from surfaces.numerics import parallel
from surfaces.numerics.stored_array import windows

__all__ = ["in_memory", "over_present"]

Array = NDArray[np.float64]
Result = TypeVar("Result")


def in_memory(hm: HeightMap) -> bool:
    """Whether the heights of a map are held in memory, all of them."""
    return isinstance(hm.source, np.ndarray)


def over_present(function: Callable[[Array], Result], hm: HeightMap) -> Iterator[Result]:
    """What a function finds in the heights of the points present, of blocks of whole rows in order;
    in threads if the map is on disk."""
    parts = 1 if in_memory(hm) else parallel.threads()
    for _, _, block in windows(hm.source):
        yield from parallel.each(
            lambda rows: function(rows[np.isfinite(rows)]),
            np.array_split(block, min(parts, len(block))),
        )
