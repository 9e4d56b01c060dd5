"""Chunks of a compiled loop on threads: it starts none for a single chunk."""

from __future__ import annotations

import functools
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

__all__ = ["run"]


@functools.cache
def _pool(workers: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(workers, thread_name_prefix="interaction")


def run(loop: Callable[[int, NDArray[np.int64]], None], rows: NDArray[np.int64]) -> None:
    """Call loop(c, rows[c]) for every chunk, all but the first on other threads.

    The loop releases the interpreter lock. Waiting threads sleep, and a short loop of one chunk
    costs no more than its call.
    """
    if len(rows) == 1:
        loop(0, rows[0])
        return
    pool = _pool(len(rows) - 1)
    others = [pool.submit(loop, c, rows[c]) for c in range(1, len(rows))]
    loop(0, rows[0])
    for other in others:
        other.result()
