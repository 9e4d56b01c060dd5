"""Compiled reading of a contact map: pixels, edges and patches in one pass over its runs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics.compiled import compiled, inner
from surfaces.patches import root

Index = NDArray[np.int64]


@inner()
def _row_runs(row: NDArray[np.float64], nx: int, begin: Index, end: Index) -> int:
    """First and last + 1 column of each run of positive values; returns their number."""
    n = 0
    inside = False
    for x in range(nx):
        if row[x] > 0.0:
            if not inside:
                begin[n] = x
                inside = True
        elif inside:
            end[n] = x
            n += 1
            inside = False
    if inside:
        end[n] = nx
        n += 1
    return n


@inner()
def _linked(parent: Index, i: int, j: int) -> Any:
    """1 if two runs were apart and are joined now, else 0."""
    a, b = root(parent, i), root(parent, j)
    if a == b:
        return 0
    parent[max(a, b)] = min(a, b)
    return 1


@inner()
def _join(
    parent: Index,
    nx: int,
    begin: Index,
    end: Index,
    n: int,
    label: int,
    old_begin: Index,
    old_end: Index,
    old_n: int,
    old_label: int,
) -> Any:
    """Join the runs of two rows that touch, by an edge or a corner; returns the common pixels and
    the joints."""
    common = joints = i = j = 0
    while i < n and j < old_n:
        shared = min(end[i], old_end[j]) - max(begin[i], old_begin[j])
        if shared >= 0:
            common += shared
            joints += _linked(parent, label + i, old_label + j)
        if end[i] < old_end[j]:
            i += 1
        else:
            j += 1
    if nx > 0 and n > 0 and old_n > 0:  # by a corner across the seam
        if begin[0] == 0 and old_end[old_n - 1] == nx:
            joints += _linked(parent, label, old_label + old_n - 1)
        if old_begin[0] == 0 and end[n - 1] == nx:
            joints += _linked(parent, label + n - 1, old_label)
    return common, joints


@compiled()
def contact_counts(pressure: NDArray[np.float64], nx: int, periodic: bool) -> Any:
    """Pixels under pressure, their edges to others, and their patches.

    Pixels of a patch meet at an edge or a corner. `pressure` has nx columns or more. Across the
    border of the map lies its other side if it is periodic, no contact if not.
    """
    ny = pressure.shape[0]
    width = nx // 2 + 1
    begin, end = np.empty((3, width), np.int64), np.empty((3, width), np.int64)
    parent = np.empty(max(width, 1024), np.int64)
    zero = np.int64(0)  # a bare 0 is a type of its own, for which `_join` is compiled anew
    pixels = edges = runs = joints = zero
    seam = nx if periodic else 0
    first_n = old_n = old_label = old_pixels = first_pixels = zero
    for y in range(ny):
        now, old = 1 + y % 2, 2 - y % 2
        n = _row_runs(pressure[y], nx, begin[now], end[now])
        if runs + n > parent.size:
            wider = np.empty(2 * parent.size + n, np.int64)
            for i in range(runs):
                wider[i] = parent[i]
            parent = wider
        row_pixels = 0
        for i in range(n):
            parent[runs + i] = runs + i
            row_pixels += end[now, i] - begin[now, i]
        edges += 2 * n
        if periodic and n > 0 and begin[now, 0] == 0 and end[now, n - 1] == nx:
            edges -= 2
            if n > 1:
                parent[runs + n - 1] = runs
                joints += 1
        common, joined = _join(
            parent, seam, begin[now], end[now], n, runs, begin[old], end[old], old_n, old_label
        )
        joints += joined
        edges += row_pixels + old_pixels - 2 * common
        if y == 0:
            first_n, first_pixels = n, row_pixels
            for i in range(n):  # whole rows take 1 s to compile, with words for other shapes
                begin[0, i], end[0, i] = begin[now, i], end[now, i]
        pixels += row_pixels
        old_n, old_label, old_pixels = n, runs, row_pixels
        runs += n
    last = 1 + (ny - 1) % 2
    if periodic:
        edges -= first_pixels
        common, joined = _join(
            parent, seam, begin[0], end[0], first_n, zero, begin[last], end[last], old_n, old_label
        )
        joints += joined
        edges += first_pixels + old_pixels - 2 * common
    else:
        edges += old_pixels
    return pixels, edges, runs - joints
