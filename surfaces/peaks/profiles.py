"""Profiles of peaks: the gap f(r, phi) about each summit, on rays to the edge of the basin."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surfaces.arrays import Array, Index, Mask
from surfaces.numerics import parallel
from surfaces.numerics.compiled import compiled
from surfaces.numerics.splines import LANES, PAD
from surfaces.numerics.stored_array import mapped, most_together
from surfaces.polar import PolarProfile

from . import _rays
from .peaks import RIM, SUMMIT, SummitArrays

__all__ = ["PART", "Profiles", "SampledRays", "bearing_areas", "ray_aspect"]


_PER_RAY, _ANGLES = 48, 256  # radii on the shortest ray, and directions, of a single profile
_NARROWEST = np.sqrt(1.0 / 8.0)  # least aspect of the ellipse on which the rays are spread


# compression of a peak mirrored at the border: half a paraboloid pressed by boundary elements
# carries 0.77 of the load of a whole one, on 0.58 of the area
_FOLD = 1.7
PART = 1024  # peaks sampled together: their directions stay in the cache
_MOST_SAMPLES = 64 * LANES  # of a ray
_TINY = 1e-300


def ray_aspect(curvature: Array) -> Array:
    """Aspect (k2/k1)^(1/3) of the ellipses in whose parameter the rays are uniform, from principal
    curvatures k1 >= k2 [1/m], shape (..., 2)."""
    ratio = curvature[..., 1] / curvature[..., 0]
    return np.maximum(ratio ** (1.0 / 3.0), _NARROWEST)


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
        Whether the peak has a contact of its own, shape (n,). It is False where the interpolated
        surface rises from the summit pixel into the basin of another peak (the grid cuts a ridge
        into several peaks). Such a profile is a paraboloid that fills the basin down to its saddle.
    owner
        Peak into whose basin the surface rises, shape (n,), the peak itself where `valid`. The
        rays of the owner run through the basins that it owns.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> fit = surfaces.fit_profiles(hm, surfaces.segment(hm))
    >>> profile = fit.profile(0)
    >>> float(profile(0.0, 0.0))
    0.0
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
    pixels: Index
    border: Mask
    valid: Mask
    owner: Index

    def __len__(self) -> int:
        return int(self.x.size)

    def rows(self, index: Index) -> Profiles:
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

    def bearing_areas(self, depths: Array) -> Array:
        """Area [m^2] of each basin above the level `depths` [m] under its summit.

        Parameters
        ----------
        depths
            Depths, shape (n, levels), that do not fall along a row.

        Notes
        -----
        Along a ray sqrt(f) is linear between the nodes; no area lies beyond the end of a ray.
        """
        area = np.zeros(depths.shape)
        rays = self.q, self.t, self.edge, self.weight
        blocks = parallel.blocks(len(area), 64)
        parallel.run(lambda *rows: bearing_areas(rows, *rays, depths, area), blocks)
        return area

    def profile(self, i: int) -> PolarProfile:
        """Profile of one peak on `_ANGLES` equispaced directions, up to its longest ray.

        Between the rays f is a periodic cubic spline over the parameter of the ellipse of
        `ray_aspect`, at points of equal distance in units of that ellipse: there a paraboloid has
        only two harmonics. Beyond the end of a ray f continues with its last slope and the
        curvature 2 q. Radii and directions are dense enough to reproduce the nodes of all rays.
        """
        from scipy.interpolate import CubicSpline

        rays = self.phi.shape[1]
        aspect = float(ray_aspect(self.curvature[i]))
        node = 2 * np.pi * np.arange(rays) / rays
        phi = 2 * np.pi * np.arange(_ANGLES) / _ANGLES
        turn = phi - self.angle[i]
        at = np.arctan2(np.sin(turn), aspect * np.cos(turn)) % (2 * np.pi)
        unit = np.eye(rays)[np.arange(rays + 1) % rays]
        share = CubicSpline(np.append(node, 2 * np.pi), unit, bc_type="periodic")(at)
        r = _graded(self.edge[i].max(), self.edge[i].min())
        far = r[1:, None] / np.sqrt(_square(at, aspect))
        scaled = np.array(
            [self._along(i, p, far * np.sqrt(_square(node[p], aspect))) for p in range(rays)]
        )
        f = np.zeros((r.size, _ANGLES))
        f[1:] = np.maximum(np.einsum("kp,pjk->jk", share, scaled), 0.5 * scaled.min(axis=0))
        edge = np.interp(at, node, self.edge[i] * np.sqrt(_square(node, aspect)), period=2 * np.pi)
        edge /= np.sqrt(_square(at, aspect))
        return PolarProfile(r, phi, np.maximum.accumulate(f, axis=0), edge)

    def _along(self, i: int, p: int, r: Array) -> Array:
        """Gap at radii `r` of one ray, continued beyond its edge."""
        from scipy.interpolate import PchipInterpolator

        end, last = self.edge[i, p], self.q[i, p, -1]
        q = PchipInterpolator(self.t, self.q[i, p])
        slope = max(end * (float(q(1.0, 1)) + 2.0 * last), 0.0)
        over = np.maximum(r - end, 0.0)
        inside = q(np.minimum(r / end, 1.0)) * np.minimum(r, end) ** 2
        return np.asarray(inside + slope * over + last * over**2)


def _graded(longest: float, shortest: float) -> Array:
    """Radii from 0 to the longest ray, equispaced in the shortest one, then in equal ratios."""
    steps = int(np.ceil(_PER_RAY * np.log(longest / shortest)))
    inner = np.linspace(0.0, shortest, _PER_RAY + 1)
    return np.concatenate([inner, np.geomspace(shortest, longest, steps + 1)[1:]])


def _square(parameter: Array | float, aspect: float) -> Array:
    """Squared radius of the ellipse of semi-axes 1 and `aspect`."""
    return np.asarray(np.cos(parameter) ** 2 + (aspect * np.sin(parameter)) ** 2)


def _steps() -> Array:
    """Radii [pixels] of the samples of a ray: steps of half a pixel or a tenth of the radius."""
    radii = [0.0, 1.0]
    for _ in range(_MOST_SAMPLES - 1):
        radii.append(radii[-1] + max(0.5, 0.1 * radii[-1]))
    return np.array(radii)


_RADII = _steps()


class SampledRays:
    """Rays of the peaks `index` (k,), sampled part by part into the arrays `phi`, `weight`, `edge`
    and `q` of `Profiles`, one row for each of these peaks."""

    def __init__(self, summits: SummitArrays, index: Index, rays: int, nodes: int) -> None:
        self._summits, self._index = summits, index
        self.phi, self.weight, self.edge = (np.empty((index.size, rays)) for _ in range(3))
        self.q = np.empty((index.size, rays, nodes))
        self._shares = np.ones(-(-(nodes - 1) // LANES) * LANES)
        self._shares[: nodes - 1] = np.arange(1, nodes) / (nodes - 1.0)
        hm, width = summits.hm, summits.spline.shape[1]
        ny, nx = hm.shape
        period = (1.0 / ny, 1.0 / nx, np.inf) if hm.periodic else (0.0, 0.0, 1.0)
        self._cell = np.array([ny, nx, *period, width, (PAD - 2) * (width + 1)])
        parameter = 2.0 * np.pi * np.arange(rays) / rays
        self._cos, self._sin = np.cos(parameter), np.sin(parameter)

    def fill(self, slot: Index) -> None:
        """Fill the rows `slot`, of `PART` at most."""
        of, peak = self._summits, self._index[slot]
        along, across = self._directions(slot, of.curvature[peak], of.angle[peak])
        k1, k2 = of.curvature[peak].T[:, :, None]
        tip = 0.5 * (k2 * along * along + k1 * across * across)
        lost = of.kinds[peak] > 0
        if lost.any():  # the surface rises into another basin: a paraboloid that fills its own
            gone, own = slot[lost], ~lost
            area = of.pixels[peak[lost]] * np.prod(of.hm.spacing)
            self.edge[gone] = np.sqrt(area / np.pi)[:, None]
            self.q[gone] = tip[lost, :, None]
            slot, peak, tip = slot[own], peak[own], tip[own]
            along, across = along[own], across[own]
        way_y, way_x, pixel = self._ways(peak, along, across)
        limit = np.full_like(pixel, np.inf)
        if of.hm.periodic:  # half-way to the image of the summit
            for n, way in zip(of.hm.shape, (way_y, way_x), strict=True):
                np.minimum(limit, 0.5 * n / np.maximum(np.abs(way), _TINY), out=limit)
        y, x = of.places[peak].T
        if of.hm.periodic:
            y, x = y % of.hm.shape[0], x % of.hm.shape[1]
        tilt = of.tilt[peak]
        fall = tilt[:, :1] * way_y + tilt[:, 1:] * way_x
        given = (
            of.spline.ravel(), self._cell, mapped(of.peaks.labels).ravel(), of.owner,
            of.dip[peak], peak, y.copy(), x.copy(), of.height[peak], way_y, way_x, fall,
            pixel, limit, _RADII, self._shares, tip, slot, self.edge, self.q,
        )  # fmt: skip
        # only this call is long enough for several threads
        size = self.phi.shape[1], self._shares.size
        parallel.run(
            lambda a, b: _rays.fit(*given, *_rays.scratch(*size), a, b),
            parallel.blocks(peak.size, 64, most_together(of.hm.source)),
        )
        blunt = slot[of.kinds[peak] != SUMMIT]
        self.q[blunt, :, 0] = self.q[blunt, :, 1]

    def _directions(self, slot: Index, curvature: Array, angle: Array) -> tuple[Array, Array]:
        """Cosine and sine of the rays in the principal axes of the peaks, shape (n, rays) each.

        The rays are equal steps in the parameter of the ellipse of semi-axes 1 and `ray_aspect`.
        Fills in the directions and their quadrature weights.
        """
        u, v = self._cos, ray_aspect(curvature)[:, None] * self._sin
        weight = 1.0 / (u * u + v * v)
        length = np.sqrt(weight)
        along, across = u * length, v * length
        half = (u.size + 1) // 2
        turn = np.zeros_like(weight)
        turn[:, 1:half] = np.arctan2(across[:, 1:half], along[:, 1:half])
        turn[:, u.size - half + 1 :] = -turn[:, half - 1 : 0 : -1]  # p and -p lie symmetric
        if u.size % 2 == 0:
            turn[:, half] = np.pi
        weight *= 2.0 * np.pi / weight.sum(axis=1)[:, None]
        self.phi[slot] = angle[:, None] + turn
        self.weight[slot] = weight
        return along, across

    def _ways(self, peak: Index, along: Array, across: Array) -> tuple[Array, Array, Array]:
        """Steps of the rays along y and x, the larger one a pixel, and their length [m]."""
        of = self._summits
        axis_x, axis_y = (turn(of.angle[peak])[:, None] for turn in (np.cos, np.sin))
        ways = [along * axis_y + across * axis_x, along * axis_x - across * axis_y]
        rim = np.flatnonzero(of.kinds[peak] == RIM)
        places = (of.peaks.row, of.peaks.col)
        for way, step, n, place in zip(ways, of.hm.spacing, of.hm.shape, places, strict=True):
            way /= step
            for border, inwards in ((0, _FOLD), (n - 1, -_FOLD)) if rim.size else ():
                at = rim[place[peak[rim]] == border]
                way[at] = inwards * np.abs(way[at])
        pixel = 1.0 / np.maximum(np.abs(ways[0]), np.abs(ways[1]))
        return ways[0] * pixel, ways[1] * pixel, pixel


@compiled()
def bearing_areas(
    rows: tuple[int, int],
    q: Array,
    t: Array,
    edge: Array,
    weight: Array,
    depths: Array,
    area: Array,
) -> None:
    """Add the areas above the flats at the ascending `depths` (n, levels) to `area`, for the rows
    rows[0] to rows[1] - 1.

    Each ray adds `weight` r^2 / 2, with the angle `weight` and the radius r at which f is the
    depth; sqrt(f) is linear between its nodes.
    """
    last = t.size - 1
    for i in range(rows[0], rows[1]):
        for k in range(edge.shape[1]):
            end, share = edge[i, k], 0.5 * weight[i, k]
            j, below, above = 0, 0.0, math.sqrt(max(q[i, k, 1], 0.0)) * t[1] * end
            for level in range(depths.shape[1]):
                root = math.sqrt(depths[i, level])
                while j < last and above < root:
                    j, below = j + 1, above
                    if j < last:
                        above = math.sqrt(max(q[i, k, j + 1], 0.0)) * t[j + 1] * end
                r = end
                if j < last:
                    r *= t[j] + (t[j + 1] - t[j]) * (root - below) / max(above - below, 1e-300)
                area[i, level] += share * r * r
