"""One contact about its optimal ellipse: its contour, its pressure, and how far to trust it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from asperity.halfspace.material import HalfSpace
from asperity.microcontact.ellipse.ellipse_operator import monomials, pressure_operator

from .ellipse_expansion import DEGREE
from .ellipse_search import SHARP_TIP, Ellipse

__all__ = ["EllipseState"]

Array = NDArray[np.float64]

_DOUBTFUL = 0.5
"""Displacement of the contour, or ratio of the third- to the second-order force, beyond which the
expansion is flagged."""

_BEYOND, _FOURTH, _THIRD, _SECOND, _FAR, _OPERATOR = 1.5, 0.25, 0.15, 0.02, 0.6, 0.15
"""Factors of the expected error; `docs/development/laws.md` says how they were chosen and
judged."""

_CENTRE = 0.0035
"""Force error over what a fit leaves at the centre, `EllipseState.centre`: 0.0006 to 0.0033 on
round tips r^0.05 to r^64, m = -0.8 to 0.8."""

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
    ellipse
        Semi-axes a, b [m], the turn of a from the x axis [rad] and the centre [m].
    displacement
        Contour over the ellipse minus 1 at many equispaced parameters from 0, (n,).
    widest
        Largest displacement of the first-order contour.
    coefs
        Displacement of the surface over the monomials of the scaled coordinates [m].
    misfit, residue
        rms of what the polynomial, and of what the whole representation leave of f, over the
        approach.
    centre
        What the representation leaves at the centre, where f was not fitted, over the approach,
        times 1 + m.
    """

    force: float
    stiffness: float
    area: float
    parts: tuple[float, ...]
    ellipse: Ellipse
    displacement: Array
    widest: float
    coefs: Array
    misfit: float
    residue: float
    centre: float

    @property
    def expected_error(self) -> float:
        """Relative error of the force to be expected: the next order, and what the fit misses."""
        _, second, third, fourth, beyond = (abs(part / self.force) for part in self.parts)
        narrow = min(abs(np.log(self.ellipse.b / self.ellipse.a)), 1.0)
        series = _BEYOND * beyond + _FOURTH * fourth + _THIRD * third
        series += (_SECOND + _FAR * self.widest**2) * second
        missed = self.residue + _CENTRE * self.centre
        return float(series + _OPERATOR * narrow * self.misfit + missed)

    @property
    def sharp(self) -> bool:
        """Whether f has a tip or edges that no polynomial describes."""
        return self.misfit > SHARP_TIP

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
        a, b, turn, x, y = self.ellipse
        return replace(
            self,
            force=self.force * force,
            stiffness=self.stiffness * length ** (1 + m),
            area=self.area * length**2,
            parts=tuple(part * force for part in self.parts),
            ellipse=Ellipse(a * length, b * length, turn, x * length, y * length),
            coefs=self.coefs * ratio,
        )

    def boundary(self, phi: Array) -> Array:
        """Boundary a(phi) [m] about the summit."""
        t = 2 * np.pi * np.arange(self.displacement.size) / self.displacement.size
        grown = 1 + self.displacement
        r, place = self.ellipse.places(grown * np.cos(t), grown * np.sin(t))
        angle = np.unwrap(place)
        where = angle[0] + np.mod(phi - angle[0], 2 * np.pi)
        return np.asarray(np.interp(where, angle, r, period=2 * np.pi))

    def pressure(self, r: Array, phi: Array, material: HalfSpace) -> Array:
        """Pressure [Pa] at the points: that of the ellipse less its edge singularity, stretched.

        Along each ray of the ellipse ``(1 - rho^2)^((m-1)/2)`` times the pressure polynomial
        minus its value at the edge, with rho measured to the displaced contour.
        """
        m = material.m
        a, b = self.ellipse.a, self.ellipse.b
        xi, eta = self.ellipse.coordinates(r, phi)
        t = np.arctan2(eta, xi)
        turn = np.linspace(0, 2 * np.pi, self.displacement.size + 1)
        closed = np.append(self.displacement, self.displacement[0])
        displacement = CubicSpline(turn, closed, bc_type="periodic")
        rho = np.hypot(xi, eta) / (1 + displacement(np.mod(t, 2 * np.pi)))
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
