"""Run kernels that release the interpreter lock on blocks of rows."""

from __future__ import annotations

import functools
import itertools
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

__all__ = ["blocks", "each", "run"]

_NAME = "row-blocks"


@functools.cache
def _pool(workers: int, process: int) -> ThreadPoolExecutor:
    """Threads kept for the next call: starting them costs more than a short loop."""
    return ThreadPoolExecutor(workers, thread_name_prefix=_NAME)


def _processors() -> int:
    """Processors that this process may use, or fewer by the variable ASPERITY_THREADS."""
    mine = hasattr(os, "sched_getaffinity")
    available = len(os.sched_getaffinity(0)) if mine else os.cpu_count() or 1
    text = os.environ.get("ASPERITY_THREADS", "")
    return min(int(text), available) if text.isdigit() and int(text) > 0 else available


def blocks(count: int, least: int = 1) -> list[tuple[int, int]]:
    """Split ``range(count)`` into one contiguous block per processor, none below `least`."""
    parts = max(1, min(_processors(), count // max(1, least)))
    bounds = [count * part // parts for part in range(parts + 1)]
    return list(itertools.pairwise(bounds))


def run(function: Callable[[int, int], Any], parts: list[tuple[int, int]]) -> list[Any]:
    """Call ``function(start, stop)`` for every block, at the same time; results in order."""
    return each(lambda part: function(*part), parts)


def each(function: Callable[[Any], Any], parts: Sequence[Any]) -> list[Any]:
    """Call ``function(part)`` for every part, at the same time; results in order."""
    if len(parts) == 1 or threading.current_thread().name.startswith(_NAME):
        return [function(part) for part in parts]
    pool = _pool(len(parts) - 1, os.getpid())
    others = [pool.submit(function, part) for part in parts[1:]]
    return [function(parts[0]), *(other.result() for other in others)]
