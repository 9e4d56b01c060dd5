"""Contact laws of all summits as the solver needs them: force, energy and footprint moment."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from surfaces._threads import blocks, run

from ..errors import InputError
from . import _laws
from .footprint import FLOOR, Footprints

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
    index
        Rows of the table that belong to these contacts, shape (n,).
    table
        Shape (rows, K, 11), for v in [j, j+1]: coefficients of s = e0 + e1 v + e2 v^2 + e3 v^3; the
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
        self.index = np.arange(len(reach))
        self.table = np.zeros((len(reach), force.shape[1] - 1, 11))
        self.repaired = np.zeros(len(reach), bool)
        self.largest = np.zeros(len(reach))
        rows = np.flatnonzero(self.usable)
        cap = STIFFEST * footprints.punch(np.sqrt(area[rows].max(axis=1) / np.pi))
        force, stiffness, self.repaired[rows] = _sound(
            reach[rows], force[rows], stiffness[rows], cap
        )
        settings = (1 + FLOOR) * footprints.self_factor, 2 / footprints.power
        run(
            lambda a, b: _laws.tabulate(
                rows[a:b],
                reach,
                force[a:b],
                stiffness[a:b],
                area,
                self.exponent,
                *settings,
                self.table,
            ),
            blocks(len(rows), 1000),
        )
        self.largest[rows] = area[rows, -1]

    def __len__(self) -> int:
        return len(self.index)

    def rows(self, index: NDArray[np.int64]) -> Laws:
        """The laws of the contacts `index` alone; the table is shared."""
        part = object.__new__(Laws)
        vars(part).update(vars(self))
        part.index = self.index[index]
        for name in ("reach", "usable", "repaired", "largest"):
            setattr(part, name, getattr(self, name)[index])
        return part

    def __call__(self, approach: NDArray[np.float64]) -> Evaluated:
        """Laws at the approaches [m], shape (n,); zero force where they are not positive."""
        out = Evaluated(len(approach))
        _laws.evaluate(
            self.index,
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
