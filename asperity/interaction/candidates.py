"""Lists of the summits that may touch at a separation, where they stand then, and their plan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.flags import Flag
from asperity.interaction.ewald.operator import Interaction
from asperity.interaction.newton.contact_shift import widened
from asperity.interaction.newton.problem import Problem

if TYPE_CHECKING:
    from asperity.interaction.newton.final_step import Solution
    from asperity.interaction.newton.laws import Evaluated

    from .elongation import Elongation
    from .footprint import Footprints
    from .population import Population

__all__ = ["Candidates", "Falling", "Listing"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

ROOM = 1.3
"""Approach over the present one for which the footprints of a list are meant."""

SAMPLE = 1000
"""Contacts of which the widest footprint and the mean distance are estimated."""

LONG = 0.5
"""Share of the moment along a footprint for which lists are meant, where it exceeds the round one:
beyond the near pairs footprints are round. With lay of 4:1 the load at 25 % of contact hangs on the
list by 0.6 %, with 6:1 by 0.3 % (by 5 and 18 % if meant for round ones; seed 1)."""

STRAY = 0.06
"""Mean distance of contacts from their centres, over their radius, at which they may stay."""

SKIN = 0.15
"""Distance from where the near pairs were listed, over the split length, that points may reach."""

ASTRAY = 1e-3
"""Share of the load that their distance from their centres may make in the slope of the field."""

MANY = 5000
"""Closed contacts from which on the two bounds below hold; for fewer they are proportionally
smaller, as one that leaps counts more."""

ALLOWED = 0.1
"""Part of the tolerance that this error of the load may be, no less than `ASTRAY`."""

LEAPING = 0.02
"""Share of the load in contacts that leap farther than the skin beyond which lists are made for
their new places."""


class Falling(NamedTuple):
    """Summits from the highest down.

    Attributes
    ----------
    rows
        Summits, shape (n,).
    y, x, depth
        Their places and minus their heights [m], shape (n,).
    """

    rows: Rows
    y: Array
    x: Array
    depth: Array

    def without(self, some: Rows) -> Falling:
        """All but `some` summits."""
        beside = np.ones(int(self.rows.max(initial=-1)) + 1, bool)
        beside[some] = False
        left = np.flatnonzero(beside[self.rows])
        return Falling(self.rows[left], self.y[left], self.x[left], self.depth[left])


@dataclass(frozen=True, eq=False)
class Candidates:
    """Summits that may touch.

    Attributes
    ----------
    rows
        Summits, shape (n,).
    overlap
        How far [m] they overlap the plane in the smooth part of the last field, shape (n,).
    low
        How low [m] the field may be.
    """

    rows: Rows
    overlap: Array
    low: float

    @classmethod
    def of(
        cls,
        summits: Falling,
        field: Interaction | None,
        separation: float,
        growth: float,
    ) -> Candidates:
        """At a separation; `growth` is how much deeper the field can be where it is negative."""
        rows, y, x, depth = summits
        low = growth * (0.0 if field is None else field.lowest)
        end = depth.searchsorted(-(separation + 1.1 * low))
        rows, overlap = rows[:end], -separation - depth[:end]
        if field is None:
            return cls(rows, overlap - 1.1 * low, low)
        smooth = field.potential(y[:end], x[:end])
        return cls(rows, overlap - np.minimum(smooth, growth * smooth), low)


@dataclass(frozen=True, eq=False)
class Listing:
    """Summits that may touch, in the order of their plan.

    Attributes
    ----------
    problem
        Their laws and their interaction.
    index
        Summits, shape (n,).
    others
        The other summits.
    offset
        Places x, y [m] of all contacts less those of their summits, shape (2, all).
    listed
        The same when the near pairs were listed.
    """

    problem: Problem
    index: Rows
    others: Falling
    offset: Array
    listed: Array

    @classmethod
    def of(
        cls,
        population: Population,
        candidates: Candidates,
        closed: Rows,
        approach: Array,
        spare: float,
        rounded: bool = False,
    ) -> Listing:
        """Of the candidates that overlap, and of `spare` times as many, at least those closed with
        an approach [m]; with round footprints if they are `rounded`."""
        elongation = None if rounded else population.elongation
        rows, overlap = candidates.rows, candidates.overlap
        touches = np.zeros(len(population), bool)
        touches[closed] = True
        overlap = np.where(touches[rows], np.inf, overlap)
        count = int(spare * int(np.count_nonzero(overlap > 0.1 * candidates.low))) + 40
        if count < len(rows):
            index = rows[np.argpartition(-overlap, count)[:count]]
        else:
            index = population.falling[: max(len(rows), count)]
        population.laws.rows(closed).make()
        offset = np.zeros((2, len(population)))
        if population.centred:
            offset[:, closed] = population.table.centre_at(closed, approach)
        dx, dy = offset[:, index]
        some = slice(None, None, 1 + len(closed) // SAMPLE)
        law = population.laws.rows(closed[some])(ROOM * approach[some])
        plan = Interaction(
            population.y[index] + dy,
            population.x[index] + dx,
            population.cell,
            population.boundary,
            population.footprints,
            widest=_widest(population.footprints, elongation, closed[some], law),
        )
        index = index[plan.order]
        problem = Problem(
            population.height[index],
            population.laws.rows(index),
            plan,
            population.deflection,
            None if elongation is None else elongation.rows(index),
        )
        return cls(problem, index, population.fallen.without(index), offset, offset)

    def lacks(
        self, field: Interaction | None, separation: float, growth: float, some: float = 0.0
    ) -> bool:
        """Whether more than `some` candidates that overlap are not listed; arguments as those of
        `Candidates.of`."""
        if not len(self.others.rows):
            return False
        missing = Candidates.of(self.others, field, separation, growth)
        return bool(np.count_nonzero(missing.overlap > 0) > some)

    def about(
        self, population: Population, rows: Rows, values: Array, tolerance: float
    ) -> Listing | None:
        """The list with its points moved to the centres of the laws, if they are too far from them
        at the `Point.values` of the summits `rows` for a `tolerance`, otherwise itself; None if the
        footprints have outgrown its plan, or points are too far from their centres where they may
        stand. Of many contacts few leap so far, to another top of their basin, and a list made for
        their last place would be as wrong when they leap back."""
        if not population.centred:
            return self
        touches = np.flatnonzero(values[0] > 0)
        some = touches[:: 1 + len(touches) // SAMPLE]
        law = population.laws.rows(rows[some])(values[0, some])
        elongation = None if self.problem.elongation is None else population.elongation
        plan = self.problem.plan
        if not plan.holds(_widest(plan.footprints, elongation, rows[some], law)):
            return None
        many = min(1.0, len(touches) / MANY)
        bound = max(ASTRAY, many * ALLOWED * tolerance)
        seen = bound, rows[some], law, *values[[0, 2, 3]][:, some]
        if not self._strayed(population, *seen):
            return self
        closed, approach = rows[touches], values[0, touches]
        offset, skin = self.offset.copy(), SKIN * plan.eta
        reach = population.table.centre_at(closed, approach) - self.listed[:, closed]
        far = (np.abs(reach) > skin).any(axis=0)
        if values[1, touches[far]].sum() > many * LEAPING * values[1].sum():
            return None
        offset[:, closed] = self.listed[:, closed] + np.clip(reach, -skin, skin)
        dx, dy = (offset - self.offset)[:, self.index]
        problem = replace(self.problem, plan=plan.moved(dy, dx))
        moved = replace(self, problem=problem, offset=offset)
        return None if moved._strayed(population, *seen) else moved

    def _strayed(
        self,
        population: Population,
        bound: float,
        closed: Rows,
        law: Evaluated,
        approach: Array,
        *tilt: Array,
    ) -> bool:
        """Whether contacts are too far from the centres of their laws for the plan to hold, or make
        more than the share `bound` of the load in the slope of the field."""
        centre = population.table.centre_at(closed, approach)
        x, y = np.subtract(centre, self.offset[:, closed])
        lower = np.sum(law.stiffness * (tilt[0] * y + tilt[1] * x))
        astray = np.hypot(x, y) - STRAY * np.sqrt(law.area / np.pi)
        return bool(np.sum(law.force * astray) > 0.0 or abs(lower) > bound * law.force.sum())

    def areas(self, population: Population, solution: Solution) -> Array:
        """Contact areas [m^2], wider where contacts stand beside rough summits, shape (n,)."""
        law, problem, table = solution.laws, self.problem, population.table
        if not (problem.deflects and hasattr(table, "flags_at")):
            return law.area
        depth = solution.approach
        rough = table.flags_at(self.index, depth) & np.uint8(Flag.BEYOND_RADIUS) > 0
        tilts = solution.tilt, problem.lean
        return widened(problem.plan.footprints, law, depth, *tilts, rough)


def _widest(
    footprints: Footprints, elongation: Elongation | None, closed: Rows, law: Evaluated
) -> float:
    """Variance [m^2] that few footprints of the contacts `closed` exceed."""
    if not len(closed):
        return 0.0
    variance = footprints.variance(law.stiffness)
    if elongation is not None:
        along = elongation.rows(closed).along
        variance = variance * np.maximum(1.0, LONG * along)
    most = int(0.98 * (len(variance) - 1))
    return float(np.partition(variance, most)[most])
