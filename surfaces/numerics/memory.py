"""The memory that may be used: a limit, what is left of it, refusals of what would not fit, arrays
that are kept on disk, and changes of whole arrays within it."""

from __future__ import annotations

import ctypes
import dataclasses
import math
import mmap
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Array
from surfaces.errors import InputError, SurfaceError, as_number
from surfaces.numerics.stored_array import (
    Blocks,
    Sections,
    Source,
    StoredArray,
    array_of,
    drop_pages,
    spans,
)

__all__ = [
    "Transform",
    "along_both",
    "available_bytes",
    "on_disk",
    "require_memory",
    "room_for",
    "set_memory",
    "zeros",
]

_USUAL = 2 << 30
"""Memory of a program that works on a map in sections of columns, if nothing limits it [bytes]."""

_PROGRAM = 384 << 20
"""What the program takes beside the arrays of a map that is worked on in blocks, libraries
included."""

_WORK = 96
"""Bytes for each element of a section: as it is read, transformed, weighed and written."""

_MMAP_THRESHOLD, _LARGE = -3, 1 << 20
"""Parameter of `mallopt`, and size [bytes] from which arrays are large."""

_MEMINFO = Path("/proc/meminfo")
_CGROUP = Path("/sys/fs/cgroup")
_limit: int | None = None

Change = Callable[[NDArray[Any]], NDArray[Any]]
Record = TypeVar("Record", bound=Any)


def set_memory(limit: int | None) -> None:
    """Let this process use so many bytes of memory from now on; None: as much as there is.

    Parameters
    ----------
    limit
        Largest resident size of the process [bytes], the libraries' share included; 384 MiB and
        more. Maps that would take more stay on disk and are read in parts; what cannot be done so
        is refused with a sentence.

    Raises
    ------
    InputError
        If the limit is smaller.

    Examples
    --------
    >>> import asperity
    >>> asperity.set_memory(2 << 30)
    >>> asperity.set_memory(None)
    """
    global _limit
    if limit is not None and not _PROGRAM <= as_number("the memory limit", limit) < math.inf:
        least = f"give at least {_PROGRAM >> 20} MiB"
        raise InputError(f"the memory limit is {limit:.0f} bytes; {least}")
    _limit = None if limit is None else int(limit)
    # the GNU C library keeps arrays below 32 MiB when they are freed, and takes a tenth more memory
    # for a map of 8192^2 points; now it gives large ones back to the system at once
    if limit is not None and os.name == "posix":
        getattr(ctypes.CDLL(None), "mallopt", lambda *_: 1)(_MMAP_THRESHOLD, _LARGE)


def available_bytes() -> int:
    """Memory that this process may still take [bytes]: what can be had without swapping, less what
    `set_memory` withholds."""
    free = _free_bytes()
    return free if _limit is None else max(0, min(free, _limit - _resident_bytes()))


def _resident_bytes() -> int:
    """Memory that this process holds; its largest so far where the system tells no more."""
    try:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _free_bytes() -> int:
    """Memory that can be had without swapping [bytes]; 4 GiB where the system does not say."""
    if _MEMINFO.is_file():
        for line in _MEMINFO.read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return min(int(line.split()[1]) * 1024, _left_in_container())
    names = os.sysconf_names if hasattr(os, "sysconf_names") else {}
    if "SC_PHYS_PAGES" in names and "SC_PAGE_SIZE" in names:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2
    return 4 << 30


def _left_in_container() -> int:
    """What the limit of a container leaves [bytes]; no limit is a very large number."""
    try:
        limit = (_CGROUP / "memory.max").read_text().strip()
        used = (_CGROUP / "memory.current").read_text().strip()
    except OSError:
        return 1 << 62
    return max(0, int(limit) - int(used)) if limit.isdigit() else 1 << 62


def require_memory(needed: int, what: str, remedy: str) -> None:
    """Refuse what needs so many bytes at its peak and would not fit, in a sentence with the subject
    `what` and a remedy."""
    free = available_bytes()
    if needed > free:
        raise SurfaceError(
            f"{what} needs {needed / 1e9:.3g} GB of memory and {free / 1e9:.3g} GB are available; "
            f"{remedy}"
        )


def room_for(least: int, what: str) -> int:
    """Bytes for the arrays of a map in sections, within the limit of `set_memory`; 2 GiB if none.

    Less than the `least` that a section takes is refused in a sentence with the subject `what`.
    """
    bound = _USUAL if _limit is None else _limit
    if bound - _PROGRAM < least:
        raise InputError(
            f"{what} takes {-(-(_PROGRAM + least) >> 20)} MiB of memory or more, not "
            f"{bound / 2**20:.4g} MiB"
        )
    require_memory(least, what, "raise the limit of memory, or free some")
    return min(bound - _PROGRAM, available_bytes())


def zeros(shape: tuple[int, ...], dtype: Any, stored: bool) -> NDArray[Any]:
    """An array of zeros: in memory, or in a file as if it were there, see `stored_array.mapped`."""
    if not stored:
        return np.zeros(shape, dtype)
    return StoredArray((shape[0], math.prod(shape[1:])), dtype, dtype).mapped.reshape(shape)


def on_disk(record: Record) -> Record:
    """A dataclass with all its arrays in files as if they were in memory."""
    moved = {}
    for field in dataclasses.fields(record):
        values = getattr(record, field.name)
        if isinstance(values, np.ndarray) and values.size > 1 and not _in_file(values):
            moved[field.name] = zeros(values.shape, values.dtype, True)
            moved[field.name][...] = values
    drop_pages()
    return dataclasses.replace(record, **moved)


def _in_file(values: Any) -> bool:
    while isinstance(values, np.ndarray):
        values = values.base
    return isinstance(values, mmap.mmap)


class Transform(NamedTuple):
    """A change of an array along its rows, then along its columns, then along its rows again.

    Attributes
    ----------
    width
        Columns after the first change.
    rows, columns, back
        The changes: of whole rows, of the whole columns of a slice, of whole rows.
    tallest
        Elements of a column while it is changed, if more than before and after.
    """

    width: int
    rows: Change
    columns: Callable[[slice, NDArray[Any]], NDArray[Any]]
    back: Change
    tallest: int = 0


def along_both(blocks: Blocks, like: Source, shape: tuple[int, int], change: Transform) -> Source:
    """An array of a shape, made by a change of blocks of whole rows, each with the number of its
    first row; on disk if `like`, of the shape before, is, and then by sections of columns.

    Raises
    ------
    InputError, SurfaceError
        If memory or disk have no room.
    """
    count, made = len(like), shape[0]
    width, rows, columns, back, tallest = change
    kind = rows(np.zeros((1, like.shape[1]))).dtype
    if isinstance(like, np.ndarray):
        changed = np.empty((count, width), kind)
        for first, block in blocks:
            changed[first : first + len(block)] = rows(block)
        found = back(columns(slice(0, width), changed))
        found.setflags(write=False)
        return found
    tall = _WORK * max(count, made, tallest)
    room = room_for(4 * tall, f"a filter of {count} x {width} waves")
    before = Sections((count, width), room // tall, kind)
    for first, block in blocks:
        before.write_rows(first, rows(block))
    after = Sections((made, width), room // tall, kind)
    for number, place in enumerate(before.columns):
        after.write(number, 0, columns(slice(*place), before.read(number)))
    del before
    step = max(1, room // (_WORK * max(width, shape[1])))

    def changed_back() -> Iterator[tuple[int, Array]]:
        for first, last in spans(made, step):
            parts = [after.read(number, first, last) for number in range(len(after.columns))]
            yield first, back(np.concatenate(parts, axis=1))

    return array_of(changed_back(), shape, like)
