"""What the steps of a preparation ask of a map in blocks of rows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics.stored_array import Source, windows

__all__ = ["middle", "replaced"]

Array = NDArray[np.float64]


def middle(heights: Source) -> float:
    """Median over the blocks of the medians of the heights present."""
    medians = []
    for _, _, rows in windows(heights):
        present = rows[~np.isnan(rows)]
        if present.size:
            medians.append(float(np.median(present)))
    return float(np.median(medians))


def replaced(
    source: Source, places: NDArray[np.int64], heights: Array
) -> Iterator[tuple[int, Array]]:
    """Blocks of rows with other heights at some places, numbers in scan order that rise."""
    for begin, _, window in windows(source):
        rows = window.copy()
        start = begin * rows.shape[1]
        part = slice(*np.searchsorted(places, (start, start + rows.size)))
        rows.flat[places[part] - start] = heights[part]
        yield begin, rows
