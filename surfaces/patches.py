"""Connected patches: of a mask over the pixels of a map, and of things joined pair by pair."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .numerics import parallel
from .numerics.compiled import compiled, inner
from .numerics.stored_array import Source, windows

__all__ = ["label_patches", "points_at", "root"]


_NO_PAIRS = np.zeros((0, 2), np.int32)


def label_patches(
    mask: NDArray[np.bool_], *, periodic: bool, corners: bool = True
) -> tuple[NDArray[np.int32], int]:
    """Labels 1..n of the connected patches of a mask, 0 outside, (ny, nx), and their number n.

    Patches are joined across the seam if `periodic`. Pixels that meet at an edge join, and those
    that meet at a corner if `corners`.
    """
    labels, count = _components(mask, 8 if corners else 4)
    shifts = (-1, 0, 1) if corners else (0,)
    pairs = _seam_pairs(labels, shifts) if periodic and count > 1 else _NO_PAIRS
    if not len(pairs):
        return labels, count - 1
    target = _merged(pairs, count)
    return target[labels], int(target.max())


def _components(mask: NDArray[np.bool_], neighbors: int) -> tuple[NDArray[np.int32], int]:
    """Labels of the map without its continuation, and their number with the background."""
    import cv2

    count, labels = cv2.connectedComponents(
        np.ascontiguousarray(mask).view(np.uint8), connectivity=neighbors, ltype=cv2.CV_32S
    )
    return np.asarray(labels, np.int32), count


def _seam_pairs(labels: NDArray[np.int32], shifts: tuple[int, ...]) -> NDArray[np.int32]:
    """Pairs of labels that meet across the seam, moved along it by `shifts`, shape (k, 2)."""
    pairs = []
    for first, last in ((labels[0], labels[-1]), (labels[:, 0], labels[:, -1])):
        for shift in shifts:
            other = np.roll(last, shift)
            both = (first > 0) & (other > 0)
            pairs.append(np.stack([first[both], other[both]], axis=1))
    return np.unique(np.concatenate(pairs), axis=0)


def _merged(pairs: NDArray[np.int32], count: int) -> NDArray[np.int32]:
    """New label of each old one when the labels of each pair are made equal."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), (count, count))
    _, group = connected_components(graph, directed=False)
    first = np.full(group.max() + 1, -1)
    first[group[::-1]] = np.arange(count)[::-1]
    order = np.argsort(np.argsort(first))
    return np.asarray(order[group], np.int32)


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
