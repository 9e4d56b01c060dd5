"""Outer iteration of the solver (defect correction): the exact residual in float64, then a contact
problem on the candidate points with an approximate operator, and again.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from surfaces.arrays import Array

from . import _grid_kernels
from .certificate import Prescribed, Reading, certify
from .contact_list import ContactList
from .full_grid import FullGridOperator
from .operator import HalfSpaceOperator
from .projected_gradients import SPARE_LOAD, solve_on_list
from .split import SplitOperator

__all__ = ["GridSolution", "NestedGrid", "PoorPredictionError", "PressureOrigin"]

Selection = tuple[ContactList, Array, Array]
"""Points of a grid, their pressures p~ and their gaps u - h [m]."""

_FIRST_BAND = 0.15
"""In the first correction points are candidates up to this gap, over the length scale and over the
error (at most 1)."""

_LATER_BAND = 2.0
"""In later corrections points are candidates up to this gap, over the length scale and the error.
"""

_WIDEST_BAND = 0.05
"""Largest gap of candidates in later corrections, over the length scale."""

_LONGEST_LIST = 0.2
"""Largest number of candidates of a predicted pressure without pressure, over the points of the
grid: a longer list costs more than a start from coarser grids."""

_LIST_SHARE = 0.3
"""Error to reach on the list, over the tolerance: the rest is the error of the approximate
operator. A smaller value makes equivalent runs (mirrored, moved) agree more closely."""

_MAX_CORRECTIONS = 60
"""Most corrections of one load."""

_MAX_IDLE = 6
"""Successive corrections that hardly lower the error after which the solution has stagnated."""

_ROUNDING = 1e-11
"""Error of a stagnated solution, over the largest displacement, that is rounding of the transforms:
of a flat map, which has no height, no more can be asked for."""

_SMALL_GRID = 128 * 128
"""Points of a grid up to which its whole transform is cheaper than the split operator."""


class PoorPredictionError(Exception):
    """A predicted pressure is so far off that a start from coarser grids costs less."""


class PressureOrigin(Enum):
    """Origin of the pressure that the solve of a grid starts from.

    All but any pressure are corrected at least once: of points about the contact that carry next to
    nothing, which make its area too large, the certificate tells little.

    Attributes
    ----------
    GIVEN
        Any pressure.
    PROLONGED
        Interpolated from a coarser grid.
    PREDICTED
        Extrapolated from the loads before, with its displacement; it may be negative in places. The
        first correction needs no transform.
    SOLVED
        Solution of this load at a larger tolerance, with its displacement.
    """

    GIVEN = "given"
    PROLONGED = "prolonged"
    PREDICTED = "predicted"
    SOLVED = "solved"


@dataclass
class GridSolution:
    """Result of the outer iteration on one grid; the solution is the state of its operator.

    Attributes
    ----------
    goal, reading
        What was asked for; certificate and sums over the solution.
    iterations
        Number of conjugate-gradient steps.
    tolerance
        Bound on the certificate that was asked for.
    converged, reason
        Whether the certificate is within the tolerance, and if not, why.
    stiffness
        Slope of the mean of p~ over the level (`contact_stiffness`) [-]; zero if not computed.
    contact
        Raw area [m^2], corrected area [m^2] and number of patches (`read_contact`); zero if not
        computed.
    """

    goal: Prescribed
    reading: Reading
    iterations: int
    tolerance: float
    converged: bool
    reason: str
    stiffness: float = 0.0
    contact: tuple[float, float, int] = (0.0, 0.0, 0)


class NestedGrid:
    """One grid of the nested solver.

    It holds the heights [m], shape (ny, nx), with a mean of nearly zero, the exact operator, whose
    `pressure` is the state of the solve, and the approximate operators on a list. `cap` is the
    largest pressure p~ [m].

    Attributes
    ----------
    mean_height, highest, rms_height
        Mean, largest and root-mean-square height about the mean [m].
    """

    def __init__(self, heights: Array, exact: HalfSpaceOperator, cap: float = math.inf) -> None:
        self.heights = heights
        self.exact = exact
        self.cap = cap
        self.mean_height, self.highest = float(heights.mean()), float(heights.max())
        square = float(np.einsum("ij,ij", heights, heights)) / heights.size
        self.rms_height = math.sqrt(max(0.0, square - self.mean_height**2))
        self._careful = False

    @property
    def pressure(self) -> Array:
        """Pressure p~ [m], shape (ny, nx): a view of the operator's input."""
        return self.exact.pressure[:, : self.heights.shape[1]]

    def solve(
        self, goal: Prescribed, tolerance: float, origin: PressureOrigin = PressureOrigin.GIVEN
    ) -> GridSolution:
        """Correct the pressure until each entry of its certificate is within the tolerance.

        A predicted pressure that is too far off is left unchanged, and PoorPredictionError is
        raised.
        """
        iterations = 0
        best, idle = math.inf, 0
        self._careful = False
        for outer in range(_MAX_CORRECTIONS):
            here = origin if outer == 0 else PressureOrigin.GIVEN
            known = here in (PressureOrigin.PREDICTED, PressureOrigin.SOLVED)
            displacement = self.exact.displacement if known else self.exact.apply()
            reading = certify(
                self.exact.pressure,
                displacement,
                self.heights,
                self.rms_height,
                cap=self.cap,
                goal=goal,
                highest_point=self.highest,
            )
            worst = reading.certificate.worst
            if worst <= tolerance and here is PressureOrigin.GIVEN:
                return GridSolution(goal, reading, iterations, tolerance, True, "")
            idle = 0 if worst < 0.7 * best else idle + 1
            self._careful = self._careful or idle >= 2
            best = min(best, worst)
            if idle >= _MAX_IDLE:
                break
            error = worst
            if goal.level is None:  # the list bears the load exactly
                error = replace(reading.certificate, load=0.0).worst
            points, values, gap = self._listed(goal, reading, error, outer == 0)
            spare = len(points) - reading.points
            if here is PressureOrigin.PREDICTED and spare > _LONGEST_LIST * self.heights.size:
                raise PoorPredictionError
            operator = self.operator(points)
            if goal.level is not None:
                gap -= goal.level
            iterations += solve_on_list(
                operator,
                values,
                gap,
                scale=reading.scale,
                tolerance=_next_error(error, _LIST_SHARE * tolerance, operator.aim),
                total=goal.mean * self.heights.size if goal.level is None else None,
                cap=self.cap,
            )
            points.fill(self.exact.pressure, values)
        if worst * reading.scale <= _ROUNDING * float(np.abs(self.exact.displacement).max()):
            return GridSolution(goal, reading, iterations, tolerance, True, "")
        reason = (
            f"the error stopped falling at {best:.1e}, above the tolerance {tolerance:.1e}, "
            f"after {outer} corrections"
        )
        return GridSolution(goal, reading, iterations, tolerance, False, reason)

    def _listed(self, goal: Prescribed, reading: Reading, error: float, first: bool) -> Selection:
        """The candidates."""
        width = _FIRST_BAND * min(1.0, error) if first else min(_WIDEST_BAND, _LATER_BAND * error)
        level = reading.level if goal.level is None else max(reading.level, goal.level)
        threshold = level + width * reading.scale
        least = math.ceil(SPARE_LOAD * goal.mean * self.heights.size / self.cap)
        listed = self.select(reading, threshold)
        if len(listed[0]) < min(least, self.heights.size):
            displacement = self.exact.displacement[:, : self.heights.shape[1]]
            gaps = (displacement - self.heights).ravel()
            rank = min(least, gaps.size) - 1
            threshold = max(threshold, float(np.partition(gaps, rank)[rank]))
            listed = self.select(reading, threshold)
        return listed

    def select(self, reading: Reading, threshold: float) -> Selection:
        """Points with a pressure or with a gap up to a threshold."""
        start, columns, pressure, gap = _grid_kernels.select(
            self.exact.pressure, self.exact.displacement, self.heights, reading.block_low, threshold
        )
        return ContactList(start, columns), pressure, gap

    def operator(self, points: ContactList) -> SplitOperator | FullGridOperator:
        """The cheaper operator for the grid, on a list; after idle corrections the more accurate
        one."""
        exact = self._careful or self.heights.size <= _SMALL_GRID
        operator = self._full if exact else self._split
        operator.bind(points)
        return operator

    @functools.cached_property
    def _split(self) -> SplitOperator:
        return SplitOperator(self.exact)

    @functools.cached_property
    def _full(self) -> FullGridOperator:
        return FullGridOperator(self.exact)


def _next_error(error: float, wanted: float, sharpest: float) -> float:
    """Error to ask of the next correction, on the way from `error` to `wanted`.

    One correction can reduce the error to the part `sharpest` at best, because its operator is an
    approximation. The least number of corrections is taken, each with the same factor.
    """
    if error <= wanted:
        return wanted
    steps = math.ceil(math.log(wanted / error) / math.log(sharpest))
    return float(error * (wanted / error) ** (1.0 / steps))
