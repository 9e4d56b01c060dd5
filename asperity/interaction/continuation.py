"""What the next solve of a population takes over from the last."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .predictor import MEMORY, Point, predict, weights

if TYPE_CHECKING:
    from asperity.interaction.ewald.operator import Interaction
    from asperity.interaction.newton.final_step import Solution

    from .candidates import CandidateList
    from .contact_system import ContactSystem

__all__ = ["Continuation"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Continuation:
    """The last points of a population, and the candidates listed for them.

    Attributes
    ----------
    system
        Summits, laws and half-space.
    candidates
        Summits listed for the last point; None before the first, and of independent contacts.
    points
        Points to predict the next from, the last one last.
    heaviest
        Separation [m] and mean pressure [Pa] of the largest load that was solved.
    solution
        The last solution.
    """

    system: ContactSystem
    candidates: CandidateList | None = None
    points: tuple[Point, ...] = ()
    heaviest: tuple[float, float] | None = None
    solution: Solution | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Without the candidates, which the next solve lists anew, and with the tangent solved."""
        solution = None if self.solution is None else self.solution.without_matrix()
        return vars(self) | {"candidates": None, "solution": solution}

    @property
    def field(self) -> Interaction | None:
        """The interaction that holds the last field."""
        return None if self.candidates is None else self.candidates.problem.plan

    def after(self, solution: Solution, candidates: CandidateList, values: Array) -> Continuation:
        """The continuation from a solution on, with its `Point.values`."""
        pressure = solution.load / self.system.nominal_area
        point = Point(solution.separation, pressure, candidates.index, values)
        heaviest = self.heaviest
        if not solution.reason and (heaviest is None or pressure > heaviest[1]):
            heaviest = solution.separation, pressure
        return Continuation(
            system=self.system,
            candidates=candidates,
            points=(*self.points[1 - MEMORY :], point),
            heaviest=heaviest,
            solution=solution,
        )

    def independent(self, solution: Solution) -> Continuation:
        """The continuation from a solution of independent contacts on."""
        return replace(self, candidates=None, solution=solution)

    def predicted(self, separation: float, pressure: float | None) -> tuple[Rows, Array]:
        """Summits to start from, and `Point.values` of each, at a separation or mean pressure."""
        system = self.system
        if self.points:
            # at a separation contacts correct what a line misses, if they are not too far
            known = self.points[-2:] if pressure is None else self.points
            return self.points[-1].rows, predict(known, separation, len(system))
        rows = system.above(separation)
        values = np.zeros((5, len(rows)))
        values[0] = 0.5 * (system.height[rows] - separation)
        return rows, values

    def predicted_separation(self, pressure: float) -> float | None:
        """Separation [m] at a mean pressure [Pa], from the points solved before; None without."""
        known = [point for point in self.points if point.pressure > 0]
        if not known:
            return None
        if len(known) == 1:
            stiffness = self.normal_stiffness
            if not stiffness > 0:  # of a failed solve
                return None
            rise = math.log(pressure / known[0].pressure) * known[0].pressure
            return known[0].separation - rise / stiffness
        place = [math.log(point.pressure) for point in known]
        share = weights(math.log(pressure), place)
        return float(np.dot(share, [point.separation for point in known]))

    @property
    def normal_stiffness(self) -> float:
        """Minus the slope of mean pressure over separation [Pa/m] at the last point."""
        assert self.solution is not None
        return self.solution.tangent[0] / self.system.nominal_area

    @property
    def response(self) -> Array:
        """Approach that each contact gains per fall of the flat [-], shape (n,)."""
        gained = np.ones(len(self.system))
        if self.points and self.solution is not None:
            gained[self.points[-1].rows] = self.solution.tangent[1]
        return gained
