"""Outer defect correction: exact residual, contact problem on the candidates, and again."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .active_set import solve_on_list
from .certificate import Certificate, certify
from .full_grid import FullGridOperator
from .load_search import LoadSearch
from .operator import HalfSpaceOperator

__all__ = ["Level", "Outcome"]

_BAND = 0.05
_MARGIN = 2.0
_REDUCTION = 0.02
_MOST_OUTER = 60
_PATIENCE = 8
_MOST_INNER = 400


@dataclass
class Outcome:
    """How the outer iteration on one grid ended."""

    certificate: Certificate
    level: float
    iterations: int
    converged: bool
    reason: str


class Level:
    """One grid of the nested solver: heights, exact operator, pressure.

    Parameters
    ----------
    heights
        Heights [m], shape (ny, nx).
    exact
        Operator on the whole grid.
    """

    def __init__(self, heights: NDArray[np.float64], exact: HalfSpaceOperator) -> None:
        self.heights = heights
        self.exact = exact
        self.rms_height = float(heights.std())
        self.inner = FullGridOperator(exact)
        self.pressure = np.zeros(heights.shape)

    def solve(self, load: float | LoadSearch, tolerance: float) -> Outcome:
        """Correct the pressure until its certificate is within the tolerance.

        Parameters
        ----------
        load
            Prescribed mean of p~ [m], positive; or a search for the load of a given level, which
            is advanced by each correction.
        tolerance
            Bound on each entry of the certificate.
        """
        search = load if isinstance(load, LoadSearch) else None
        iterations = 0
        best, idle = math.inf, 0
        for outer in range(_MOST_OUTER):
            mean = search.mean if search else load
            displacement = self.exact.displacement(self.pressure)
            certificate, level, scale = certify(
                self.pressure,
                displacement,
                self.heights,
                self.rms_height,
                mean_pressure=None if search else mean,
                offset=search.offset if search else None,
            )
            if certificate.worst <= tolerance:
                return Outcome(certificate, level, iterations, True, "")
            idle = 0 if certificate.worst < 0.7 * best else idle + 1
            best = min(best, certificate.worst)
            if idle >= _PATIENCE:
                break
            error = max(certificate.complementarity, certificate.penetration)
            if search:
                mean = search.update(level, error * scale)
                error = max(error, certificate.load)
            iterations += self._correct(mean, displacement, level, scale, error, outer, tolerance)
        reason = (
            f"the error stopped falling at {best:.1e}, above the tolerance {tolerance:.1e}, "
            f"after {outer} corrections"
        )
        return Outcome(certificate, level, iterations, False, reason)

    def _correct(
        self,
        mean: float,
        displacement: NDArray[np.float64],
        level: float,
        scale: float,
        error: float,
        outer: int,
        tolerance: float,
    ) -> int:
        """One solve on the list of candidates; returns the iterations spent."""
        gap = displacement - self.heights
        width = _BAND * min(1.0, error if outer == 0 else _MARGIN / _BAND * error) * scale
        points = np.flatnonzero((self.pressure != 0.0) | (gap <= level + width))
        self.inner.bind(points)
        aim = 0.5 * tolerance if self.inner.exact else max(0.5 * tolerance, _REDUCTION * error)
        values, spent = solve_on_list(
            self.inner,
            self.pressure.ravel()[points],
            gap.ravel()[points],
            scale=scale,
            tolerance=aim,
            longest=_MOST_INNER,
            total=mean * self.pressure.size,
        )
        self.pressure.ravel()[points] = values
        return spent
