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
        False where the summit could not be resolved (a plateau, a spike, fewer than nine pixels
        inside the edge), shape (n,). Such a profile is the paraboloid with the curvatures given.
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

    def __len__(self) -> int:
        return int(self.x.size)

    def __repr__(self) -> str:
        return (
            f"<Profiles: {len(self)} peaks, {self.phi.shape[1]} rays, {self.t.size} nodes, "
            f"{int(self.valid.sum())} resolved>"
        )

    def f(self) -> Array:
        """Gap f [m] at the nodes, shape (n, rays, nodes); it does not fall along a ray."""
        return self.q * (self.t * self.edge[:, :, None]) ** 2

    def profile(self, i: int, *, angles: int = 64) -> PolarProfile:
        """Profile of one peak on `angles` equispaced directions, up to its longest ray.

        Between the rays q and the edge are interpolated by a periodic monotone cubic; beyond the
        edge of a ray f goes on with its last q.
        """
        from scipy.interpolate import PchipInterpolator

        turn = np.unwrap(self.phi[i])
        turn = np.concatenate([turn[-3:] - 2 * np.pi, turn, turn[:3] + 2 * np.pi])
        table = np.column_stack([self.q[i], self.edge[i]])
        table = np.concatenate([table[-3:], table, table[:3]])
        phi = 2 * np.pi * np.arange(angles) / angles
        inside = turn[3] + np.mod(phi - turn[3], 2 * np.pi)
        at_phi = PchipInterpolator(turn, table)(inside)
        edge = at_phi[:, -1]
        r = edge.max() * self.t
        t = np.minimum(r[:, None] / edge, 1.0)
        f = np.empty((r.size, angles))
        for k in range(angles):
            q = PchipInterpolator(self.t, at_phi[k, :-1])(t[:, k])
            f[:, k] = np.maximum.accumulate(q * r**2)
        return PolarProfile(r, phi, f)


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
        If the peaks belong to a map of another shape.
    InputError
        If there are too few rays or nodes.

    Notes
    -----
    The map is interpolated by the quintic B-spline through all its points. The summit is the
    maximum of the spline. The rays are uniform in the parameter of an ellipse with the aspect
    ``(k2/k1) ** (1/3)`` (the square root of the aspect of the Hertz contact, at least 1/sqrt(8)),
    which keeps the angular quadrature accurate for elongated contacts. A ray ends at the first
    local maximum of f, or where it has left the basin of its peak for another.
    """
    if rays < 4 or nodes < 4:
        raise InputError(f"rays is {rays} and nodes is {nodes}; give at least 4 of each")
    if peaks.labels.shape != hm.shape:
        raise SurfaceError(
            f"the peaks belong to a map of shape {peaks.labels.shape}, not {hm.shape}; "
            "segment this map first"
        )
    n = len(peaks)
    pixels = np.rint(peaks.basin_area / np.prod(hm.spacing)).astype(np.int64)
    summits, curvature, angle = np.empty((n, 3)), np.empty((n, 2)), np.empty(n)
    phi, weight, edge = (np.empty((n, rays)) for _ in range(3))
    q, valid = np.empty((n, rays, nodes)), np.empty(n, np.bool_)
    spline = _spline.coefficients(hm.heights, hm.periodic)
    near = np.lexsort((peaks.col, peaks.row // 32))  # neighbors share the cache

    def fit(start: int, stop: int) -> None:
        _rays.fit(
            hm.heights, spline.ravel(), spline.shape[1], peaks.labels, hm.periodic, hm.spacing,
            near, peaks.row, peaks.col, peaks.prominence, pixels, peaks.min_prominence, summits,
            curvature, angle, phi, weight, edge, q, valid, start, stop,
        )  # fmt: skip

    _threads.run(fit, _threads.blocks(n, 64))
    return Profiles(
        x=summits[:, 0].copy(),
        y=summits[:, 1].copy(),
        height=summits[:, 2].copy(),
        curvature=curvature,
        angle=angle,
        phi=phi,
        weight=weight,
        edge=edge,
        t=np.linspace(0.0, 1.0, nodes),
        q=q,
        pixels=pixels,
        border=peaks.border.copy(),
        valid=valid,
    )
