"""A curve as chains of loads, each continued: the secant through two solutions starts the next.

Half of a load's work is too short for two threads to share well; two chains, each on one thread,
share nothing.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from ._grid_kernels import extrapolate
from .correction import Level, Outcome
from .load_search import LoadSearch
from .problem import ContactProblem

__all__ = ["LoadPath", "follow_chains", "split_loads"]

_LEAST_LOADS = 8
"""Loads from which on there are two chains."""

_LEAST_POINTS = 200 * 200
"""Grid points from which on there are two chains."""

_LOAD_COST = 5.0
"""Extra cost of the heaviest load, over the cost of a load near zero."""

_START_COST = 2.0
"""Cost of the first load of a chain, which starts from coarser grids."""

_LARGEST_RATIO = 4.0
"""Ratio of two loads above which the next starts from coarser grids."""

_LARGEST_STEP = 3.0
"""Step over the distance of the last two loads above which there is no extrapolation."""


def split_loads(shares: NDArray[np.float64], points: int) -> list[range]:
    """Chains of the loads, in ascending order, that take about the same time.

    Parameters
    ----------
    shares
        Loads over the largest, ascending, shape (n,).
    points
        Points of the grid: on a small one, and for few loads, there is one chain.

    Notes
    -----
    The rule does not look at the number of threads, so that the results do not depend on it.
    A load of share s costs about 1 + 5 s, the start of a chain in the middle 2.
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
    if not together:
        for chain in chains:
            follow(chain, stop)
        return
    with ThreadPoolExecutor(len(chains), thread_name_prefix="loads") as pool:
        others = [pool.submit(follow, chain, stop) for chain in chains]
        try:
            for other in others:
                other.result()
        finally:
            stop.set()


class LoadPath:
    """Solves one problem at growing loads.

    Parameters
    ----------
    problem
        Map, material and boundary, planned.

    Notes
    -----
    The displacement is linear in the pressure, so that the gap of an extrapolated pressure is
    known exactly without a transform; negative pressures are repaired by the first correction.
    The older state is kept in single precision.
    The state of no load, p = u = 0, is the first support of the secant. A step to more than four
    times the load starts from the coarser grids instead.
    """

    def __init__(self, problem: ContactProblem) -> None:
        self.problem = problem
        self._old: tuple[NDArray[np.float32], NDArray[np.float32]] | None = None
        self._means = (0.0, 0.0)
        self._level = 0.0
        self._stiffness: float | None = None

    def solve(self, *, pressure: float | None = None, separation: float | None = None) -> Outcome:
        """Solve at the next mean pressure [Pa] or separation [m]."""
        problem, level = self.problem, self.problem.level
        load, offset = problem.prescribed(pressure, separation)
        if not problem.touches(load, offset):
            self._old, self._means = None, (0.0, 0.0)
            _, search = problem.start(load, offset)
            return level.solve(search or load, problem.tolerance)
        last = self._means[1]
        mean = load if offset is None else self._forecast(offset)
        if 0.0 < mean <= _LARGEST_RATIO * last:
            self._predict(level, mean)
            search = None if offset is None else LoadSearch(offset, mean, self._stiffness)
            outcome = level.solve(search or load, problem.tolerance, predicted=True)
        else:
            self._old = None
            spent, search = problem.start(load, offset)
            outcome = level.solve(search or load, problem.tolerance)
            outcome.iterations += spent
        self._remember(outcome, search)
        return outcome

    def _forecast(self, offset: float) -> float:
        """Load at a level, if it goes on growing exponentially with it; zero if not known."""
        last = self._means[1]
        if last <= 0.0 or not self._stiffness:
            return 0.0
        exponent = self._stiffness * (offset - self._level) / last
        if exponent > math.log(_LARGEST_RATIO):
            return 0.0
        self._stiffness *= math.exp(exponent)
        return last * math.exp(exponent)

    def _predict(self, level: Level, mean: float) -> None:
        """Extrapolate pressure and displacement to a mean pressure."""
        now = level.exact.pressure, level.exact.displacement
        if self._old is None:
            self._old = np.zeros(now[0].shape, np.float32), np.zeros(now[1].shape, np.float32)
        before, last = self._means
        step = (mean - last) / (last - before) if last > before else math.inf
        shares = (1.0 + step, -step) if abs(step) <= _LARGEST_STEP else (mean / last, 0.0)
        for field, old in zip(now, self._old, strict=True):
            extrapolate(field, old, *shares)

    def _remember(self, outcome: Outcome, search: LoadSearch | None) -> None:
        """Take the solution as the next support of the secant."""
        mean = outcome.reading.total / self.problem.hm.heights.size
        rise, growth = outcome.reading.level - self._level, mean - self._means[1]
        if self._old is not None and rise > 0.0 and growth > 0.0:
            self._stiffness = growth / rise
        if search and search.stiffness:
            self._stiffness = search.stiffness
        self._means = (self._means[1] if self._old is not None else 0.0, mean)
        self._level = outcome.reading.level
