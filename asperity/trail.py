"""States of a population, and the way from one to the next."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .interaction.laws import Evaluated
from .interaction.operator import Interaction
from .interaction.solver import Solution, conjugate_gradients, descend
from .interaction.state import Problem
from .interaction.tangent import Tangent

if TYPE_CHECKING:
    from .population import Population

__all__ = ["PopulationState", "Trail"]

SPARE = 1.35
"""Listed summits over those that can touch now, so that lists last for several separations."""

MAX_PLACED = 4
"""Times that the lists are made anew at one separation: deeper, or about moved contacts."""

STRAY = 0.03
"""Mean distance of contacts from their centres, over their radius, at which they may stay."""

MAX_SEARCH = 40
"""Separations tried to reach a mean pressure."""

SEARCH_TOLERANCE = 5e-3
"""Tolerance of a solve on the way to a mean pressure."""

FEW = 64
"""Laws that suffice to know the size of the footprints."""


@dataclass(frozen=True, eq=False)
class PopulationState:
    """Contacts of a population at one separation.

    Attributes
    ----------
    separation
        Distance of the rigid flat from the mean plane [m]: of the deformed surface for a periodic
        cell (mean gap), of the surface at rest for a free half-space.
    approach, force, stiffness, area
        Of each summit [m], [N], [N/m], [m^2], shape (n,); zero where it is open.
    mean_pressure
        Load over nominal area [Pa].
    contact_area
        Sum of the contact areas [m^2].
    active
        Number of closed contacts.
    filled_share
        Share of the load on contacts that cover more than half of their basin [-].
    residual
        Upper estimate of the relative error of the load by incomplete solution [-].
    converged, reason
        Whether the point can be used, and one sentence if it cannot.
    iterations, products
        Newton steps and applications of the interaction.
    lowest_candidate
        Height [m] above which a summit can touch in the field of the others.
    """

    separation: float
    approach: NDArray[np.float64]
    force: NDArray[np.float64]
    stiffness: NDArray[np.float64]
    area: NDArray[np.float64]
    mean_pressure: float
    contact_area: float
    active: int
    filled_share: float
    residual: float
    converged: bool
    reason: str
    iterations: int
    products: int
    lowest_candidate: float
    _trail: Trail = field(repr=False)

    @functools.cached_property
    def normal_stiffness(self) -> float:
        """Minus the slope of mean pressure over separation [Pa/m], by the tangent matrix."""
        return self._trail.stiffness(self.approach)


@dataclass(frozen=True, eq=False)
class Trail:
    """The last two separations and approaches, and the lists made for them."""

    population: Population
    problem: Problem | None = None
    index: NDArray[np.int64] | None = None
    listed: float = math.inf
    lowest: float = 0.0
    points: tuple[tuple[float, NDArray[np.float64], NDArray[np.float64]], ...] = ()
    offset: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None

    def at(self, separation: float, tolerance: float) -> PopulationState:
        """State at a separation."""
        population = self.population
        if not population.interaction:
            return self._independent(separation)
        trail, steps, products = self, 0, 0
        guess, shift = self._predict(separation)
        for placed in range(MAX_PLACED + 1):
            trail = trail._placed(guess)
            trail = trail._listing(separation)
            assert trail.problem is not None and trail.index is not None
            solution = descend(
                trail.problem,
                separation,
                guess[trail.index],
                shift=shift[trail.index],
                tolerance=tolerance,
            )
            lowest = trail.problem.plan.lowest
            steps, products = steps + solution.steps, products + solution.products
            guess, shift = np.zeros((2, len(population)))
            guess[trail.index], shift[trail.index] = solution.approach, solution.shift
            trail = replace(trail, lowest=lowest)
            if solution.reason or placed == MAX_PLACED:
                break
            away = trail._away(trail.index, solution.approach, solution.laws)
            if separation + lowest >= trail.listed and away <= STRAY:
                break
        return trail._state(separation, solution, steps, products)

    def _placed(self, approach: NDArray[np.float64]) -> Trail:
        """The contacts at the centres that their laws give at these approaches."""
        population = self.population
        if not population.centred:
            return self
        rows = np.flatnonzero(approach > 0)
        laws = population.laws.rows(rows)(approach[rows])
        if self.problem is not None and self._away(rows, approach[rows], laws) <= STRAY:
            return self
        x, y = np.zeros((2, len(population)))
        x[rows], y[rows] = population.table.centre_at(rows, approach[rows])
        return replace(self, offset=(x, y), problem=None)

    def _away(
        self, rows: NDArray[np.int64], approach: NDArray[np.float64], laws: Evaluated
    ) -> float:
        """Mean distance of contacts from the centres of their laws over their radius."""
        if self.offset is None:
            return 0.0
        x, y = self.population.table.centre_at(rows, approach)
        away = np.hypot(x - self.offset[0][rows], y - self.offset[1][rows])
        radius = np.sqrt(laws.area / np.pi)
        return float(laws.force @ away) / max(float(laws.force @ radius), 1e-300)

    def under(
        self, pressure: float, tolerance: float, state: PopulationState | None
    ) -> PopulationState:
        """State at a mean pressure: safeguarded Newton iteration for its logarithm."""
        population = self.population
        top = float(population.height[population.falling[0]])
        if pressure == 0:
            return self.at(top, tolerance)
        low, high, step = -math.inf, top, 0.1 * float(np.ptp(population.height)) or 0.1 * abs(top)
        if state is None or not state.mean_pressure > 0:
            state = self.at(self._independent_separation(pressure), tolerance)
        anchor = state._trail.points[-1:]
        for _ in range(MAX_SEARCH):
            if not state.converged:
                return state
            error = math.log(state.mean_pressure / pressure) if state.mean_pressure > 0 else -1e3
            if abs(error) <= 0.5 * tolerance and state.residual <= tolerance:
                return replace(state, _trail=state._trail._anchored(anchor))
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

    def _anchored(
        self, anchor: tuple[tuple[float, NDArray[np.float64], NDArray[np.float64]], ...]
    ) -> Trail:
        """The same trail with the start of the search as the point before the last."""
        if not anchor or not self.points or anchor[0][0] == self.points[-1][0]:
            return self
        return replace(self, points=(anchor[0], self.points[-1]))

    def stiffness(self, approach: NDArray[np.float64]) -> float:
        """Minus the slope of mean pressure over separation [Pa/m] at the state just reached."""
        population = self.population
        if self.problem is None or self.index is None:
            total = float(population.laws(approach).stiffness.sum())
            return total / population.nominal_area
        own = approach[self.index]
        if not own.any():
            return 0.0
        tangent = Tangent(self.problem.plan, own > 0, self.problem.laws(own).stiffness)
        change, _ = conjugate_gradients(tangent, np.ones(len(tangent)), tolerance=0.01)
        return float(change.sum()) / population.nominal_area

    def _independent_separation(self, pressure: float) -> float:
        """Separation at which independent contacts would carry the pressure, within a few %."""
        population = self.population
        high = float(population.height[population.falling[0]])
        width = 0.1 * float(np.ptp(population.height)) or 0.1 * abs(high)

        def carried(separation: float) -> float:
            laws = population.laws(population.height - separation)
            return float(laws.force.sum()) / population.nominal_area

        low = high - width
        while carried(low) < pressure:
            high, width = low, 2 * width
            low = high - width
        for _ in range(12):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if carried(middle) > pressure else (low, middle)
        return 0.5 * (low + high)

    def _listing(self, separation: float) -> Trail:
        """Lists that hold every summit that the field can bring to touch."""
        needed = separation + 1.1 * self.lowest
        if self.problem is not None and needed >= self.listed:
            return self
        population = self.population
        height = population.height[population.falling]
        touching = int(np.searchsorted(-height, -needed))
        count = min(len(height), int(SPARE * touching) + 40)
        end = min(needed, float(height[-1]))
        listed = float(height[count]) if count < len(height) else end - (float(height[0]) - end)
        index = population.falling[:count]
        x, y = population.x[index], population.y[index]
        if self.offset is not None:
            x, y = x + self.offset[0][index], y + self.offset[1][index]
        plan = Interaction(
            y,
            x,
            population.cell,
            population.boundary,
            population.footprints,
            widest=self._widest(index, listed),
        )
        index = index[plan.order]
        problem = Problem(
            population.height[index], population.laws.rows(index), plan, population.deflection
        )
        return replace(self, problem=problem, index=index, listed=listed)

    def _widest(self, index: NDArray[np.int64], listed: float) -> float:
        """Variance [m^2] that few footprints will exceed before the summits are listed again."""
        population = self.population
        ready = index[population.laws.ready[index]]
        ready = ready if len(ready) >= FEW else index[:FEW]
        bound = population.laws.rows(ready)(population.height[ready] - listed)
        return float(np.quantile(population.footprints.variance(bound.stiffness), 0.98))

    def _predict(self, separation: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Approaches and deflections extrapolated from the last two separations."""
        population = self.population
        if not self.points:
            start = np.maximum(0.5 * (population.height - separation), 0.0)
            return start, np.zeros(len(population))
        here, now, shift = self.points[-1]
        there, before, old = self.points[0]
        ratio = 0.0 if here == there else (separation - here) / (here - there)
        ratio = min(max(ratio, -1.5), 1.5)
        known = np.isfinite(before) & np.isfinite(now)
        rate = np.where(known, now - np.where(known, before, 0.0), 0.0)
        guess = np.where(np.isfinite(now), now, 0.0) + ratio * rate
        return np.maximum(guess, 0.0), shift + ratio * np.where(known, shift - old, 0.0)

    def _state(
        self, separation: float, solution: Solution, steps: int, products: int
    ) -> PopulationState:
        assert self.index is not None
        population = self.population
        n = len(population)
        approach, force, stiffness, area = np.zeros((4, n))
        approach[self.index] = solution.approach
        force[self.index] = solution.laws.force
        stiffness[self.index] = solution.laws.stiffness
        area[self.index] = solution.laws.area
        signed = np.full(n, -np.inf)
        signed[self.index] = np.where(
            solution.approach > 0, solution.approach, np.minimum(solution.wanted, 0.0)
        )
        shift = np.zeros(n)
        shift[self.index] = solution.shift
        trail = replace(self, points=(*self.points[-1:], (separation, signed, shift)))
        return trail._pack(separation, approach, force, stiffness, area, solution, steps, products)

    def _independent(self, separation: float) -> PopulationState:
        population = self.population
        approach = np.maximum(population.height - separation, 0.0)
        laws = population.laws(approach)
        done = Solution(approach, approach, laws, np.zeros(len(approach)), 0.0, 0, 0, "")
        trail = replace(self, listed=-math.inf, problem=None)
        return trail._pack(separation, approach, laws.force, laws.stiffness, laws.area, done, 0, 0)

    def _pack(
        self,
        separation: float,
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
            separation=separation,
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
            lowest_candidate=separation + 1.1 * self.lowest,
            _trail=self,
        )
