"""A second decomposition with more waves, for loads that contacts of few fine waves carry."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

from asperity.multiscale.surface_point import refinement_weight

from .decomposition import Decomposition
from .plan import Plan, refined_plan

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.interaction.population import PopulationState
    from surfaces.heightmap import HeightMap

__all__ = ["RefinedState", "Refinement"]

TOLERANCE = 4e-3
"""Bound on the residual of a load on refined contacts, which are few."""


@dataclass(frozen=True, eq=False)
class RefinedState:
    """A load on the contacts of a decomposition that keeps more waves for them.

    Attributes
    ----------
    decomposition, state
        The refined decomposition, and its contacts under the load.
    weight
        How much they count: 1 where few fine waves lie under the contacts, towards 0 where many do.
    """

    decomposition: Decomposition
    state: PopulationState
    weight: float


class Refinement:
    """Solves loads on refined contacts where fine waves do not average out under the others.

    Parameters
    ----------
    hm, material, plan
        What the decomposition that is refined was made from.

    Notes
    -----
    The refined decomposition is made when it is first needed, of the whole map where contacts come
    near the height below which nothing was segmented.
    """

    def __init__(self, hm: HeightMap, material: HalfSpace, plan: Plan) -> None:
        self.hm, self.material, self.plan = hm, material, plan
        self._refined: Decomposition | None = None

    def solve(self, state: PopulationState, last: RefinedState | None) -> RefinedState | None:
        """The load of a state on refined contacts; None where these would tell nothing new.

        Parameters
        ----------
        state
            Contacts of the decomposition that is refined.
        last
            A refined state of a near load, to start from.
        """
        law = self.plan.sub_contact_law
        weight = (
            0.0 if law is None else refinement_weight(law, state, self.plan.parameters.refinement)
        )
        if weight == 0.0 or self._plan is None:
            return None
        if self._refined is None:
            self._refined = Decomposition.of(self.hm, self.material, self._plan)
        near = last is not None and last.decomposition is self._refined
        found = self._solved(state.mean_pressure, last.state if last and near else None)
        if not self._refined.deep_enough(found):
            self._refined = self._refined.of_whole_map()
            found = self._solved(state.mean_pressure, None)
        return RefinedState(self._refined, found, weight) if found.converged else None

    @functools.cached_property
    def _plan(self) -> Plan | None:
        return refined_plan(self.plan)

    def _solved(self, pressure: float, start: PopulationState | None) -> PopulationState:
        assert self._refined is not None
        population = self._refined.population
        return population.solve(mean_pressure=pressure, state=start, tolerance=TOLERANCE)
