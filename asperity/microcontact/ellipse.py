"""Law "ellipse": expansion about the optimal ellipse, of one profile or of a batch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from asperity.indentation import Indentation
from asperity.material import HalfSpace
from surfaces.polar import PolarProfile, PowerSumProfile

from .basis import basis_of
from .branch import RisingBranch
from .ellipse_batch import NODES, second_order_area, tabulate
from .ellipse_tables import (
    DEGREE,
    LOG_RATIO,
    EllipseTables,
    ellipse_tables,
    monomials,
    pressure_operator,
)
from .flags import Flag
from .validity import profile_flags

__all__ = ["NODES", "EllipseState", "indent", "solve_ellipse", "tabulate"]

Array = NDArray[np.float64]

_ANGLES = 720
_REGION = 1.08
"""Size of the ellipse on which f is fitted over that of the contact."""

_NEWTON = 40
_ROUNDS = 12
_STEP = 0.01
"""Logarithmic step of the approach for the stiffness."""

_DOUBTFUL = 0.5
"""Displacement of the contour beyond which the expansion is flagged."""

_BRACKET = 0.15
"""Error of the force over its second-order part, from the profiles of `ellipse_law`."""

_MISFIT = 0.005
"""rms residual of the polynomial over the approach beyond which it is flagged."""


@dataclass(frozen=True, eq=False)
class EllipseState:
    """One contact about its optimal ellipse.

    Attributes
    ----------
    force, stiffness, area
        F [N], dF/dd [N/m], contact area [m^2].
    lower
        Force of the elliptic punch alone [N], a lower bound for the fitted profile.
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
    misfit
        rms residual of the fit over the approach.
    """

    force: float
    stiffness: float
    area: float
    lower: float
    axes: tuple[float, float, float]
    centre: tuple[float, float]
    displacement: Array
    widest: float
    coefs: Array
    misfit: float

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
        return np.interp(where, angle, r, period=2 * np.pi)

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
        operator = pressure_operator(m, b / a)
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
    f is fitted by a polynomial on an ellipse a little larger than the contact, and fitted again
    until the ellipse no longer changes. The stiffness is a difference of the force at one fit.
    """
    tables = ellipse_tables(material.m)
    a, b, turn, x0, y0 = _first_ellipse(profile, start)
    levels = np.exp(0.5 * _STEP * np.arange(-2.0, 3.0))
    for _ in range(_ROUNDS):
        region = (_REGION * a, _REGION * b, turn, x0, y0)
        coefs, misfit = _fit(profile, region, approach)
        size = np.sqrt(region[0] * region[1])
        state, shape = _march(coefs, region, float(size), levels, tables)
        if not state[2, 0] > 0:
            return None
        found = shape[2]
        new = _in_plane(found, region, size)
        change = max(abs(np.log(new[0] / a)), abs(np.log(new[1] / b)))
        change = max(change, np.hypot(new[3] - x0, new[4] - y0) / b)
        a, b, turn, x0, y0 = new
        if change < 1e-3:
            break
    force = state[:, 0]
    slope = force @ np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12 * _STEP)
    middle = state[2:3]
    area = second_order_area(middle[None], np.array([[slope]]))[0, 0]
    grown = (area - middle[0, 4]) / middle[0, 5] if middle[0, 5] > 0 else 0.0
    unit = material.modulus * size ** (1 + material.m)
    scaled, _ = _fit(profile, (a, b, turn, x0, y0), 1.0)
    scaled = -scaled
    scaled[0] += approach
    return EllipseState(
        force=float(middle[0, 0] * unit * approach),
        stiffness=float(slope * unit),
        area=float(area * size**2),
        lower=float(middle[0, 0] * (1 - middle[0, 7]) * unit * approach),
        axes=(a, b, turn),
        centre=(x0, y0),
        displacement=_around(found[5:], tables) + grown,
        widest=float(middle[0, 6]),
        coefs=scaled,
        misfit=misfit,
    )


def _first_ellipse(
    profile: PowerSumProfile | PolarProfile, radius: float
) -> tuple[float, float, float, float, float]:
    """Ellipse of the Hertzian aspect about the summit, long axis along the smaller curvature."""
    coefs, _ = _fit(profile, (radius, radius, 0.0, 0.0, 0.0), 1.0)
    values, axes = np.linalg.eigh([[coefs[3], 0.5 * coefs[4]], [0.5 * coefs[4], coefs[5]]])
    ratio = float(np.clip(values[0] / values[1], 1e-3, 1.0)) ** 0.63 if values[1] > 0 else 1.0
    root = np.sqrt(ratio)
    turn = float(np.arctan2(axes[1, 0], axes[0, 0]))
    return float(radius / root), float(radius * root), turn, 0.0, 0.0


def _fit(
    profile: PowerSumProfile | PolarProfile,
    region: tuple[float, float, float, float, float],
    unit: float,
) -> tuple[Array, float]:
    """Polynomial of f/unit in the scaled coordinates of an ellipse, and its rms residual."""
    a, b, turn, x0, y0 = region
    xi, eta, matrix, inverse = _fit_points(DEGREE)
    c, s = np.cos(turn), np.sin(turn)
    x, y = x0 + c * a * xi - s * b * eta, y0 + s * a * xi + c * b * eta
    f = np.asarray(profile(np.hypot(x, y), np.arctan2(y, x))) / unit
    coefs = inverse @ f
    return coefs, float(np.sqrt(np.mean((matrix @ coefs - f) ** 2)))


@lru_cache(maxsize=4)
def _fit_points(degree: int) -> tuple[Array, Array, Array, Array]:
    """Points of the fit in the scaled coordinates, monomials at them, and the pseudo-inverse."""
    rho = np.sqrt((np.arange(10) + 0.5) / 10)
    t = 2 * np.pi * np.arange(32) / 32
    xi, eta = (rho[:, None] * np.cos(t)).ravel(), (rho[:, None] * np.sin(t)).ravel()
    i, j = monomials(degree)
    matrix = xi[:, None] ** i * eta[:, None] ** j
    return xi, eta, matrix, np.linalg.pinv(matrix, rcond=1e-12)


def _march(
    scaled: Array,
    region: tuple[float, float, float, float, float],
    size: float,
    levels: Array,
    tables: EllipseTables,
) -> tuple[Array, Array]:
    """States and shapes at the levels, in units of `size` and in the axes of the region."""
    from ._ellipse_kernels import SHAPE, STATES, march

    i, j = monomials(tables.degree)
    coefs = scaled / ((region[0] / size) ** i * (region[1] / size) ** j)
    state, shape = np.zeros((1, levels.size, STATES)), np.zeros((1, levels.size, SHAPE))
    first, last, count = LOG_RATIO
    march(
        coefs[None, None], np.full((1, 1), np.inf), np.full((1, 4), np.inf), np.ones(1), levels,
        _NEWTON, tables.m, tables.rows, first, (count - 1) / (last - first), tables.moments, state,
        shape,
    )  # fmt: skip
    return state[0], shape[0]


def _in_plane(
    found: Array, region: tuple[float, float, float, float, float], size: float
) -> tuple[float, float, float, float, float]:
    """Ellipse found in the axes of a region and units of `size`, in the plane [m]."""
    a, b, x, y, turn = (float(v) for v in found[:5])
    c, s = np.cos(region[2]), np.sin(region[2])
    x0 = region[3] + size * (c * x - s * y)
    y0 = region[4] + size * (s * x + c * y)
    turn += region[2]
    if b > a:
        a, b, turn = b, a, turn + 0.5 * np.pi
    return size * a, size * b, turn, float(x0), float(y0)


def _around(quarters: Array, tables: EllipseTables) -> Array:
    """Values at the four mirror images of the quarter nodes, in order around the ellipse."""
    first, second, third, fourth = quarters.reshape(4, tables.nodes.size)
    return np.concatenate([first, second[-2::-1], third[1:], fourth[-2:0:-1]])


def indent(
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    approach: Array,
    *,
    law: str = "ellipse",
) -> Indentation:
    """Solution by the law "ellipse"; see `asperity.indent`."""
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

    def pressure(r: Array, angle: Array) -> Array:
        return rows(
            [None if one is None else one.pressure(r, angle, material) for one in states], angle
        )

    force, stiffness, lower = shaped("force"), shaped("stiffness"), shaped("lower")
    misfit = np.where(depth > 0, shaped("misfit").ravel(), 0.0).reshape(approach.shape)
    flags = profile_flags(profile, depth, phi, contour(phi)).reshape(approach.shape)
    flags[(shaped("widest") > _DOUBTFUL) | (misfit > _MISFIT)] |= np.uint8(Flag.CONTOUR_DOUBTFUL)
    flags[~np.isfinite(force)] |= np.uint8(Flag.TURNING)
    touching = force > 0
    share = np.where(touching, (force - lower) / np.where(touching, force, 1.0), 0.0)
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
        error_estimate=_BRACKET * np.abs(share) + misfit,
        contour_function=contour,
        pressure_function=pressure,
    )
