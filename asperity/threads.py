"""The number of threads of every parallel stage, set in one place."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from surfaces import _threads
from surfaces._threads import set_threads, threads

__all__ = [
    "idle_threads",
    "limit_threads",
    "set_threads",
    "short_barriers",
    "threads",
    "use_numba",
]


@contextmanager
def limit_threads(count: int | None) -> Iterator[int]:
    """Use `count` threads inside the block, then return to what was set before."""
    before = _threads.chosen()
    set_threads(count)
    try:
        yield threads()
    finally:
        set_threads(before)


def short_barriers() -> None:
    """Make the waiting threads of OpenMP sleep soon; call before the first compiled parallel loop.

    A barrier that spins for long costs more on a busy machine than the loop that it ends; one
    that sleeps at once costs a wake-up per loop, and schedulers that pack tasks then run both
    threads on one processor. 10 000 spins (below 0.5 ms) bridge the gap between two loops.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    os.environ.setdefault("GOMP_SPINCOUNT", "10000")


def idle_threads(limit: int) -> int:
    """Threads, at most `limit`, for which a processor is idle at this moment; at least one.

    Counts the runnable tasks of the machine (Linux; elsewhere returns the limit). A thread that
    must wait for a processor makes all others wait at the next barrier.
    """
    if limit == 1:
        return 1
    try:
        with open("/proc/loadavg") as file:
            runnable = int(file.read().split()[3].split("/")[0])
    except (OSError, ValueError, IndexError):
        return limit
    return max(1, min(limit, (os.cpu_count() or limit) - runnable + 1))


def use_numba(count: int) -> None:
    """Let compiled loops run on `count` threads, as far as numba was started with so many."""
    short_barriers()
    import numba

    numba.set_num_threads(max(1, min(count, int(getattr(numba.config, "NUMBA_NUM_THREADS", 1)))))
