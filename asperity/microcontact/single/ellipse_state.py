"""One contact about its optimal ellipse: its contour, its pressure, and how far to trust it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.material import HalfSpace
from asperity.microcontact.ellipse.ellipse_operator import monomials, pressure_operator

from .ellipse_expansion import DEGREE
from .ellipse_search import SHARP

__all__ = ["EllipseState"]

Array = NDArray[np.float64]

_ANGLES = 2880
"""Points of a contour from which its radius is read."""

_DOUBTFUL = 0.5
"""Displacement of the contour, or ratio of the third- to the second-order force, beyond which the
expansion is flagged."""

_BEYOND, _FOURTH, _THIRD, _SECOND, _FAR, _OPERATOR = 1.5, 0.25, 0.15, 0.02, 0.6, 0.15
"""Factors of the expected error; `docs/development/laws.md` says how they were chosen and
judged."""

_RESIDUE = 0.005
"""rms error of the representation of f over the approach beyond which it is flagged."""


@dataclass(frozen=True, eq=False)
class EllipseState:
    """One contact about its optimal ellipse.

    Attributes
    ----------
    force, stiffness, area
        F [N], dF/dd [N/m], contact area [m^2].
    parts
        Force of the elliptic punch alone, its parts of second, third and fourth order, and the
        estimate of the rest [N].
    axes
        Semi-axes a, b [m] and the turn of a from the x axis [rad].
    centre
        Centre of the ellipse [m].
    displacement
        Contour over the ellipse minus 1 at equispaced parameters of the ellipse from 0, (n,).
    widest
        Largest displacement of the first-order contour.
    coefs
        Displacement of the surface over the monomials of the scaled coordinates [m].
    misfit, residue
        rms of what the polynomial, and of what the whole representation leave of f, over the
        approach.
    """

    force: float
    stiffness: float
    area: float
    parts: tuple[float, ...]
    axes: tuple[float, float, float]
    centre: tuple[float, float]
    displacement: Array
    widest: float
    coefs: Array
    misfit: float
    residue: float

    @property
    def expected_error(self) -> float:
        """Relative error of the force to be expected: the next order, and what the fit misses."""
        _, second, third, fourth, beyond = (abs(part / self.force) for part in self.parts)
        narrow = min(abs(np.log(self.axes[1] / self.axes[0])), 1.0)
        series = _BEYOND * beyond + _FOURTH * fourth + _THIRD * third
        series += (_SECOND + _FAR * self.widest**2) * second
        return float(series + _OPERATOR * narrow * self.misfit + self.residue)

    @property
    def sharp(self) -> bool:
        """Whether f has a tip or edges that no polynomial describes."""
        return self.misfit > SHARP

    @property
    def doubtful(self) -> bool:
        """Whether the expansion has been carried too far, or f is not represented."""
        _, second, third, fourth, _ = self.parts
        far = (
            self.widest > _DOUBTFUL
            or abs(third + fourth) > _DOUBTFUL * abs(second) + 1e-3 * self.force
        )
        return far or self.residue > _RESIDUE

    def scaled(self, ratio: float, k: float, m: float) -> EllipseState:
        """The similar contact of a body r^k psi(phi) at `ratio` times the approach."""
        length = ratio ** (1 / k)
        force = ratio * length ** (1 + m)
        a, b, turn = self.axes
        return replace(
            self,
            force=self.force * force,
            stiffness=self.stiffness * length ** (1 + m),
            area=self.area * length**2,
            parts=tuple(part * force for part in self.parts),
            axes=(a * length, b * length, turn),
            centre=(self.centre[0] * length, self.centre[1] * length),
            coefs=self.coefs * ratio,
        )

    def boundary(self, phi: Array) -> Array:
        """Boundary a(phi) [m] about the summit."""
        a, b, turn = self.axes
        count = _ANGLES
        t = 2 * np.pi * np.arange(count) / count
        spectrum = np.fft.rfft(self.displacement) * (count / self.displacement.size)
        spectrum[-1] /= 2
        grown = 1 + np.fft.irfft(spectrum, count)
        x, y = a * np.cos(t) * grown, b * np.sin(t) * grown
        c, s = np.cos(turn), np.sin(turn)
        x, y = self.centre[0] + c * x - s * y, self.centre[1] + s * x + c * y
        angle, r = np.unwrap(np.arctan2(y, x)), np.hypot(x, y)
        where = angle[0] + np.mod(phi - angle[0], 2 * np.pi)
        return np.asarray(np.interp(where, angle, r, period=2 * np.pi))

    def pressure(self, r: Array, phi: Array, material: HalfSpace) -> Array:
        """Pressure [Pa] at the points: that of the ellipse less its edge singularity, stretched.

        Along each ray of the ellipse ``(1 - rho^2)^((m-1)/2)`` times the pressure polynomial
        minus its value at the edge, with rho measured to the displaced contour.
        """
        m = material.m
        a, b, turn = self.axes
        x, y = r * np.cos(phi) - self.centre[0], r * np.sin(phi) - self.centre[1]
        c, s = np.cos(turn), np.sin(turn)
        xi, eta = (c * x + s * y) / a, (c * y - s * x) / b
        t = np.arctan2(eta, xi)
        rho = np.hypot(xi, eta) / (1 + self._displacement(t))
        inside = rho < 1
        rho = np.where(inside, rho, 0.0)
        i, j = monomials(DEGREE)
        # the table is for semi-axes of unit product: lengths in units of sqrt(ab)
        size = np.sqrt(a * b)
        operator = pressure_operator(m, b / a, DEGREE)
        weights = material.modulus * size ** (m - 1) * (self.coefs @ operator)
        edge = np.cos(t) ** i[:, None] * np.sin(t) ** j[:, None]
        inner = edge * rho ** (i + j)[:, None]
        body = weights @ (inner - edge)
        return np.where(inside, body * (1 - rho**2) ** ((m - 1) / 2), 0.0)

    def _displacement(self, t: Array) -> Array:
        amplitudes = np.fft.rfft(self.displacement) / self.displacement.size
        order = np.arange(amplitudes.size)
        twice = np.where((order == 0) | (2 * order == self.displacement.size), 1.0, 2.0)
        waves = np.exp(1j * np.multiply.outer(t, order))
        return np.asarray((waves @ (twice * amplitudes)).real)
