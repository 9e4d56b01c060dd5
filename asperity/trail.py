"""The way of a population from one state to the next."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .interaction.operator import Interaction
from .interaction.solver import Solution, descend
from .interaction.state import Problem
from .path import MEMORY, Point, forecast, weights
from .states import PopulationState

if TYPE_CHECKING:
    from .population import Population

__all__ = ["Trail"]

SPARE = 1.3
"""Listed summits over those that can touch now, so that lists last for several separations."""

DEEPER = 1.1
"""How much deeper the field may be at the next separation."""

NEW_LOAD = 1.05
"""The same where a load was asked for, which is mostly too far from the last for its lists."""

ROOM = 1.3
"""Approach over the present one for which the footprints of a list are meant."""

MAX_PLACED = 4
"""Times that the lists are made anew at one separation: deeper, or about moved contacts."""

STRAY = 0.03
"""Mean distance of contacts from their centres, over their radius, at which they may stay."""

BLIND = 0.1
"""Tolerance of the first solve of all, whose lists and centres are guessed."""

MAX_SEARCH = 40
"""Separations tried to reach a mean pressure."""

SEARCH_TOLERANCE = 5e-3
"""Tolerance of a solve on the way to a mean pressure."""


@dataclass(frozen=True, eq=False)
class Trail:
    """The last points, and the lists made for them."""

    population: Population
    problem: Problem | None = None
    index: NDArray[np.int64] | None = None
    listed: NDArray[np.bool_] | None = None
    field: Interaction | None = None
    lowest: float = 0.0
    points: tuple[Point, ...] = ()
    offset: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    compliance: NDArray[np.float64] | None = None

    def at(
        self, separation: float, tolerance: float, pressure: float | None = None
    ) -> PopulationState:
        """State at a separation, or at a mean pressure with a first guess of its separation."""
        population = self.population
        if not population.interaction:
            return self._independent(separation)
        trail, steps, products = self, 0, 0
        load = None if pressure is None else pressure * population.nominal_area
        start = np.zeros((len(population), 3))
        if self.points:
            start = forecast(self.points, separation)
            if len(self.points) == 1 and self.compliance is not None:
                fall = self.points[0].separation - separation
                start[:, 0] += np.where(start[:, 0] > 0, self.compliance * fall, 0.0)
        else:
            start[:, 0] = 0.5 * (population.height - separation)
        guess, growth, spare = np.maximum(start[:, 0], 0.0), DEEPER, SPARE
        if pressure is not None and self.points and self.points[-1].pressure > 0:
            growth, spare = max(1.0, pressure / self.points[-1].pressure), NEW_LOAD
        for placed in range(MAX_PLACED + 1):
            blind = not self.points and placed == 0
            trail = trail._placed(guess)
            trail = trail._listing(separation, guess, growth, spare)
            assert trail.problem is not None and trail.index is not None
            shares = 1.0 if trail.compliance is None else trail.compliance[trail.index]
            for problem in trail.problem.simpler():
                solution = descend(
                    problem,
                    separation,
                    guess[trail.index],
                    tilt=start[trail.index, 1:],
                    tolerance=max(tolerance, BLIND) if blind else tolerance,
                    load=load,
                    compliance=shares,
                )
                if not solution.reason:
                    break
            separation, lowest = solution.separation, trail.problem.plan.lowest
            steps, products = steps + solution.steps, products + solution.products
            guess, start[:] = np.zeros(len(population)), 0.0
            guess[trail.index], start[trail.index, 1:] = solution.approach, solution.tilt
            trail = replace(trail, field=trail.problem.plan, lowest=lowest)
            if solution.reason or placed == MAX_PLACED:
                break
            if not (blind or trail._strayed(guess) or trail._missed(separation, 1.0)):
                break
            growth = 1.0
        return trail._state(solution, steps, products)

    def _placed(self, approach: NDArray[np.float64]) -> Trail:
        """The contacts at the centres that their laws give at these approaches."""
        population = self.population
        if not population.centred:
            return self
        if self.problem is not None and not self._strayed(approach):
            return self
        rows = np.flatnonzero(approach > 0)
        x, y = np.zeros((2, len(population)))
        x[rows], y[rows] = population.table.centre_at(rows, approach[rows])
        return replace(self, offset=(x, y), problem=None)

    def _strayed(self, approach: NDArray[np.float64]) -> bool:
        """Whether contacts are too far from the centres of their laws for the lists to hold."""
        if self.offset is None:
            return self.population.centred
        rows = np.flatnonzero(approach > 0)
        law = self.population.laws.rows(rows)(approach[rows])
        x, y = self.population.table.centre_at(rows, approach[rows])
        away = law.force * np.hypot(x - self.offset[0][rows], y - self.offset[1][rows])
        return bool(away.sum() > STRAY * (law.force * np.sqrt(law.area / np.pi)).sum())

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
        return found if found.converged else self._search(pressure, tolerance, state)

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
        for _ in range(MAX_SEARCH):
            if not state.converged:
                return state
            error = math.log(state.mean_pressure / pressure) if state.mean_pressure > 0 else -1e3
            if abs(error) <= 0.5 * tolerance and state.residual <= tolerance:
                return state
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
        reason = f"{MAX_SEARCH} separations did not bring the mean pressure to {pressure:g} Pa"
        return replace(state, converged=False, reason=reason)

    def _independent_separation(self, pressure: float) -> float:
        """Separation at which independent contacts would carry the pressure, within a few %."""
        population = self.population
        falling = population.height[population.falling]
        high = float(falling[0])
        width = 0.01 * float(np.ptp(population.height)) or 0.01 * abs(high)

        def carried(separation: float) -> float:
            above = population.falling[: np.searchsorted(-falling, -separation)]
            laws = population.laws.rows(above)(population.height[above] - separation)
            return float(laws.force.sum()) / population.nominal_area

        low = high - width
        while carried(low) < pressure:
            high, width = low, 2 * width
            low = high - width
        for _ in range(12):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if carried(middle) > pressure else (low, middle)
        return 0.5 * (low + high)

    def _candidates(
        self, separation: float, growth: float
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Summits that may touch, and how far [m] they overlap the plane in the smooth part of the
        last field; `growth` is how much deeper the field may become where it is negative."""
        population = self.population
        height = population.height[population.falling]
        low = growth * self.lowest
        end = np.searchsorted(-height, -(separation + 1.1 * low))
        rows = population.falling[:end]
        if self.field is None:
            return rows, height[:end] - separation - 1.1 * low
        field = self.field.potential(*self._places(rows))
        return rows, height[:end] - separation - np.minimum(field, growth * field)

    def _missed(self, separation: float, growth: float) -> bool:
        """Whether a summit that is not listed may touch."""
        assert self.listed is not None
        rows, overlap = self._candidates(separation, growth)
        return bool((~self.listed[rows] & (overlap > 0)).any())

    def _listing(
        self, separation: float, guess: NDArray[np.float64], growth: float, spare: float
    ) -> Trail:
        """Lists that hold every summit that the field can bring to touch."""
        if self.problem is not None and not self._missed(separation, growth):
            return self
        population = self.population
        rows, overlap = self._candidates(separation, growth)
        overlap[guess[rows] > 0] = np.inf
        touching = int(np.count_nonzero(overlap > 0.1 * growth * self.lowest))
        count = int(spare * touching) + 40
        if count < len(rows):
            index = rows[np.argpartition(-overlap, count)[:count]]
        else:
            index = population.falling[: max(len(rows), count)]
        closed = index[guess[index] > 0]
        law = population.laws.rows(closed)(ROOM * guess[closed])
        variance = population.footprints.variance(law.stiffness)
        plan = Interaction(
            *self._places(index),
            population.cell,
            population.boundary,
            population.footprints,
            widest=float(np.quantile(variance, 0.98)) if len(closed) else 0.0,
        )
        index = index[plan.order]
        listed = np.zeros(len(population), bool)
        listed[index] = True
        problem = Problem(
            population.height[index],
            population.laws.rows(index),
            plan,
            population.deflection,
            None if population.elongation is None else population.elongation.rows(index),
        )
        return replace(self, problem=problem, index=index, listed=listed)

    def _places(self, rows: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Places y, x [m] of contacts, about their centres as far as these are known."""
        y, x = self.population.y[rows], self.population.x[rows]
        if self.offset is None:
            return y, x
        return y + self.offset[1][rows], x + self.offset[0][rows]

    def _state(self, solution: Solution, steps: int, products: int) -> PopulationState:
        assert self.index is not None
        population = self.population
        n = len(population)
        approach, force, stiffness, area = np.zeros((4, n))
        approach[self.index] = solution.approach
        force[self.index] = solution.laws.force
        stiffness[self.index] = solution.laws.stiffness
        area[self.index] = solution.laws.area
        closed = solution.approach > 0
        values = np.full((n, 3), np.nan)
        values[self.index, 0] = np.where(
            closed, solution.approach, np.minimum(solution.wanted, 0.0)
        )
        values[self.index, 1:] = solution.tilt
        pressure = float(solution.laws.force.sum()) / population.nominal_area
        point = Point(solution.separation, pressure, values)
        compliance = np.ones(n)
        compliance[self.index] = solution.shares
        trail = replace(self, points=(*self.points[1 - MEMORY :], point), compliance=compliance)
        return trail._pack(approach, force, stiffness, area, solution, steps, products)

    def _independent(self, separation: float) -> PopulationState:
        population = self.population
        approach = np.maximum(population.height - separation, 0.0)
        laws = population.laws(approach)
        still = np.zeros((len(approach), 2))
        slope = float(laws.stiffness.sum())
        done = Solution(separation, approach, approach, laws, still, 0.0, 0, 0, "", slope)
        trail = replace(self, listed=None, problem=None)
        return trail._pack(approach, laws.force, laws.stiffness, laws.area, done, 0, 0)

    def _pack(
        self,
        approach: NDArray[np.float64],
        force: NDArray[np.float64],
        stiffness: NDArray[np.float64],
        area: NDArray[np.float64],
        solution: Solution,
        steps: int,
        products: int,
    ) -> PopulationState:
        population = self.population
        laws = population.laws if self.problem is None else self.problem.laws
        load = float(force.sum())
        filled = float(solution.laws.force[laws.filled(solution.laws)].sum())
        return PopulationState(
            separation=solution.separation,
            approach=approach,
            force=force,
            stiffness=stiffness,
            area=area,
            mean_pressure=load / population.nominal_area,
            contact_area=float(area.sum()),
            active=int(np.count_nonzero(approach)),
            filled_share=filled / load if load > 0 else 0.0,
            residual=solution.residual,
            converged=not solution.reason,
            reason=solution.reason,
            iterations=steps,
            products=products,
            normal_stiffness=solution.slope / population.nominal_area,
            lowest_candidate=solution.separation + 1.1 * self.lowest,
            _trail=self,
        )
