"""A curve as chains of loads that are solved at the same time, each on one thread.

Half of a load's work is too short for two threads to share well; two chains share nothing.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

__all__ = ["follow_chains", "split_loads"]

_LEAST_LOADS = 8
"""Loads from which on there are two chains."""

_LEAST_POINTS = 200 * 200
"""Grid points from which on there are two chains."""

_LOAD_COST = 5.0
"""Extra cost of the heaviest load, over the cost of a load near zero."""

_START_COST = 2.0
"""Cost of the first load of a chain, which starts from coarser grids."""


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
