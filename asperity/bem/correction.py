"""Outer defect correction: exact residual, contact problem on the candidates, and again."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from . import _grid_kernels
from .certificate import Reading, certify
from .contact_list import ContactList
from .full_grid import FullGridOperator
from .operator import HalfSpaceOperator
from .projected_gradients import SPARE_LOAD, solve_on_list
from .split import SplitOperator

__all__ = ["Level", "Outcome", "PoorPredictionError", "PressureOrigin"]

_FIRST_BAND = 0.15
"""Gap over the length scale below which points are candidates in the first correction, times the
error (at most 1)."""

_LATER_BAND = 2.0
"""Gap over the length scale, times the error, below which points are candidates later."""

_WIDEST_BAND = 0.05
"""Bound of the band of later corrections."""

_LONGEST_LIST = 0.2
"""Share of the grid by which the candidates of a predicted pressure may outnumber the points that
it presses: a longer list costs more than a start from coarser grids."""

_LIST_SHARE = 0.3
"""Error to reach on the list over the tolerance: the rest is left to the approximate operator, and
equivalent runs (mirrored, moved) agree the closer."""

_MAX_CORRECTIONS = 60
"""Corrections of one load at most."""

_MAX_IDLE = 6
"""Corrections in a row that hardly lower the error, after which the solution has stagnated."""

_MAX_INNER = 200
"""Iterations on the list within one correction."""

_SMALL_GRID = 128 * 128
"""Points up to which the transform of the whole grid is cheaper than the split operator."""


class PoorPredictionError(Exception):
    """A predicted pressure is so far off that a start from coarser grids costs less."""


class PressureOrigin(Enum):
    """Where the pressure comes from that a grid is solved from.

    Attributes
    ----------
    GIVEN
        From anywhere.
    PROLONGED
        From a coarser grid: it is corrected in any case, as points about the contact that carry
        next to nothing make its area too large.
    PREDICTED
        From the loads before, possibly negative in places, with its displacement: it is corrected
        in any case, and the first correction needs no transform.
    SOLVED
        From this load at a larger tolerance, with its displacement.
    """

    GIVEN = "given"
    PROLONGED = "prolonged"
    PREDICTED = "predicted"
    SOLVED = "solved"


@dataclass
class Outcome:
    """How the outer iteration on one grid ended.

    Attributes
    ----------
    reading
        The certificate and what was read with it.
    iterations
        Conjugate-gradient steps spent.
    tolerance
        Bound on the certificate that was asked for.
    converged, reason
        Whether it was met, and why not.
    stiffness
        Slope of the mean of p~ over the level (`contact_stiffness`) [-]; zero where not asked for.
    contact
        Raw area [m^2], corrected area [m^2] and number of patches (`read_contact`); zero where not
        asked for.
    """

    reading: Reading
    iterations: int
    tolerance: float
    converged: bool
    reason: str
    stiffness: float = 0.0
    contact: tuple[float, float, int] = (0.0, 0.0, 0)


class Level:
    """One grid of the nested solver: heights [m], shape (ny, nx), the exact operator, whose
    `pressure` is the state, with a largest pressure p~ [m], and the operators on a list.

    Attributes
    ----------
    mean_height, highest, rms_height
        Mean, largest and root-mean-square height about the mean [m].
    """

    def __init__(
        self, heights: NDArray[np.float64], exact: HalfSpaceOperator, cap: float = math.inf
    ) -> None:
        self.heights = heights
        self.exact = exact
        self.cap = cap
        self.mean_height, self.highest = float(heights.mean()), float(heights.max())
        self.rms_height = float(heights.std())
        self._careful = False
        self._split: SplitOperator | None = None
        self._full: FullGridOperator | None = None

    @property
    def pressure(self) -> NDArray[np.float64]:
        """Pressure p~ [m], shape (ny, nx): a view of the operator's input."""
        return self.exact.pressure[:, : self.heights.shape[1]]

    def solve(
        self,
        load: float,
        offset: float | None,
        tolerance: float,
        origin: PressureOrigin = PressureOrigin.GIVEN,
    ) -> Outcome:
        """Correct the pressure until each entry of its certificate is within the tolerance.

        Prescribed is the level u - h of the contact [m], `offset`, or without one the mean of p~
        [m], `load`. A predicted pressure that is too far off stays as it was predicted, and raises
        PoorPredictionError.
        """
        mean = load if offset is None else None
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
                mean_pressure=mean,
                offset=offset,
                approach=math.inf if offset is None else offset + self.highest,
            )
            worst = reading.certificate.worst
            unsure = here in (PressureOrigin.PREDICTED, PressureOrigin.PROLONGED)
            if worst <= tolerance and not unsure:
                return Outcome(reading, iterations, tolerance, True, "")
            idle = 0 if worst < 0.7 * best else idle + 1
            self._careful = self._careful or idle >= 2
            best = min(best, worst)
            if idle >= _MAX_IDLE:
                break
            error = worst if mean is None else replace(reading.certificate, load=0.0).worst
            listed = self._listed(mean, offset, displacement, reading, error, outer == 0)
            if (
                here is PressureOrigin.PREDICTED
                and len(listed[0]) - reading.points > _LONGEST_LIST * self.heights.size
            ):
                raise PoorPredictionError
            iterations += self._correct(listed, mean, offset, reading.scale, error, tolerance)
        reason = (
            f"the error stopped falling at {best:.1e}, above the tolerance {tolerance:.1e}, "
            f"after {outer} corrections"
        )
        return Outcome(reading, iterations, tolerance, False, reason)

    def _listed(
        self,
        mean: float | None,
        offset: float | None,
        displacement: NDArray[np.float64],
        reading: Reading,
        error: float,
        first: bool,
    ) -> tuple[ContactList, NDArray[np.float64], NDArray[np.float64]]:
        """The candidates, their pressures and their gaps."""
        width = _FIRST_BAND * min(1.0, error) if first else min(_WIDEST_BAND, _LATER_BAND * error)
        level = reading.level if offset is None else max(reading.level, offset)
        threshold = level + width * reading.scale
        total = None if mean is None else mean * self.heights.size
        least = math.ceil(SPARE_LOAD * (total or 0.0) / self.cap)
        start, columns, values, gap = self._candidates(displacement, reading, threshold)
        if columns.size < min(least, self.heights.size):
            gaps = (displacement[:, : self.heights.shape[1]] - self.heights).ravel()
            rank = min(least, gaps.size) - 1
            threshold = max(threshold, float(np.partition(gaps, rank)[rank]))
            start, columns, values, gap = self._candidates(displacement, reading, threshold)
        return ContactList(start, columns), values, gap

    def _correct(
        self,
        listed: tuple[ContactList, NDArray[np.float64], NDArray[np.float64]],
        mean: float | None,
        offset: float | None,
        scale: float,
        error: float,
        tolerance: float,
    ) -> int:
        """One solve on the list of candidates; returns the iterations spent."""
        points, values, gap = listed
        operator = self.operator(points)
        if offset is not None:
            gap -= offset
        spent = solve_on_list(
            operator,
            values,
            gap,
            scale=scale,
            tolerance=_next_error(error, _LIST_SHARE * tolerance, operator.aim),
            longest=_MAX_INNER,
            total=None if mean is None else mean * self.heights.size,
            cap=self.cap,
        )
        points.fill(self.exact.pressure, values)
        return spent

    def _candidates(
        self, displacement: NDArray[np.float64], reading: Reading, threshold: float
    ) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
        """Points under pressure or with a gap up to the threshold, see `_grid_kernels.select`."""
        found: tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]
        found = _grid_kernels.select(
            self.exact.pressure, displacement, self.heights, reading.block_low, threshold
        )
        return found

    def operator(self, points: ContactList) -> SplitOperator | FullGridOperator:
        """The cheaper operator for the grid, on a list; the sharper one after idle corrections."""
        if self._careful or self.heights.size <= _SMALL_GRID:
            if self._full is None:
                self._full = FullGridOperator(self.exact)
            self._full.bind(points)
            return self._full
        if self._split is None:
            self._split = SplitOperator(self.exact)
        self._split.bind(points)
        return self._split


def _next_error(error: float, wanted: float, sharpest: float) -> float:
    """Error to ask of one correction on the way to the wanted one.

    The fewest corrections that can reach it, none reducing the error more than `sharpest`, reduce
    it by the same factor each: more would be lost to the approximate operator.
    """
    if error <= wanted:
        return wanted
    steps = math.ceil(math.log(wanted / error) / math.log(sharpest))
    return float(error * (wanted / error) ** (1.0 / steps))
