"""Fourth-order expansion of one contact about an ellipse, for every profile and every grading.

On an ellipse ``rho < 1`` the displacement d - f leaves the edge amplitude P(t) of the pressure
``(1 - rho^2)^((m-1)/2)``; Q, Q2, Q3 are minus its derivatives with the logarithm of the size
(of alternating sign: f is multiplied by its degree). P is small on an ellipse near the contact, and
so is what deviates in Q, Q2 from their means over t: both count as first order.
`ellipse_series` holds the expansion itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.transforms import kappa
from asperity.microcontact.ellipse.ellipse_operator import (
    between,
    ellipse_tables,
    fourier_moments,
    monomials,
    product_weights,
)
from surfaces.arrays import Array

__all__ = ["ANGLES", "DEGREE", "Edge", "Gap", "edge_of", "fit_points", "fitted"]

Complex = NDArray[np.complex128]

DEGREE = 8
"""Degree of the polynomial whose edge amplitude on the ellipse is exact."""

ANGLES = 192
"""Equispaced parameters t on an ellipse."""

_WAVES = ANGLES // 2 + 1
"""Harmonics that they tell apart."""

_FIT_RADII = 14
"""Radii at which f is fitted."""

_POWERS = np.arange(9)
"""Powers of rho for what the polynomial leaves."""

_SINGULAR_CUT = 1e-7
"""Relative singular value below which the radial fit takes no notice."""

_REGION = 1.08
"""Size of the ellipse on which f is fitted over that of the contact."""

_RHO = _REGION * np.sqrt((np.arange(_FIT_RADII) + 0.5) / _FIT_RADII)
"""These radii, over the semi-axes of the contact."""


@dataclass(frozen=True, eq=False)
class Gap:
    """f over an ellipse: a polynomial of the scaled coordinates, and powers of rho for the rest.

    Attributes
    ----------
    polynomial
        Coefficients over `monomials(DEGREE)` [m].
    rest
        Amplitudes of ``rho^k e^(i n t)`` [m], shape (n, k).
    misfit, residue
        Root mean square [m] of what the polynomial leaves, and of what both leave.
    """

    polynomial: Array
    rest: Complex
    misfit: float
    residue: float

    @property
    def centre(self) -> float:
        """f of the representation at the centre [m]."""
        return float(self.polynomial[0] + self.rest[0, 0].real)


@dataclass(frozen=True, eq=False)
class Edge:
    """What the displacement d - f leaves at the edge of one ellipse, in units of the modulus.

    Attributes
    ----------
    m, axes
        Exponent of the grading; semi-axes a, b [m].
    lower
        Force of the elliptic punch.
    scale
        Factor of ``int w P dt`` in the change of the force: ``pi P* s^(1+m)``.
    amplitude
        P [m] at equispaced parameters t.
    slopes
        Edge amplitudes of f times its degree to the power 1, 2, 3 [m], shape (3, ANGLES).
    weight
        Quadrature weights of ``w = gamma^(m-1)``.
    """

    m: float
    axes: tuple[float, float]
    lower: float
    scale: float
    amplitude: Array
    slopes: Array
    weight: Array

    @property
    def level(self) -> float:
        """Mean of Q [m]."""
        return float(self.weight @ self.slopes[0] / self.weight.sum())

    @property
    def shift(self) -> Array:
        """First-order displacement x = P/Q of the contour."""
        return self.amplitude / self.level


@lru_cache(maxsize=1)
def fit_points() -> tuple[Array, Array, Array, Array]:
    """Scaled places (xi, eta) of the samples, the monomials there, and their pseudo-inverse."""
    t = 2 * np.pi * np.arange(ANGLES) / ANGLES
    xi, eta = np.outer(_RHO, np.cos(t)).ravel(), np.outer(_RHO, np.sin(t)).ravel()
    i, j = monomials(DEGREE)
    matrix = xi[:, None] ** i * eta[:, None] ** j
    return xi, eta, matrix, _inverse(matrix, 1e-12)


@lru_cache(maxsize=1)
def _radial_fit() -> tuple[Array, Array, Array]:
    """Powers at the sampled radii; pseudo-inverses of all, and of all but the constant."""
    powers = _RHO[:, None] ** _POWERS
    bare = np.zeros((_POWERS.size, _FIT_RADII))
    bare[1:] = _inverse(powers[:, 1:], _SINGULAR_CUT)
    return powers, _inverse(powers, _SINGULAR_CUT), bare


def _inverse(matrix: Array, cut: float) -> Array:
    return np.asarray(np.linalg.pinv(matrix, rcond=cut), dtype=float)


def fitted(samples: Array) -> Gap:
    """Representation of the values of f at `fit_points`."""
    _, _, matrix, inverse = fit_points()
    polynomial = inverse @ samples
    left = (samples - matrix @ polynomial).reshape(_FIT_RADII, ANGLES)
    powers, whole, bare = _radial_fit()
    waves = np.fft.rfft(left, axis=1)
    rest = (bare @ waves).T
    rest[0] = whole @ waves[:, 0]
    missed = left - np.fft.irfft(powers @ rest.T, ANGLES, axis=1)
    rest[1:] *= 2
    return Gap(polynomial, rest / ANGLES, _rms(left), _rms(missed))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values * values)))


def edge_of(gap: Gap, approach: float, a: float, b: float, m: float) -> Edge:
    """Edge amplitudes on the ellipse of semi-axes `a`, `b` on which `gap` was fitted."""
    rows, moments = ellipse_tables(m, DEGREE)
    row = between(rows, np.log(b / a))
    quarter = DEGREE + 1
    i, j = monomials(DEGREE)
    count = i.size
    table = row[: count * quarter].reshape(count, quarter)
    unit, punch = float(table[0, 0]), float(row[count * quarter + quarter])
    full = table[:, _FOLD] * _SIGN_X ** i[:, None] * _SIGN_Y ** j[:, None]
    polynomial = (gap.polynomial * (i + j) ** _ORDERS[:, None]) @ full
    factor, punch_mean = _rest_factors(m)
    rest = (gap.rest * factor[: len(gap.rest)]) @ (_POWERS ** _ORDERS[:, None]).T
    rest[1:] /= 2
    waves = np.fft.rfft(polynomial) / _NODE.size
    edge = ANGLES * (np.fft.irfft(waves, ANGLES) + np.fft.irfft(rest.T, ANGLES))
    mean = gap.polynomial @ moments + gap.rest[0].real @ punch_mean
    size = np.sqrt(a * b)
    return Edge(
        m=m,
        axes=(a, b),
        lower=float(punch * size ** (1 + m) * (approach - mean)),
        scale=float(np.pi * size ** (1 + m) * unit),
        amplitude=unit * approach - edge[0],
        slopes=edge[1:],
        weight=_edge_weight(m, b / a),
    )


def _edge_weight(m: float, ratio: float) -> Array:
    """Weights at the parameters t, exact for trigonometric polynomials times gamma^(m-1)."""
    widths = (ratio * _FINE_COSINE + (1 - _FINE_COSINE) / ratio) ** ((m - 1) / 2)
    moments = np.zeros(_WAVES)
    moments[::2] = fourier_moments(widths, ANGLES // 4 + 1)
    return product_weights(moments, ANGLES, 2 * np.pi)


@lru_cache(maxsize=8)
def _rest_factors(m: float) -> tuple[Array, Array]:
    """Edge amplitude of ``rho^k e^(i n t)`` on the circle, shape (n, k), and mean of rho^k under
    the pressure of the flat punch."""
    order = np.arange(_WAVES)[:, None]
    return kappa(m, _POWERS + order) / np.pi, kappa(m, _POWERS) / (_POWERS + 1 + m) * (1 + m)


_NODE = np.arange(4 * DEGREE)
_FOLD = np.abs(np.mod(_NODE + DEGREE, 2 * DEGREE) - DEGREE)
_SIGN_X = np.where((_NODE > DEGREE) & (_NODE < 3 * DEGREE), -1.0, 1.0)
_SIGN_Y = np.where(_NODE > 2 * DEGREE, -1.0, 1.0)
_ORDERS = np.arange(4)
_FINE_COSINE = np.cos(np.pi * np.arange(2048) / 2048) ** 2
