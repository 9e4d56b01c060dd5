"""Law "ellipse" of one contact: expansion about the optimal ellipse."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np

from asperity.errors import Flag
from asperity.halfspace.footprint import Footprints
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.ellipse.ellipse_operator import monomials, pressure_operator
from surfaces.arrays import Array
from surfaces.polar import PolarProfile, PowerLawProfile, PowerSumProfile

from . import circle
from .basis import Basis, around, basis_of, radius_at
from .ellipse_expansion import DEGREE
from .ellipse_search import SHARP_TIP, Ellipse, Search
from .indentation import Indentation, profile_flags
from .pressure import of_unit_powers

__all__ = ["indent"]


_ANGLES = 720
"""Angles at which the flags look at a contour."""

_POINTS = 2880
"""Points of a contour from which its radius is read."""

_LAST = 0.5
"""Share of the last order of the contour that is taken: its orders alternate, and half of the last
stands for it and those that follow (Euler)."""

_DOUBTFUL = 0.5
"""Displacement of the contour, or ratio of the third- to the second-order force, beyond which the
expansion is flagged."""

_BEYOND, _FOURTH, _THIRD, _SECOND, _FAR, _OPERATOR = 1.5, 0.25, 0.15, 0.02, 0.6, 0.15
"""Factors of the expected error; `docs/development/laws.md` says how they were chosen and
judged."""

_CENTRE = 0.0035
"""Force error over what a fit leaves at the centre, `_State.centre`: 0.0006 to 0.0033 on
round tips r^0.05 to r^64, m = -0.8 to 0.8."""

_TIP = 1e-3
"""Radius, over the contour, within which the pressure of a tip is that at this radius: of powers
that stand for another one the first may be infinite at the tip."""

_RESIDUE = 0.005
"""rms error of the representation of f over the approach beyond which it is flagged."""


@dataclass(frozen=True, eq=False)
class _State:
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
    coefs, powers
        Displacement of the surface over the monomials of the scaled coordinates [m]; f less its
        polynomial over the powers of their radius [m], on average over the angle.
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
    powers: Array
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

    def scaled(self, ratio: float, k: float, m: float) -> _State:
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
            powers=self.powers * ratio,
        )

    def boundary(self, phi: Array) -> Array:
        """Boundary a(phi) [m] about the summit."""
        t = 2 * np.pi * np.arange(self.displacement.size) / self.displacement.size
        grown = 1 + self.displacement
        r, angle = self.ellipse.places(grown * np.cos(t), grown * np.sin(t))
        return np.asarray(np.interp(phi, angle, r, period=2 * np.pi))

    def pressure(self, r: Array, phi: Array, material: HalfSpace) -> Array:
        """Pressure [Pa] at the points: that of the ellipse less its edge singularity, stretched.

        Along each ray of the ellipse ``(1 - rho^2)^((m-1)/2)`` times the pressure polynomial
        minus its value at the edge, with rho measured to the displaced contour; and that of the
        powers of rho which no polynomial holds, such as a tip, as on the circle of equal area.
        """
        m = material.m
        a, b = self.ellipse.a, self.ellipse.b
        xi, eta = self.ellipse.coordinates(r, phi)
        t = np.arctan2(eta, xi)
        rho = np.hypot(xi, eta) / (1 + around(self.displacement)(t))
        inside = rho < 1
        rho = np.where(inside, rho, 0.0)
        i, j = monomials(DEGREE)
        # the table is for semi-axes of unit product: lengths in units of sqrt(ab)
        size = np.sqrt(a * b)
        operator = pressure_operator(m, np.array([b / a]), DEGREE)[0]
        weights = material.modulus * size ** (m - 1) * (self.coefs @ operator)
        edge = np.cos(t) ** i[:, None] * np.sin(t) ** j[:, None]
        inner = edge * rho ** (i + j)[:, None]
        body = weights @ (inner - edge) * (1 - rho**2) ** ((m - 1) / 2)
        unit = material.modulus * size ** (m - 1)
        body += unit * of_unit_powers(self.powers, np.maximum(rho, _TIP), m)
        return np.where(inside, body, 0.0)


def _state(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, approach: float, start: float
) -> _State | None:
    """Contact at one approach [m], of a radius near `start` [m]; None if no ellipse was found, or
    it pulls.

    The expansion is made about the ellipse of the contour that the one about the best ellipse
    gives. The stiffness is that of a power law, or a difference of the force.
    """
    search = Search(profile, material.m, approach, start)
    best = search.optimum(search.first, approach)
    if best is None:
        return None
    ellipse, gap, one, widest = search.solved(best, approach)
    if not one.force > 0:
        return None
    if isinstance(profile, PowerLawProfile):
        power = 1 + (1 + material.m) / profile.k
    else:
        power = search.power(best, approach)
    unit = material.modulus
    coefs = -gap.polynomial
    coefs[0] += approach
    middle = float(profile(*ellipse.places(np.zeros(1), np.zeros(1)))[0])
    e1, e2, e3 = one.contour
    # logarithm of the squared contour; at a kink the higher orders ring and cut the corner
    kinked = len(getattr(profile, "corners", ())) > 0
    grown = e1 if kinked else e1 + e2 - e1**2 / 2 + _LAST * (e3 - e1 * e2 + e1**3 / 3)
    grown = np.exp(np.clip(grown, -3.0, 3.0))
    mean = float((1 + e1 + e2 + _LAST * e3).mean())
    if 0.5 < mean < 2:
        grown *= mean / grown.mean()
    waves = np.fft.rfft(np.sqrt(grown) - 1)
    waves[-1] /= 2
    return _State(
        force=unit * one.force,
        stiffness=unit * one.force * power / approach,
        area=float(np.pi * ellipse.a * ellipse.b * grown.mean()),
        parts=tuple(
            unit * part for part in (one.lower, one.second, one.third, one.fourth, one.beyond)
        ),
        ellipse=ellipse,
        displacement=np.fft.irfft(waves, _POINTS) * (_POINTS / grown.size),
        widest=widest,
        coefs=coefs,
        powers=gap.rest[0].real,
        misfit=gap.misfit / approach,
        residue=gap.residue / approach,
        centre=(1 + material.m) * abs(gap.centre - middle) / approach,
    )


def _states(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, depth: Array, basis: Basis
) -> list[_State | None]:
    """Contacts at several approaches; those of a power law are all similar to that of the radius
    one: the search of a kinked body ends elsewhere at each approach."""
    start = radius_at(basis, depth)
    touching = np.isfinite(start) & (start > 0)
    pairs = zip(depth.tolist(), start.tolist(), touching, strict=True)
    if not (isinstance(profile, PowerLawProfile) and touching.any()):
        return [_state(profile, material, d, a) if touch else None for d, a, touch in pairs]
    unit = float(basis.depth(np.ones(1))[0])
    one = _state(profile, material, unit, 1.0)
    return [
        one.scaled(d / unit, profile.k, material.m) if one is not None and touch else None
        for d, _, touch in pairs
    ]


def indent(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, approach: Array
) -> Indentation:
    """Solution by the law "ellipse"; see `asperity.indent`.

    The pressure of a sharp tip, which is no polynomial, is that of the law "harmonic", stretched.
    """
    states = _states(profile, material, approach, basis_of(profile, material.m))
    phi = 2 * np.pi * np.arange(_ANGLES) / _ANGLES

    def rows(told: Callable[[_State], Array], size: int) -> Array:
        """What is told of each contact, shape (n, size): zero without one, NaN if not found."""
        out = np.repeat(np.where(approach > 0, np.nan, 0.0)[:, None], size, axis=1)
        for row, one in zip(out, states, strict=True):
            if one is not None:
                row[:] = told(one)
        return out

    def column(name: str) -> Array:
        return rows(attrgetter(name), 1)[:, 0]

    def contour(angle: Array) -> Array:
        return rows(lambda one: one.boundary(angle), angle.size)

    force, stiffness, area = column("force"), column("stiffness"), column("area")

    def pressure(r: Array, angle: Array) -> Array:
        values = rows(lambda one: one.pressure(r, angle, material), angle.size)
        for row, one in enumerate(states):
            if one is None or not one.sharp:
                continue
            tip = circle.indent(profile, material, approach[[row]], law="harmonic")
            # stretched to the contour of the ellipse, and scaled to its force
            share = tip.contour_function(angle)[0] / one.boundary(angle)
            scale = force[row] / tip.force[0] * tip.contact_area[0] / area[row]
            values[row] = scale * tip.pressure_function(r * share, angle)[0]
        return values

    flags = profile_flags(profile, approach, phi, contour(phi))
    doubtful = np.array([one is not None and one.doubtful for one in states])
    flags[doubtful] |= np.uint8(Flag.CONTOUR_DOUBTFUL)
    flags[~np.isfinite(force)] |= np.uint8(Flag.TURNING)
    return Indentation(
        law="ellipse",
        material=material,
        approach=approach,
        force=force,
        contact_area=area,
        radius=Footprints(material.modulus, material.m).radius(np.maximum(stiffness, 0.0)),
        stiffness=stiffness,
        flags=flags,
        error_estimate=column("expected_error"),
        contour_function=contour,
        pressure_function=pressure,
    )
