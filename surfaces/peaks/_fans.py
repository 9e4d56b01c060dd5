"""Rays of many peaks: their directions, and the kernel that fills them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics import parallel
from surfaces.numerics.spline_expansion import LANES
from surfaces.numerics.splines import PAD

from . import _rays
from .profiles import ray_aspect
from .summit_arrays import RIM, SUMMIT, SummitArrays

__all__ = ["PART", "Fans"]

_FOLD = 1.7  # half a paraboloid at the border carries 0.77 of the load, on 0.58 of the area (BEM)
PART = 1024  # peaks whose directions stay in the cache
_MOST_SAMPLES = 64 * LANES  # of a ray
_TINY = 1e-300

Array = NDArray[np.float64]
Rows = NDArray[np.int64]


def _steps() -> Array:
    """Radii [pixels] at which the rays are looked at: steps of half a pixel that grow with it."""
    radii = [0.0, 1.0]
    for _ in range(_MOST_SAMPLES - 1):
        radii.append(radii[-1] + max(0.5, 0.1 * radii[-1]))
    return np.array(radii)


_RADII = _steps()


class Fans:
    """The rays of some peaks, to be filled part by part.

    Parameters
    ----------
    summits
        Summits of all peaks of the map.
    index
        Rows of the peaks, shape (k,).
    rays, nodes
        Rays per peak, nodes per ray.

    Attributes
    ----------
    phi, weight, edge, q
        As in `Profiles`, one row per element of `index`.
    """

    def __init__(self, summits: SummitArrays, index: Rows, rays: int, nodes: int) -> None:
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

    def fill(self, slots: Rows) -> None:
        """Fill the rows `slots`."""
        for start in range(0, slots.size, PART):
            self._fill(slots[start : start + PART])

    def _fill(self, slot: Rows) -> None:
        of, peak = self._summits, self._index[slot]
        along, across = self._directions(slot, of.curvature[peak], of.angle[peak])
        k1, k2 = of.curvature[peak].T[:, :, None]
        tip = 0.5 * (k2 * along * along + k1 * across * across)
        lost = of.kinds[peak] > 0
        if lost.any():  # in the basin of another peak: the paraboloid that fills its own
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
            of.spline.ravel(), self._cell, of.peaks.labels.ravel(), of.owner,
            of.dip[peak], peak, y.copy(), x.copy(), of.height[peak], way_y, way_x, fall,
            pixel, limit, _RADII, self._shares, tip, slot, self.edge, self.q,
        )  # fmt: skip
        # the calls before are too short for several threads, which would wait for each other
        size = self.phi.shape[1], self._shares.size
        parallel.run(
            lambda a, b: _rays.fit(*given, *_rays.scratch(*size), a, b),
            parallel.blocks(peak.size, 64),
        )
        blunt = slot[of.kinds[peak] != SUMMIT]
        self.q[blunt, :, 0] = self.q[blunt, :, 1]

    def _directions(self, slot: Rows, curvature: Array, angle: Array) -> tuple[Array, Array]:
        """Cosine and sine of the directions in the frames of the peaks, shape (n, rays) each.

        Equal steps of the parameter of the ellipse of semi-axes 1 and `ray_aspect`.
        The directions and their quadrature weights are filled in.
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

    def _ways(self, peak: Rows, along: Array, across: Array) -> tuple[Array, Array, Array]:
        """Steps of one pixel over y and x, and their length [m]."""
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
