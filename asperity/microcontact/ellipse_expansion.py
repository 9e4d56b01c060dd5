"""Third-order expansion of one contact about an ellipse, for every profile and every grading.

On an ellipse ``rho < 1`` the displacement d - f leaves the edge amplitude P(t) of the pressure
``(1 - rho^2)^((m-1)/2)``; Q and Q2 are minus its first and second derivatives with the logarithm of
the size. With y = 1 - rho^2 the true pressure is ``(y + eta)^((1+m)/2)`` times a power series in
y + eta, where 1 + eta is the square of the displaced contour. Expanded in eta it must be, order by
order, the pressure of d - f on the ellipse plus fields that leave no displacement: those of
exponent (m-3)/2 belong one to each Fourier mode, and R turns their values at the edge into the
amplitude (m-1)/2 that goes with them. With x = P/Q, w = gamma^(m-1), s the mean radius:

    eta = 2 x + (m-1) [R(P x) - 2 x R P]/Q + x^2 (2 - Q2/Q) - 2 x q/Q
    F   = F_ellipse + pi/2 P* s^(1+m) int w P x dt + F3
    F3  = pi P* s^(1+m) int w x { (m-1)/3 R(P x) - (m-1)/2 x R P + x^2/3 (Q - Q2/2) - x q/2
          + (m-1)/6 P (R x + x - x' gamma'/gamma) } dt

Here Q is the mean over t and q what deviates from it (on the ellipse of a paraboloid Q is
uniform), so that P and q are of first order.

On the circle R = -n/2 for the harmonic n, the second-order force is that of the harmonic-resolved
theory, and the area, pi a b <1 + eta>, is the one that it takes from dF/dd = stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from asperity.transforms import kappa

from .ellipse_tables import (
    LOG_RATIO,
    edge_slopes,
    ellipse_tables,
    fourier_moments,
    monomials,
    product_weights,
)

__all__ = ["ANGLES", "DEGREE", "Expansion", "Gap", "expand", "fit_points", "fitted"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

DEGREE = 8
"""Degree of the polynomial whose edge amplitude on the ellipse is exact."""

ANGLES = 192
_RADII = 14
_POWERS = np.arange(9)
_CUT = 1e-7
"""Relative singular value below which the radial fit takes no notice."""

_REGION = 1.08
"""Size of the ellipse on which f is fitted over that of the contact."""

_SERIES_END = 0.5
"""Largest ratio of the third- to the second-order part that is continued."""

_SLOPES = 12
"""Fourier modes of which R is exact on the ellipse; the higher ones are local."""


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


@dataclass(frozen=True, eq=False)
class Expansion:
    """Expansion about one ellipse, in units of the modulus.

    Attributes
    ----------
    lower, second, third
        Force of the elliptic punch, and its second- and third-order parts.
    stiffer
        What 1/(1 + q/Q) adds to the second-order part beyond 1 - q/Q where q is positive.
    level
        Q [m].
    shift
        First-order displacement x of the contour at equispaced parameters t.
    weight
        Quadrature weights of ``gamma^(m-1)``.
    squared
        1 + eta: square of the displaced contour over the ellipse.
    """

    lower: float
    second: float
    third: float
    stiffer: float
    level: float
    shift: Array
    weight: Array
    squared: Array

    @property
    def beyond(self) -> float:
        """Estimate of the part beyond the third order: `stiffer`, and half of what continues the
        series of the parts geometrically."""
        if not self.second > 0:
            return self.stiffer
        ratio = min(abs(self.third) / self.second, _SERIES_END)
        return self.stiffer + 0.5 * self.third * ratio / (1 - ratio)

    @property
    def force(self) -> float:
        """Force, to third order and the estimate of the rest."""
        return self.lower + self.second + self.third + self.beyond


@lru_cache(maxsize=4)
def fit_points(degree: int) -> tuple[Array, Array, Array, Array]:
    """Scaled places (xi, eta) of the samples, the monomials there, and their pseudo-inverse."""
    rho = _REGION * np.sqrt((np.arange(_RADII) + 0.5) / _RADII)
    t = 2 * np.pi * np.arange(ANGLES) / ANGLES
    xi: Array = (rho[:, None] * np.cos(t)).ravel()
    eta: Array = (rho[:, None] * np.sin(t)).ravel()
    i, j = monomials(degree)
    matrix = xi[:, None] ** i * eta[:, None] ** j
    return xi, eta, matrix, _inverse(matrix, 1e-12)


@lru_cache(maxsize=1)
def _radial_fit() -> tuple[Array, Array, Array]:
    """Powers at the sampled radii; pseudo-inverses of all, and of all but the constant."""
    rho = _REGION * np.sqrt((np.arange(_RADII) + 0.5) / _RADII)
    powers = rho[:, None] ** _POWERS
    bare = np.zeros((_POWERS.size, _RADII))
    bare[1:] = _inverse(powers[:, 1:], _CUT)
    return powers, _inverse(powers, _CUT), bare


def _inverse(matrix: Array, cut: float) -> Array:
    return np.asarray(np.linalg.pinv(matrix, rcond=cut), dtype=float)


def fitted(samples: Array) -> Gap:
    """Representation of the values of f at `fit_points(DEGREE)`."""
    _, _, matrix, inverse = fit_points(DEGREE)
    polynomial = inverse @ samples
    left = (samples - matrix @ polynomial).reshape(_RADII, ANGLES)
    powers, whole, bare = _radial_fit()
    waves = np.fft.rfft(left, axis=1)
    rest = (bare @ waves).T
    rest[0] = whole @ waves[:, 0]
    missed = left - np.fft.irfft(powers @ rest.T, ANGLES, axis=1)
    rest[1:] *= 2
    return Gap(polynomial, rest / ANGLES, _rms(left), _rms(missed))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values * values)))


def expand(gap: Gap, approach: float, a: float, b: float, m: float) -> Expansion:
    """Expansion about the ellipse of semi-axes `a`, `b` on which `gap` was fitted."""
    tables = ellipse_tables(m, DEGREE)
    row = _between(tables.rows, np.log(b / a))
    quarter = DEGREE + 1
    count = tables.order.size
    table = row[: count * quarter].reshape(count, quarter)
    unit, punch = float(table[0, 0]), float(row[count * quarter + quarter])
    i, j = monomials(DEGREE)
    k = tables.order
    mean = float(gap.polynomial @ tables.moments)
    full = table[:, _FOLD] * _SIGN_X ** i[:, None] * _SIGN_Y ** j[:, None]
    c = gap.polynomial
    poly = _resampled(np.stack([c, k * c, k * k * c]) @ full)
    order = np.arange(gap.rest.shape[0])[:, None]
    rest = gap.rest * kappa(m, _POWERS + order) / np.pi
    waves = np.stack([rest.sum(axis=1), rest @ _POWERS, rest @ _POWERS**2])
    waves[:, 1:] /= 2
    edge = poly + np.fft.irfft(waves * ANGLES, ANGLES, axis=1)
    mean += float((gap.rest[0].real * _punch_mean(m, _POWERS)).sum())
    amplitude, slope, bend = unit * approach - edge[0], edge[1], edge[2]

    size = np.sqrt(a * b)
    ratio = b / a
    fine = 2 * np.pi * np.arange(4096) / 4096
    widths = (ratio * np.cos(fine) ** 2 + np.sin(fine) ** 2 / ratio) ** ((m - 1) / 2)
    weight = product_weights(fourier_moments(widths, ANGLES // 2 + 1), ANGLES, 2 * np.pi)
    reach = _EdgeSlope(m, ratio)
    level = float(weight @ slope / weight.sum())
    uneven = slope - level
    x = amplitude / level
    turn = reach(np.stack([amplitude, amplitude * x, x]))
    scale = np.pi * size ** (1 + m) * unit
    curved = x - reach.bend * _derivative(x)
    cubic = (m - 1) * (turn[1] / 3 - x * turn[0] / 2) + x * x / 3 * (level - bend / 2)
    u = uneven / level
    cubic += (m - 1) / 6 * amplitude * (turn[2] + curved) - amplitude * u / 2
    stiffer = np.maximum(u, 0) ** 2 / (1 + np.maximum(u, 0))
    eta = 2 * x * (1 - u) + x * x * (2 - bend / level)
    eta += (m - 1) * (turn[1] - 2 * x * turn[0]) / level
    return Expansion(
        lower=punch * size ** (1 + m) * (approach - mean),
        second=float(scale / 2 * (weight @ (amplitude * x))),
        third=float(scale * (weight @ (x * cubic))),
        stiffer=float(scale / 2 * (weight @ (x * amplitude * stiffer))),
        level=level,
        shift=x,
        weight=weight,
        squared=1 + eta,
    )


class _EdgeSlope:
    """The operator R of one axis ratio on functions of t, shape (..., ANGLES)."""

    def __init__(self, m: float, ratio: float) -> None:
        rows = edge_slopes(m, _SLOPES)
        matrix = _between(rows.reshape(rows.shape[0], -1), np.log(ratio))
        self._matrix = matrix.reshape(2, _SLOPES + 1, _SLOPES + 1)
        self._matrix[:, 0] *= 2  # a mode is two entries of the transform, the mean is one
        t = 2 * np.pi * np.arange(ANGLES) / ANGLES
        width = ratio * np.cos(t) ** 2 + np.sin(t) ** 2 / ratio
        self._width = np.sqrt(width)
        self.bend = np.sin(2 * t) * (1 / ratio - ratio) / (2 * width)

    def __call__(self, values: Array) -> Array:
        waves = np.fft.rfft(values, axis=-1)
        low, high = waves[..., : _SLOPES + 1], waves.copy()
        high[..., : _SLOPES + 1] = 0
        cosine, sine = self._matrix
        out = np.zeros_like(waves)
        out[..., : _SLOPES + 1] = low.real @ cosine.T + 1j * (low.imag @ sine.T)
        local = np.fft.rfft(np.fft.irfft(high, ANGLES) / self._width)
        local *= -0.5 * np.arange(local.shape[-1])
        return np.asarray(np.fft.irfft(out, ANGLES) + np.fft.irfft(local, ANGLES) / self._width)


def _between(rows: Array, position: float) -> Array:
    """Row at a logarithm of the axis ratio, by local cubics."""
    first, last, count = LOG_RATIO
    place = min(max((position - first) / (last - first) * (count - 1), 1.0), count - 2.001)
    i = int(place)
    u = place - i
    share = np.array(
        [
            -u * (u - 1) * (u - 2) / 6,
            (u + 1) * (u - 1) * (u - 2) / 2,
            -(u + 1) * u * (u - 2) / 2,
            (u + 1) * u * (u - 1) / 6,
        ]
    )
    return np.asarray(share @ rows[i - 1 : i + 3])


def _punch_mean(m: float, k: NDArray[np.int64]) -> Array:
    """Mean of rho^k under the pressure of the flat punch."""
    return kappa(m, k) / (k + 1 + m) * (1 + m)


def _resampled(values: Array) -> Array:
    """Trigonometric polynomials given at 4 DEGREE equispaced points, at ANGLES of them."""
    waves = np.fft.rfft(values, axis=-1)
    waves[..., DEGREE + 1 :] = 0
    return np.asarray(np.fft.irfft(waves, ANGLES, axis=-1) * (ANGLES / values.shape[-1]))


def _derivative(values: Array) -> Array:
    waves = np.fft.rfft(values)
    return np.fft.irfft(1j * np.arange(waves.size) * waves, ANGLES)


_NODE = np.arange(4 * DEGREE)
_FOLD = np.abs(np.mod(_NODE + DEGREE, 2 * DEGREE) - DEGREE)
_SIGN_X = np.where((_NODE > DEGREE) & (_NODE < 3 * DEGREE), -1.0, 1.0)
_SIGN_Y = np.where(_NODE > 2 * DEGREE, -1.0, 1.0)
