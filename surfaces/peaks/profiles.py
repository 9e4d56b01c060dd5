"""Profiles of all peaks of a map: gap f(r, phi) about each summit, on rays to the basin edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surfaces.polar import PolarProfile

__all__ = ["Profiles", "ray_aspect"]

_PER_RAY, _ANGLES = 48, 256  # radii on the shortest ray, and directions, of a single profile
_NARROWEST = np.sqrt(1.0 / 8.0)  # least aspect of the ellipse on which the rays are spread

Array = NDArray[np.float64]


def ray_aspect(curvature: Array) -> Array:
    """Aspect of the ellipses on which the rays are spread: the root of that of the contact.

    Parameters
    ----------
    curvature
        Principal curvatures k1 >= k2 [1/m], shape (..., 2).
    """
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
        Whether there is a summit, shape (n,). False where the interpolated surface rises from
        the summit pixel into the basin of another peak (the grid cuts a ridge into several
        peaks). Such a profile is a paraboloid that fills the basin down to its saddle; it stands
        for no contact of its own.
    owner
        Peak into whose basin the surface rises, shape (n,), the peak itself where `valid`. The
        rays of the owner run through the basins that it owns.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine(
    ...     (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
    ... )
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

    def profile(self, i: int) -> PolarProfile:
        """Profile of one peak on `_ANGLES` equispaced directions, up to its longest ray.

        Between the rays f is a periodic cubic spline in the parameter of the ellipse on which
        they are spread, at equal distances in units of that ellipse, where a paraboloid has two
        harmonics only. Beyond the edge of a ray f goes on with its last slope and the curvature
        2 q. The radii and directions lie dense enough to return the nodes of all rays.
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
