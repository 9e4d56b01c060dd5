"""Profiles of all peaks of a map: gap f(r, phi) about each summit, on rays to the basin edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import _rays, _spline, _threads
from .errors import InputError, SurfaceError
from .heightmap import HeightMap
from .peaks import Peaks
from .polar import PolarProfile

__all__ = ["Profiles", "fit_profiles"]

_SAME = 0.2  # two summits nearer than this [pixels] are one

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Profiles:
    """Profiles f(r, phi) of n peaks, one row of every array per peak.

    Parameters
    ----------
    x, y
        Sub-pixel summit [m], shape (n,).
    height
        Height of that summit [m], shape (n,).
    curvature
        Principal curvatures k1 >= k2 > 0 [1/m] of ``f ~ (k1 X^2 + k2 Y^2)/2``, shape (n, 2).
    angle
        Direction of the axis of k2, the long axis of the contact, counter-clockwise from +x [rad],
        in (-pi/2, pi/2], shape (n,).
    phi
        Directions of the rays [rad], shape (n, rays); the first is `angle`.
    weight
        Angular quadrature weights of the rays, shape (n, rays); their sum is 2 pi.
    edge
        Length of the rays [m], shape (n, rays).
    t
        Nodes on every ray, shape (nodes,), equispaced from 0 to 1.
    q
        f/r^2 [1/m] at ``r = t * edge``, shape (n, rays, nodes); at t = 0 half the curvature.
    pixels
        Pixels of the basin, shape (n,).
    border
        True where the basin touches the border of a map that is not periodic, shape (n,).
    valid
        Whether there is a summit, shape (n,). False where the interpolated surface rises from
        the summit pixel into the basin of another peak (the grid cuts a ridge into several
        peaks). Such a profile is a paraboloid that fills the basin down to its saddle; it stands
        for no contact of its own.
    owner
        Peak into whose basin the surface rises, shape (n,), the peak itself where `valid`. The
        rays of the owner run through the basins that it owns.
    """

    x: Array
    y: Array
    height: Array
    curvature: Array
    angle: Array
    phi: Array
    weight: Array
    edge: Array
    t: Array
    q: Array
    pixels: NDArray[np.int64]
    border: NDArray[np.bool_]
    valid: NDArray[np.bool_]
    owner: NDArray[np.int64]

    def __len__(self) -> int:
        return int(self.x.size)

    def rows(self, index: NDArray[np.int64]) -> Profiles:
        """The profiles of the peaks `index`; `owner` keeps the numbers of all peaks."""
        every = vars(self)
        return Profiles(**{k: v if k == "t" else v[index] for k, v in every.items()})

    def __repr__(self) -> str:
        return (
            f"<Profiles: {len(self)} peaks, {self.phi.shape[1]} rays, {self.t.size} nodes, "
            f"{int(self.valid.sum())} summits>"
        )

    def f(self) -> Array:
        """Gap f [m] at the nodes, shape (n, rays, nodes); it does not fall along a ray."""
        return self.q * (self.t * self.edge[:, :, None]) ** 2

    def profile(self, i: int, *, angles: int = 64) -> PolarProfile:
        """Profile of one peak on `angles` equispaced directions, up to its longest ray.

        Between the rays f is a periodic cubic spline in the parameter of the ellipse on which
        they are spread, at equal fractions of that ellipse, where a paraboloid has two harmonics
        only; the edge is a monotone cubic. Beyond the edge of a ray f goes on with its last q.
        """
        from scipy.interpolate import CubicSpline, PchipInterpolator

        rays = self.phi.shape[1]
        aspect = _rays.aspect_of(*self.curvature[i])
        phi = 2 * np.pi * np.arange(angles) / angles
        turn = phi - self.angle[i]
        at = np.arctan2(np.sin(turn), aspect * np.cos(turn)) % (2 * np.pi)
        node = 2 * np.pi * np.arange(-3, rays + 4) / rays
        wrapped = np.arange(-3, rays + 4) % rays
        edge = PchipInterpolator(node, self.edge[i, wrapped])(at)
        section = CubicSpline(
            node[3:-3], self.q[i, wrapped[3:-3]] * _square(node[3:-3], aspect), bc_type="periodic"
        )
        q = np.maximum(section(at) / _square(at, aspect), self.q[i].min(axis=0))
        r = edge.max() * self.t
        t = np.minimum(r[:, None] / edge, 1.0)
        f = np.empty((r.size, angles))
        for k in range(angles):
            f[:, k] = PchipInterpolator(self.t, q[k])(t[:, k]) * r**2
        return PolarProfile(r, phi, np.maximum.accumulate(f, axis=0))


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
    another: basins are not star-shaped, and rays cut at their edge cover only nine tenths of the
    map. A plateau, which has no curvature of its own, starts with the paraboloid that fills its
    basin. A peak that is highest at the border of a map that is not periodic is mirrored there
    and compressed by 1.7 across it: a whole contact that carries as much as the half there is.
    Unflooded pixels count to no basin, so that `segment(above=...)` changes hardly a ray
    above that height.
    """
    if rays < 4 or nodes < 4:
        raise InputError(f"rays is {rays} and nodes is {nodes}; give at least 4 of each")
    if peaks.labels.shape != hm.shape:
        raise SurfaceError(
            f"the peaks belong to a map of shape {peaks.labels.shape}, not {hm.shape}; "
            "segment this map first"
        )
    n = len(peaks)
    depth = peaks.prominence
    if not (depth > 0.0).all():  # the lowest peak of all has none; its basin is filled anyway
        relief = float(np.ptp(hm.heights))
        if relief == 0.0:
            raise SurfaceError("the map is constant; there is no summit to fit")
        depth = np.maximum(depth, 1e-6 * relief)
    spline = _spline.coefficients(hm.heights, hm.periodic)
    grid = (hm.heights, spline.ravel(), spline.shape[1], peaks.labels)
    places, expansions, kinds = np.empty((n, 2)), np.empty((n, 6)), np.empty(n, np.int64)
    parts = _threads.blocks(n, 64)
    _threads.run(
        lambda a, b: _rays.summits(
            *grid, hm.periodic, peaks.row, peaks.col, places, expansions, kinds, a, b
        ),
        parts,
    )
    owner = _owners(hm, peaks, places, kinds)
    counts = np.rint(peaks.basin_area / np.prod(hm.spacing)).astype(np.int64)
    pixels = np.bincount(owner, weights=counts, minlength=n).astype(np.int64)
    border = np.zeros(n, np.bool_)
    np.logical_or.at(border, owner, peaks.border)
    own = owner == np.arange(n)
    pixels[~own], border[~own] = counts[~own], peaks.border[~own]

    summit, curvature, angle = np.empty((n, 3)), np.empty((n, 2)), np.empty(n)
    phi, weight, edge = (np.empty((n, rays)) for _ in range(3))
    q = np.empty((n, rays, nodes))
    near = np.lexsort((peaks.col, peaks.row // 32))  # neighbors share the cache
    _threads.run(
        lambda a, b: _rays.fit(
            *grid, owner, hm.periodic, hm.spacing, near, peaks.row, peaks.col, depth,
            pixels, peaks.min_prominence, places, expansions, kinds, summit, curvature, angle, phi,
            weight, edge, q, a, b,
        ),
        parts,
    )  # fmt: skip
    return Profiles(
        x=summit[:, 0].copy(),
        y=summit[:, 1].copy(),
        height=summit[:, 2].copy(),
        curvature=curvature,
        angle=angle,
        phi=phi,
        weight=weight,
        edge=edge,
        t=np.linspace(0.0, 1.0, nodes),
        q=q,
        pixels=pixels,
        border=border,
        valid=own,
        owner=owner,
    )


def _square(parameter: Array, aspect: float) -> Array:
    """Squared radius of the ellipse of semi-axes 1 and `aspect`, as a column."""
    return np.asarray(np.cos(parameter) ** 2 + (aspect * np.sin(parameter)) ** 2)[:, None]


def _owners(
    hm: HeightMap, peaks: Peaks, places: Array, kinds: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Peak that stands for each peak; `kinds` is updated for those that share a summit."""
    n = len(peaks)
    rank = np.arange(n)
    pixel = np.rint(places).astype(np.int64)
    if hm.periodic:
        pixel %= hm.shape
    at = peaks.labels[pixel[:, 0], pixel[:, 1]] if n else rank
    shared = (kinds == _rays.SUMMIT) & (at >= 0) & (at != rank)
    shared[shared] &= kinds[at[shared]] == _rays.SUMMIT
    away = places[shared] - places[at[shared]]
    if hm.periodic:
        away -= np.array(hm.shape) * np.round(away / hm.shape)
    shared[shared] &= np.hypot(*away.T) < _SAME
    kinds[shared] = 1 + at[shared]
    owner = np.where(kinds > 0, kinds - 1, rank)
    for _ in range(n):
        further = owner[owner]
        if np.array_equal(further, owner):
            return owner
        owner = further
    return owner
