"""Radial transforms of the half-space, homogeneous and graded at once (homogeneous is m = 0).

Every radial integral of the contact laws is one operator (docs/development/laws.md). For the
angular harmonic f_n(r) e^(i n phi)

    e_n(a) = int_0^1 t^(n+1) [(n + 1 + m) f_n(at) + at f_n'(at)] w(t) dt,
    w(t) = (1 - t^2)^((m-1)/2),

is the strength of the edge singularity that f_n leaves on a circle of radius a; n = 0 gives the
approach D(a), and n = 2 put in for every harmonic gives the published contour. A power r^k has
the closed multiplier e_n = kappa_m(k + n) a^k, a sampled ray weights for its samples. Tables of the
contact laws are read by cubics through four neighboring nodes.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh_tridiagonal
from scipy.special import beta, betainc, betaincc, gammaln, roots_jacobi

from surfaces.arrays import Array, Index

__all__ = [
    "count_below",
    "edge_weights",
    "gauss_jacobi",
    "kappa",
    "lagrange",
    "moment_weights",
    "moments",
]


_LARGE_EXPONENT = 2000.0
"""Exponent above which differences of log-Gamma lose digits."""

MOMENT_RADII, EDGE_RADII = 13, 25
"""Radii of a ray, from 0 to 1 of its length, at which moments and edge operator are given."""

_OTHERS = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])


def kappa(m: float, k: ArrayLike) -> Array:
    """Multiplier kappa_m(k) = Gamma(k/2+1) Gamma((1+m)/2) / Gamma((k+m+1)/2).

    Parameters
    ----------
    m
        Exponent of the grading, -1 < m < 1.
    k
        Exponents of r (plus the harmonic n), non-negative, any shape.

    Returns
    -------
    kappa
        Dimensionless, shape of `k`; relative error below 1e-12 for every k.

    Notes
    -----
    Popov, Li and Willert (2023), equation 33 ff. Above k = 2000 the ratio of Gamma functions is
    taken from its asymptotic series, since differences of log-Gamma lose digits there.
    """
    exponent = np.asarray(k, dtype=float)
    delta = (1 - m) / 2
    small = np.minimum(exponent, _LARGE_EXPONENT)
    near = gammaln(small / 2 + 1) - gammaln((small + m + 1) / 2)
    middle = np.maximum(exponent, _LARGE_EXPONENT) / 2 + (1 + m) / 4
    far = delta * np.log(middle) + np.log1p(-delta * (delta * delta - 1) / (24 * middle**2))
    return np.asarray(
        np.exp(np.where(exponent < _LARGE_EXPONENT, near, far) + gammaln((1 + m) / 2))
    )


@lru_cache(maxsize=64)
def gauss_jacobi(m: float, points: int) -> tuple[Array, Array]:
    """Nodes t in (0, 1) and weights of int_0^1 h(t) (1 - t^2)^((m-1)/2) dt = sum w h(t).

    Notes
    -----
    Exact for polynomials of degree ``2 points - 1``: the recurrence of the orthogonal polynomials
    of this weight is found on a fine Gauss-Jacobi rule with (1 + t)^((m-1)/2) in its weights
    (Stieltjes), its Jacobi matrix gives nodes and weights (Golub and Welsch).
    """
    x, v = roots_jacobi(2 * points + 40, (m - 1) / 2, 0)
    fine = (1 + x) / 2
    v = v * 2 ** (-(m + 1) / 2) * (1 + fine) ** ((m - 1) / 2)
    diagonal, off = np.empty(points), np.empty(points)
    previous, current, norm = np.zeros_like(fine), np.ones_like(fine), np.sum(v)
    for k in range(points):
        diagonal[k] = np.sum(v * fine * current**2) / norm
        above = (fine - diagonal[k]) * current - (off[k - 1] if k else 0.0) * previous
        previous, current = current, above
        grown = np.sum(v * current**2)
        off[k], norm = grown / norm, grown
    t, vectors = eigh_tridiagonal(diagonal, np.sqrt(off[:-1]))
    w = np.sum(v) * vectors[0] ** 2
    t.setflags(write=False)
    w.setflags(write=False)
    return t, w


def moments(m: float, edges: Array, orders: Index) -> Array:
    """Exact moments int t^j (1 - t^2)^((m-1)/2) dt of the segments between `edges`.

    Parameters
    ----------
    m
        Exponent of the grading.
    edges
        Rising segment ends t in [0, 1], shape (..., s + 1).
    orders
        Exponents j >= 0, shape (p,).

    Returns
    -------
    moments
        Shape (..., s, p).

    Notes
    -----
    Incomplete Beta functions of x = t^2; the difference is taken from the side on which it does
    not cancel.
    """
    x = (edges * edges)[..., None]
    p, q = (np.asarray(orders, dtype=float) + 1) / 2, (m + 1) / 2
    low, high = betainc(p, q, x), betaincc(p, q, x)
    from_left = low[..., 1:, :] - low[..., :-1, :]
    from_right = high[..., :-1, :] - high[..., 1:, :]
    difference = np.where(x[..., :-1, :] < 0.5, from_left, from_right)
    return np.asarray(0.5 * beta(p, q) * difference)


@lru_cache(maxsize=8)
def moment_weights(m: float, nodes: int) -> Array:
    """Weights (`MOMENT_RADII`, nodes) of ``h(a) = int t**3 q(a t) (1-t*t)**((m-1)/2) dt``.

    ``a`` runs over equispaced fractions of the ray from 0 to 1, ``q`` over equispaced nodes with
    local cubics between them.
    """
    return _weights(m, nodes, 0, MOMENT_RADII)[0]


@lru_cache(maxsize=8)
def edge_weights(m: float, nodes: int, order: int) -> Array:
    """Weights (`EDGE_RADII`, nodes) of ``(order + 3 + m) h + a h'`` with h as in `moment_weights`,
    of the power t**(order + 3).

    Times ``a**2`` this is the edge operator of harmonic `order` of one ray
    (docs/development/laws.md).
    """
    value, slope = _weights(m, nodes, order, EDGE_RADII)
    return (order + 3 + m) * value + slope


def _weights(m: float, nodes: int, order: int, radii: int) -> tuple[Array, Array]:
    """Weights of h and of a h'."""
    t, w = gauss_jacobi(m, 24)
    value, slope = np.zeros((2, radii, nodes))
    weight = (w * t ** (order + 3))[:, None]
    for n, a in enumerate(np.linspace(0, 1, radii)):
        position = a * t * (nodes - 1)
        four = np.clip(position.astype(int), 1, nodes - 3)[:, None] + np.arange(-1, 3)
        share, change = lagrange(four, position)
        np.add.at(value[n], four, weight * share)
        np.add.at(slope[n], four, weight * change * position[:, None])
    return value, slope


def lagrange(nodes: ArrayLike, x: ArrayLike) -> tuple[Array, Array]:
    """Weights, shape (..., 4), of the values at four `nodes`, (..., 4), in the value and in the
    slope at `x`, (...), of the cubic through them.

    Examples
    --------
    >>> value, slope = lagrange([0.0, 1.0, 2.0, 3.0], 1.5)
    >>> (value * 16).tolist(), (slope * 24).tolist()
    ([-1.0, 9.0, 9.0, -1.0], [1.0, -27.0, 27.0, -1.0])
    """
    node, at = np.asarray(nodes, dtype=float), np.asarray(x, dtype=float)
    others = node[..., _OTHERS]
    a, b, c = np.moveaxis(at[..., None, None] - others, -1, 0)
    below = np.prod(node[..., None] - others, axis=-1)
    return a * b * c / below, (a * b + b * c + c * a) / below


def count_below(places: Array, at: Array) -> Index:
    """Number of the `places` of a row, (n, k), that are below each of `at`, (n, l), shape (n, l).

    Examples
    --------
    >>> count_below(np.array([[0.0, 1.0, 2.0]]), np.array([[0.5, 2.0]])).tolist()
    [[1, 2]]
    """
    return np.asarray(np.count_nonzero(places[:, :, None] < at[:, None], axis=1))
