"""The displaced contour and its force, order by order, from the edge amplitudes on an ellipse.

With y = 1 - rho^2 and 1 + eta the square of the displaced contour, the true pressure is
``(y + eta)^(b+1)`` times a power series ``c_1 + c_2 (y + eta) + ...``, b = (m-1)/2. Expanded in
eta, its coefficient of ``y^(b+k)`` is ``A_k = sum_l C(b+k+l, l) eta^l c_(k+l)``; the whole must be
the pressure a_0 y^b + a_1 y^(b+1) + ... of d - f on the ellipse (a_0 = P) plus a field that leaves
no displacement, which its singular coefficients A_-1, A_-2, ... determine:

    A_0 = P   + R A_-1 + S A_-2 + ...         A_1 = a_1 + R' A_-1 + ...

R and R' take the value at the edge of the field of exponent b - 1 to its next two coefficients
(-n/2 and n (n-2)/8 on the circle, tables over the axis ratio for ellipses). Scaling such a field
gives another one, so that the fields of lower exponent follow from these:

    S = [(b+1) R' - R - b R R] / (b-1).

Scaling the field of d - f likewise gives ``a_1 = (Q + 2 b R P)/(2b+2)`` and so on. With the change
of the force, which a field of exponent b - 1 makes ``scale/(2 b) int w A_-1 dt``,

    F = F_ellipse + scale/(2 b) int w {A_-1 + b/(b-1) (1 - R) A_-2 + b/(b-2) (1 - R - S) A_-3} dt.

Solved for eta and c order by order: the force to the fourth, the contour to the third order.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import binom

from asperity.microcontact.ellipse.ellipse_operator import between, edge_slopes
from surfaces.arrays import Array

from .ellipse_expansion import ANGLES, Edge

__all__ = ["Expansion", "expand"]


_MODES = 12
"""Fourier modes of which R and R' are exact on the ellipse; the higher ones are local."""

_SERIES_END = 0.3
"""Ratio of the fourth- to the second-order part beyond which the series is not continued."""


@dataclass(frozen=True, eq=False)
class Expansion:
    """Expansion about one ellipse, in units of the modulus.

    Attributes
    ----------
    lower, second, third, fourth
        Force of the elliptic punch, and its parts of those orders.
    contour
        Parts of first, second and third order of eta at equispaced parameters t, shape
        (3, ANGLES): 1 + eta is the square of the displaced contour over the ellipse.
    """

    lower: float
    second: float
    third: float
    fourth: float
    contour: Array

    @property
    def beyond(self) -> float:
        """What continues the even parts geometrically, as long as they fall quickly."""
        if not 0 < self.fourth < self.second:
            return 0.0
        ratio = self.fourth / self.second
        return self.fourth * ratio / (1 - ratio) / (1 + (ratio / _SERIES_END) ** 4)

    @property
    def force(self) -> float:
        """Force, to fourth order and the estimate of the rest."""
        return self.lower + self.second + self.third + self.fourth + self.beyond

    @property
    def squared(self) -> Array:
        """1 + eta."""
        return np.asarray(1 + self.contour.sum(axis=0))


def expand(edge: Edge) -> Expansion:
    """Contour and force from the edge amplitudes of `d - f` on one ellipse."""
    b = (edge.m - 1) / 2
    level, bent, third = edge.slopes @ edge.weight / edge.weight.sum()
    uneven, unbent = edge.slopes[0] - level, edge.slopes[1] - bent
    fields = _EdgeFields(edge.m, edge.axes[1] / edge.axes[0])
    turned = fields(np.stack([edge.amplitude, uneven]))
    bend = fields(edge.amplitude, 1)

    # pressure of d - f: a_k = mean + first order
    a1 = level / (2 * b + 2), (uneven + 2 * b * turned[0]) / (2 * b + 2)
    a1_slope = bent / (2 * b + 2), (unbent - 2 * b * turned[1]) / (2 * b + 2)
    a2 = (
        (2 * a1[0] - a1_slope[0]) / (2 * b + 4),
        (2 * a1[1] - a1_slope[1] + 2 * b * bend) / (2 * b + 4),
    )
    a2_slope = (2 * a1_slope[0] - third / (2 * b + 2)) / (2 * b + 4)
    a3 = (4 * a2[0] - a2_slope) / (2 * b + 6)

    # orders of eta (e), of c_1 and c_2, and of the singular coefficients (s)
    e1 = edge.amplitude / ((b + 1) * a1[0])
    c1, c2 = a1[1] - (b + 2) * e1 * a2[0], a2[1] - (b + 3) * e1 * a3
    half, sixth = binom(b + 1, 2), binom(b + 2, 3)
    s2 = half * e1**2 * a1[0]
    by_s2, by_s2_bent = fields(s2), fields(s2, 1)
    e2 = by_s2 / (b + 1) - e1 * c1 - binom(b + 2, 2) / (b + 1) * e1**2 * a2[0]
    e2 = e2 / a1[0]
    c1_second = by_s2_bent - (b + 2) * (e2 * a2[0] + e1 * c2) - binom(b + 3, 2) * e1**2 * a3
    s3 = half * (2 * e1 * e2 * a1[0] + e1**2 * c1) + sixth * e1**3 * a2[0]
    low3 = binom(b + 1, 3) * e1**3 * a1[0]
    by_s3, by_low3 = fields(np.stack([s3, low3]))
    right = by_s3 + fields.lower(low3, by_low3, b)
    right -= binom(b + 2, 2) * (2 * e1 * e2 * a2[0] + e1**2 * c2)
    right -= binom(b + 3, 3) * e1**3 * a3
    e3 = (right / (b + 1) - e2 * c1 - e1 * c1_second) / a1[0]
    s4 = half * ((2 * e1 * e3 + e2**2) * a1[0] + 2 * e1 * e2 * c1 + e1**2 * c1_second)
    s4 += sixth * (3 * e1**2 * e2 * a2[0] + e1**3 * c2) + binom(b + 3, 4) * e1**4 * a3
    low4 = binom(b + 1, 3) * (3 * e1**2 * e2 * a1[0] + e1**3 * c1)
    low4 += binom(b + 2, 4) * e1**4 * a2[0]
    lowest = binom(b + 1, 4) * e1**4 * a1[0]
    by_low4, by_lowest = fields(np.stack([low4, lowest]))
    inner = s4 + b / (b - 1) * (low4 - by_low4)
    inner += b / (b - 2) * (lowest - by_lowest - fields.lower(lowest, by_lowest, b))
    work = np.stack([s2, s3 + b / (b - 1) * (low3 - by_low3), inner]) @ edge.weight
    second, third, fourth = (edge.scale / (2 * b) * work).tolist()
    return Expansion(edge.lower, second, third, fourth, np.stack([e1, e2, e3]))


class _EdgeFields:
    """The operators R, R' of one axis ratio on functions of t, shape (..., ANGLES)."""

    def __init__(self, m: float, ratio: float) -> None:
        self._matrices = between(_rows(m), np.log(ratio)).reshape(2, 2, _MODES + 1, _MODES + 1)
        self._width = np.sqrt(ratio * _SQUARES[0] + _SQUARES[1] / ratio)

    def __call__(self, values: Array, which: int = 0) -> Array:
        """R (0) or R' (1) of the values."""
        waves = np.fft.rfft(values)
        low = waves[..., : _MODES + 1]
        cosine, sine = self._matrices[which]
        out = np.zeros_like(waves)
        out[..., : _MODES + 1] = low.real @ cosine.T + 1j * (low.imag @ sine.T)
        waves[..., : _MODES + 1] = 0
        local = self._local(np.fft.irfft(waves, ANGLES))
        if which == 1:
            local = 0.5 * (self._local(local) + local)
        return np.asarray(np.fft.irfft(out, ANGLES) + local)

    def lower(self, values: Array, turned: Array, b: float) -> Array:
        """S of the values, of which `turned` is R."""
        return ((b + 1) * self(values, 1) - turned - b * self(turned)) / (b - 1)

    def _local(self, values: Array) -> Array:
        """R of short waves: half the wave number along the edge."""
        waves = np.fft.rfft(values / self._width) * _HALF_ORDER
        return np.asarray(np.fft.irfft(waves, ANGLES) / self._width)


@lru_cache(maxsize=8)
def _rows(m: float) -> Array:
    """Matrices of R and R' per axis ratio, flattened; a mode is two entries of the transform, the
    mean is one."""
    rows = edge_slopes(m, _MODES)
    rows[..., 0, :] *= 2
    return rows.reshape(len(rows), -1)


_T = 2 * np.pi * np.arange(ANGLES) / ANGLES
_SQUARES = np.cos(_T) ** 2, np.sin(_T) ** 2
_HALF_ORDER = -0.5 * np.arange(ANGLES // 2 + 1)
