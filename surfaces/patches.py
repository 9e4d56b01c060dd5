"""Connected patches: of a mask over the pixels of a map, and of things joined pair by pair."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .numerics import parallel
from .numerics.compiled import compiled, inner
from .numerics.stored_array import Source, windows

__all__ = ["count_patches", "label_patches", "points_at", "root"]


def label_patches(
    mask: NDArray[np.bool_], *, periodic: bool, corners: bool = True
) -> tuple[NDArray[np.int32], int]:
    """Labels 1..n of the connected patches of a mask, 0 outside, (ny, nx), and their number n.

    Patches are joined across the seam if `periodic`. Pixels that meet at an edge join, and those
    that meet at a corner if `corners`.
    """
    labels, count = _components(mask, 8 if corners else 4)
    joined = _across_seam(labels, corners) if periodic else {}
    if joined:
        first = np.arange(count)
        for label, lower in sorted(joined.items()):
            first[label] = first[lower]
        labels = (np.cumsum(first == np.arange(count), dtype=np.int32) - 1)[first][labels]
    return labels, count - 1 - len(joined)


def count_patches(mask: NDArray[np.bool_], *, periodic: bool) -> int:
    """Number of the patches of a mask that `label_patches` finds."""
    labels, count = _components(mask, 8)
    return count - 1 - len(_across_seam(labels, True) if periodic else ())


def _components(mask: NDArray[np.bool_], neighbors: int) -> tuple[NDArray[np.int32], int]:
    """Labels of the map without its continuation, and their number with the background."""
    import cv2

    count, labels = cv2.connectedComponents(
        np.ascontiguousarray(mask).view(np.uint8), connectivity=neighbors, ltype=cv2.CV_32S
    )
    return np.asarray(labels, np.int32), count


def _across_seam(labels: NDArray[np.int32], corners: bool) -> dict[int, int]:
    """A lower label of the same patch for each label of which the seam hides that it has one.

    Lines of pixels on both sides of the seam meet as they lie, and moved along each other by a
    pixel if corners join.
    """
    lower: dict[int, int] = {}
    for first, last in (labels[0], labels[-1]), (labels[:, 0], labels[:, -1]):
        round_end = np.concatenate((last[-1:], last, last[:1]))
        starts = (0, 1, 2) if corners else (1,)
        own = np.tile(first, len(starts))
        other = np.concatenate([round_end[start:][: len(first)] for start in starts])
        apart = (own > 0) & (other > 0) & (own != other)
        for a, b in zip(own[apart].tolist(), other[apart].tolist(), strict=True):
            while a in lower:
                a = lower[a]
            while b in lower:
                b = lower[b]
            if a != b:
                lower[max(a, b)] = min(a, b)
    return lower


def points_at(
    heights: Source, levels: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns of the points whose height may be one of some levels [m], and few others."""
    bits = max(10, int(levels.size).bit_length() + 4)  # 16 places for a level
    table = np.zeros(1 << bits, np.bool_)
    mark = np.empty((1, levels.size), np.bool_)
    _place(levels[None], np.uint64(64 - bits), table, True, mark)

    def part(first: int, last: int) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
        found = []
        for begin, _, rows in windows(heights, first, last):
            mark = np.empty(rows.shape, np.bool_)
            _place(rows, np.uint64(64 - bits), table, False, mark)
            row, column = np.nonzero(mark)
            found.append((row + begin, column))
        return found

    ny, nx = heights.shape
    parts = [pair for each in parallel.run(part, parallel.lines(ny, ny * nx)) for pair in each]
    row, column = (np.concatenate(places) for places in zip(*parts, strict=True))
    return row, column


@compiled()
def _place(
    heights: NDArray[np.float64],
    shift: Any,
    table: NDArray[np.bool_],
    fill: bool,
    mark: NDArray[np.bool_],
) -> None:
    """Fill the places of some heights in a table, or `mark` the heights whose places are full."""
    for i in range(heights.shape[0]):
        bits = (heights[i] + 0.0).view(np.uint64)  # one zero, not two
        for j in range(bits.size):
            place = (bits[j] * np.uint64(0x9E3779B97F4A7C15)) >> shift
            if fill:
                table[place] = True
            mark[i, j] = table[place]


@inner()
def root(parent: NDArray[np.int64], i: Any) -> Any:
    """First of the group of `i`, whose way to it is halved; it is its own parent."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i
