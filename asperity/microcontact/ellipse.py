"""Law "ellipse": expansion about the optimal ellipse, of one profile or of a batch."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from asperity.indentation import Indentation
from asperity.material import HalfSpace
from surfaces.polar import PolarProfile, PowerLawProfile, PowerSumProfile

from .basis import basis_of
from .branch import RisingBranch
from .ellipse_batch import NODES, tabulate
from .ellipse_expansion import DEGREE
from .ellipse_search import SHARP, Search, Solved
from .flags import Flag
from .galin import monomials, pressure_operator
from .validity import profile_flags

__all__ = ["NODES", "EllipseState", "indent", "solve_ellipse", "tabulate"]

Array = NDArray[np.float64]

_ANGLES = 720
_DOUBTFUL = 0.5
"""Displacement of the contour, or ratio of the third- to the second-order force, beyond which the
expansion is flagged."""

_BEYOND, _FOURTH, _THIRD, _SECOND, _FAR, _OPERATOR = 1.5, 0.25, 0.15, 0.02, 0.6, 0.15
"""Factors of the expected error; `docs/laws.md` says how they were chosen and judged."""

_LAST = 0.5
"""Share of the last order of the contour that is taken: its orders alternate, and half of the last
stands for it and those that follow (Euler)."""

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
        count = 4 * _ANGLES
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


def solve_ellipse(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, approach: float, start: float
) -> EllipseState | None:
    """Contact of a profile at one approach; None if no ellipse was found.

    Parameters
    ----------
    profile
        The profile.
    material
        Half-space.
    approach
        Approach [m], positive.
    start
        Radius [m] near that of the contact.

    Notes
    -----
    The expansion is made about the ellipse of the contour that the one about the best ellipse
    gives. The stiffness is that of a power law, or a difference of the force.
    """
    search = Search(profile, material.m, approach, start)
    best = search.optimum(search.first, approach)
    if best is None:
        return None
    solved = search.solved(best, approach)
    if isinstance(profile, PowerLawProfile):
        power = 1 + (1 + material.m) / profile.k
    else:
        power = search.power(best, approach)
    return _state(solved, material, approach, power, _cornered(profile))


def _states(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, depth: Array, start: Array
) -> list[EllipseState | None]:
    """Contacts at several approaches; those of a power law are all similar to the first."""
    states: list[EllipseState | None] = []
    first: tuple[float, EllipseState] | None = None
    for d, a in zip(depth, start, strict=True):
        if not (np.isfinite(a) and a > 0):
            states.append(None)
        elif first is not None and isinstance(profile, PowerLawProfile):
            states.append(first[1].scaled(float(d) / first[0], profile.k, material.m))
        else:
            one = solve_ellipse(profile, material, float(d), float(a))
            first = None if one is None else (float(d), one)
            states.append(one)
    return states


def _cornered(profile: PowerSumProfile | PolarProfile) -> bool:
    """Whether the section has kinks."""
    return len(getattr(profile, "corners", ())) > 0


def _state(
    solved: Solved, material: HalfSpace, approach: float, power: float, kinked: bool
) -> EllipseState:
    (a, b, turn, x, y), gap, one, widest = solved
    unit = material.modulus
    coefs = -gap.polynomial
    coefs[0] += approach
    e1, e2, e3 = one.contour
    # logarithm of the squared contour; at a kink the higher orders ring and cut the corner
    grown = e1 if kinked else e1 + e2 - e1**2 / 2 + _LAST * (e3 - e1 * e2 + e1**3 / 3)
    grown = np.exp(np.clip(grown, -3.0, 3.0))
    mean = float((1 + e1 + e2 + _LAST * e3).mean())
    if 0.5 < mean < 2:
        grown *= mean / grown.mean()
    return EllipseState(
        force=unit * one.force,
        stiffness=unit * one.force * power / approach,
        area=float(np.pi * a * b * grown.mean()),
        parts=tuple(
            unit * part for part in (one.lower, one.second, one.third, one.fourth, one.beyond)
        ),
        axes=(a, b, turn),
        centre=(x, y),
        displacement=np.sqrt(grown) - 1,
        widest=widest,
        coefs=coefs,
        misfit=gap.misfit / approach,
        residue=gap.residue / approach,
    )


def indent(
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    approach: Array,
    *,
    law: str = "ellipse",
) -> Indentation:
    """Solution by the law "ellipse"; see `asperity.indent`.

    The pressure of a sharp tip, which is no polynomial, is that of the law "harmonic".
    """
    from .expansion import indent as resolved

    depth = approach.ravel()
    start = RisingBranch(basis_of(profile, material.m)).radius(depth)
    states = _states(profile, material, depth, start)
    phi = 2 * np.pi * np.arange(_ANGLES) / _ANGLES

    def rows(values: list[Array | float | None], empty: Array) -> Array:
        out = np.where(depth > 0, np.nan, 0.0)
        out = np.repeat(out[:, None], empty.size, axis=1)
        for row, value in zip(out, values, strict=True):
            if value is not None:
                row[:] = value
        return out

    def shaped(name: str) -> Array:
        values = [None if one is None else getattr(one, name) for one in states]
        return rows(values, np.zeros(1))[:, 0].reshape(approach.shape)

    def contour(angle: Array) -> Array:
        return rows([None if one is None else one.boundary(angle) for one in states], angle)

    sharp = np.array([one is not None and one.sharp for one in states])

    def pressure(r: Array, angle: Array) -> Array:
        values = rows(
            [None if one is None else one.pressure(r, angle, material) for one in states], angle
        )
        if np.any(sharp):
            tips = resolved(profile, material, depth[sharp], law="harmonic")
            values[sharp] = tips.pressure_function(r, angle)
        return values

    force, stiffness = shaped("force"), shaped("stiffness")
    flags = profile_flags(profile, depth, phi, contour(phi)).reshape(approach.shape)
    doubtful = rows([None if one is None else float(one.doubtful) for one in states], np.zeros(1))
    flags[doubtful.reshape(approach.shape) > 0] |= np.uint8(Flag.CONTOUR_DOUBTFUL)
    flags[~np.isfinite(force)] |= np.uint8(Flag.TURNING)
    p = 1 + material.m
    return Indentation(
        law=law,
        material=material,
        approach=approach,
        force=force,
        contact_area=shaped("area"),
        radius=(p * np.maximum(stiffness, 0.0) / (2 * material.modulus)) ** (1 / p),
        stiffness=stiffness,
        flags=flags,
        error_estimate=shaped("expected_error"),
        contour_function=contour,
        pressure_function=pressure,
    )
