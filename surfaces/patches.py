"""Connected patches: of a mask over the pixels of a map, and of things joined pair by pair."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .numerics import parallel
from .numerics.compiled import compiled, inner
from .numerics.stored_array import Source, windows

__all__ = ["count_patches", "label_patches", "points_at", "root"]

_STRIP = 1 << 20
"""Pixels whose patches are found at once where they are counted only."""


def label_patches(
    mask: NDArray[np.bool_], *, periodic: bool, corners: bool = True
) -> tuple[NDArray[np.int32], int]:
    """Labels 1..n of the connected patches of a mask, 0 outside, (ny, nx), and their number n.

    Patches are joined across the seam if `periodic`. Pixels that meet at an edge join, and those
    that meet at a corner if `corners`.
    """
    labels, count = _components(mask, 8 if corners else 4)
    shifts = (-1, 0, 1) if corners else (0,)
    if not periodic or count == 1:
        return labels, count - 1
    lines = (labels[0], labels[-1]), (labels[:, 0], labels[:, -1])
    pairs = np.concatenate([_meeting(first, last, shifts) for first, last in lines])
    if not len(pairs):
        return labels, count - 1
    target = _merged(pairs, count)
    return target[labels], int(target.max())


def count_patches(mask: NDArray[np.bool_], *, periodic: bool) -> int:
    """Number of the patches of a mask that `label_patches` finds, in strips of rows: the labels of
    a whole map would take four bytes for each pixel."""
    count, step = 0, max(1, _STRIP // mask.shape[1])
    strips = []
    for y in range(0, len(mask), step):
        labels, found = _components(mask[y : y + step], 8)
        lines = labels[0], labels[-1], labels[:, 0], labels[:, -1]
        strips.append([np.where(line > 0, line + count, 0) for line in lines])
        count += found - 1
    top, bottom, left, right = zip(*strips, strict=True)
    beside = list(zip(bottom[:-1], top[1:], strict=True))
    if periodic:
        beside += [(bottom[-1], top[0]), (np.concatenate(left), np.concatenate(right))]
    else:  # nothing follows the last column
        beside = [(np.append(first, 0), np.append(last, 0)) for first, last in beside]
    parent: dict[int, int] = {}
    for first, last in beside:
        for a, b in _meeting(first, last, (-1, 0, 1)).tolist():
            while a in parent:
                a = parent[a]
            while b in parent:
                b = parent[b]
            if a != b:
                parent[max(a, b)] = min(a, b)
    return count - len(parent)


def _components(mask: NDArray[np.bool_], neighbors: int) -> tuple[NDArray[np.int32], int]:
    """Labels of the map without its continuation, and their number with the background."""
    import cv2

    count, labels = cv2.connectedComponents(
        np.ascontiguousarray(mask).view(np.uint8), connectivity=neighbors, ltype=cv2.CV_32S
    )
    return np.asarray(labels, np.int32), count


def _meeting(
    first: NDArray[np.int32], last: NDArray[np.int32], shifts: tuple[int, ...]
) -> NDArray[np.int32]:
    """Pairs of different labels that meet where two lines of pixels lie side by side, and moved
    along each other by `shifts`, round the end, shape (k, 2)."""
    other = last[np.subtract.outer(np.arange(len(last)), shifts).T % len(last)]
    own = np.broadcast_to(first, other.shape)
    apart = (own > 0) & (other > 0) & (own != other)
    return np.stack((own[apart], other[apart]), axis=1)


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
