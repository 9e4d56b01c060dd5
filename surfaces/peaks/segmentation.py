"""Segmentation of a height map into peaks and their basins."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Array, Index, Mask
from surfaces.errors import InputError, SurfaceError, as_number
from surfaces.heightmap import HeightMap, require_full
from surfaces.numerics import parallel
from surfaces.numerics.stored_array import each_block, windows

from . import _flood
from .peaks import Peaks
from .strips import Flooded, flood_strips, neighbor_distances

__all__ = ["require_wolf", "segment"]

_MOST_PIXELS = 2**31 - 4  # links are kept in 32 bits


def segment(
    hm: HeightMap,
    *,
    above: float | None = None,
    min_prominence: float = 0.0,
    wolf: float | None = None,
) -> Peaks:
    """Find every peak of a map, its basin, its saddle and its neighbors.

    Parameters
    ----------
    hm
        Height map without missing points; its border is crossed where it is periodic. A map that
        stays on disk is flooded in strips, with labels on disk.
    above
        Flood only pixels at or above this height [m]; None: all.
    min_prominence
        Smallest prominence [m] of a peak. The basins of lower ones join the neighbor across their
        saddle.
    wolf
        Smallest prominence in per cent of the height range of the map (Wolf pruning). The larger of
        both limits counts.

    Returns
    -------
    Peaks
        Peaks in descending height.

    Raises
    ------
    SurfaceError
        If points are missing.
    InputError
        If a limit is negative or not a number.

    Notes
    -----
    The peaks are those of a watershed flood of the 8-connected grid in descending height, found
    without sorting the pixels. Each pixel is linked to its steepest higher neighbor: the basin of a
    peak consists of the pixels whose links lead to it. A plateau without a higher neighbor is one
    peak. The saddle of two peaks is the lowest point of the highest path between them. This point
    lies where the path crosses from one basin to another, because inside a basin each pixel has a
    rising path to the peak. The passes between touching basins therefore determine all saddles and
    prominences, and only the passes are sorted (Kruskal's maximum spanning tree).

    References
    ----------
    ISO 25178-2:2012, 3.3 (segmentation, Wolf pruning).

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> peaks = surfaces.segment(hm)
    >>> peaks.labels.shape, bool(peaks.height[0] == hm.heights.max())
    ((32, 48), True)
    """
    require_full(hm, "segmentation")
    limit = _limit(hm, min_prominence, wolf)
    if above is not None and np.isnan(as_number("above", above)):
        raise InputError("above is not a number; give a height in m or None")
    level = -np.inf if above is None else float(above)
    stored = not isinstance(hm.source, np.ndarray)
    found = (flood_strips(hm, level) if stored else None) or _flood_all(hm, level)
    summit, height, labels, counts, keys, tops = found
    both = (
        lambda: _unique_pairs(keys, tops, summit.size),
        lambda: _merged(height, keys, tops, _lowest(hm, level), limit),
    )
    single = len(parallel.lines(hm.shape[0], hm.shape[0] * hm.shape[1])) == 1
    run: Any = map if single else parallel.each  # small maps do not repay a second thread
    (pairs, passes), (saddle, parent, keeper) = run(lambda part: part(), both)
    kept = np.flatnonzero(keeper == np.arange(summit.size))
    if kept.size < summit.size:
        place = np.full(summit.size + 1, -1, np.int32)
        place[kept] = np.arange(kept.size)
        renamed = np.append(place[keeper], np.int32(-1))
        labels = each_block(labels, lambda held: np.take(renamed, held))
        counts = np.bincount(renamed[:-1], weights=counts, minlength=kept.size)
        ends = np.sort(renamed[pairs].astype(np.int64), axis=1)
        apart = ends[:, 0] != ends[:, 1]
        keys = ends[apart, 0] * kept.size + ends[apart, 1]
        pairs, passes = _unique_pairs(keys, passes[apart], kept.size)
        parent = np.where(parent[kept] >= 0, renamed[parent[kept]], -1)
        saddle, summit, height = saddle[kept], summit[kept], height[kept]
    row, col = np.divmod(summit, hm.shape[1])
    return Peaks(
        row=row,
        col=col,
        x=hm.x[col],
        y=hm.y[row],
        height=height,
        prominence=height - saddle,
        saddle=saddle,
        parent=parent,
        basin_area=np.asarray(counts * (hm.spacing[0] * hm.spacing[1]), np.float64),
        border=_at_border(labels, kept.size, hm.periodic),
        labels=labels,
        neighbors=pairs,
        passes=passes,
        min_prominence=limit,
    )


def _flood_all(hm: HeightMap, above: float) -> Flooded:
    """Flood the pixels of a map in memory that lie at or above a height [m]."""
    flat = hm.heights.ravel()
    if flat.size > _MOST_PIXELS:
        raise SurfaceError(
            f"the map has {flat.size} points, more than {_MOST_PIXELS}; crop or resample it"
        )
    link, summit, runs = _links(hm, above)
    summit = np.sort(summit)
    summit = summit[_falling(flat[summit])]
    link[summit] = np.arange(summit.size)
    parallel.each(partial(_flood.follow, link), runs)
    labels = link.reshape(hm.shape)
    counts = np.zeros((len(runs), summit.size), np.int64)
    found = parallel.each(
        lambda part: _flood.touching(hm.heights, labels, hm.periodic, counts[part], runs[part]),
        range(len(runs)),
    )
    keys, tops = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return Flooded(summit, flat[summit], labels, counts.sum(axis=0), keys, tops)


def _lowest(hm: HeightMap, above: float) -> float:
    """Lowest height of a map at or above the height `above` [m]; infinite if there is none."""
    if above <= hm.roughness.lowest:
        return hm.roughness.lowest
    found = [rows[rows >= above].min(initial=np.inf) for _, _, rows in windows(hm.source)]
    return float(min(found))


def _merged(
    height: Array, keys: Index, passes: Array, lowest: float, limit: float
) -> tuple[Array, Index, Index]:
    """Saddle and parent of each peak, and the peak that keeps its basin after pruning; a pair of
    peaks may have several of the passes."""
    order = _falling(passes, keys)
    low = keys[order] // height.size
    high = keys[order] - low * height.size
    return _flood.merge(height, low, high, passes[order], lowest, limit)  # type: ignore[no-any-return]


def _unique_pairs(keys: Index, passes: Array, n: int) -> tuple[Index, Array]:
    """Pairs (k, 2) of the keys ``first * n + second``, each once and in order; highest passes."""
    if not keys.size:
        return np.empty((0, 2), np.int64), np.empty(0)
    order = np.argsort(keys)
    keys = keys[order]
    first = np.flatnonzero(np.diff(keys, prepend=-1))
    keys = keys[first]
    low = keys // n
    return np.column_stack([low, keys - low * n]), np.maximum.reduceat(passes[order], first)


def _falling(values: Array, keys: Index | None = None) -> Index:
    """Order of descending values; equal ones by their keys, or by position without keys.

    Only equal values are sorted stably: a stable sort of all is slower.
    """
    order = np.argsort(-values)
    ranked = values[order]
    step = ranked[1:] != ranked[:-1]
    tied = np.flatnonzero(~np.append(step, True) | ~np.append(True, step))
    if tied.size:
        group = np.cumsum(step[tied[1:] - 1])
        held = order[tied]
        rank = held if keys is None else keys[held]
        order[tied] = held[np.lexsort((rank, np.append(0, group)))]
    return order


def require_wolf(wolf: float) -> None:
    """Refuse a limit of Wolf pruning that is no percentage."""
    if not 0.0 <= as_number("wolf", wolf) <= 100.0:
        raise InputError(f"wolf is {wolf}; it must be a percentage from 0 to 100")


def _limit(hm: HeightMap, min_prominence: float, wolf: float | None) -> float:
    if not as_number("min_prominence", min_prominence) >= 0.0:
        raise InputError(f"min_prominence is {min_prominence}; it must be a height of at least 0 m")
    if wolf is None:
        return float(min_prominence)
    require_wolf(wolf)
    return max(float(min_prominence), wolf / 100.0 * (hm.roughness.highest - hm.roughness.lowest))


def _links(hm: HeightMap, above: float) -> tuple[NDArray[np.int32], Index, list[NDArray[np.int32]]]:
    """Pointer map (`_flood`), summit pixels in any order, and the flooded runs of each block."""
    heights = hm.heights
    link = np.empty(heights.size, np.int32)
    found = parallel.run(
        partial(_flood.ascend, heights, hm.periodic, above, neighbor_distances(hm), link),
        parallel.lines(heights.shape[0], heights.size),
    )
    summits = [part[0] for part in found]
    flats = np.concatenate([part[1] for part in found])
    if flats.size:
        summits.append(_flood.drain_plateaus(heights.ravel(), hm.shape, hm.periodic, link, flats))
    return link, np.concatenate(summits).astype(np.int64), [part[2] for part in found]


def _at_border(labels: NDArray[np.int32], n: int, periodic: bool) -> Mask:
    border = np.zeros(n + 1, np.bool_)
    if not periodic:
        for rim in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
            border[rim] = True
    return border[:n]
