"""Outliers: points that exceed the roughness around them are marked as missing."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np
from scipy.ndimage import median_filter

from surfaces.arrays import Array, Index
from surfaces.errors import SurfaceError, as_number
from surfaces.heightmap import HeightMap, require_map
from surfaces.numerics.stored_array import Source, array_of, each_block, rows_around, windows

from .filling import middle, quick_fill, replaced

__all__ = ["mark_outliers"]


_NINE_TENTHS = 1.6449  # nine tenths of a normal variable lie within this many deviations
_MEAN = 0.7979  # mean absolute value of a normal variable, in deviations
_AROUND = 11  # side [pixels] of the surroundings of a point
_REACH = 4  # rows about a point that its roughness takes: twice half a median filter
_ROUNDS = 5  # searches for spikes, at most
_DWARFED = 1e-2  # largest height without the spikes found, over the scale, that changes the scale


def mark_outliers(hm: HeightMap, threshold: float = 6.0) -> HeightMap:
    """Turn spikes into missing points.

    Parameters
    ----------
    hm
        The map; missing points are left out of the judgement.
    threshold
        A point is a spike if its roughness (what a 5 x 5 median filter, applied twice, leaves)
        exceeds this many standard deviations, of the map and of the 11 x 11 points about it; at
        least 3.

    Returns
    -------
    HeightMap
        History step ``outliers`` with the smallest limit [m] and the count.

    Raises
    ------
    SurfaceError
        If the threshold is below 3.

    Notes
    -----
    The deviation of the map is its ninth decile over 1.6449, that of the surroundings 1.25 times
    the mean, spikes cut off in both: steep or rough places are not taken for spikes. Repeated
    until nothing more is found, at most five times, with spikes replaced by the medians: a spike
    wider than two points is taken from its rim inwards.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> heights = hm.heights.copy()
    >>> heights[10, 20] += 1e-3
    >>> surfaces.mark_outliers(hm.replace(heights=heights)).missing
    1
    """
    require_map(hm)
    if not as_number("outliers", threshold) >= 3.0:
        raise SurfaceError(f"outliers is {threshold}; use 3 or more robust standard deviations")
    level = middle(hm.source)
    scale = max(hm.roughness.highest - level, level - hm.roughness.lowest) or 1.0
    z = quick_fill(each_block(hm.source, lambda heights: (heights - level) / scale))
    spikes: Index = np.empty(0, np.int64)
    limit = _limit(hm, z, threshold)
    for _ in range(_ROUNDS):
        found = [_spikes(strip, limit, threshold, hm.periodic) for strip in _strips(hm, z)]
        places, medians = (np.concatenate(part) for part in zip(*found, strict=True))
        fresh = ~np.isin(places, spikes)
        places, medians = places[fresh], medians[fresh]
        if not places.size:
            break
        spikes = np.union1d(spikes, places)
        z = array_of(replaced(z, places, medians), z.shape, z)
        top = max(float(np.abs(rows).max()) for _, _, rows in windows(z))
        if 0.0 < top < _DWARFED:  # a far spike had hidden the others below the rounding
            z = each_block(z, partial(np.multiply, 1.0 / top))
            scale *= top
            limit = _limit(hm, z, threshold)
    step = {
        "step": "outliers",
        "threshold": threshold,
        "limit": limit * scale,
        "count": len(spikes),
    }
    gaps = np.full(len(spikes), np.nan)
    return hm.with_rows(replaced(hm.source, spikes, gaps), step=step)


def _limit(hm: HeightMap, z: Source, threshold: float) -> float:
    """Smallest roughness of a spike, over the scale of z, above the rounding of the medians."""
    return threshold * _ninth_decile(hm, z) / _NINE_TENTHS + 1e-7


class _Strip(NamedTuple):
    """Roughness of a block of rows, and of those about it, across the seam of a periodic map.

    Attributes
    ----------
    begin, rows
        Number of the first row of the block, and its heights.
    block
        Rows of the block in what follows.
    rough, median
        Roughness and medians.
    """

    begin: int
    rows: Array
    block: slice
    rough: Array
    median: Array


def _strips(hm: HeightMap, z: Source) -> Iterator[_Strip]:
    """Strips of the map; `z` holds its heights without gaps and spikes."""
    ny = hm.shape[0]
    for begin, end, rows in windows(hm.source):
        low, high = begin - _AROUND // 2, end + _AROUND // 2
        if not hm.periodic:
            low, high = max(0, low), min(ny, high)
        first = low - _REACH if hm.periodic else max(0, low - _REACH)
        part = rows_around(z, first, high + _REACH, hm.periodic)
        median = _median(part, hm.periodic)
        rough = part - median
        rough = np.abs(rough - _median(rough, hm.periodic))
        inner = slice(low - first, high - first)
        block = slice(begin - low, end - low)
        yield _Strip(begin, rows, block, rough[inner], median[inner])


def _ninth_decile(hm: HeightMap, z: Source) -> float:
    """Ninth decile of the roughness of the points present, the upper tenth of which is kept."""
    place = 0.9 * (z.size - hm.missing - 1)
    upper = np.empty(0)
    for strip in _strips(hm, z):
        upper = np.append(upper, strip.rough[strip.block][~np.isnan(strip.rows)])
        below = max(0, len(upper) - z.size + hm.missing + int(place))
        upper = np.partition(upper, below)[below:]
    lowest = np.partition(upper, min(1, len(upper) - 1))[:2]
    return float(np.quantile(lowest, place - int(place)))


def _spikes(strip: _Strip, limit: float, threshold: float, periodic: bool) -> tuple[Index, Array]:
    """Places of the points of a block that stand out, and the medians about them."""
    half = _AROUND // 2
    rough, sides = np.minimum(strip.rough, limit), ((0, 0), (half, half))
    rough = np.pad(rough, sides, "wrap") if periodic else np.pad(rough, sides, "reflect")
    around = cv2.blur(rough, (_AROUND, _AROUND))[:, half:-half] / _MEAN
    stand_out = strip.rough > np.maximum(limit, threshold * around)
    places = np.flatnonzero(stand_out[strip.block] & ~np.isnan(strip.rows))
    return places + strip.begin * strip.rows.shape[1], strip.median[strip.block].ravel()[places]


def _median(z: Array, periodic: bool) -> Array:
    """Median of the 5 x 5 points about each point; the map goes on evenly beyond its border."""
    padded = np.pad(z, 2, mode="wrap") if periodic else _extended(_extended(z).T).T
    blurred = cv2.medianBlur(padded.astype(np.float32), 5)
    return np.asarray(blurred[2:-2, 2:-2], dtype=np.float64)


def _extended(z: Array) -> Array:
    """Two rows more on either side, mirrored through the medians along the border rows."""
    first, last = (median_filter(row, 5, mode="nearest") for row in (z[0], z[-1]))
    return np.vstack([2.0 * first - z[2:0:-1], z, 2.0 * last - z[-2:-4:-1]])
