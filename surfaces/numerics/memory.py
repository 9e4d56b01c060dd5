"""The memory that may be used, and arrays that stay on disk to spare it."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.errors import InputError, SurfaceError, as_number

__all__ = [
    "BLOCK_BYTES",
    "StoredArray",
    "available_bytes",
    "each_block",
    "require_memory",
    "room_for",
    "set_memory",
    "windows",
]

BLOCK_BYTES = 16 << 20
"""Part of an array on disk that one thread holds at a time [bytes]."""

_USUAL = 2 << 30
"""Memory of a program that works on a map in sections of columns, if nothing limits it [bytes]."""

_PROGRAM = 384 << 20
"""What the program takes beside the arrays of a map that is worked on in blocks, libraries
included."""

_MEMINFO = Path("/proc/meminfo")
_CGROUP = Path("/sys/fs/cgroup")
_limit: int | None = None


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
    if limit is not None and not as_number("the memory limit", limit) > _PROGRAM:
        raise InputError(f"the memory limit is {limit} bytes; give at least {_PROGRAM >> 20} MiB")
    _limit = None if limit is None else int(limit)


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
    """Refuse in one sentence what would not fit.

    Parameters
    ----------
    needed
        Bytes that the step will hold at its peak.
    what
        Subject of the sentence.
    remedy
        What to do instead.
    """
    free = available_bytes()
    if needed > free:
        raise SurfaceError(
            f"{what} needs {needed / 1e9:.3g} GB of memory and {free / 1e9:.3g} GB are available; "
            f"{remedy}"
        )


def room_for(least: int, what: str) -> int:
    """Bytes for the arrays of a map in sections, within the limit of `set_memory`; 2 GiB if none.

    Parameters
    ----------
    least
        Bytes of arrays without which there is no section.
    what
        Subject of the sentence that refuses less.
    """
    bound = _USUAL if _limit is None else _limit
    if bound - _PROGRAM < least:
        raise InputError(
            f"{what} takes {-(-(_PROGRAM + least) >> 20)} MiB of memory or more, not "
            f"{bound / 2**20:.4g} MiB"
        )
    require_memory(least, what, "raise the limit of memory, or free some")
    return min(bound - _PROGRAM, available_bytes())


class StoredArray:
    """An array (rows, columns) in a file of its own, which goes when nothing refers to it.

    Reads parts as numpy does for the indices ``[rows]`` and ``[rows, columns]``, each a number, a
    slice or an array of whole numbers; an array of both reads points.

    Parameters
    ----------
    shape
        Rows and columns.
    dtype
        Type of the numbers in the file.
    read_as
        Type of the numbers as they are read.
    folder
        Folder of the file; that of temporary files if None.

    Raises
    ------
    SurfaceError
        If there is no room for the file.
    """

    ndim = 2

    def __init__(
        self,
        shape: tuple[int, int],
        dtype: Any,
        read_as: Any = np.float64,
        folder: Path | None = None,
    ) -> None:
        self.shape = shape
        self.dtype = np.dtype(read_as)
        self._kept = np.dtype(dtype)
        self._changes: tuple[Callable[[NDArray[Any]], NDArray[Any]], ...] = ()
        needed, place = shape[0] * shape[1] * self._kept.itemsize, folder or tempfile.gettempdir()
        self._file = tempfile.TemporaryFile(dir=place, buffering=0)
        try:
            os.posix_fallocate(self._file.fileno(), 0, needed)
        except OSError as error:
            remedy = "set TMPDIR to a folder that has" if folder is None else "make room there"
            raise SurfaceError(
                f"{place} has no room for {needed / 1e9:.3g} GB of a map that does not fit into "
                f"memory ({error.strerror}); {remedy}"
            ) from error

    def __len__(self) -> int:
        return self.shape[0]

    @property
    def size(self) -> int:
        """Number of its elements."""
        return self.shape[0] * self.shape[1]

    def write(self, first: int, rows: NDArray[Any]) -> None:
        """Put whole rows in, from row `first` on."""
        data = np.ascontiguousarray(rows, self._kept)
        view, at = data.data.cast("B"), first * self.shape[1] * self._kept.itemsize
        while len(view):
            done = os.pwrite(self._file.fileno(), view, at)
            view, at = view[done:], at + done

    def each(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> StoredArray:
        """The array with every element changed as it is read."""
        other = object.__new__(type(self))
        vars(other).update(vars(self), _changes=(*self._changes, change))
        return other

    def __sub__(self, number: float) -> StoredArray:
        return self.each(lambda values: values - number)

    def __getitem__(self, index: Any) -> NDArray[Any]:
        rows, columns = (*(index if isinstance(index, tuple) else (index,)), slice(None))[:2]
        lines, places = np.arange(self.shape[0])[rows], np.arange(self.shape[1])[columns]
        if isinstance(rows, slice) or isinstance(columns, slice):
            found = np.empty((lines.size, places.size), self.dtype)
            for part in self._runs(lines.ravel()):
                self._read(int(lines.ravel()[part.start]), places.ravel(), found[part])
            return found.reshape(*lines.shape, *places.shape)
        lines, places = np.broadcast_arrays(lines, places)
        points = np.empty(lines.shape, self.dtype)
        for line in np.unique(lines):
            here = lines == line
            row = np.empty((1, int(here.sum())), self.dtype)
            self._read(int(line), places[here], row)
            points[here] = row[0]
        return points[()]

    def _runs(self, lines: NDArray[np.int64]) -> Iterator[slice]:
        """Parts of a list of rows that follow each other, of `BLOCK_BYTES` at most."""
        most = max(1, BLOCK_BYTES // (self.shape[1] * self.dtype.itemsize))
        ends = np.append(np.flatnonzero(np.diff(lines) != 1) + 1, lines.size)
        start = 0
        for end in ends.tolist():
            while start < end:
                yield slice(start, min(start + most, end))
                start = min(start + most, end)

    def _read(self, first: int, places: NDArray[np.int64], out: NDArray[Any]) -> None:
        """Columns `places` of the rows from `first` on, as many as `out` has."""
        if not out.size:
            return
        width, step = self.shape[1], self._kept.itemsize
        low = int(places.min())
        count = int(places.max()) - low + 1
        in_line = count == len(places) and bool((np.diff(places) == 1).all())
        as_kept = in_line and not self._changes and self._kept == self.dtype
        kept = out if as_kept else np.empty((len(out), count), self._kept)
        if count == width:
            self._fill(kept, first * width * step)
        else:
            for row, line in enumerate(kept):
                self._fill(line, ((first + row) * width + low) * step)
        if as_kept:
            return
        values = kept if in_line else kept[:, places - low]
        for change in self._changes:
            values = change(values.astype(self.dtype, copy=False))
        out[...] = values

    def _fill(self, out: NDArray[Any], at: int) -> None:
        """Read a contiguous array from place `at` of the file."""
        view = out.data.cast("B")
        while len(view):
            done = os.preadv(self._file.fileno(), [view], at)
            view, at = view[done:], at + done


Source = NDArray[np.float64] | StoredArray


def windows(
    source: Source, first: int = 0, last: int | None = None, below: int = 0
) -> Iterator[tuple[int, int, NDArray[np.float64], int]]:
    """The rows from `first` to `last` of an array in parts: one part if it is in memory.

    Yields
    ------
    begin, end
        Rows of this part.
    window
        An array that holds them and `below` more after them, as if the whole were repeated: row i
        is ``window[(i - top) % len(window)]``.
    top
        The row with which it begins.
    """
    count = source.shape[0]
    last = count if last is None else last
    if isinstance(source, np.ndarray):
        yield first, last, source, 0
        return
    step = max(1, BLOCK_BYTES // (8 * source.shape[1]))
    for begin in range(first, last, step):
        end = min(begin + step, last)
        window = source[begin : min(end + below, count)]
        if end + below > count:
            window = np.concatenate([window, source[np.arange(count, end + below) % count]])
        yield begin, end, window, begin


def each_block(source: Source, change: Callable[[Any], Any]) -> Any:
    """An array with every element changed, at once or as it is read."""
    return source.each(change) if isinstance(source, StoredArray) else change(source)
