"""A curve as chains of loads, each continued: the secant through two solutions starts the next.

Half of a load's work is too short for two threads to share well; two chains, each on one thread,
share nothing.
"""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Array
from surfaces.numerics.parallel import apart, by_rows

from ._grid_kernels import extrapolate
from .bounds import AREA_OVER_LOAD_ERROR, area_error, load_error
from .certificate import Prescribed
from .correction import GridSolution, PoorPredictionError, PressureOrigin
from .problem import ContactProblem

__all__ = ["NO_LIMIT", "LoadPath", "follow_chains", "split_loads", "stopping"]

NO_LIMIT = math.inf, math.inf
"""Accuracy in load and area of a path on which every load has the tolerance of the problem."""

_LEAST_LOADS = 8
"""Least number of loads for two chains."""

_LEAST_POINTS = 200 * 200
"""Least number of grid points for two chains."""

_LOAD_COST = 5.0
"""Extra cost of the heaviest load, over the cost of a load near zero."""

_START_COST = 2.0
"""Cost of the first load of a chain, which starts from coarser grids, over that of one near zero.
"""

_AIM = 0.9
"""Error aimed at over the error allowed: the ratio of error and tolerance changes a little."""

_MOST_OVER = 1e2
"""Largest error over that allowed from which the tolerance is told; infinite ones count as this."""

_LEAST_SHARE = 0.3
"""Least share of the accuracy in area for the certificate, however much of it one pixel takes."""

_MOST_TIMES = 5
"""Most times that a load is solved to a smaller tolerance."""

_SMALLEST_TOLERANCE = 1e-11
"""Smallest tolerance that an accuracy leads to."""

_LARGEST_RATIO = 4.0
"""Ratio of two loads above which the second starts from coarser grids."""

_FEW_POINTS = 50_000
"""Points under pressure up to which the state at no load is a point of the secant."""

_LARGEST_STEP = 3.0
"""Step over the difference of the last two loads, above which the last state is scaled instead of
extrapolated."""


def split_loads(shares: Array, points: int) -> list[range]:
    """Split ascending loads into two chains that take about equal time.

    `shares` are the loads over the largest. There is one chain for few loads or on a grid of few
    points.

    Notes
    -----
    The split does not depend on the number of threads, so that the results do not either. A load of
    share s costs about 1 + `_LOAD_COST` s, the start of the second chain `_START_COST`.
    """
    n = len(shares)
    if n < _LEAST_LOADS or points < _LEAST_POINTS:
        return [range(n)]
    done = np.cumsum(1.0 + _LOAD_COST * shares)
    longer = np.maximum(done, done[-1] - done + _START_COST)
    first = int(longer[:-1].argmin()) + 1
    return [range(first), range(first, n)]


def follow_chains(
    chains: Sequence[range], follow: Callable[[range, threading.Event], None], *, together: bool
) -> None:
    """Call ``follow(chain, stop)`` for every chain; `stop` is set if another one failed."""
    stop = threading.Event()

    def followed(chain: range) -> None:
        with stopping(stop):
            follow(chain, stop)

    try:
        for group in [chains] if together else [[chain] for chain in chains]:
            apart(followed, group)
    finally:  # of one that was interrupted
        stop.set()


@contextlib.contextmanager
def stopping(stop: threading.Event) -> Iterator[None]:
    """Set `stop` if the body raises."""
    try:
        yield
    except BaseException:
        stop.set()
        raise


class LoadPath:
    """Solves one problem at growing loads.

    Parameters
    ----------
    problem
        Map, material and boundary, planned.
    accuracy
        Relative errors allowed in load and area. If the certificate allows larger errors, a load is
        solved again to a smaller tolerance, with which the next load begins. The first load begins
        with the tolerance that its coarser grid would need.
    guess
        Pressure [Pa] that the first load starts from in place of the coarser grids, if given.

    Notes
    -----
    The next state is extrapolated by the secant through the last two. The displacement is linear in
    the pressure, so that the gap of an extrapolated pressure is known exactly without a transform;
    the first correction repairs negative pressures. The older state is kept in single precision.

    While the contact has few points, the state at no load, p = u = 0, is the first point of the
    secant. With many points a secant from there costs more than a start from the coarser grids; so
    does a step to more than `_LARGEST_RATIO` times the load, or a poor prediction.
    """

    def __init__(
        self, problem: ContactProblem, accuracy: tuple[float, float], guess: Array | None = None
    ) -> None:
        self.problem = problem
        self._accuracy, self._guess = accuracy, guess
        self._tolerance = problem.tolerance
        self._old: tuple[NDArray[np.float32], ...] | None = None
        self._means = (0.0, 0.0)
        self._level = 0.0
        self._points = 0
        self._stiffness = 0.0
        self._kept = np.empty((2, 0))

    def solve(self, kind: str, value: float) -> GridSolution:
        """Solve at the next mean pressure [Pa] or separation [m]."""
        problem = self.problem
        goal = problem.prescribed(kind, value)
        if not problem.touches(goal):
            self._old, self._means = None, (0.0, 0.0)
            problem.start(goal)
            return problem.finest.solve(goal, problem.tolerance)
        last = self._means[1]
        mean = goal.mean if goal.level is None else self._forecast(goal.level)
        solution = None
        near = 0.0 < mean <= _LARGEST_RATIO * last
        # the state at no load counts as known while the contact has few points
        if near and (self._means[0] > 0.0 or self._points <= _FEW_POINTS):
            self._predict(mean)
            with contextlib.suppress(PoorPredictionError):
                solution = problem.solve(goal, self._tolerance, PressureOrigin.PREDICTED)
        else:
            state = problem.finest.exact.pressure, problem.finest.exact.displacement
            self._old = tuple(field.astype(np.float32) for field in state) if near else None
        if solution is None:
            coarse = problem.start(goal, self._guess)
            self._guess = None
            if coarse is not None and coarse.converged:
                load_left = load_error(problem, coarse)
                self._needed_tolerance(coarse, load_left, AREA_OVER_LOAD_ERROR * load_left, 0.0)
            solution = problem.solve(goal, self._tolerance, PressureOrigin.PROLONGED)
            solution.iterations += coarse.iterations if coarse is not None else 0
        solution = self._sharpened(solution, goal)
        self._remember(solution)
        return solution

    def state(self) -> Array:
        """All that the next load depends on, in one array; asked for after each load."""
        pressure = self.problem.finest.exact.pressure
        old = self._kept if self._old is not None else np.empty((2, 0))
        place = np.flatnonzero(pressure)
        self._kept = np.stack([place, pressure.flat[place]])
        facts = (self._tolerance, *self._means, self._level, self._points, self._stiffness)
        return np.concatenate([[old.shape[1], *facts], old.ravel(), self._kept.ravel()])

    def go_on(self, state: Array) -> None:
        """Stand where a path of the same problem stood when it had this state."""
        count, self._tolerance, *means, self._level, points, self._stiffness = state[:7].tolist()
        self._means, self._points = (means[0], means[1]), int(points)
        old, self._kept = (each.reshape(2, -1) for each in np.split(state[7:], [2 * int(count)]))
        exact = self.problem.finest.exact
        self._put(old)
        self._old = exact.pressure.astype(np.float32), exact.displacement.astype(np.float32)
        self._put(self._kept)

    def _put(self, kept: Array) -> None:
        """Press the surface by pressures at places of the grid, and at no others."""
        exact = self.problem.finest.exact
        exact.pressure[:] = 0.0
        exact.pressure.flat[kept[0].astype(np.intp)] = kept[1]
        exact.apply()

    def _sharpened(self, solution: GridSolution, goal: Prescribed) -> GridSolution:
        """Solve to smaller tolerances until load and area are within the accuracy: usually once,
        more often where many points open or close together."""
        for _ in range(_MOST_TIMES if self._accuracy < NO_LIMIT else 0):
            area, pixel = area_error(self.problem, solution)
            error = load_error(self.problem, solution), area
            if max(error[0], area - pixel) <= 0.0 or not solution.converged:
                break
            tolerance = self._needed_tolerance(solution, error[0], area - pixel, pixel)
            met = error[0] <= self._accuracy[0] and area <= self._accuracy[1]
            if met or tolerance >= solution.tolerance:
                break
            spent = solution.iterations
            solution = self.problem.solve(goal, tolerance, PressureOrigin.SOLVED)
            solution.iterations += spent
        return solution

    def _needed_tolerance(
        self, solution: GridSolution, load: float, area: float, pixel: float
    ) -> float:
        """Tolerance at which load and area would be within the accuracy; the next load begins with
        it. The solution has the errors `load`, and `area` plus `pixel`, the error of one pixel."""
        allowed = max(self._accuracy[1] - pixel, _LEAST_SHARE * self._accuracy[1])
        over = max(load / self._accuracy[0], area / allowed)
        if not over > 0.0:
            return solution.tolerance
        tolerance = max(_AIM * solution.tolerance / min(over, _MOST_OVER), _SMALLEST_TOLERANCE)
        self._tolerance = min(tolerance, self.problem.tolerance)
        return tolerance

    def _forecast(self, level: float) -> float:
        """Load at a level, extrapolated exponentially with the stiffness; zero if not known."""
        last = self._means[1]
        if last <= 0.0 or self._stiffness == 0.0:
            return 0.0
        exponent = self._stiffness * (level - self._level) / last
        return last * math.exp(exponent) if exponent <= math.log(_LARGEST_RATIO) else 0.0

    def _predict(self, mean: float) -> None:
        """Extrapolate pressure and displacement to a mean pressure."""
        exact = self.problem.finest.exact
        now = exact.pressure, exact.displacement
        if self._old is None:
            self._old = np.zeros(now[0].shape, np.float32), np.zeros(now[1].shape, np.float32)
        before, last = self._means
        step = (mean - last) / (last - before) if last > before else math.inf
        shares = (1.0 + step, -step) if abs(step) <= _LARGEST_STEP else (mean / last, 0.0)
        for field, old in zip(now, self._old, strict=True):
            by_rows(extrapolate, field.shape, field, old, *shares)

    def _remember(self, solution: GridSolution) -> None:
        """Keep the solution as the last point of the secant."""
        mean = solution.reading.total / self.problem.hm.heights.size
        self._means = (self._means[1] if self._old is not None else 0.0, mean)
        self._level, self._stiffness = solution.reading.level, solution.stiffness
        self._points = solution.reading.points
