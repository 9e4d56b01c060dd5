"""Arrays of the peaks of a map and of their summits; flat tops.

On a flat top, whose points have one height, the spline through the map only rings: such a top is
found from the heights themselves.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Array, Index, Mask
from surfaces.checks import HIGHEST_SHARE
from surfaces.errors import InputError, SurfaceError
from surfaces.heightmap import HeightMap, require_map
from surfaces.numerics.stored_array import SAMPLED_LINES, windows

__all__ = [
    "PLATEAU",
    "RIM",
    "SUMMIT",
    "Peaks",
    "SummitArrays",
    "expected_peaks",
    "flat_share",
    "flat_tops",
    "require_peaks",
]


SUMMIT, PLATEAU, RIM = 0, -1, -2
"""Kinds of peaks: the surface has a maximum near the pixel; it has none (flat tops too); it has
none, and the pixel lies at the border of the map."""


@dataclass(frozen=True, eq=False)
class Peaks:
    """Peaks of a height map in descending height, one row of every array per peak.

    Parameters
    ----------
    row, col
        Pixel of the summit, shape (n,); for a plateau its pixel nearest to its centroid.
    x, y
        Centre of that pixel [m], shape (n,).
    height
        Height of the summit pixel [m], shape (n,).
    prominence
        Height of the summit above its saddle [m], shape (n,); not negative.
    saddle
        Height [m] of the highest pass to a higher peak, shape (n,); the lowest height flooded for a
        peak without such a pass.
    parent
        Highest peak on the other side of the saddle, shape (n,); -1 if there is none.
    basin_area
        Area [m^2] of the basin, shape (n,).
    border
        True where the basin touches the border of a map that is not periodic, shape (n,).
    labels
        Peak whose basin holds the pixel, shape (ny, nx); -1 where not flooded. On disk if the map
        is on disk (`surfaces.numerics.stored_array.mapped`).
    neighbors
        Pairs of peaks whose basins touch, shape (k, 2), the higher peak first.
    passes
        Height [m] of the highest pass between each pair, shape (k,).
    min_prominence
        Limit of pruning [m] that was applied.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> peaks = surfaces.segment(hm, min_prominence=0.1 * hm.rms_height)
    >>> len(peaks) == int(peaks.labels.max()) + 1
    True
    """

    row: Index
    col: Index
    x: Array
    y: Array
    height: Array
    prominence: Array
    saddle: Array
    parent: Index
    basin_area: Array
    border: Mask
    labels: NDArray[np.int32]
    neighbors: Index
    passes: Array
    min_prominence: float = 0.0

    def __len__(self) -> int:
        return int(self.height.size)

    def __repr__(self) -> str:
        if not len(self):
            return "<Peaks: none>"
        return (
            f"<Peaks: {len(self)}, heights {self.height[-1]:.4g} .. {self.height[0]:.4g} m, "
            f"{int(self.border.sum())} at the border>"
        )


@dataclass(frozen=True, eq=False)
class SummitArrays:
    """Arrays of the summits of n peaks, one row per peak.

    Attributes
    ----------
    x, y, height, curvature, angle, pixels, border, valid, owner
        As in `Profiles`.
    peaks
        The peaks.
    hm
        The map that was segmented.
    spline
        Coefficients of the spline through the map.
    places
        Row and column of the summits [pixels], shape (n, 2).
    kinds
        `SUMMIT`, `RIM` or `PLATEAU`; or 1 + m if the surface rises from the peak into the basin of
        peak m, shape (n,).
    floor
        Height [m] above which the basins of joined summits are one, shape (n,); infinite for a
        summit that was not joined.
    tilt
        Fall of the surface along y and x [m per pixel] by a tilt of the basin, shape (n, 2).
    dip
        Fall of f along a ray [m] at which the ray ends, shape (n,).
    single
        `owner` before any summits were joined, shape (n,).
    """

    x: Array
    y: Array
    height: Array
    curvature: Array
    angle: Array
    pixels: Index
    border: Mask
    valid: Mask
    owner: Index
    peaks: Peaks = field(repr=False)
    hm: HeightMap = field(repr=False)
    spline: Array = field(repr=False)
    places: Array = field(repr=False)
    kinds: Index = field(repr=False)
    floor: Array = field(repr=False)
    tilt: Array = field(repr=False)
    dip: Array = field(repr=False)
    single: Index = field(repr=False)

    def __len__(self) -> int:
        return int(self.x.size)


def expected_peaks(hm: HeightMap, above: float) -> int:
    """Number of points above a height [m] that are higher than their neighbors, estimated from
    `SAMPLED_LINES` rows of the map."""
    ny, nx = hm.shape
    rows = np.arange(1, ny - 1, max(1, (ny - 2) // SAMPLED_LINES))
    lines = [hm.source[rows + step] for step in (-1, 0, 1)]
    peak = lines[1][:, 1:-1] > above
    for line, step in itertools.product(lines, range(3)):
        if (line is not lines[1]) or step != 1:
            peak &= lines[1][:, 1:-1] >= line[:, step : nx - 2 + step]
    return int(peak.mean() * ny * nx)


def require_peaks(peaks: object, hm: HeightMap) -> None:
    """Refuse what are no peaks, or are those of another map."""
    require_map(hm)
    if not isinstance(peaks, Peaks):
        raise InputError(f"the peaks of segment are needed, not {type(peaks).__name__}")
    if peaks.labels.shape != hm.shape:
        raise SurfaceError(
            f"the peaks belong to a map of shape {peaks.labels.shape}, not {hm.shape}; "
            "segment this map first"
        )


def flat_tops(hm: HeightMap, peaks: Peaks) -> tuple[Index, Index]:
    """Peaks with a flat top, and the middle of each.

    Returns
    -------
    rows
        Peaks with a highest point whose eight neighbors have its height too, (k,).
    middle
        Row and column of the one of these points that is nearest to their mean, (k, 2).
    """
    heights, shape = hm.source, np.array(hm.shape)
    tops = np.stack((peaks.row, peaks.col), axis=1)
    around = np.array([[0, 0], [0, 1], [0, -1], [1, 0], [-1, 0]])[:, None]
    here, *beside = heights[tuple(np.moveaxis((tops + around) % shape, -1, 0))]
    rows = np.flatnonzero(np.logical_or.reduce([height == here for height in beside]))
    if not rows.size:
        return rows, tops[:0]
    top, slot = np.full(len(peaks) + 1, np.inf), np.zeros(len(peaks) + 1, np.int64)
    top[rows], slot[rows] = here[rows], np.arange(rows.size)
    found = [
        np.add(np.argwhere(part == top[peaks.labels[begin:end]]), (begin, 0))
        for begin, end, part in windows(heights)
    ]
    points = np.concatenate(found)
    points = points[_level_steps(hm, points).all(axis=1)]
    of = slot[peaks.labels[tuple(points.T)]]
    square = np.zeros(of.size)
    for along, period in zip(points.T, shape if hm.periodic else (None, None), strict=True):
        square += _off_mean(along.astype(float), of, period) ** 2
    order = np.lexsort((square, of))
    flat, first = np.unique(of[order], return_index=True)
    return rows[flat], points[order[first]]


def _off_mean(place: Array, of: Index, period: int | None) -> Array:
    """Distance along one axis of each point from the mean of its group `of`.

    On a periodic axis positions are first taken within half a period of the circular mean of the
    group, so that the result does not depend on where the map begins.
    """
    count = np.maximum(np.bincount(of), 1)
    if period is not None:
        turn = 2.0 * np.pi * place / period
        sine, cosine = np.bincount(of, np.sin(turn)), np.bincount(of, np.cos(turn))
        place = place - (np.arctan2(sine, cosine) * period / (2.0 * np.pi))[of]
        place -= period * np.round(place / period)
    return np.asarray(place - (np.bincount(of, place) / count)[of])


def flat_share(hm: HeightMap) -> float:
    """Share of the highest points whose eight neighbors have their height."""
    if not hm.has_equal_neighbors:
        return 0.0
    heights = hm.heights
    top = np.argwhere(heights >= np.quantile(heights, 1.0 - HIGHEST_SHARE))
    return float(np.mean(_level_steps(hm, top).all(axis=1)))


def _level_steps(hm: HeightMap, points: Index) -> Mask:
    """Whether each of the nine points about each of the `points` (k, 2) has its height, (k, 9)."""
    steps = np.stack(np.meshgrid((-1, 0, 1), (-1, 0, 1), indexing="ij"), axis=-1).reshape(9, 2)
    near, shape = points[:, None] + steps, np.array(hm.shape)
    inside = hm.periodic | ((near >= 0) & (near < shape)).all(axis=2)
    near %= shape
    here = hm.source[tuple(points.T)][:, None]
    return np.asarray(inside & (hm.source[near[:, :, 0], near[:, :, 1]] == here))
