"""The number of threads of every parallel stage, set in one place."""

from __future__ import annotations

import os

from surfaces.numerics.parallel import set_threads, threads

from .errors import AsperityError

__all__ = [
    "idle_threads",
    "require_own_threads",
    "set_threads",
    "threads",
    "use_numba",
]

_first: int | None = None
"""Process in which compiled loops first ran on several threads."""


def require_own_threads() -> None:
    """Refuse a process forked from one whose compiled loops ran on threads: they would end it.

    Raises
    ------
    AsperityError
        Saying how to start such a process. GNU OpenMP does not outlive a fork.
    """
    global _first
    _first = _first or os.getpid()
    if _first == os.getpid():
        return
    from numba.np.ufunc.parallel import threading_layer

    if threading_layer() == "omp":  # type: ignore[no-untyped-call]
        raise AsperityError(
            "boundary elements have run in the process from which this one was forked, and their "
            'threads do not outlive that; use multiprocessing.get_context("spawn")'
        )


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
    import numba

    numba.set_num_threads(max(1, min(count, int(getattr(numba.config, "NUMBA_NUM_THREADS", 1)))))
