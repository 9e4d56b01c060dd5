"""Exact operator of the elliptic contact on polynomials (Galin), and its tables over axis ratios.

On an ellipse with semi-axes ``a, b`` and scaled coordinates ``xi = x/a, eta = y/b`` a pressure
``(1 - rho**2)**((m-1)/2)`` times a polynomial displaces the half-space by a polynomial of the
same degree and parity. Everything is algebra and products with the Fourier moments of one weight
per axis ratio. Per monomial of the displacement the tables hold the amplitude of the edge
singularity at nodes on a quarter of the ellipse, and the second-order effect of a displaced
contour. A table takes a fraction of a second.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.polynomial import polynomial
from scipy.special import eval_jacobi, factorial, gamma, poch, roots_jacobi

from asperity.halfspace.transforms import lagrange
from surfaces.arrays import Array, Index

__all__ = [
    "DEGREE",
    "LOG_RATIO",
    "between",
    "edge_operator",
    "edge_slopes",
    "ellipse_tables",
    "fourier_moments",
    "monomials",
    "parity_of",
    "pressure_operator",
    "product_weights",
]


DEGREE = 6
"""Default degree of the profile polynomials."""

LOG_RATIO = (math.log(1 / 80), math.log(2.5), 64)
"""First and last ln(b/a) of the tables and the number of nodes."""


def monomials(degree: int) -> tuple[Index, Index]:
    """Exponents ``i, j`` of x**i y**j up to a degree, ordered by degree and then by j."""
    pairs = [(k - j, j) for k in range(degree + 1) for j in range(k + 1)]
    i, j = np.array(pairs).T
    return i, j


def parity_of(degree: int) -> Index:
    """Class of each monomial: 0 even-even, 1 odd-odd, 2 odd in x, 3 odd in y."""
    i, j = monomials(degree)
    return np.choose((i % 2) + 2 * (j % 2), [0, 2, 3, 1])


def fourier_moments(weight: Array, count: int) -> Array:
    """Mean of ``weight * cos(2 k t)`` over the period pi of weights sampled on it, k < count."""
    return np.asarray(np.fft.rfft(weight, axis=-1).real[..., :count] / weight.shape[-1])


def product_weights(moments: Array, nodes: int, period: float) -> Array:
    """Weights of an even number of equispaced points: exact for trigonometric polynomials times
    weight.

    ``moments[..., k]`` are the means of weight * cos(2 pi k t / period).
    """
    return np.asarray(period * np.fft.irfft(moments, nodes))


def _rotations(degree: int, psi: Array) -> Array:
    """Matrices (psi, n, n): coefficients of monomials of (x, y) in those of (u, v).

    ``x = u cos - v sin``, ``y = u sin + v cos``.
    """
    i, j = monomials(degree)
    n = i.size
    c, s = np.cos(psi), np.sin(psi)
    out = np.zeros((psi.size, n, n))
    index = {(int(p), int(q)): r for r, (p, q) in enumerate(zip(i, j, strict=True))}
    for r in range(n):
        for p in range(i[r] + 1):
            for q in range(j[r] + 1):
                # u**p (-v)**(i-p) from x**i, u**q v**(j-q) from y**j
                coef = math.comb(i[r], p) * math.comb(j[r], q) * (-1.0) ** (i[r] - p)
                power = p + q
                out[:, r, index[power, i[r] + j[r] - power]] += (
                    coef * c ** (p + j[r] - q) * s ** (i[r] - p + q)
                )
    return out


def _chord_transform(degree: int, m: float) -> Array:
    """Row j: polynomial in s0 of ``int |s-s0|**-m (1-s**2)**((m-1)/2) s**j ds``, |s0| < 1."""
    # scipy divides by (1 + m/2) - 1, which is zero where m is lost beside one
    exponent = (m - 1) / 2 if abs(m) > 1e-12 else -0.5
    s, w = roots_jacobi(degree + 2, exponent, exponent)
    order = np.arange(degree + 1)
    eigen = np.pi / math.cos(m * np.pi / 2) * poch(m, order) / factorial(order)
    points = np.cos((np.arange(degree + 1) + 0.5) * np.pi / (degree + 1))
    to_powers = np.linalg.inv(np.vander(points, degree + 1, increasing=True))
    values, coefs = (eval_jacobi(order, exponent, exponent, x[:, None]) for x in (s, points))
    shares = (w * s ** order[:, None]) @ values * (eigen / (w @ values**2))
    return np.asarray(shares @ (to_powers @ coefs).T)


def _chord_transform_lower(degree: int, m: float, upper: Array) -> Array:
    """As `_chord_transform` with exponent (m-3)/2 (finite part): degree j gives degree j - 2."""
    out = np.zeros_like(upper)
    out[2] = -upper[0]
    for j in range(2, degree):
        derivative = np.append(polynomial.polyder(upper[j]), 0.0)
        out[j + 1] = (j * out[j - 1] - derivative) / (j + m - 1)
    return out


def _on_chords(degree: int, transform: Array, drop: int) -> Array:
    """Matrix of u**a v**b -> displacement polynomial in (u, v); (1-v**2)**((a-l-drop)/2)."""
    i, j = monomials(degree)
    index = {(int(p), int(q)): r for r, (p, q) in enumerate(zip(i, j, strict=True))}
    out = np.zeros((i.size, i.size))
    for r in range(i.size):
        for power in range((i[r] - drop) % 2, i[r] - drop + 1, 2):
            half = (i[r] - drop - power) // 2
            for k in range(half + 1):
                column = index[power, int(j[r]) + 2 * k]
                out[r, column] += transform[i[r], power] * math.comb(half, k) * (-1.0) ** k
    return out


def _operator(degree: int, m: float, transform: Array, drop: int, ratio: Array) -> Array:
    """Displacement coefficients of pressure monomials on unit-area ellipses (ratio, n, n)."""
    count = 4 * (degree + 1)
    psi = np.arange(count) * np.pi / count
    forward = _rotations(degree, psi)
    backward = _rotations(degree, -psi)
    single = forward @ _on_chords(degree, transform, drop) @ backward
    ratio = ratio[:, None]
    fine = np.arange(8192) * np.pi / 8192
    weight = (np.cos(fine) ** 2 / ratio + ratio * np.sin(fine) ** 2) ** (-(1 + m) / 2)
    weights = product_weights(fourier_moments(weight, count // 2 + 1), count, np.pi)
    n = single.shape[1]
    return (weights @ single.reshape(count, -1)).reshape(-1, n, n) * (
        math.cos(m * np.pi / 2) / np.pi
    )


def _edge_monomials(degree: int, t: Array) -> Array:
    """Monomials at the parameters t of the edge, (monomials, t)."""
    i, j = monomials(degree)
    return np.asarray(np.cos(t) ** i[:, None] * np.sin(t) ** j[:, None])


def _punch_moments(degree: int, m: float) -> Array:
    """Mean of xi**i eta**j over the ellipse under (1 - rho**2)**((m-1)/2)."""
    i, j = monomials(degree)
    even = (i % 2 == 0) & (j % 2 == 0)
    angular = gamma((i + 1) / 2) * gamma((j + 1) / 2) / (np.pi * gamma((i + j) / 2 + 1))
    p, q = (i + j) / 2 + 1, (m + 1) / 2
    return np.where(even, angular * gamma(p) * gamma(q) / gamma(p + q) * q, 0.0)


def pressure_operator(m: float, ratio: Array, degree: int = DEGREE) -> Array:
    """Pressure polynomials of displacement monomials on ellipses of ``a b = 1``, of axis ratios
    (n,).

    Row r holds the coefficients of the polynomial that ``(1 - rho**2)**((m-1)/2)`` multiplies,
    for unit modulus, shape (n, monomials, monomials).
    """
    operator = _operator(degree, m, _chord_transform(degree, m), 0, ratio)
    return np.asarray(np.linalg.inv(operator))


def edge_operator(m: float, ratio: Array, degree: int = DEGREE) -> Array:
    """Edge amplitudes of displacement monomials: the pressure polynomials at the edge.

    Shape (n, monomials, degree + 1), at t from 0 to pi/2; even or odd beyond by parity.
    """
    nodes = np.linspace(0, np.pi / 2, degree + 1)
    return pressure_operator(m, ratio, degree) @ _edge_monomials(degree, nodes)


def _free_fields(
    m: float, ratio: Array, degree: int, count: int
) -> Iterator[tuple[int, Index, Array, list[Array]]]:
    """Fields ``P (1 - rho**2)**((m-3)/2)``, P a polynomial, that cause no displacement.

    Yields for each parity class: 0 for cosines or 1 for sines; the numbers k of the Fourier modes
    that P has at the edge; these modes at `count` equispaced parameters t, shape (t, k); the first
    and the second coefficient of P there in powers of ``1 - rho**2``, shape (ratio, t, k) each.
    """
    # displacement by the monomials times (1 - rho**2)**((m-3)/2), finite parts
    transform = _chord_transform_lower(degree, m, _chord_transform(degree, m))
    lower = _operator(degree, m, transform, 2, ratio)
    parity, order = parity_of(degree), np.sum(monomials(degree), axis=0)
    t = np.arange(count) * 2 * np.pi / count
    edge = _edge_monomials(degree, t)
    for kind, (form, first) in enumerate(((0, 0), (1, 2), (0, 1), (1, 1))):
        rows = np.flatnonzero(parity == kind)
        number = np.arange(first, degree + 1, 2)
        modes = (np.cos if form == 0 else np.sin)(np.outer(t, number))
        null = np.swapaxes(lower[:, rows[:, None], rows], 1, 2)
        null = null / np.abs(null).max()
        values = np.broadcast_to(edge[rows].T, (ratio.size, t.size, rows.size))
        system = np.concatenate([null, values], axis=1)
        right = np.concatenate([np.zeros((rows.size, number.size)), modes])
        solution = np.linalg.pinv(system, rcond=1e-12) @ right
        slopes = [
            np.einsum("rt,brk->btk", edge[rows] * factor[rows, None], solution)
            for factor in (-order / 2, order * (order - 2) / 8)
        ]
        yield form, number, modes, slopes


def _stiffness_forms(m: float, ratio: Array, degree: int, moments: Array) -> Array:
    """Upper triangles of the second-order form S of the stiffness, per ratio.

    A contour displaced by the Fourier modes x_i changes the stiffness in second order by
    sum S_ij x_i x_j. `moments` are the means of ``gamma**(m-1) cos(k t)`` over the edges.
    """
    count = 2 * (moments.shape[1] - 1)
    weight, bent = (
        product_weights(part, count, 2 * np.pi)
        for part in (moments, -moments * np.arange(moments.shape[1]) ** 2)
    )
    out = []
    for _, number, modes, (slope, _) in _free_fields(m, ratio, degree, count):
        form = np.einsum("bt,ti,btj->bij", weight, modes, 0.5 * m * modes + (m - 1) * slope)
        form = form + 0.25 * np.einsum("bt,ti,tj->bij", bent, modes, modes)
        form = 0.5 * (form + np.swapaxes(form, 1, 2))
        for p in range(number.size):
            for q in range(p, number.size):
                out.append(form[:, p, q] * (1.0 if p == q else 2.0))
    return np.array(out).T


def edge_slopes(m: float, degree: int) -> Array:
    """Operators R and R' of docs/development/laws.md in Fourier modes up to an even degree.

    A field ``P (1 - rho**2)**((m-3)/2)`` without displacement has the expansion P = P0 + P1 y + P2
    y^2 in ``y = 1 - rho**2`` at the edge. The matrices take the modes of P0 to those of P1 and of
    P2, for cosines and for sines; shape (ratios, 2, 2, degree + 1, degree + 1), with the index of
    the coefficient before that of cosine and sine. On the circle they are ``-k/2`` and
    ``k (k - 2)/8``.
    """
    ratio, count = np.exp(np.linspace(*LOG_RATIO)), 4 * (degree + 1)
    out = np.zeros((ratio.size, 2, 2, degree + 1, degree + 1))
    for form, number, modes, slopes in _free_fields(m, ratio, degree, count):
        norm = np.sum(modes * modes, axis=0)
        for which, inner in enumerate(slopes):
            out[:, which, form, number[:, None], number] = np.swapaxes(
                np.einsum("btk,tl->bkl", inner, modes) / norm, 1, 2
            )
    return out


@lru_cache(maxsize=8)
def ellipse_tables(m: float, degree: int = DEGREE) -> tuple[Array, Array]:
    """Tables of the elliptic contact for one grading exponent -1 < m < 1 and an even degree of the
    profile polynomials, at least 2; built once per process.

    Returns
    -------
    rows
        One row per ln(b/a): edge amplitudes (monomial, node) flattened, quadrature weights of
        ``gamma**(m-1)`` at the nodes, stiffness of the unit punch (s = 1, modulus 1), and the
        upper triangles of the second-order stiffness form of the four parity classes.
    moments
        Mean of each monomial under the flat-punch pressure of the ellipse.
    """
    quarter = degree + 1
    nodes = np.linspace(0, np.pi / 2, quarter)
    ratio = np.exp(np.linspace(*LOG_RATIO))
    fine = np.arange(8192) * np.pi / 8192
    squared = np.cos(fine) ** 2 * ratio[:, None] + np.sin(fine) ** 2 / ratio[:, None]
    moments = np.zeros((ratio.size, 4 * (degree + 2) + 1))
    moments[:, ::2] = fourier_moments(squared ** ((m - 1) / 2), 2 * (degree + 2) + 1)
    around = 4 * degree
    on_quarter = product_weights(moments[:, : around // 2 + 1], around, 2 * np.pi)[:, :quarter]
    on_quarter = on_quarter * np.where((nodes == 0) | (nodes == nodes[-1]), 2.0, 4.0)
    stiffness = 2 / ((1 + m) * moments[:, :1])
    forms = _stiffness_forms(m, ratio, degree, moments)
    edge = edge_operator(m, ratio, degree).reshape(ratio.size, -1)
    rows = np.concatenate([edge, on_quarter, stiffness, forms], axis=1)
    return np.ascontiguousarray(rows), _punch_moments(degree, m)


def between(rows: Array, position: float) -> Array:
    """Row of a table at ln(b/a) = `position`, by cubic interpolation (Lagrange, four rows)."""
    first, last, count = LOG_RATIO
    place = min(max((position - first) / (last - first) * (count - 1), 0.0), count - 1.0)
    i = min(max(int(place), 1), count - 3)
    return np.asarray(lagrange(np.arange(-1, 3), place - i)[0] @ rows[i - 1 : i + 3])
