"""Sub-pixel summits of all peaks, and profiles of those that are asked for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from surfaces.arrays import Array, Index
from surfaces.errors import SurfaceError, as_count
from surfaces.heightmap import HeightMap
from surfaces.numerics import parallel, splines
from surfaces.numerics.stored_array import Source, mapped, most_together
from surfaces.patches import ends_of

from . import _climb
from .peaks import PLATEAU, RIM, SUMMIT, Peaks, SummitArrays, flat_tops, require_peaks
from .profiles import PART, Profiles, SampledRays

__all__ = ["Summits", "fit_profiles", "locate_summits"]

_BAND = 32  # rows of a band; `_near` orders peaks by bands
_SAME = 0.2  # two summits nearer than this [pixels] are one
_RING = 0.1  # the spline rings on a flat top by up to this part of its height


@dataclass(frozen=True, eq=False)
class Summits(SummitArrays):
    """Summits of n peaks. `rows` samples the rays of some of them.

    At light loads most peaks never touch, and the rays of all would cost more than all the rest.
    """

    def joined(self, pairs: Index, floors: Array) -> Summits:
        """Summits with the basins of each of the `pairs` (k, 2) joined to one basin.

        It belongs to the higher summit, of equal ones to that with the larger basin. The basins of
        a pair count as one above the height `floors` [m], shape (k,).
        """
        owner, floor = self.owner.copy(), self.floor.copy()
        pixels, border, valid = self.pixels.copy(), self.border.copy(), self.valid.copy()
        for (first, second), low in zip(pairs, floors, strict=True):
            into, lost = sorted(
                (owner[first], owner[second]), key=lambda i: (-self.height[i], -pixels[i])
            )
            if into == lost:
                continue
            floor[into] = min(floor[into], floor[lost], low)
            owner[owner == lost] = into
            pixels[into] += pixels[lost]
            border[into] |= border[lost]
            valid[lost] = False
        return replace(self, owner=owner, floor=floor, pixels=pixels, border=border, valid=valid)

    def tilted(self, index: Index, gradient: Array, dip: Array) -> Summits:
        """Summits after a tilt of the basins of the peaks `index` (k,).

        The surface of each falls by the `gradient` along y and x [-], (k, 2), in addition. A ray
        ends where f has fallen by `dip` [m], (k,).

        Notes
        -----
        The summit moves to the next maximum of the tilted surface uphill in its basin; `valid` says
        whether there is one. `height` is that of the surface without tilt.
        """
        hm, peaks = self.hm, self.peaks
        names = "x", "y", "height", "curvature", "angle", "valid", "places", "kinds", "tilt", "dip"
        own = {name: getattr(self, name).copy() for name in names}
        own["tilt"][index], own["dip"][index] = gradient * np.asarray(hm.spacing), dip
        row, col = peaks.row.copy(), peaks.col.copy()
        heights, labels = hm.mapped, mapped(peaks.labels)
        _climb.uphill(heights, labels, self.owner, hm.periodic, own["tilt"], index, row, col)
        places, kinds = own["places"], own["kinds"]
        start = (row, col, own["tilt"], index)
        expansions = _climbed(hm, peaks.labels, self.spline, start, places, kinds)
        summit, own["curvature"][index], own["angle"][index] = _climb.frames(
            hm.source[row[index], col[index]], hm.shape[0], hm.spacing, peaks.prominence[index],
            self.pixels[index], places[index], expansions[index], kinds[index],
        )  # fmt: skip
        own["x"][index], own["y"][index], own["height"][index] = summit.T
        own["valid"][index] &= kinds[index] == SUMMIT
        return replace(self, **own)

    def near(self, index: Index) -> Index:
        """Order of the peaks `index` in which neighbors on the map follow each other."""
        return _near(self.peaks.row[index], self.peaks.col[index])

    def rows(self, index: Index, *, rays: int = 16, nodes: int = 17) -> Profiles:
        """Profiles of the peaks `index` (k,), in that order; rays and nodes as in `fit_profiles`.
        `owner` counts the peaks of the whole map."""
        rays, nodes = as_count("rays", rays, 4), as_count("nodes", nodes, 4)
        sampled = SampledRays(self, index, rays, nodes)
        near = self.near(index)
        parallel.run(lambda a, b: sampled.fill(near[a:b]), parallel.blocks(len(index), PART, PART))
        names = ("x", "y", "height", "curvature", "angle", "pixels", "border", "valid", "owner")
        own: dict[str, Any] = {name: getattr(self, name)[index] for name in names}
        t = np.linspace(0.0, 1.0, nodes)
        return Profiles(
            phi=sampled.phi, weight=sampled.weight, edge=sampled.edge, t=t, q=sampled.q, **own
        )


def locate_summits(hm: HeightMap, peaks: Peaks) -> Summits:
    """Find the summits of peaks: climb from each pixel to a maximum of the surface through the
    points of the map. Raises the errors of `fit_profiles`."""
    require_peaks(peaks, hm)
    n = len(peaks)
    depth = _depths(peaks)
    if not (depth > 0.0).all():  # a peak at the lowest height flooded has no depth
        relief = hm.roughness.highest - hm.roughness.lowest
        if relief == 0.0:
            raise SurfaceError("the map is constant; there is no summit to fit")
        depth = np.maximum(depth, 1e-6 * relief)
    spline = splines.coefficients(hm.source, hm.periodic)
    places, kinds, level = np.empty((n, 2)), np.empty(n, np.int64), np.zeros((n, 2))
    start = (peaks.row, peaks.col, level, _near(peaks.row, peaks.col))
    expansions = _climbed(hm, peaks.labels, spline, start, places, kinds)
    dip = np.full(n, peaks.min_prominence)
    flat, middle = flat_tops(hm, peaks)
    flat, middle = (array[kinds[flat] != RIM] for array in (flat, middle))
    if flat.size:
        row, col = peaks.row.copy(), peaks.col.copy()
        row[flat], col[flat] = middle.T
        places[flat], kinds[flat] = middle, PLATEAU
        peaks = replace(peaks, row=row, col=col)
    dip[flat] = np.maximum(dip[flat], _RING * depth[flat])
    owner = _owners(hm, peaks, places, kinds)
    own = owner == np.arange(n)
    counts = np.rint(peaks.basin_area / np.prod(hm.spacing)).astype(np.int64)
    pixels = np.bincount(owner, weights=counts, minlength=n).astype(np.int64)
    border = np.bincount(owner, weights=peaks.border, minlength=n) > 0
    pixels[~own], border[~own] = counts[~own], peaks.border[~own]
    summit, curvature, angle = _climb.frames(
        peaks.height, hm.shape[0], hm.spacing, depth, pixels, places, expansions, kinds
    )
    x, y, height = (np.ascontiguousarray(column) for column in summit.T)
    return Summits(
        x, y, height, curvature, angle, pixels, border, own, owner, peaks, hm, spline, places,
        kinds, np.full(n, np.inf), level, dip, owner,
    )  # fmt: skip


def _climbed(
    hm: HeightMap,
    labels: Source,
    spline: Array,
    start: tuple[Index, Index, Array, Index],
    places: Array,
    kinds: Index,
) -> Array:
    """Climb from the rows and columns of the pixels of all peaks, on the surface with their tilts,
    for the peaks of an order: `start`. Fills in their places and kinds; returns the expansions of
    the surface there, (n, 6), see `_climb.climb`."""
    given, expansions = (hm.mapped, spline, mapped(labels), hm.periodic), np.empty((len(kinds), 6))
    parallel.run(
        partial(_climb.summits, *given, *start, places, expansions, kinds),
        parallel.blocks(len(start[-1]), 512, most_together(hm.source)),
    )
    return expansions


def _depths(peaks: Peaks) -> Array:
    """Height [m] of each peak above its pass to a peak that is at least as high. It does not depend
    on which of equal peaks is the parent, as `prominence` does."""
    saddle, parent = peaks.saddle.copy(), peaks.parent
    even = np.flatnonzero((parent >= 0) & (peaks.height[parent] == peaks.height))
    np.maximum.at(saddle, parent[even], peaks.saddle[even])
    return np.asarray(peaks.height - saddle)


def fit_profiles(hm: HeightMap, peaks: Peaks, *, rays: int = 16, nodes: int = 17) -> Profiles:
    """Fit the profile of every peak of a map.

    Parameters
    ----------
    hm
        The map that was segmented.
    peaks
        Its peaks, from `segment`.
    rays
        Directions per peak, at least 4.
    nodes
        Radial nodes per ray, at least 4.

    Returns
    -------
    Profiles
        One profile per peak, in the order of `peaks`.

    Raises
    ------
    SurfaceError
        If the peaks belong to a map of another shape, or the map is constant.
    InputError
        If there are too few rays or nodes.

    Notes
    -----
    The map is interpolated by the quintic B-spline through all its points. The summit is the
    maximum of the spline. The rays are uniform in the parameter of an ellipse with the aspect
    ``(k2/k1) ** (1/3)`` (the square root of the aspect of the Hertz contact, at least 1/sqrt(8)),
    which keeps the angular quadrature accurate for elongated contacts. A ray ends at the first
    local maximum of f, or a tenth beyond the point where it leaves the basin of its peak for
    another: basins are not star-shaped, and rays cut at their edge would cover only nine tenths of
    the map. A plateau has no curvature of its own and gets that of the paraboloid that fills its
    basin. The summit of a flat top (`flat_tops`) is its middle; its rays pass over the rings of the
    spline. A peak that is highest at the border of a map that is not periodic is mirrored at the
    border and compressed by 1.7 across it: this whole contact carries as much as the half that
    exists. Unflooded pixels belong to no basin, so that `segment(above=...)` changes hardly a ray
    above that height.

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> x = np.arange(48) + 0.5
    >>> y = np.arange(32) + 0.5
    >>> heights = np.cos(2 * np.pi * x / 24) + np.cos(2 * np.pi * y / 32)[:, None]
    >>> hm = surfaces.HeightMap(heights, 1.0, periodic=True)
    >>> fit = surfaces.fit_profiles(hm, surfaces.segment(hm))
    >>> [f"{k:.4f}" for k in fit.curvature[0]]
    ['0.0685', '0.0386']
    >>> f"{(2 * np.pi / 24) ** 2:.4f} {(2 * np.pi / 32) ** 2:.4f}"
    '0.0685 0.0386'
    """
    return locate_summits(hm, peaks).rows(np.arange(len(peaks)), rays=rays, nodes=nodes)


def _near(row: Index, col: Index) -> Index:
    """Order of pixels by bands of rows, then by columns: neighbors share the cache."""
    return np.argsort((row // _BAND << 32) + col)


def _owners(hm: HeightMap, peaks: Peaks, places: Array, kinds: Index) -> Index:
    """Owner of each peak (`Profiles.owner`). If two peaks have one summit, `kinds` of the one whose
    basin does not hold it becomes 1 + the other."""
    n = len(peaks)
    rank = np.arange(n)
    pixel = np.rint(places).astype(np.int64)
    if hm.periodic:
        pixel %= hm.shape
    at = peaks.labels[pixel[:, 0], pixel[:, 1]] if n else rank
    shared = (kinds == SUMMIT) & (at >= 0) & (at != rank)
    shared[shared] &= kinds[at[shared]] == SUMMIT
    away = places[shared] - places[at[shared]]
    if hm.periodic:
        away -= np.array(hm.shape) * np.round(away / hm.shape)
    shared[shared] &= np.hypot(*away.T) < _SAME
    kinds[shared] = 1 + at[shared]
    return ends_of(np.where(kinds > 0, kinds - 1, rank))
