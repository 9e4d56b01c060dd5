"""Flood of a map that stays on disk, strip by strip, with the peaks of the map in memory."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Array, Index
from surfaces.heightmap import HeightMap
from surfaces.numerics.memory import require_memory
from surfaces.numerics.stored_array import BLOCK_BYTES, StoredArray, rows_around
from surfaces.patches import ends_of

from . import _flood

__all__ = ["Flooded", "flood_strips", "neighbor_distances"]

Labels = NDArray[np.int32]

STRIP_HALO = 8
"""Rows on both sides of a strip that are read first, to follow the plateaus that leave it."""

PEAK_BYTES = 400
"""Bytes of memory of a peak with its passes while basins are merged."""


class Flooded(NamedTuple):
    """Peaks of a map, in descending height, before any is pruned; or those of a strip of its rows,
    in the order of their pixels.

    In a strip the peaks have the first labels; the others stand for the pixels of the row above and
    of the row below it, at which links that leave the strip end.

    Attributes
    ----------
    summit
        Pixel in the map of each peak.
    height
        Height of each peak [m].
    labels
        Label of each pixel, shape (rows, nx), in memory or on disk: the peak whose basin holds it;
        -1: not flooded.
    counts
        Pixels of each of the n labels.
    keys, passes
        Touching pairs as ``first * n + second``, some several times, and their passes [m].
    """

    summit: Index
    height: Array
    labels: Any
    counts: Index
    keys: Index
    passes: Array


def flood_strips(hm: HeightMap, above: float) -> Flooded | None:
    """Peaks, basins and passes of a map, in strips of whole rows with a halo on both sides.

    Pixels below the height `above` [m] are not flooded. None if a plateau is as long as the map:
    then no strip tells where it leads.

    Raises
    ------
    SurfaceError
        If the peaks, or a strip with the plateaus that cross its borders, do not fit into memory.
    """
    ny, nx = hm.shape
    step = max(1, BLOCK_BYTES // (8 * nx))
    firsts = range(0, ny, step)
    labels = StoredArray((ny, nx), np.int32, np.int32)
    strips, rims, found = [], [], 0
    for number, first in enumerate(firsts):
        strip = _flooded(hm, first, min(first + step, ny), above)
        if strip is None:
            return None
        labels.write(first, strip.labels)
        rims.append(strip.labels[[0, -1]])
        strips.append(strip._replace(labels=rims[-1]))
        found += strip.summit.size
        require_memory(
            PEAK_BYTES * found * (len(firsts) - number - 1) // (number + 1),
            f"a map of {ny} x {nx} points with {found} peaks in its first {number + 1} strips",
            "raise the limit of memory, or flood only the heights above some level (above=)",
        )
    summit = np.concatenate([strip.summit for strip in strips])
    height = np.concatenate([strip.height for strip in strips])
    order = np.argsort(-height, kind="stable")
    rank = np.empty(summit.size, np.int64)
    rank[order] = np.arange(summit.size)
    counts, keys = np.zeros(summit.size, np.int64), []
    for first, strip, name in zip(firsts, strips, _names(strips, rank, hm.periodic), strict=True):
        held = strip.counts > 0
        np.add.at(counts, name[held], strip.counts[held])
        low, high = np.sort(name[np.stack(np.divmod(strip.keys, strip.counts.size))], axis=0)
        keys.append(np.where(low < high, low * summit.size + high, -1))
        rows = labels[first : first + step]
        labels.write(first, np.append(name, -1)[rows])
    key, passes = np.concatenate(keys), np.concatenate([strip.passes for strip in strips])
    held = key >= 0
    return Flooded(summit[order], height[order], labels, counts, key[held], passes[held])


def _flooded(hm: HeightMap, first: int, last: int, above: float) -> Flooded | None:
    """The rows from `first` to `last`, flooded; None if a plateau there is as long as the map."""
    (ny, nx), halo = hm.shape, STRIP_HALO
    while True:
        top, window = first - halo, _rows(hm, first - halo, last + halo)
        above_all, below_all = not hm.periodic and top <= 0, not hm.periodic and last + halo >= ny
        begin, end = -top if above_all else 1, ny - top if below_all else len(window) - 1
        link = np.full(window.size, -1, np.int32)
        peaks, flats, runs = _flood.ascend(
            window, hm.periodic, above, neighbor_distances(hm), link, begin, end
        )
        flat = flats.astype(np.int64)
        ends = [row for row, whole in ((begin, above_all), (end - 1, below_all)) if not whole]
        cut = flat[np.isin(flat // nx, ends)]
        rows = first - top - 1, last - top + 1
        if not _reach(window, hm.periodic, link, flat, cut, rows):
            break
        halo *= 2
        if halo > ny:
            return None
    order = np.argsort((flat // nx + top) % ny * nx + flat % nx)
    level_tops = _flood.drain_plateaus(window.ravel(), window.shape, hm.periodic, link, flat[order])
    start, stop = (first - top - 1) * nx, (last - top + 1) * nx
    summit = np.sort(np.concatenate([peaks, level_tops])).astype(np.int64)
    summit = summit[(summit >= start + nx) & (summit < stop - nx)] - start
    inside = runs.astype(np.int64)
    inside = inside[(inside[:, 0] >= start + nx) & (inside[:, 0] < stop - nx)] - start
    heights = window[first - top - 1 : last - top + 1]
    labels = link[start:stop].reshape(heights.shape)
    labels[labels < -1] += np.int32(start)
    for row, offset in ((0, 0), (-1, nx)):
        flooded = (heights[row] >= above) & np.isfinite(heights[row])
        labels[row] = np.where(flooded, summit.size + offset + np.arange(nx), -1)
    labels.flat[summit] = np.arange(summit.size)
    own = inside.astype(np.int32)
    _flood.follow(labels.reshape(-1), own)
    counts = np.zeros(summit.size + 2 * nx, np.int64)
    keys, passes = _flood.touching(heights, labels, hm.periodic, counts, own)
    place = summit + (first - 1) * nx
    return Flooded(place, heights.ravel()[summit], labels[1:-1], counts, keys, passes)


def neighbor_distances(hm: HeightMap) -> tuple[float, float, float]:
    """Distances [m] of a pixel to its neighbors above, beside and diagonal."""
    return *hm.spacing, float(np.hypot(*hm.spacing))


def _reach(
    window: Array, periodic: bool, link: Labels, flat: Index, cut: Index, rows: tuple[int, int]
) -> bool:
    """Whether plateaus, of pixels `flat`, that hold a pixel of `cut` have any in some rows."""
    link, queue = link.copy(), np.empty(flat.size, np.int64)
    queue[: cut.size], link[cut] = cut, -2 - cut
    at = np.zeros((flat.size, 2), np.int64)
    size = _flood.spread(window.ravel(), window.shape, periodic, link, queue, at, cut.size)
    row = queue[:size] // window.shape[1]
    return bool(((row >= rows[0]) & (row < rows[1])).any())


def _rows(hm: HeightMap, top: int, bottom: int) -> Array:
    """Rows of the map from `top` to `bottom`; beyond its border those across, or -inf."""
    ny, nx = hm.shape
    require_memory(
        32 * nx * (bottom - top),
        f"a strip of {bottom - top} rows with the plateaus that cross its borders",
        "raise the limit of memory, or crop the map",
    )
    ends = (0, 0) if hm.periodic else (max(-top, 0), max(bottom - ny, 0))
    held = rows_around(hm.source, top, bottom, hm.periodic)
    return np.pad(held, (ends, (0, 0)), constant_values=-np.inf)


def _names(strips: list[Flooded], rank: Index, periodic: bool) -> list[Index]:
    """Peak in the map of each label of each strip, -1 if none.

    A way that leaves a strip goes on from a pixel of the next one, whose label may lead on in turn.
    """
    nx = strips[0].labels.shape[1]
    first = [0, *itertools.accumulate(strip.counts.size for strip in strips)]
    lead = np.arange(first[-1] + 1)  # the last stands for none
    peak = np.full(lead.size, -1)
    held = 0
    for number, strip in enumerate(strips):
        count = strip.summit.size
        peak[first[number] : first[number] + count] = rank[held : held + count]
        held += count
        for side, other in ((0, number - 1), (1, number + 1)):
            at = first[number] + count + side * nx
            if periodic or 0 <= other < len(strips):
                label = strips[other % len(strips)].labels[1 - side]
                lead[at : at + nx] = np.where(label >= 0, first[other % len(strips)] + label, -1)
    lead[lead < 0] = first[-1]
    names = peak[ends_of(lead)]
    return [names[a:b] for a, b in itertools.pairwise(first)]
