"""Exact operator of the elliptic contact on polynomials (Galin).

On an ellipse with semi-axes ``a, b`` and scaled coordinates ``xi = x/a, eta = y/b`` a pressure
``(1 - rho**2)**((m-1)/2)`` times a polynomial displaces the half-space by a polynomial of the
same degree and parity. Everything is algebra and products with the Fourier moments of one weight
per axis ratio.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray
from scipy.special import eval_jacobi, gamma, roots_jacobi

__all__ = [
    "DEGREE",
    "edge_operator",
    "fourier_moments",
    "monomials",
    "parity_of",
    "pressure_operator",
    "product_weights",
    "punch_moments",
    "steeper_operator",
]

Array = NDArray[np.float64]

DEGREE = 6
"""Default degree of the profile polynomials."""


def monomials(degree: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Exponents ``i, j`` of x**i y**j up to a degree, ordered by degree and then by j."""
    pairs = [(k - j, j) for k in range(degree + 1) for j in range(k + 1)]
    i, j = np.array(pairs).T
    return i, j


def parity_of(degree: int) -> NDArray[np.int64]:
    """Class of each monomial: 0 even-even, 1 odd-odd, 2 odd in x, 3 odd in y."""
    i, j = monomials(degree)
    return np.choose((i % 2) + 2 * (j % 2), [0, 2, 3, 1])


def fourier_moments(weight: Array, count: int) -> Array:
    """Mean of ``weight * cos(2 k t)`` over the period pi of weights sampled on it, k < count."""
    return np.asarray(np.fft.rfft(weight, axis=-1).real[..., :count] / weight.shape[-1])


def product_weights(moments: Array, nodes: int, period: float) -> Array:
    """Weights of ``nodes`` equispaced points: exact for trigonometric polynomials times weight.

    ``moments[..., k]`` are the means of weight * cos(2 pi k t / period).
    """
    k = np.arange(moments.shape[-1])
    factor = np.where(k == 0, 1.0, 2.0)
    factor[2 * k == nodes] = 1.0
    keep = 2 * k <= nodes
    cosine = np.cos(2 * np.pi * np.outer(k, np.arange(nodes)) / nodes)
    return np.asarray(period / nodes * (moments * (factor * keep)) @ cosine)


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
    eigen = np.ones(degree + 1)
    for j in range(1, degree + 1):
        eigen[j] = eigen[j - 1] * (m + j - 1) / j
    eigen *= np.pi / math.cos(m * np.pi / 2)
    points = np.cos((np.arange(degree + 1) + 0.5) * np.pi / (degree + 1))
    to_powers = np.linalg.inv(np.vander(points, degree + 1, increasing=True))
    out = np.zeros((degree + 1, degree + 1))
    for order in range(degree + 1):
        norm = math.sqrt((w * eval_jacobi(order, exponent, exponent, s) ** 2).sum())
        coef = to_powers @ eval_jacobi(order, exponent, exponent, points) / norm
        values = polynomial.polyval(s, coef)
        for j in range(degree + 1):
            out[j] += eigen[order] * (w * s**j * values).sum() * coef
    return out


def _chord_transform_lower(degree: int, m: float, upper: Array) -> Array:
    """As `_chord_transform` with exponent (m-3)/2 (finite part): degree j gives degree j - 2."""
    out = np.zeros_like(upper)
    if degree >= 2:
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


def _edge_amplitudes(degree: int, operator: Array, nodes: Array) -> Array:
    """(ratio, monomial, node): edge amplitude that goes with a displacement monomial."""
    i, j = monomials(degree)
    parity = parity_of(degree)
    edge = np.cos(nodes) ** i[:, None] * np.sin(nodes) ** j[:, None]
    out = np.empty((operator.shape[0], i.size, nodes.size))
    for kind in range(4):
        rows = np.flatnonzero(parity == kind)
        block = operator[:, rows[:, None], rows]
        out[:, rows] = np.linalg.solve(
            block, np.broadcast_to(edge[rows], (len(block), *edge[rows].shape))
        )
    return out


def punch_moments(degree: int, m: float) -> Array:
    """Mean of xi**i eta**j over the ellipse under (1 - rho**2)**((m-1)/2)."""
    i, j = monomials(degree)
    even = (i % 2 == 0) & (j % 2 == 0)
    angular = gamma((i + 1) / 2) * gamma((j + 1) / 2) / (np.pi * gamma((i + j) / 2 + 1))
    p, q = (i + j) / 2 + 1, (m + 1) / 2
    return np.where(even, angular * gamma(p) * gamma(q) / gamma(p + q) * q, 0.0)


def edge_operator(m: float, ratio: Array, degree: int = DEGREE) -> Array:
    """Edge amplitudes of displacement monomials on ellipses of ``a b = 1`` of axis ratios (n,).

    Amplitude P(t) of ``p = P (1 - rho**2)**((m-1)/2)`` for unit modulus, shape
    (n, monomials, degree + 1), at t from 0 to pi/2; even or odd beyond by parity.
    """
    nodes = np.linspace(0, np.pi / 2, degree + 1)
    operator = _operator(degree, m, _chord_transform(degree, m), 0, ratio)
    return _edge_amplitudes(degree, operator, nodes)


def pressure_operator(m: float, ratio: float, degree: int = DEGREE) -> Array:
    """Pressure polynomial of each displacement monomial on the ellipse of ``a b = 1``.

    Row r holds the coefficients of the polynomial that ``(1 - rho**2)**((m-1)/2)`` multiplies,
    for unit modulus, shape (monomials, monomials).
    """
    operator = _operator(degree, m, _chord_transform(degree, m), 0, np.array([ratio]))[0]
    return np.asarray(np.linalg.inv(operator))


def steeper_operator(m: float, ratio: Array, degree: int) -> Array:
    """Displacement coefficients of the monomials times ``(1 - rho**2)**((m-3)/2)``, finite parts,
    on ellipses of ``a b = 1`` of axis ratios (n,), shape (n, monomials, monomials)."""
    transform = _chord_transform_lower(degree, m, _chord_transform(degree, m))
    return _operator(degree, m, transform, 2, ratio)
