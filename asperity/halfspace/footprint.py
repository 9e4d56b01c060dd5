"""Gaussian footprints of microcontacts on a homogeneous or graded half-space."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike
from scipy.special import gamma, hyp1f1

from surfaces.arrays import Array

__all__ = ["OUTSIDE_SHARE", "Footprints", "pair_table", "smooth_part", "smooth_polynomials"]

OUTSIDE_SHARE = 0.02
"""Share of a contact's own compliance that is kept outside its footprint (delta)."""

PAIR_NODES = 2048
SMOOTH_DEGREE = 12


@dataclass(frozen=True)
class Footprints:
    """How an increment of force is spread, and what two spread forces do to each other.

    Parameters
    ----------
    modulus
        Effective modulus E* or E_m* [Pa m^-m].
    m
        Exponent of the grading, -1 < m < 1.

    Notes
    -----
    With Lambda(q) = Lambda_1 q^(m-1) (docs/development/half_space.md), two Gaussians of variance v
    and v' per axis at distance r interact, with S^2 = v + v' and p = 1 + m, through

        g(r; S^2) = 1/(4 pi^2) int Lambda(q) exp(-q^2 S^2 / 2) exp(i q r) d^2q
                  = Lambda_1 Gamma(p/2) / (4 pi) (S^2/2)^(-p/2) 1F1(p/2; 1; -r^2 / (2 S^2)).

    One Gaussian acts on itself with S^2 = 2 v, so its self-compliance is
    s v^(-p/2), s = Lambda_1 Gamma(p/2) / (4 pi).

    **The rule that fixes the footprint.** A contact of tangent stiffness k is, to an increment, a
    flat punch of compliance 1/k. Its footprint gets that compliance but for a floor delta,

        s v^(-p/2) = 1 / ((1 + delta) k),   hence   v = ((1 + delta) s k)^(2/p).

    The tangent matrix diag(1/k) + (g_ij) off the diagonal is then W' S W + delta/(1+delta)
    diag(1/k): a Gram matrix of the positive semi-definite half-space operator S in the footprints
    W, plus a positive floor. It is positive definite for any set of contacts, at any overlap.
    Nothing is fitted: with k = 2 E_m* a^p / p of the round punch the second moment of the footprint
    comes out as 2 v = 0.637, 0.560, 0.695 a^2 for m = 0, 0.5, -0.3 against the punch's own
    2 a^2 / (3 + m) = 0.667, 0.571, 0.741 a^2 (delta = 0).
    """

    modulus: float
    m: float = 0.0

    @property
    def power(self) -> float:
        """Exponent p = 1 + m of the decay r^-p of a point force."""
        return 1.0 + self.m

    @property
    def point(self) -> float:
        """C_m [m^p / N]: a point force F displaces by C_m F / r^p."""
        return math.sin((1 - abs(self.m)) * math.pi / 2) / (math.pi * self.modulus)

    @property
    def symbol(self) -> float:
        """Lambda_1: the half-space answers a wave of pressure by Lambda_1 q^(m-1)."""
        return 2 ** (1 - self.m) * math.pi / (self.modulus * math.gamma(self.power / 2) ** 2)

    @property
    def self_factor(self) -> float:
        """s: a Gaussian of variance v displaces itself by s v^(-p/2) F."""
        return self.symbol * math.gamma(self.power / 2) / (4 * math.pi)

    @property
    def rule(self) -> tuple[float, float]:
        """Factor f and exponent q of the variance (f k)^q of a footprint."""
        return (1 + OUTSIDE_SHARE) * self.self_factor, 2 / self.power

    def variance(self, stiffness: ArrayLike) -> Array:
        """Variance per axis [m^2] of the footprint of a contact of tangent stiffness k [N/m]."""
        factor, exponent = self.rule
        return np.asarray((factor * np.asarray(stiffness, float)) ** exponent)

    def punch(self, radius: ArrayLike) -> Array:
        """Stiffness [N/m] of the flat round punch of a radius [m]."""
        p = self.power
        return np.asarray(2 * self.modulus * np.asarray(radius, float) ** p / p)

    def radius(self, stiffness: ArrayLike) -> Array:
        """Radius [m] of the flat round punch of a stiffness [N/m], the inverse of `punch`."""
        p = self.power
        return np.asarray((p * np.asarray(stiffness, float) / (2 * self.modulus)) ** (1 / p))


def _pair_shape(m: float, w: Array) -> tuple[Array, ...]:
    """H, K, J of w = S^2 / (r^2 + S^2): with R = r^2 + S^2, g = C_m H R^(-p/2),
    dg/dS^2 = C_m K R^(-p/2-1), dg/dr / r = C_m J R^(-p/2-1); 1, p^2/2 and -p for points."""
    a = (1 + m) / 2
    # s / C_m, from Gamma(p/2) Gamma(1 - p/2) = pi / cos(m pi / 2)
    scale = 2 ** (1 - m) * gamma(1 - a) / 4
    w = np.asarray(w, float)
    wide = np.maximum(w, 1e-300)
    z = (1 - w) / (2 * wide)
    grown = np.where(w > 0, scale * (wide / 2) ** (-a), 1.0)
    value = grown * hyp1f1(a, 1.0, -z)
    slope = -a * grown / wide * hyp1f1(a + 1, 1.0, -z)
    pull = -a * grown / wide * hyp1f1(a + 1, 2.0, -z)
    # expansion in w for points: the products above lose their meaning at w = 0
    small = w < 1e-8
    limits = (1.0, 2 * a * a, -2 * a)
    return tuple(
        np.where(small, limit, v) for limit, v in zip(limits, (value, slope, pull), strict=True)
    )


def pair_table(m: float) -> Array:
    """H, K and J at equispaced w = S^2 / (r^2 + S^2) in [0, 1], shape (nodes + 1, 3)."""
    return np.stack(_pair_shape(m, np.linspace(0.0, 1.0, PAIR_NODES + 1)), axis=1)


def smooth_polynomials(m: float, limit: float) -> Array:
    """Smooth part of the point kernel for x = (r/eta)^2 up to `limit`.

    Returns
    -------
    coefficients
        Polynomials in x - limit/2 for e = exp(-x)/Gamma(a) and for g_2, shape (2,
        `SMOOTH_DEGREE` + 1), lowest power first, within 2e-7 for `limit` = 4.

    Notes
    -----
    g_k is the k-th derivative of g_0 = x^(-a) P(a, x) by x, a = p/2 (`smooth_part`); the lower ones
    follow from it without loss: g_1 = -(x g_2 + e) / (a + 1), g_0 = (e - x g_1) / a.
    """
    a, count = (1 + m) / 2, 4 * SMOOTH_DEGREE
    t = np.cos(np.pi * (np.arange(count) + 0.5) / count)
    x = limit * (1 + t) / 2
    edge = np.exp(-x) / gamma(a)
    second = (edge - smooth_part(m, x)[4] / 8) / a
    fits = (chebyshev.cheb2poly(chebyshev.chebfit(t, f, SMOOTH_DEGREE)) for f in (edge, second))
    return np.stack(list(fits)) * (2 / limit) ** np.arange(SMOOTH_DEGREE + 1)


def smooth_part(m: float, x: Array) -> tuple[Array, ...]:
    """Smooth part of the point kernel at x = (r/eta)^2.

    Returns
    -------
    columns
        f, eta^2 Laplacian f, eta^4 Laplacian^2 f, and eta^2 f'/r, eta^4 (Laplacian f)'/r, in units
        of C_m eta^-p, each like x.

    Notes
    -----
    Ewald split of q^(m-1) = 1/Gamma((1-m)/2) int_0^inf t^(-(1+m)/2) exp(-q^2 t) dt at t = eta^2/4.
    The smooth part has the symbol Lambda(q) Q((1-m)/2, q^2 eta^2 / 4) and the shape
    f = C_m eta^-p g_0, g_0 = x^(-a) P(a, x), a = p/2, with the incomplete gamma functions P and
    Q = 1 - P. The derivatives of g_0 by x are g_k = (-1)^k 1F1(a+k; a+k+1; -x) / ((a+k) Gamma(a)).
    """
    a = (1 + m) / 2
    g0, g1, g2 = ((-1) ** k / ((a + k) * gamma(a)) * hyp1f1(a + k, a + k + 1, -x) for k in range(3))
    edge = np.exp(-x) / gamma(a)
    first, second = -4 * (a * g1 + edge), 16 * (a * (a + 1) * g2 + (1 - a - x) * edge)
    return g0, first, second, 2 * g1, -8 * (a * g2 - edge)
