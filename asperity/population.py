"""All summits of a surface under one plane: independent or elastically coupled."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError
from .interaction.footprint import Footprints
from .interaction.laws import Evaluated, Laws
from .interaction.operator import Interaction
from .interaction.solver import Solution, conjugate_gradients, descend
from .interaction.state import Problem
from .interaction.tangent import Tangent
from .microcontact.growing import GrowingTable

if TYPE_CHECKING:
    from .material import HalfSpace
    from .microcontact.table import LawTable

__all__ = ["Population", "PopulationState"]

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

LARGEST_AREA = 0.5
"""Contact area over nominal area beyond which separate contacts have lost their meaning."""


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
    _trail: _Trail = field(repr=False)

    @functools.cached_property
    def normal_stiffness(self) -> float:
        """Minus the slope of mean pressure over separation [Pa/m], by the tangent matrix."""
        return self._trail.stiffness(self.approach)


class Population:
    """Summits with their laws, their places and the body that couples them.

    Parameters
    ----------
    x, y
        Places of the summits [m], shape (n,).
    height
        Heights [m] above the mean plane of the map, shape (n,).
    table
        Contact laws of the summits, or a growing table that makes those that are needed.
    cell
        Nominal area (Ly, Lx) [m].
    boundary
        "periodic" or "free".
    material
        Elastic half-space.
    interaction
        False: the classical sum of independent contacts.
    deflection
        Whether coupled contacts stand at the centres that their laws give, and move aside under
        the slope of their neighbors' field; otherwise they stay at their summits.

    Raises
    ------
    InputError
        If lengths disagree or a value is not usable.

    Notes
    -----
    Contact i has the approach d_i = z_i - s - u_i. The displacement u_i by all other contacts (and
    by the images of its own force in a periodic cell) is taken over the footprint of the contact:
    `asperity.interaction` has the formulation.
    """

    def __init__(
        self,
        *,
        x: ArrayLike,
        y: ArrayLike,
        height: ArrayLike,
        table: LawTable | GrowingTable,
        cell: tuple[float, float],
        boundary: str,
        material: HalfSpace,
        interaction: bool = True,
        deflection: bool = True,
    ) -> None:
        self.x, self.y, self.height = (
            _column(value, name) for value, name in ((x, "x"), (y, "y"), (height, "height"))
        )
        rows = len(table) if isinstance(table, GrowingTable) else len(table.reach)
        if not len(self.x) == len(self.y) == len(self.height) == rows:
            raise InputError(
                f"x, y, height and table have {len(self.x)}, {len(self.y)}, {len(self.height)} "
                f"and {rows} rows; they must agree"
            )
        if len(self.x) == 0:
            raise InputError("the population has no summit; lower the height to segment above")
        if boundary not in ("periodic", "free"):
            raise InputError(f'boundary must be "periodic" or "free", got {boundary!r}')
        if not (len(cell) == 2 and min(cell) > 0 and math.isfinite(max(cell))):
            raise InputError(f"cell must be two positive lengths, got {cell!r}")
        self.boundary, self.material = boundary, material
        self._table = table
        self.cell = (float(cell[0]), float(cell[1]))
        self.interaction = interaction and (boundary == "periodic" or len(self.height) > 1)
        self.deflection = deflection
        self.footprints = Footprints(material.modulus, material.m)
        self.laws = Laws(table, self.footprints)
        usable = np.flatnonzero(self.laws.usable)
        if len(usable) == 0:
            raise InputError("no summit of the population has a usable contact law")
        self.falling = usable[np.argsort(-self.height[usable], kind="stable")]

    def __len__(self) -> int:
        return len(self.height)

    @property
    def table(self) -> LawTable:
        """Contact laws of the summits; of a growing table, those made so far."""
        return self._table.table if isinstance(self._table, GrowingTable) else self._table

    @property
    def centred(self) -> bool:
        """Whether contacts stand at the centres that their laws give."""
        return self.deflection and getattr(self.table, "centre", None) is not None

    @property
    def nominal_area(self) -> float:
        """Area of the cell [m^2]."""
        return self.cell[0] * self.cell[1]

    def solve(
        self,
        *,
        separation: float | None = None,
        mean_pressure: float | None = None,
        state: PopulationState | None = None,
        tolerance: float = 1e-3,
    ) -> PopulationState:
        """Contacts at a separation or at a mean pressure.

        Parameters
        ----------
        separation
            Distance of the flat from the mean plane [m].
        mean_pressure
            Load over nominal area [Pa], in place of the separation.
        state
            A state of this population at a near separation, to start from.
        tolerance
            Bound on the residual, and on the relative error of the mean pressure.

        Returns
        -------
        PopulationState
            Marked as not converged, with the reason, where the solve failed or the contacts fill
            more of the nominal area than the model can describe.
        """
        if (separation is None) == (mean_pressure is None):
            raise InputError("give either separation or mean_pressure")
        if not tolerance > 0:
            raise InputError(f"tolerance must be positive, got {tolerance!r}")
        trail = _Trail(self) if state is None else state._trail
        if separation is not None:
            return self._judged(trail.at(_finite(separation, "separation"), tolerance))
        pressure = _finite(mean_pressure, "mean_pressure")
        if pressure < 0:
            raise InputError(f"mean_pressure must not be negative, got {pressure:g} Pa")
        return self._judged(trail.under(pressure, tolerance, state))

    def _judged(self, state: PopulationState) -> PopulationState:
        share = state.contact_area / self.nominal_area
        if state.converged and share > LARGEST_AREA:
            reason = (
                f"contacts fill {100 * share:.0f} % of the nominal area, more than the "
                f"{100 * LARGEST_AREA:.0f} % up to which separate contacts are a model"
            )
            return replace(state, converged=False, reason=reason)
        return state


@dataclass(frozen=True, eq=False)
class _Trail:
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

    def _placed(self, approach: NDArray[np.float64]) -> _Trail:
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
            if abs(error) <= tolerance and state.residual <= tolerance:
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
    ) -> _Trail:
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

    def _listing(self, separation: float) -> _Trail:
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


def _column(value: ArrayLike, name: str) -> NDArray[np.float64]:
    array = np.ascontiguousarray(value, dtype=float)
    if array.ndim != 1:
        raise InputError(f"{name} must be one-dimensional, got shape {array.shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{name} holds values that are not finite")
    return array


def _finite(value: float | None, name: str) -> float:
    number = math.nan if value is None else float(value)
    if not math.isfinite(number):
        raise InputError(f"{name} must be finite, got {value!r}")
    return number
