"""Candidates: the summits that may touch at a separation, and where their contacts stand."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from asperity.errors import Flag
from asperity.interaction.ewald.near_pairs import widest_in_cell
from asperity.interaction.ewald.operator import Interaction
from asperity.interaction.newton.contact_shift import widened
from asperity.interaction.newton.state import CandidateValues, Problem
from surfaces.arrays import Array, Index

if TYPE_CHECKING:
    from asperity.interaction.ewald.mesh import SmoothField
    from asperity.interaction.newton.final_step import Solution
    from asperity.interaction.newton.laws import Evaluated

    from .contact_system import ContactSystem

__all__ = ["CandidateList"]


FOOTPRINT_GROWTH = 1.3
"""The near pairs of a list reach as far as footprints at this multiple of the present approach."""

SAMPLED_CONTACTS = 1000
"""Contacts from which the widest footprint and the mean distance from the centres are estimated."""

ELONGATED_SHARE = 0.5
"""Share of the second moment along an elongated footprint that the near pairs allow for; beyond the
near pairs footprints are round. The list changes the load at 25 % of contact by 0.6 % with lay of
4:1, by 0.3 % with 6:1 (by 5 and 18 % if it allows for round footprints only; seed 1)."""

WIDEST_SHARE = 0.95
"""Share of the load on footprints no wider than the near pairs of a list allow for, unless these
would reach beyond the cell; in any case they allow for `WIDEST_NUMBER` of the contacts. One contact
that carries a third of the load reaches far: by the number alone the loads of 14 of 40 maps
depended on the load path by more than a tenth of the stated error, with the load those of 4."""
WIDEST_NUMBER = 0.98

LARGEST_DISTANCE = 0.06
"""Largest mean distance between points and centres of contacts, over the contact radius."""

PAIR_LIST_SKIN = 0.15
"""Largest distance of a point from its place when the near pairs were listed, over the split length
of `Interaction`."""

LARGEST_FIELD_ERROR = 1e-3
"""Largest error of the load, as a share of it, by the distance between points and centres in the
slope of the field."""

MANY_CONTACTS = 5000
"""Closed contacts from which on the next two bounds hold. For fewer contacts the bounds are smaller
in proportion, since each contact has a larger share of the load."""

ERROR_PER_TOLERANCE = 0.1
"""The error bounded by `LARGEST_FIELD_ERROR` may be this part of the tolerance, if that is more."""

LARGEST_LEAPING_LOAD = 0.02
"""Largest share of the load on contacts whose centres leap farther than the skin. Beyond it the
list is made anew for the new places."""

RETURNING_SHARE = 0.5
"""Share of its way that a point moves if it moves back: contacts on one ridge can pass their load,
and with it their centres, back and forth."""


@dataclass(frozen=True, eq=False)
class CandidateList:
    """Summits that may touch, in the order of the points of `problem.coupling`.

    Attributes
    ----------
    system
        Summits, laws and half-space.
    problem
        Laws and interaction of the candidates.
    index
        Summit of each candidate, shape (n,).
    others
        Summits that are no candidates, from the highest down.
    offset
        Positions x, y [m] of all contacts relative to their summits, shape (2, all).
    paired
        `offset` when the near pairs were listed.
    moved
        Last change of `offset` [m], shape (2, all).
    """

    system: ContactSystem
    problem: Problem
    index: Index
    others: Index
    offset: Array
    paired: Array
    moved: Array

    @classmethod
    def of(
        cls,
        system: ContactSystem,
        rows: Index,
        values: CandidateValues,
        *,
        field: SmoothField | None,
        separation: float,
        growth: float,
        spare: float,
    ) -> CandidateList:
        """The candidates at a separation [m], from a prediction of the contacts.

        `values` are those predicted of the summits `rows`: summits predicted to be closed are
        candidates in any case. `field` is the smooth part of the last field, if any; where it is
        negative it may be `growth` times as deep. `spare` is the number of candidates over that of
        the summits that overlap.
        """
        elongation = system.elongation
        touches = values.interference > 0
        closed, approach = rows[touches], values.interference[touches]
        near, overlap = _overlaps(system, system.by_height, field, separation, growth)
        certain = np.zeros(len(system), bool)
        certain[closed] = True
        overlap = np.where(certain[near], np.inf, overlap)
        count = int(spare * int(np.count_nonzero(overlap > 0.1 * _lowest(field, growth)))) + 40
        if count < len(near):
            index = near[np.argpartition(-overlap, count)[:count]]
        else:
            index = system.by_height[: max(len(near), count)]
        system.laws.rows(closed).make()
        offset = np.zeros((2, len(system)))
        if system.has_centres:
            offset[:, closed] = system.table.centre_at(closed, approach)
        dx, dy = offset[:, index]
        some = slice(None, None, 1 + len(closed) // SAMPLED_CONTACTS)
        law = system.laws.rows(closed[some])(FOOTPRINT_GROWTH * approach[some])
        form = None
        if elongation is not None and system.contact_shift:
            form = elongation.moments[index]
        coupling = Interaction(
            system.y[index] + dy,
            system.x[index] + dx,
            system.cell,
            system.boundary,
            system.footprints,
            form=form,
            widest=_widest(system, closed[some], law),
        )
        index = index[coupling.order]
        problem = Problem(
            height=system.height[index],
            laws=system.laws.rows(index),
            coupling=coupling,
            contact_shift=system.contact_shift,
            elongation=None if elongation is None else elongation.rows(index),
            fitted=system.parameters.contact_shift,
        )
        others = np.ones(len(system), bool)
        others[index] = False
        left = system.by_height[others[system.by_height]]
        return cls(
            system=system,
            problem=problem,
            index=index,
            others=left,
            offset=offset,
            paired=offset,
            moved=np.zeros_like(offset),
        )

    def lacks(
        self, field: SmoothField | None, separation: float, growth: float, allowed: float = 0.0
    ) -> bool:
        """Whether more than `allowed` summits that overlap are no candidates; other arguments are
        those of `of`."""
        if not len(self.others):
            return False
        _, overlap = _overlaps(self.system, self.others, field, separation, growth)
        return bool(np.count_nonzero(overlap > 0) > allowed)

    def recentred(
        self, rows: Index, values: CandidateValues, tolerance: float
    ) -> CandidateList | None:
        """The list with each point moved to the centre of its contact, as the laws give it at the
        `values` of the summits `rows`.

        Returns the list itself if the points are near enough to the centres for the `tolerance`;
        None if a new list is needed: the footprints have outgrown the near pairs, or the points
        are too far from the centres even after they moved as far as the near pairs allow. A few of
        many contacts may leap farther, to another top of their basin: they do not call for a new
        list, which would be as wrong when they leap back.
        """
        system = self.system
        if not system.has_centres:
            return self
        touches = np.flatnonzero(values.interference > 0)
        some = touches[:: 1 + len(touches) // SAMPLED_CONTACTS]
        laws = system.laws.rows(rows[some])
        laws.make()
        sample = values.rows(some)
        law = laws(sample.interference)
        coupling = self.problem.coupling
        if not coupling.holds(_widest(system, rows[some], law)):
            return None
        many = min(1.0, len(touches) / MANY_CONTACTS)
        bound = max(LARGEST_FIELD_ERROR, many * ERROR_PER_TOLERANCE * tolerance)
        seen = bound, rows[some], law, sample
        if not self._strayed(*seen):
            return self
        closed, approach = rows[touches], values.interference[touches]
        paired, skin = self.paired[:, closed], PAIR_LIST_SKIN * coupling.eta
        reach = system.table.centre_at(closed, approach) - paired
        far = (np.abs(reach) > skin).any(axis=0)
        leaping = values.force[touches[far]].sum()
        if leaping > many * LARGEST_LEAPING_LOAD * values.force.sum():
            return None
        change = np.zeros_like(self.offset)
        change[:, closed] = paired + np.clip(reach, -skin, skin) - self.offset[:, closed]
        if replace(self, offset=self.offset + change)._strayed(*seen):
            return None
        back = np.sum(change * self.moved, axis=0) < 0
        change[:, back] *= RETURNING_SHARE
        dx, dy = change[:, self.index]
        problem = replace(self.problem, coupling=coupling.moved(dy, dx))
        return replace(self, problem=problem, offset=self.offset + change, moved=change)

    def _strayed(
        self, bound: float, closed: Index, law: Evaluated, values: CandidateValues
    ) -> bool:
        """Whether points are too far from the centres of their contacts: by `LARGEST_DISTANCE` in
        the mean, or so that the tilt of the field over this distance changes the load by more than
        the share `bound`."""
        centre = self.system.table.centre_at(closed, values.interference)
        x, y = np.subtract(centre, self.offset[:, closed])
        along_y, along_x = values.tilt.T
        lower = np.sum(law.stiffness * (along_y * y + along_x * x))
        astray = np.hypot(x, y) - LARGEST_DISTANCE * np.sqrt(law.area / np.pi)
        return bool(np.sum(law.force * astray) > 0.0 or abs(lower) > bound * law.force.sum())

    def areas(self, solution: Solution) -> Array:
        """Contact areas [m^2], shape (n,), with the growth (`widened`) of contacts that stand
        beside rough summits."""
        law, problem, table = solution.laws, self.problem, self.system.table
        depth = solution.approach
        rough = table.flags_at(self.index, depth) & np.uint8(Flag.BEYOND_RADIUS) > 0
        tilts = solution.tilt, problem.radii
        return widened(problem.coupling.footprints, law, depth, *tilts, rough, problem.fitted)


def _lowest(field: SmoothField | None, growth: float) -> float:
    """Lowest value [m] that the field may reach: zero or less."""
    return growth * (0.0 if field is None else field.lowest)


def _overlaps(
    system: ContactSystem,
    summits: Index,
    field: SmoothField | None,
    separation: float,
    growth: float,
) -> tuple[Index, Array]:
    """Those of the `summits`, sorted from the highest down, that may touch, and how far [m] each
    would overlap the flat in the smooth part of the last field."""
    low = _lowest(field, growth)
    rows = system.above(separation + 1.1 * low, summits)
    overlap = system.height[rows] - separation
    if field is None:
        return rows, overlap - 1.1 * low
    smooth = field.potential(system.y[rows], system.x[rows])
    return rows, overlap - np.minimum(smooth, growth * smooth)


def _widest(system: ContactSystem, closed: Index, law: Evaluated) -> float:
    """Variance [m^2] of the widest footprints of the contacts `closed` that the near pairs of a
    list allow for (`WIDEST_SHARE`)."""
    if not len(closed):
        return 0.0
    variance = system.footprints.variance(law.stiffness)
    if system.elongation is not None:
        along = system.elongation.rows(closed).along
        variance = variance * np.maximum(1.0, ELONGATED_SHARE * along)
    order = np.argsort(variance)
    load = np.cumsum(law.force[order])
    widest = float(variance[order[np.searchsorted(load, WIDEST_SHARE * load[-1])]])
    if system.boundary == "periodic":
        widest = min(widest, widest_in_cell(system.cell))
    return max(widest, float(variance[order[int(WIDEST_NUMBER * (len(order) - 1))]]))
