"""Connected patches: of a mask over the pixels of a map, and of things joined pair by pair."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from surfaces.arrays import Array, Index, Mask

from .numerics import parallel
from .numerics.compiled import inner
from .numerics.stored_array import Source

__all__ = ["count_patches", "ends_of", "label_patches", "points_at", "root"]


def label_patches(
    mask: Mask, *, periodic: bool, corners: bool = True
) -> tuple[NDArray[np.int32], int]:
    """Labels 1..n of the connected patches of a mask, 0 outside, (ny, nx), and their number n.

    Patches are joined across the seam if `periodic`. Pixels that meet at an edge join, and those
    that meet at a corner if `corners`.
    """
    labels, count = _components(mask, 8 if corners else 4)
    if periodic:
        count, group = _across_seam(labels, count, corners)
        labels = group[labels]
    return labels, count - 1


def count_patches(mask: Mask, *, periodic: bool) -> int:
    """Number of the patches of a mask that `label_patches` finds."""
    labels, count = _components(mask, 8)
    return (_across_seam(labels, count, True)[0] if periodic else count) - 1


def _components(mask: Mask, neighbors: int) -> tuple[NDArray[np.int32], int]:
    """Labels of the map without its continuation, and their number with the background."""
    import cv2

    count, labels = cv2.connectedComponents(
        np.ascontiguousarray(mask).view(np.uint8), connectivity=neighbors, ltype=cv2.CV_32S
    )
    return np.asarray(labels, np.int32), count


def _across_seam(
    labels: NDArray[np.int32], count: int, corners: bool
) -> tuple[int, NDArray[np.int32]]:
    """Number of patches, with the background, of `count` of which the seam cuts some, and the new
    label of each.

    Lines of pixels on both sides of the seam meet as they lie, and moved along each other by a
    pixel if corners join.
    """
    pairs = []
    for first, last in (labels[0], labels[-1]), (labels[:, 0], labels[:, -1]):
        round_end = np.concatenate((last[-1:], last, last[:1]))
        for start in (0, 1, 2) if corners else (1,):
            pairs.append((first, round_end[start:][: len(first)]))
    one, other = np.concatenate(pairs, axis=1)
    met = (one > 0) & (other > 0)
    weights = np.ones(np.count_nonzero(met))
    links = coo_array((weights, (one[met], other[met])), shape=(count, count))
    return connected_components(links, directed=False)  # type: ignore[no-any-return]


def points_at(heights: Source, levels: Array) -> tuple[Index, Index]:
    """Rows and columns of the points whose height may be one of some levels [m], and few others."""
    bits = max(10, int(levels.size).bit_length() + 4)  # 16 places for a level
    table = np.zeros(1 << bits, np.bool_)
    table[_hashed(levels, bits)] = True

    def found(place: slice, rows: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        row, column = np.nonzero(table[_hashed(rows, bits)])
        return row + place.start, column

    parts = zip(*parallel.over_rows(found, heights), strict=True)
    row, column = (np.concatenate(places) for places in parts)
    return row, column


def _hashed(heights: Array, bits: int) -> NDArray[np.uint64]:
    """Places of heights in a table of 2^bits, by Fibonacci hashing."""
    words = (heights + 0.0).view(np.uint64)  # one zero, not two
    words *= np.uint64(0x9E3779B97F4A7C15)
    words >>= np.uint64(64 - bits)
    return words


def ends_of(lead: Index) -> Index:
    """Thing at the end of the way from each thing to the one that it leads to, and so on; those at
    an end lead to themselves."""
    for _ in range(lead.size):
        further = lead[lead]
        if np.array_equal(further, lead):
            break
        lead = further
    return lead


@inner()
def root(parent: Index, i: Any) -> Any:
    """First of the group of `i`, whose way to it is halved; it is its own parent."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i
