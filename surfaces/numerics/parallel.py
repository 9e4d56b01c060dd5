"""The number of threads, and loops over blocks of rows on that many."""

from __future__ import annotations

import contextvars
import functools
import itertools
import math
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

from numpy.typing import NDArray

from surfaces.errors import InputError, as_count

from .stored_array import Source, drop_pages, spans, windows

__all__ = [
    "Turn",
    "apart",
    "aside",
    "available",
    "blocks",
    "by_rows",
    "each",
    "lines",
    "over_rows",
    "run",
    "set_threads",
    "threads",
]

_NAME = "row-blocks"
_VARIABLE = "ASPERITY_THREADS"
_chosen: int | None = None

_alone = contextvars.ContextVar("alone", default=False)
"""Whether the work has one thread of its own, see `apart`."""

_POINTS = 2**17
"""Points of a map that repay a thread, in a loop that takes a few ns for each."""

_CACHED = 2**16
"""Points that one thread looks at together, in a loop that makes arrays of them."""

Result = TypeVar("Result")


@functools.cache
def _pool(workers: int, process: int) -> ThreadPoolExecutor:
    """Threads kept for the next call: starting them costs more than a short loop."""
    return ThreadPoolExecutor(workers, thread_name_prefix=_NAME)


def available() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def threads() -> int:
    """Number of threads in use: as set, else ASPERITY_THREADS, else every processor."""
    return 1 if _alone.get() else _chosen or _default()


@functools.cache
def _default() -> int:
    """Number of threads if none is set; asked once, as that takes 7 us."""
    text = os.environ.get(_VARIABLE, "")
    if not text:
        return available()
    if not text.isdigit() or int(text) < 1:
        raise InputError(f"{_VARIABLE} is {text!r}; give a whole number of threads, at least 1")
    return min(int(text), available())


def set_threads(count: int | None) -> None:
    """Use `count` threads from now on, at most one per processor; None returns to the default.

    Examples
    --------
    >>> import asperity
    >>> asperity.set_threads(2)
    >>> asperity.set_threads(None)  # as many as there are processors
    """
    global _chosen
    chosen = None if count is None else as_count("the number of threads", count, 1)
    _chosen = None if chosen is None else min(chosen, available())


class Turn:
    """A lock that its thread may take again; a copy or a pickle of it is a free one."""

    def __init__(self) -> None:
        self._lock = threading.RLock()

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *raised: object) -> None:
        self._lock.release()

    def __reduce__(self) -> tuple[type[Turn], tuple[()]]:
        return Turn, ()


def blocks(count: int, least: int = 1, most: float = math.inf) -> list[tuple[int, int]]:
    """Split ``range(count)`` into one contiguous block per processor, none below `least`; into as
    many as it takes for none to be above `most`."""
    parts = max(min(threads(), count // max(1, least)), math.ceil(count / most))
    if parts < 2:
        return [(0, count)]
    bounds = [count * part // parts for part in range(parts + 1)]
    return list(itertools.pairwise(bounds))


def lines(count: int, points: int) -> list[tuple[int, int]]:
    """Split the `count` lines of a map of so many points into blocks that repay a thread."""
    return blocks(count, count * _POINTS // points)


def run(function: Callable[[int, int], Any], parts: list[tuple[int, int]]) -> list[Any]:
    """Call ``function(start, stop)`` for every block, at the same time; results in order."""
    return each(lambda part: function(*part), parts)


def by_rows(kernel: Callable[..., Any], shape: tuple[int, int], *args: Any) -> list[Any]:
    """Call ``kernel((start, stop), *args)`` for blocks of the rows of a map of this shape, at the
    same time; results in order."""
    parts = lines(shape[0], shape[0] * shape[1])
    return run(lambda start, stop: kernel((start, stop), *args), parts)


def each(function: Callable[[Any], Any], parts: Sequence[Any]) -> list[Any]:
    """Call ``function(part)`` for every part, at the same time; results in order.

    What a part touched of mapped arrays is given back when it ends (`stored_array.mapped`). The
    other threads begin at the first parts. When this one has done its own, it takes those that
    nobody has begun from the end, so that many parts of unequal work keep all threads busy.
    """

    def done(part: Any) -> Any:
        found = function(part)
        drop_pages()
        return found

    if len(parts) < 2 or threads() == 1 or threading.current_thread().name.startswith(_NAME):
        return [done(part) for part in parts]
    pool = _pool(min(len(parts), threads()) - 1, os.getpid())
    others = [pool.submit(done, part) for part in parts[1:]]
    try:
        results = [done(parts[0])]
        own = []
        while others and others[-1].cancel():
            others.pop()
            own.append(done(parts[len(others) + 1]))
        return [*results, *(other.result() for other in others), *reversed(own)]
    finally:  # of one that was interrupted nobody wants the rest
        for other in others:
            other.cancel()


def over_rows(
    function: Callable[[slice, NDArray[Any]], Result], source: Source
) -> Iterator[Result]:
    """What ``function(place, rows)`` finds in parts of the rows of an array, in order and in
    threads."""
    step = max(1, _CACHED // source.shape[1])
    for begin, _, rows in windows(source):
        parts = [(slice(begin + a, begin + b), rows[a:b]) for a, b in spans(len(rows), step)]
        yield from each(lambda part: function(*part), parts)


def apart(
    function: Callable[[Any], Any],
    parts: Sequence[Any],
    beside: Callable[[], Any] | None = None,
) -> list[Any]:
    """As `each`, for parts that by themselves would take all threads: one thread for each.

    Meanwhile this thread calls `beside` first, which takes those that are left.
    """
    first = [] if beside is None else [beside]
    several = len(first) + len(parts) > 1

    def alone(part: Any) -> Any:
        _alone.set(_alone.get() or several)
        return function(part)

    tasks = [functools.partial(contextvars.copy_context().run, alone, part) for part in parts]
    return each(lambda task: task(), [*first, *tasks])[len(first) :]


def aside(function: Callable[[], Any]) -> None:
    """Call a function beside the rest, if more than one thread may be used; else leave it. What it
    raises is not told of."""
    if threads() > 1:
        pool = ThreadPoolExecutor(1)
        pool.submit(function)
        pool.shutdown(wait=False)
