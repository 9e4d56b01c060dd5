"""The way of a population from one state to the next."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.ewald.operator import Interaction
from asperity.interaction.newton.corrected_forecast import foreseen
from asperity.interaction.newton.final_step import Solution
from asperity.interaction.newton.laws import BLOCK
from asperity.interaction.newton.solver import descend

from .candidates import Candidates, Listing
from .population_state import PopulationState
from .predictor import MEMORY, Point, forecast, weights

if TYPE_CHECKING:
    from asperity.interaction.newton.problem import Problem

    from .population import Population

__all__ = ["Trail"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

SPARE = 1.5
"""Listed summits over those that can touch now, so that lists last for several separations."""

DEEPER = 1.1
"""How much deeper the field may be at the next separation."""

NEW_LOAD = 1.05
"""The same where a load was asked for, which is mostly too far from the last for its lists."""

MAX_PLACED = 4
"""Times that the lists are made anew at one separation: deeper, or about moved contacts."""

BLIND = 0.1
"""Tolerance of the first solve of all, whose lists and centres are guessed."""

LACKING = 0.05
"""Contacts that a list may lack after a solve, over the closed ones and the tolerance."""

CROWDED = 0.3
"""Contact area over nominal area beyond which a point that does not come out is refused."""

MAX_SEARCH = 40
"""Separations tried to reach a mean pressure."""

SEARCH_TOLERANCE = 5e-3
"""Tolerance of a solve on the way to a mean pressure."""

EXACT = 1e-6
"""Relative error of the load of independent contacts, for which a step costs no field."""

LEVEL = 1e-9
"""Rise of the flat under more load that rounding explains, over its fall since the first touch."""


def _listed(
    population: Population,
    rows: Rows,
    values: Array,
    field: Interaction | None,
    separation: float,
    growth: float,
    spare: float,
    rounded: bool,
) -> Listing:
    """Lists for a separation, about the `Point.values` of the summits `rows`."""
    closed = values[0] > 0
    near = Candidates.of(population.fallen, field, separation, growth)
    return Listing.of(population, near, rows[closed], values[0, closed], spare, rounded)


def _along(index: Rows, rows: Rows, values: Array, count: int) -> Array:
    """The `Point.values` of the summits `index`, of those known of `rows`, among `count` in all."""
    known = np.zeros((len(values), count))
    known[:, rows] = values
    return known.take(index, axis=1)  # row by row, as loops are compiled for


@dataclass(frozen=True, eq=False)
class Trail:
    """The last points, and the lists made for them."""

    population: Population
    listing: Listing | None = None
    field: Interaction | None = None
    points: tuple[Point, ...] = ()
    heaviest: tuple[float, float] | None = None

    def at(
        self, separation: float, tolerance: float, pressure: float | None = None
    ) -> PopulationState:
        """State at a separation, or at a mean pressure with a first guess of its separation."""
        population = self.population
        if not population.interaction:
            return self._independent(separation)
        load = None if pressure is None else pressure * population.nominal_area
        rows, values = self._start(separation, load)
        growth, spare = DEEPER, SPARE
        if pressure is not None and self.points and self.points[-1].pressure > 0:
            growth, spare = max(1.0, pressure / self.points[-1].pressure), NEW_LOAD
        listing = self.listing
        if listing is not None:
            lacks = listing.lacks(self.field, separation, growth)
            listing = None if lacks else listing.about(population, rows, values, tolerance)
        trail, good, steps, products = self, None, 0, 0
        blind, rounded = not self.points, False
        for placed in range(MAX_PLACED + 1):
            if listing is None:
                lists = trail.field, separation, growth, spare, rounded
                listing = _listed(population, rows, values, *lists)
            if rows is not listing.index:
                values = _along(listing.index, rows, values, len(population))
                rows = listing.index
            problem, approach = listing.problem, values[0]
            if load is None and placed == 0 and len(self.points) > 1:
                ahead, products = foreseen(problem, approach, values[1], tolerance=tolerance)
                approach = ahead if math.isfinite(float(ahead.sum())) else approach
            solve = functools.partial(
                self._solved, separation, load, approach, values, tolerance, blind
            )
            problem, solution = self._settled(solve, problem, rounding=good is None)
            steps, products = steps + solution.steps, products + solution.products
            if good is None and placed < MAX_PLACED and self._unsettled(problem, solution):
                listing, rounded = None, True
                continue
            if not solution.reason:
                listing = replace(listing, problem=problem)
            values = np.stack(
                (solution.wanted, solution.laws.force, *solution.tilt.T, solution.shares)
            )
            separation = solution.separation
            trail = replace(trail, listing=listing, field=listing.problem.plan)
            if solution.reason and good is not None:
                trail, solution, values = good  # whose contacts have hardly strayed
                break
            if solution.reason or placed == MAX_PLACED:
                break
            growth, last = 1.0, listing
            # those that only just touch carry less than their share of the load
            few = LACKING * tolerance * np.count_nonzero(values[0] > 0)
            lacks = listing.lacks(trail.field, separation, growth, few)
            again = not (lacks or blind)
            listing = listing.about(population, rows, values, tolerance) if again else None
            blind = False
            if listing is last:
                break
            good = None if listing is None else (trail, solution, values)
        if solution.reason and self._share(solution) > CROWDED:
            reason = (
                f"contacts fill {100 * self._share(solution):.0f} % of the nominal area and do not "
                f"settle ({solution.reason}): they are too crowded to be separate"
            )
            solution = replace(solution, reason=reason)
        return trail._state(solution, values, steps, products)

    def _solved(
        self,
        separation: float,
        load: float | None,
        approach: Array,
        values: Array,
        tolerance: float,
        blind: bool,
        problem: Problem,
    ) -> Solution:
        """What a problem comes to from approaches and the other `Point.values`, refused if it is
        out of order."""
        found = descend(
            problem,
            separation,
            approach,
            tilt=values[2:4].T,
            tolerance=max(tolerance, BLIND) if blind else tolerance,
            load=load,
            compliance=np.where(values[4] > 0, values[4], 1.0),
        )
        return self._ordered(found, tolerance)

    def _settled(
        self, solve: Callable[[Problem], Solution], problem: Problem, *, rounding: bool
    ) -> tuple[Problem, Solution]:
        """What a problem comes to; with `rounding`, if long footprints may have kept single
        contacts from settling, with round ones of these."""
        found = solve(problem)
        if not (rounding and self._unsettled(problem, found)) or found.restless is None:
            return problem, found
        problem = problem.rounded(found.restless)
        again = solve(problem)
        steps, products = found.steps + again.steps, found.products + again.products
        return problem, replace(again, steps=steps, products=products)

    def _unsettled(self, problem: Problem, solution: Solution) -> bool:
        """Whether long footprints, not the crowd, may be why a point did not come out."""
        return bool(
            solution.reason and problem.elongation is not None and self._share(solution) <= CROWDED
        )

    def _share(self, solution: Solution) -> float:
        """Contact area over nominal area."""
        return float(solution.laws.area.sum()) / self.population.nominal_area

    def _ordered(self, solution: Solution, tolerance: float) -> Solution:
        """The solution, refused if the flat would stand higher than under less load, as above no
        elastic body: footprints that overlap far can pass their load to each other until few
        contacts carry it."""
        load = solution.load / self.population.nominal_area
        if solution.reason or not load > 0:
            return solution
        top = float(self.population.height[self.population.falling[0]])
        for separation, pressure in ((top, 0.0), self.heaviest or (top, 0.0)):
            apart = abs(load - pressure) > 2 * tolerance * max(load, pressure)
            over = (solution.separation - separation) * (1 if load > pressure else -1)
            if apart and over > LEVEL * (top - separation):
                reason = (
                    f"at {load:.3g} Pa the flat would stand higher than under less load: the "
                    "contacts overlap too far to be separate"
                )
                return replace(solution, reason=reason)
        return solution

    def _start(self, separation: float, load: float | None) -> tuple[Rows, Array]:
        """Summits with something to start from, and `Point.values` of each."""
        population = self.population
        if self.points:
            # what differs from a line the contacts themselves put right, if they are not too far
            known = self.points if load is not None else self.points[-2:]
            return self.points[-1].rows, forecast(known, separation, len(population))
        rows = population.falling[: np.searchsorted(population.fallen.depth, -separation)]
        values = np.zeros((5, len(rows)))
        values[0] = 0.5 * (population.height[rows] - separation)
        return rows, values

    def under(
        self, pressure: float, tolerance: float, state: PopulationState | None
    ) -> PopulationState:
        """State at a mean pressure."""
        population = self.population
        if pressure == 0:
            return self.at(float(population.height[population.falling[0]]), tolerance)
        if not population.interaction:
            return self._search(pressure, tolerance, state)
        found = self.at(self._forecast(pressure, state), tolerance, pressure)
        if found.converged:
            return found
        if found.contact_area > CROWDED * population.nominal_area:
            return found
        searched = self._search(pressure, tolerance, state)
        return searched if searched.converged or searched.residual < found.residual else found

    def _forecast(self, pressure: float, state: PopulationState | None) -> float:
        """Separation [m] at a mean pressure, from the points solved before."""
        known = [point for point in self.points if point.pressure > 0]
        if not known or state is None:
            return self._independent_separation(pressure)
        if len(known) == 1:
            rise = math.log(pressure / known[0].pressure) * known[0].pressure
            return known[0].separation - rise / state.normal_stiffness
        place = [math.log(point.pressure) for point in known]
        share = weights(math.log(pressure), place)
        return float(np.dot(share, [point.separation for point in known]))

    def _search(
        self, pressure: float, tolerance: float, state: PopulationState | None
    ) -> PopulationState:
        """State at a mean pressure: safeguarded Newton iteration for its logarithm."""
        population = self.population
        top = float(population.height[population.falling[0]])
        low, high, step = -math.inf, top, 0.1 * float(np.ptp(population.height)) or 0.1 * abs(top)
        if state is None or not state.mean_pressure > 0:
            state = self.at(self._independent_separation(pressure), tolerance)
        bound = 0.5 * tolerance if population.interaction else EXACT
        best, least = state, math.inf
        for _ in range(MAX_SEARCH):
            if not state.converged:
                return state
            error = math.log(state.mean_pressure / pressure) if state.mean_pressure > 0 else -1e3
            if abs(error) < least and state.residual <= tolerance:
                best, least = state, abs(error)
            if least <= bound:
                return best
            here = state.separation
            # a rough pressure near the wanted one does not tell on which side it lies
            if abs(error) > 5 * state.residual:
                low, high = (here, high) if error > 0 else (low, min(high, here))
            guess = high - step
            if state.mean_pressure > 0:
                guess = here + error * state.mean_pressure / state.normal_stiffness
            if not low < guess < high:
                guess = 0.5 * (low + high) if math.isfinite(low) else high - step
            step *= 2
            # far from the pressure a rough solve shows the way
            rough = max(tolerance, SEARCH_TOLERANCE if abs(error) > 10 * SEARCH_TOLERANCE else 0.0)
            state = state._trail.at(guess, rough)
        if least <= 0.5 * tolerance:  # heights do not tell smaller loads apart
            return best
        reason = f"{MAX_SEARCH} separations did not bring the mean pressure to {pressure:g} Pa"
        return replace(state, converged=False, reason=reason)

    def _independent_separation(self, pressure: float) -> float:
        """Separation at which independent contacts would carry the pressure, within a few %."""
        population = self.population
        depth = population.fallen.depth
        population.laws.rows(population.falling[:BLOCK]).make()  # one by one they would cost more

        def carried(separation: float) -> float:
            above = population.falling[: np.searchsorted(depth, -separation)]
            laws = population.laws.rows(above)(-separation - depth[: len(above)])
            return float(laws.force.sum()) / population.nominal_area

        # by numbers of summits: one that stands out must not lead far down among the others
        high, end = -float(depth[0]), BLOCK
        width = 0.01 * float(np.ptp(population.height)) or 0.01 * abs(high)
        low = -float(depth[min(end, len(depth) - 1)])
        while carried(low) < pressure:
            high, end, width = low, 2 * end, 2 * width
            low = -float(depth[end]) if end < len(depth) else low - width
        for _ in range(8):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if carried(middle) > pressure else (low, middle)
        return 0.5 * (low + high)

    def _state(
        self, solution: Solution, values: Array, steps: int, products: int
    ) -> PopulationState:
        assert self.listing is not None
        index = self.listing.index
        pressure = solution.load / self.population.nominal_area
        point = Point(solution.separation, pressure, index, values)
        heaviest = self.heaviest
        if not solution.reason and (heaviest is None or pressure > heaviest[1]):
            heaviest = solution.separation, pressure
        trail = replace(self, points=(*self.points[1 - MEMORY :], point), heaviest=heaviest)
        area = self.listing.areas(self.population, solution)
        return trail._pack(index, area, solution, steps, products)

    def _independent(self, separation: float) -> PopulationState:
        population = self.population
        approach = np.maximum(population.height - separation, 0.0)
        laws = population.laws(approach)
        still, slope = np.zeros((len(approach), 2)), float(laws.stiffness.sum())
        shares = np.ones(len(approach))
        done = Solution(
            separation,
            approach,
            approach,
            laws,
            still,
            0.0,
            0,
            0,
            "",
            shares,
            lambda: (slope, shares),
        )
        trail = replace(self, listing=None)
        return trail._pack(np.arange(len(approach)), laws.area, done, 0, 0)

    def _pack(
        self, rows: Rows, area: Array, solution: Solution, steps: int, products: int
    ) -> PopulationState:
        population = self.population
        laws = population.laws if self.listing is None else self.listing.problem.laws
        law = solution.laws
        load = solution.load
        lowest = 0.0 if self.field is None else self.field.lowest
        filled = float(law.force[laws.filled(law)].sum())
        return PopulationState(
            separation=solution.separation,
            mean_pressure=load / population.nominal_area,
            contact_area=float(area.sum()),
            active=int(np.count_nonzero(law.force)),
            filled_share=filled / load if load > 0 else 0.0,
            residual=solution.residual,
            converged=not solution.reason,
            reason=solution.reason,
            iterations=steps,
            products=products,
            lowest_candidate=solution.separation + 1.1 * lowest,
            _trail=self,
            _rows=rows,
            _known=(solution.approach, law.force, law.stiffness, area),
            _answer=functools.partial(_per_area, solution.answer, population.nominal_area),
        )


def _per_area(answer: Callable[[], tuple[float, Array]], area: float) -> tuple[float, Array]:
    slope, shares = answer()
    return slope / area, shares
