"""Arrays of groups of eight: working space, and rows of eight profiles turned into lanes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .compiled import inner
from .lanes import LANES, load, store, transpose


@inner()
def spread_rows(source, rows, out, space):
    """Rows of an array of whole groups (`packed`), one in every lane; `space` is eight groups."""
    width = source.shape[1] // LANES
    for k in range(width):
        for lane in range(LANES):
            store(space, lane, load(source, rows[lane] * width + k))
        transpose(space, 0, 1, out, k * LANES, 1)


@inner()
def collect_rows(source, target, rows, count, space):
    """The first `count` lanes as rows of an array of whole groups; `space` is eight groups."""
    width = target.shape[1] // LANES
    for k in range(width):
        transpose(source, k * LANES, 1, space, 0, 1)
        for lane in range(count):
            store(target, rows[lane] * width + k, load(space, lane))


@inner()
def ordered(keys, highest):
    """Places of whole numbers from 0 to `highest` in rising order."""
    begin = np.zeros(highest + 2, np.int64)
    for key in keys:
        begin[key + 1] += 1
    for key in range(highest + 1):
        begin[key + 1] += begin[key]
    order = np.empty(keys.size, np.int64)
    for i in range(keys.size):
        order[begin[keys[i]]] = i
        begin[keys[i]] += 1
    return order


def groups(count: int) -> NDArray[np.float64]:
    """Working space of `count` groups, at the start of a cache line."""
    space = np.zeros((count + 1) * LANES)
    first = (-(space.ctypes.data // 8)) % LANES
    return space[first : first + count * LANES]


def packed(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """One row per profile, lengthened by zeros to whole groups."""
    rows = np.ascontiguousarray(values).reshape(len(values), math.prod(values.shape[1:]))
    spare = -rows.shape[1] % LANES
    return np.pad(rows, ((0, 0), (0, spare))) if spare else rows
