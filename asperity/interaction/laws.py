"""Contact laws of all summits as the solver needs them: force, energy and footprint moment."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from . import _laws
from .footprint import Footprints

__all__ = ["FILLED", "STIFFEST", "Evaluated", "LawNodes", "Laws"]

FILLED = 0.5
"""Contact area over that at reach, the whole basin, beyond which a contact counts as filled."""

STIFFEST = 1.5
"""Largest stiffness over that of a round punch of the same area; an ellipse of 6:1 has 1.28."""


class LawNodes(Protocol):
    """What the solver reads of a table of contact laws (`asperity.microcontact.table`)."""

    reach: NDArray[np.float64]
    force: NDArray[np.float64]
    stiffness: NDArray[np.float64]
    area: NDArray[np.float64]

    @property
    def exponent(self) -> float: ...


class Evaluated:
    """Laws of some contacts at their approaches; arrays over the contacts.

    Attributes
    ----------
    force, stiffness
        F [N] and its slope k = dF/dd [N/m].
    area
        Contact area [m^2].
    energy
        U = int_0^d F dd [J].
    moment
        m = (1/F) int_0^F v(k) dF [m^2], the variance of the footprint of the whole force.
    growth
        F dm/dF = v - m [m^2], by which the footprint of an increment exceeds it.
    """

    __slots__ = ("area", "energy", "force", "growth", "moment", "stiffness")

    def __init__(self, n: int) -> None:
        self.force, self.stiffness, self.area = np.zeros((3, n))
        self.energy, self.moment, self.growth = np.zeros((3, n))


class Laws:
    """Force, energy and footprint moment of many contacts over their approach.

    Parameters
    ----------
    nodes
        Tables with `reach` (n,) [m], `force` [N], `stiffness` [N/m] and `area` [m^2] (n, K+1) at
        the approaches reach (j/K)^2, and the `exponent` p of F = v^p s(v), v = K sqrt(d/reach).
    footprints
        Kernel that turns a stiffness into a footprint.

    Attributes
    ----------
    usable
        Contacts that can carry load, bool, shape (n,): reach and the force there are positive.
    repaired
        Contacts whose table broke a law of contact and was mended, bool, shape (n,).
    largest
        Contact area [m^2] at reach, shape (n,).
    widest
        Variance [m^2] of the footprint of the filled basin, shape (n,).
    table
        Shape (n, K, 11), for v in [j, j+1]: coefficients of s = e0 + e1 v + e2 v^2 + e3 v^3; the
        constant of the energy; coefficients of the moment in v - j; area/v^2 at both ends.

    Notes
    -----
    s is a cubic Hermite polynomial, linear in the first interval, so that Hertz contacts are exact
    at any grading. The energy is integrated in closed form; the moment is a growing cubic
    Hermite polynomial with the slope dm/dF = (v - m)/F at the nodes. Beyond `reach` the basin is
    filled: the contact is a flat punch of constant stiffness and footprint.

    The coupled problem needs what every true law has (theory 7.6): the contact grows with the
    approach, and its stiffness with it, up to that of a flat punch of the contact. A table that
    breaks this gets the largest convex force below its own, no steeper than `STIFFEST` times a
    round punch of its largest area; nodal stiffnesses are kept between those of the neighboring
    intervals.
    """

    def __init__(self, nodes: LawNodes, footprints: Footprints) -> None:
        reach = np.ascontiguousarray(nodes.reach, float)
        force, stiffness, area = (
            np.asarray(a, float) for a in (nodes.force, nodes.stiffness, nodes.area)
        )
        names = {"reach": reach, "force": force, "stiffness": stiffness, "area": area}
        for name, array in names.items():
            if not np.isfinite(array).all():
                raise InputError(f"law table: {name} holds values that are not finite")
        self.exponent, self.footprints = float(nodes.exponent), footprints
        self.usable = (reach > 0) & (force[:, -1] > 0)
        self.reach = np.where(self.usable, reach, 0.0)
        self.table = np.zeros((len(reach), force.shape[1] - 1, 11))
        self.repaired = np.zeros(len(reach), bool)
        self.largest, self.widest = np.zeros((2, len(reach)))
        rows = np.flatnonzero(self.usable)
        cap = STIFFEST * footprints.punch(np.sqrt(area[rows].max(axis=1) / np.pi))
        force, stiffness, self.repaired[rows] = _sound(
            reach[rows], force[rows], stiffness[rows], cap
        )
        self.table[rows] = _tabulate(reach[rows], force, stiffness, self.exponent, footprints)
        shape = area[rows, 1:] / np.arange(1.0, force.shape[1]) ** 2
        self.table[rows, :, 9] = np.concatenate((shape[:, :1], shape[:, :-1]), axis=1)
        self.table[rows, :, 10] = shape
        self.largest[rows] = area[rows, -1]
        self.widest[rows] = footprints.variance(stiffness[:, -1])

    def __len__(self) -> int:
        return len(self.reach)

    def rows(self, index: NDArray[np.int64]) -> Laws:
        """The laws of the contacts `index` alone."""
        part = object.__new__(Laws)
        part.exponent, part.footprints = self.exponent, self.footprints
        for name in ("reach", "usable", "repaired", "largest", "widest", "table"):
            setattr(part, name, getattr(self, name)[index])
        return part

    def __call__(self, approach: NDArray[np.float64]) -> Evaluated:
        """Laws at the approaches [m], shape (n,); zero force where they are not positive."""
        out = Evaluated(len(approach))
        _laws.evaluate(
            approach,
            self.reach,
            self.exponent,
            self.table,
            out.force,
            out.stiffness,
            out.area,
            out.energy,
            out.moment,
            out.growth,
        )
        return out

    def filled(self, law: Evaluated) -> NDArray[np.bool_]:
        """Which contacts cover more than `FILLED` of the area that they have at reach."""
        return np.asarray(law.area > FILLED * self.largest)


def _tabulate(
    reach: NDArray[np.float64],
    force: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    power: float,
    footprints: Footprints,
) -> NDArray[np.float64]:
    """The table of `Laws` for usable contacts."""
    steps = force.shape[1] - 1
    v = np.arange(1.0, steps + 1)
    slope = stiffness * 2 * reach[:, None] * np.arange(steps + 1) / steps**2
    s = force[:, 1:] * v**-power
    ds = slope[:, 1:] * v**-power - power * s / v
    # first interval: straight, through the first node, not below a fifth of its value
    ds[:, 0] = np.minimum(ds[:, 0], 0.8 * s[:, 0])
    first = s[:, :1] - ds[:, :1]
    table = np.zeros((*s.shape, 11))
    local = _hermite(
        np.concatenate((first, s[:, :-1]), 1), s, np.concatenate((ds[:, :1], ds[:, :-1]), 1), ds
    )
    e = table[..., :4]
    j = v - 1
    e[..., 3] = local[3]
    e[..., 2] = local[2] - 3 * local[3] * j
    e[..., 1] = local[1] - 2 * local[2] * j + 3 * local[3] * j**2
    e[..., 0] = local[0] - local[1] * j + local[2] * j**2 - local[3] * j**3
    _energy(table, reach, power)
    _moment(table, reach, power, footprints)
    return table


def _sound(
    reach: NDArray[np.float64],
    force: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    cap: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Forces and stiffnesses that both grow, and which rows had to be changed."""
    steps = force.shape[1] - 1
    slack = 1e-6 * stiffness[:, -1:]
    broken = (np.diff(stiffness, axis=1) < -slack).any(axis=1)
    broken |= (np.diff(force, axis=1) <= 0).any(axis=1)
    broken |= (stiffness > cap[:, None]).any(axis=1)
    u2 = (np.arange(steps + 1) / steps) ** 2
    force, stiffness = force.copy(), stiffness.copy()
    # a law that stands still would have an infinite compliance
    hull = np.maximum(force[broken], 1e-3 * force[broken, -1:] * u2**2)
    hull[:, 0] = 0.0
    _laws.convex(u2, hull)
    depth = reach[broken, None] * np.diff(u2)
    secant = np.minimum(np.diff(hull, axis=1) / depth, cap[broken, None])
    force[broken, 1:] = np.cumsum(secant * depth, axis=1)
    force[broken, 0] = 0.0
    above = np.concatenate((secant, secant[:, -1:]), axis=1)
    below = np.concatenate((np.zeros((len(secant), 1)), secant), axis=1)
    above[:, -1] = np.maximum(cap[broken], secant[:, -1])
    stiffness[broken] = np.clip(stiffness[broken], below, above)
    return force, stiffness, broken


def _hermite(
    left: NDArray[np.float64],
    right: NDArray[np.float64],
    left_slope: NDArray[np.float64],
    right_slope: NDArray[np.float64],
) -> tuple[NDArray[np.float64], ...]:
    """Coefficients of the cubic on the unit interval."""
    rise = right - left
    return (
        left,
        left_slope,
        3 * rise - 2 * left_slope - right_slope,
        left_slope + right_slope - 2 * rise,
    )


def _energy(table: NDArray[np.float64], reach: NDArray[np.float64], power: float) -> None:
    """Constant of the energy on each interval: U = constant + primitive of F dd/dv."""
    steps = table.shape[1]
    width = (2 * reach / steps**2)[:, None]
    j = np.arange(steps)

    def primitive(v: NDArray[np.float64]) -> NDArray[np.float64]:
        q = power + 2
        series = sum(table[..., k] * v**k / (q + k) for k in range(4))
        return np.asarray(width * v**q * series)

    start, end = primitive(j), primitive(j + 1.0)
    done = np.cumsum(end - start, axis=1)
    table[..., 4] = np.concatenate((np.zeros((len(table), 1)), done[:, :-1]), 1) - start


def _moment(
    table: NDArray[np.float64], reach: NDArray[np.float64], power: float, kernel: Footprints
) -> None:
    """Moment m = (1/F) int v(k) dF by Gauss quadrature on each interval, Hermite between."""
    steps = table.shape[1]
    j = np.arange(steps)

    def slope(v: NDArray[np.float64]) -> NDArray[np.float64]:
        s = sum(table[..., k] * v**k for k in range(4))
        ds = sum(k * table[..., k] * v ** (k - 1) for k in range(1, 4))
        return np.asarray(np.maximum(v ** (power - 1) * (power * s + v * ds), 0.0))

    def variance(v: NDArray[np.float64]) -> NDArray[np.float64]:
        return kernel.variance(slope(v) * steps**2 / (2 * reach[:, None] * v))

    part = np.zeros(table.shape[:2])
    force = np.zeros_like(part)
    for t, weight in zip(*np.polynomial.legendre.leggauss(5), strict=True):
        v = j + (1 + t) / 2
        force += weight / 2 * slope(v)
        part += weight / 2 * slope(v) * variance(v)
    force = np.cumsum(force, axis=1)
    moment = np.cumsum(part, axis=1) / force
    bend = (variance(j + 1.0) - moment) * slope(j + 1.0) / force
    zero = np.zeros((len(table), 1))
    # slopes limited so that the moment grows between the nodes too (Fritsch and Carlson 1980)
    secant = np.diff(moment, axis=1, prepend=0.0)
    after = np.concatenate((secant[:, 1:], secant[:, -1:]), axis=1)
    bend = np.clip(bend, 0.0, 3 * np.maximum(np.minimum(secant, after), 0.0))
    table[..., 5:9] = np.stack(
        _hermite(
            np.concatenate((zero, moment[:, :-1]), 1),
            moment,
            np.concatenate((zero, bend[:, :-1]), 1),
            bend,
        ),
        axis=-1,
    )
