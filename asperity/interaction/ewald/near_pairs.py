"""Near pairs of the Ewald sum: how far they reach, their lists, and the threads that share them.

The split length says how far near pairs reach, and what is left to the mesh.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Array, Index
from surfaces.numerics.parallel import each, threads

from . import _near_kernels

__all__ = [
    "CHEAP_PAIRS",
    "CUT_OVER_SPLIT_LENGTH",
    "CUT_RATIO",
    "NearPairs",
    "chunks",
    "least_cut",
    "near_pairs",
    "split_length",
    "total",
    "widest_in_cell",
]

CUT_OVER_SPLIT_LENGTH = 2.0
"""Cut-off distance of the near pairs, over the split length eta."""

MEAN_NEIGHBORS = 15
"""Neighbors within the cut-off, on average."""

FEW_POINTS, FEW_NEIGHBORS = 3_500, 11
"""Points whose mesh is short, and their neighbors: pairs and mesh then take the same time."""

LONGEST_REACH = 16.0
"""Cut-off of the near pairs on a free half-space over the extent of the points, at most: where all
points are near each other, what the mesh adds is smaller, and with it its errors."""

CHEAP_PAIRS = 5_000
"""Near pairs, twice over, that cost little, of however few points: what footprints are beyond them
does not average out over few contacts."""

SPLIT_OVER_WIDTH = 3.0
"""Least split length over the root of the widest variance: moments must stay an expansion."""

NEAREST_IMAGE = 0.499
"""Cut-off of a periodic cell over its shorter side up to which no point has two images near another
one: the largest that footprints do not ask for."""

FARTHEST = math.sqrt(0.5)
"""Largest distance of two points of a square cell over its side. Near pairs that reach farther hold
images of a footprint that lie on it, as those of a contact that carries most of the load do: with
graded bodies (m = -0.5) the load was 14 % too high, not 6."""

MOST_PAIRS = 2_000_000
"""Near pairs, twice over, up to which footprints may ask for more."""

CUT_RATIO = 1.19
"""Ratio of the cut-offs that interactions in a periodic cell may have: they share meshes then."""

PAIRS_PER_THREAD = 25_000
"""Pairs whose part of a field repays a thread."""

TRAILING_PLACES = 8
"""Places behind the last pair of a chunk that whole vectors may read or write."""


def split_length(count: int, size: tuple[float, float], periodic: bool, widest: float) -> float:
    """Split length eta [m] of an interaction of `count` points.

    The cell, or the extent of the points on a free half-space, has the sides `size` (Ly, Lx) [m].
    The largest variance of a footprint is `widest` [m^2]. Within the cut-off there are as many
    neighbors on average as are fastest.
    """
    neighbors = max(FEW_NEIGHBORS if count <= FEW_POINTS else MEAN_NEIGHBORS, CHEAP_PAIRS / count)
    # within this distance of a point there are `neighbors` of a plane or, if more, of a line
    reach = max(
        math.sqrt(neighbors / math.pi * size[0] * size[1] / count),
        0.5 * neighbors * max(size) / count,
    )
    floor = least_cut(count, size, periodic, widest)
    reach = max(reach, floor)
    if periodic:
        cut = _shared_cut(reach, floor, NEAREST_IMAGE * min(size))
    else:
        cut = max(min(reach, LONGEST_REACH * math.hypot(*size)), floor)
    return cut / CUT_OVER_SPLIT_LENGTH


def least_cut(count: int, size: tuple[float, float], periodic: bool, widest: float) -> float:
    """Least cut-off [m] for footprints of the variance `widest`, no more than so many points can
    have; arguments as of `split_length`."""
    least = CUT_OVER_SPLIT_LENGTH * SPLIT_OVER_WIDTH * math.sqrt(widest)
    if not periodic:
        return least
    affordable = math.sqrt(MOST_PAIRS / math.pi * size[0] * size[1]) / count
    return min(least, max(affordable, NEAREST_IMAGE * min(size)))


def widest_in_cell(size: tuple[float, float]) -> float:
    """Variance [m^2] of a footprint whose near pairs reach all places of a periodic cell."""
    return (FARTHEST * min(size) / (CUT_OVER_SPLIT_LENGTH * SPLIT_OVER_WIDTH)) ** 2


def _shared_cut(wanted: float, least: float, largest: float) -> float:
    """The cut-off nearest to that wanted, but no more than the largest, of those that lists share;
    the next one where it is below the least."""
    rungs = max(round(math.log(largest / wanted, CUT_RATIO)), 0)
    if largest * CUT_RATIO**-rungs < least:
        rungs = math.floor(math.log(largest / least, CUT_RATIO))
    return largest * CUT_RATIO**-rungs


def total(parts: NDArray[np.floating], rows: Index | None = None) -> NDArray[np.floating]:
    """Sum of what all chunks have made, in the place of the first; of these `rows` only, if any."""
    here = slice(None) if rows is None else slice(*rows)
    for part in parts[1:]:
        parts[0, here] += part[here]
    return np.asarray(parts[0])


class NearPairs(NamedTuple):
    """Pairs of points i < j within a cut-off: the bounds (n, 2) of those of each i, their columns j
    and their distances by y and x, (2, pairs)."""

    ptr: Index
    col: NDArray[np.int32]
    pair: NDArray[np.float32]


def near_pairs(
    y: Array, x: Array, start: Index, cells: tuple[int, int], size: tuple[float, float], wrap: bool
) -> NearPairs:
    """Pairs within the cut-off of points sorted by their cells, in split lengths."""
    n = len(y)
    count = max(1, min(threads(), n // 2000, cells[0]))
    edges = np.linspace(0, cells[0], count + 1).astype(np.int64)
    rows = np.stack((edges[:-1], edges[1:]), axis=1)
    ptr = np.zeros((n, 2), np.int64)
    col, pair = np.empty(0, np.int32), np.empty((2, 0), np.float32)
    first, number = np.zeros(len(rows), np.int64), np.zeros(len(rows), np.int64)

    def find(c: int) -> None:
        place = y, x, start, cells, size, wrap, CUT_OVER_SPLIT_LENGTH**2, rows[c], first[c]
        number[c] = _near_kernels.half_list(*place, ptr, col, pair) - first[c]

    each(find, range(count))  # counts them
    if number.any():
        end = np.cumsum(number + TRAILING_PLACES)
        first[1:] = end[:-1]
        col, pair = np.zeros(end[-1], np.int32), np.zeros((2, end[-1]), np.float32)
        each(find, range(count))
    return NearPairs(ptr, col, pair)


def chunks(pairs: Index) -> Index:
    """Runs of rows with about equal work, one for each thread, shape (chunks, 2)."""
    count = max(1, min(threads(), int(pairs.sum()) // PAIRS_PER_THREAD))
    work = np.cumsum(pairs + 8)
    inner = np.searchsorted(work, work[-1] * np.arange(1, count) / count)
    edges = np.concatenate(([0], inner, [len(pairs)])).astype(np.int64)
    return np.stack((edges[:-1], edges[1:]), axis=1)
