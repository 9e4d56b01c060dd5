"""Trial of HDF5 calls in a child process, since damaged files can hang or crash the library.

Damaged global heaps (where HDF5 keeps attributes of variable length) send the library into an
endless loop or a segmentation fault, which no exception handler can catch. The child does the
same calls under a time limit; only if it survives does this process do them.
"""

from __future__ import annotations

import os
from collections.abc import Callable

from h5py import _objects

__all__ = ["survives"]

CPU_SECONDS = 3
"""Processor time after which an attempt hangs."""


def survives(attempt: Callable[[], object]) -> bool:
    """Whether `attempt` comes to an end, by return or exception, within `CPU_SECONDS`.

    The limit is on processor time: an endless loop spends it, a slow disk does not. Where
    processes cannot be forked the answer is always True. The child owns the lock of h5py, which
    is taken before the fork, so that no other thread of the parent can hold it there.
    """
    if not hasattr(os, "fork"):
        return True
    import resource

    with _objects.phil:
        child = os.fork()
        if child == 0:
            try:
                resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS))
                attempt()
            finally:
                os._exit(0)
    _, status = os.waitpid(child, 0)
    return os.WIFEXITED(status)
