"""The number of threads of every parallel stage, set in one place."""

from __future__ import annotations

import os

from surfaces._threads import set_threads, threads

__all__ = [
    "idle_threads",
    "set_threads",
    "threads",
    "use_numba",
]


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
