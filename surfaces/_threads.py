"""Run kernels that release the interpreter lock on blocks of rows."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

__all__ = ["blocks", "each", "run"]


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


def each(function: Callable[[Any], Any], parts: list[Any]) -> list[Any]:
    """Call ``function(part)`` for every part, at the same time; results in order."""
    if len(parts) == 1:
        return [function(parts[0])]
    with ThreadPoolExecutor(len(parts)) as pool:
        return list(pool.map(function, parts))
