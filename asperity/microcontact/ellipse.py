"""Law "ellipse": expansion about the optimal ellipse, of one profile or of a batch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asperity.indentation import Indentation
from asperity.material import HalfSpace
from surfaces.polar import PolarProfile, PowerSumProfile

from .basis import basis_of
from .branch import RisingBranch
from .ellipse_batch import NODES, tabulate
from .ellipse_expansion import ANGLES, DEGREE, Expansion, Gap, expand, fit_points, fitted
from .ellipse_tables import monomials, pressure_operator
from .flags import Flag
from .validity import profile_flags

__all__ = ["NODES", "EllipseState", "indent", "solve_ellipse", "tabulate"]

Array = NDArray[np.float64]

_ANGLES = 720
_NEWTON = 30
_STILL = 1e-5
_STEP = 0.01
"""Logarithmic step of the approach for the stiffness."""

_SHARP = 0.005
"""Misfit of the polynomial over the approach above which a tip is sharp: its ellipse stays about
the summit, since powers of the distance from there describe what the polynomial leaves."""

_DOUBTFUL = 0.5
"""Displacement of the contour, or ratio of the third- to the second-order force, beyond which the
expansion is flagged."""

_SECOND, _LOCAL, _BEYOND, _OPERATOR = 0.02, 0.1, 3.0, 0.15
"""Factors of the expected error; `docs/laws.md` says how they were chosen and judged."""

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
        Force of the elliptic punch alone, its second- and its third-order part, and the estimate
        of the rest [N].
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
    parts: tuple[float, float, float, float]
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
        _, second, third, beyond = (abs(part / self.force) for part in self.parts)
        ratio = min(third / second, 1.0) if second > 0 else 0.0
        narrow = min(abs(np.log(self.axes[1] / self.axes[0])), 1.0)
        series = (ratio + _LOCAL) * third + _BEYOND * beyond
        return float(series + _SECOND * second + _OPERATOR * narrow * self.misfit + self.residue)

    @property
    def sharp(self) -> bool:
        """Whether f has a tip or edges that no polynomial describes."""
        return self.misfit > _SHARP

    @property
    def doubtful(self) -> bool:
        """Whether the expansion has been carried too far, or f is not represented."""
        _, second, third, _ = self.parts
        far = self.widest > _DOUBTFUL or abs(third) > _DOUBTFUL * abs(second) + 1e-3 * self.force
        return far or self.residue > _RESIDUE

    def boundary(self, phi: Array) -> Array:
        """Boundary a(phi) [m] about the summit."""
        a, b, turn = self.axes
        t = 2 * np.pi * np.arange(4 * _ANGLES) / (4 * _ANGLES)
        grown = 1 + self._displacement(t)
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


class _Ellipse(NamedTuple):
    """Semi-axes [m], turn [rad] and centre [m]."""

    a: float
    b: float
    turn: float
    x: float
    y: float

    def places(self, xi: Array, eta: Array) -> tuple[Array, Array]:
        """Places (r, phi) of scaled coordinates."""
        c, s = np.cos(self.turn), np.sin(self.turn)
        x = self.x + c * self.a * xi - s * self.b * eta
        y = self.y + s * self.a * xi + c * self.b * eta
        return np.hypot(x, y), np.arctan2(y, x)

    def moved(self, step: Array) -> _Ellipse:
        """Ellipse whose boundary is displaced by `step` over the modes of `_MODES`."""
        step = np.clip(step, -0.3, 0.3)
        shear = 2 * step[2] / (self.a / self.b + self.b / self.a)
        strain = np.array([[1 + step[0], shear], [shear, 1 + step[1]]])
        c, s = np.cos(self.turn), np.sin(self.turn)
        axes, size, _ = np.linalg.svd(np.array([[c, -s], [s, c]]) @ strain * [self.a, self.b])
        x, y = step[3] * self.a, step[4] * self.b
        turn = np.arctan2(axes[1, 0], axes[0, 0])
        return _Ellipse(
            float(size[0]),
            float(size[1]),
            float(turn),
            self.x + c * x - s * y,
            self.y + s * x + c * y,
        )


_T = 2 * np.pi * np.arange(ANGLES) / ANGLES
_MODES = np.stack([np.cos(_T) ** 2, np.sin(_T) ** 2, np.sin(2 * _T), np.cos(_T), np.sin(_T)])


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
    Newton steps of the exact force of the elliptic punch, f fitted again on every ellipse. The
    stiffness is a difference of the force.
    """
    m = material.m
    first, free = _first_ellipse(profile, start, approach)
    solved = _optimum(profile, approach, m, first, free)
    if solved is None:
        return None
    best, gap, one = solved
    around = [
        _optimum(profile, approach * np.exp(k * _STEP), m, best, free) for k in (-2, -1, 1, 2)
    ]
    forces = [np.nan if near is None else near[2].force for near in around]
    slope = float(np.dot(forces, [1.0, -8.0, 8.0, -1.0])) / (12 * _STEP * approach)
    unit = material.modulus
    coefs = -gap.polynomial
    coefs[0] += approach
    mean = float(one.squared.mean())
    second = one.squared - 1 - 2 * one.shift**2
    if len(getattr(profile, "corners", ())):
        second = 2 * one.shift  # at a kink the second order rings and cuts the corner
    grown = np.exp(np.clip(second, -3.0, 3.0))
    if 0.5 < mean < 2:
        grown *= mean / grown.mean()
    return EllipseState(
        force=unit * one.force,
        stiffness=unit * slope,
        area=float(np.pi * best.a * best.b * grown.mean()),
        parts=(unit * one.lower, unit * one.second, unit * one.third, unit * one.beyond),
        axes=(best.a, best.b, best.turn),
        centre=(best.x, best.y),
        displacement=np.sqrt(grown) - 1,
        widest=float(np.abs(one.shift).max()),
        coefs=coefs,
        misfit=gap.misfit / approach,
        residue=gap.residue / approach,
    )


def _optimum(
    profile: PowerSumProfile | PolarProfile, approach: float, m: float, start: _Ellipse, free: bool
) -> tuple[_Ellipse, Gap, Expansion] | None:
    """Ellipse of the largest force of the elliptic punch, its centre `free` or held."""
    xi, eta, _, _ = fit_points(DEGREE)
    best = start
    modes = _MODES if free else _MODES[:3]
    for _ in range(_NEWTON):
        gap = fitted(np.asarray(profile(*best.places(xi, eta))))
        one = expand(gap, approach, best.a, best.b, m)
        if not (np.isfinite(one.lower) and one.level > 0):
            return None
        step = np.zeros(5)
        weighted = modes * one.weight
        step[: len(modes)] = np.linalg.solve(weighted @ modes.T, weighted @ one.shift)
        if np.abs(step).max() < _STILL:
            return best, gap, one
        best = best.moved(step)
    return (best, gap, one) if np.abs(step).max() < 1e-2 and one.lower > 0 else None


def _first_ellipse(
    profile: PowerSumProfile | PolarProfile, radius: float, approach: float
) -> tuple[_Ellipse, bool]:
    """Ellipse of the Hertzian aspect about the summit, a circle about a sharp one, and whether
    its centre is free."""
    xi, eta, _, _ = fit_points(DEGREE)
    circle = _Ellipse(radius, radius, 0.0, 0.0, 0.0)
    gap = fitted(np.asarray(profile(*circle.places(xi, eta))))
    c = gap.polynomial
    values, axes = np.linalg.eigh([[c[3], 0.5 * c[4]], [0.5 * c[4], c[5]]])
    if gap.misfit > _SHARP * approach or not values[1] > 0:
        return circle, gap.misfit <= _SHARP * approach
    root = float(np.clip(values[0] / values[1], 1e-3, 1.0)) ** 0.315
    turn = float(np.arctan2(axes[1, 0], axes[0, 0]))
    return _Ellipse(radius / root, radius * root, turn, 0.0, 0.0), True


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
    states = [
        solve_ellipse(profile, material, float(d), float(a)) if np.isfinite(a) and a > 0 else None
        for d, a in zip(depth, start, strict=True)
    ]
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
        radius=(p * stiffness / (2 * material.modulus)) ** (1 / p),
        stiffness=stiffness,
        flags=flags,
        error_estimate=shaped("expected_error"),
        contour_function=contour,
        pressure_function=pressure,
    )
