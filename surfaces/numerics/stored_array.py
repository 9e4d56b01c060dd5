"""Arrays that stay on disk to spare memory, and loops over their parts."""

from __future__ import annotations

import functools
import io
import itertools
import math
import mmap
import os
import tempfile
import threading
import weakref
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Array, Index
from surfaces.errors import SurfaceError

__all__ = [
    "BLOCK_BYTES",
    "SAMPLED_LINES",
    "Blocks",
    "Sections",
    "Source",
    "StoredArray",
    "array_of",
    "blocks_of",
    "drop_pages",
    "each_block",
    "mapped",
    "most_together",
    "rows_around",
    "sampled_lines",
    "spans",
    "windows",
]

BLOCK_BYTES = 16 << 20
"""Part of an array on disk that one thread holds at a time [bytes]."""

_SCATTERED = 16
"""Places, far from each other, that a loop over a mapped array touches before it gives back what it
touched: about each the system maps 64 kB of every row."""

SAMPLED_LINES = 64
"""Number of lines along an axis from which what holds for all of them is estimated."""

_pages: weakref.WeakSet[mmap.mmap] = weakref.WeakSet()
_changing = threading.Lock()  # of `_pages`, while they are gone through

Span = tuple[int, int]


class _File(io.FileIO):
    """A file that is closed when nothing refers to it, without the warning of an open one."""

    def __del__(self) -> None:
        self.close()


class StoredArray:
    """An array (rows, columns) in a file of its own, which goes when nothing refers to it.

    Reads parts as numpy does for the indices ``[rows]`` and ``[rows, columns]``, each a number, a
    slice or an array of whole numbers; an array of both reads points.

    Parameters
    ----------
    dtype, read_as
        Types of the numbers in the file, and as they are read.
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
        with tempfile.TemporaryFile(dir=place, buffering=0) as file:
            self._file = _File(os.dup(file.fileno()), "r+")
        try:
            os.posix_fallocate(self._file.fileno(), 0, needed)
        except (OSError, OverflowError) as error:  # so many bytes have no 64-bit number
            remedy = "set TMPDIR to a folder that has" if folder is None else "make room there"
            raise SurfaceError(
                f"{place} has no room for {needed / 1e9:.3g} GB of a map that does not fit into "
                f"memory ({getattr(error, 'strerror', error)}); {remedy}"
            ) from error

    def __len__(self) -> int:
        return self.shape[0]

    @property
    def size(self) -> int:
        """Number of its elements."""
        return self.shape[0] * self.shape[1]

    def write(self, first: int, rows: NDArray[Any]) -> None:
        """Put whole rows in, from row `first` on."""
        data = np.ascontiguousarray(rows, self._kept).ravel().view(np.uint8)  # there may be none
        view, at = data.data, first * self.shape[1] * self._kept.itemsize
        while len(view):
            done = os.pwrite(self._file.fileno(), view, at)
            view, at = view[done:], at + done

    def each(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> StoredArray:
        """The array with every element changed as it is read."""
        other = object.__new__(type(self))
        vars(other).update(vars(self), _changes=(*self._changes, change))
        vars(other).pop("mapped", None)
        return other

    @functools.cached_property
    def mapped(self) -> NDArray[Any]:
        """The whole as an array whose pages are read when they are touched; see `drop_pages`."""
        kept = self
        if self._changes or self._kept != self.dtype:
            kept = StoredArray(self.shape, self.dtype, self.dtype)
            for begin, _, rows in windows(self):
                kept.write(begin, rows)
        pages = mmap.mmap(kept._file.fileno(), 0)
        with _changing:
            _pages.add(pages)
        return np.ndarray(self.shape, self.dtype, pages)

    def __getitem__(self, index: Any) -> NDArray[Any]:
        rows, columns = (*(index if isinstance(index, tuple) else (index,)), slice(None))[:2]
        lines, places = np.arange(self.shape[0])[rows], np.arange(self.shape[1])[columns]
        if isinstance(rows, slice) or isinstance(columns, slice):
            found = np.empty((lines.size, places.size), self.dtype)
            for part in self._runs(lines.ravel()):
                self._read(int(lines.ravel()[part.start]), places.ravel(), found[part])
            return found.reshape(*lines.shape, *places.shape)
        lines, places = np.broadcast_arrays(lines, places)
        points = np.empty(lines.size, self.dtype)
        order = np.argsort(lines, axis=None, kind="stable")
        held, first = np.unique(lines.ravel()[order], return_index=True)
        along = places.ravel()
        for line, here in zip(held.tolist(), np.split(order, first[1:]), strict=False):
            row = np.empty((1, here.size), self.dtype)
            self._read(line, along[here], row)
            points[here] = row[0]
        return points.reshape(lines.shape)[()]

    def _runs(self, lines: Index) -> Iterator[slice]:
        """Parts of a list of rows that follow each other, of `BLOCK_BYTES` at most."""
        most = max(1, BLOCK_BYTES // (self.shape[1] * self.dtype.itemsize))
        ends = np.append(np.flatnonzero(np.diff(lines) != 1) + 1, lines.size)
        start = 0
        for end in ends.tolist():
            while start < end:
                yield slice(start, min(start + most, end))
                start = min(start + most, end)

    def _read(self, first: int, places: Index, out: NDArray[Any]) -> None:
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


Source = NDArray[Any] | StoredArray
Blocks = Iterable[tuple[int, Array]]


def windows(
    source: Source, first: int = 0, last: int | None = None, below: int = 0
) -> Iterator[tuple[int, int, Array]]:
    """The rows from `first` to `last` of an array in parts, the same in memory and on disk: sums
    over them are equal to the last digit.

    Yields
    ------
    begin, end
        Rows of this part.
    window
        A read-only array of them and `below` more after them, as if the whole were repeated: row i
        is ``window[(i - begin) % len(window)]``.
    """
    count = source.shape[0]
    last = count if last is None else last
    step = max(1, BLOCK_BYTES // (8 * source.shape[1]))
    for begin in range(first, last, step):
        end = min(begin + step, last)
        window = source[begin : min(end + below, count)]
        if end + below > count:
            window = np.concatenate([window, source[np.arange(count, end + below) % count]])
        window = window.view()
        window.setflags(write=False)  # loops are compiled for arrays of one kind
        yield begin, end, window


def blocks_of(source: Source) -> Blocks:
    """Blocks of whole rows, each with the number of its first row."""
    return ((begin, rows) for begin, _, rows in windows(source))


def rows_around(source: Source, top: int, bottom: int, periodic: bool) -> NDArray[Any]:
    """Rows from `top` to `bottom` of an array that is repeated, or as many of them as there are."""
    if periodic and (top < 0 or bottom > len(source)):
        return source[np.arange(top, bottom) % len(source)]
    return source[max(top, 0) : min(bottom, len(source))]


def sampled_lines(source: Source, axis: int) -> NDArray[Any]:
    """Some lines of an array along an axis, evenly spread, shape (lines, points)."""
    stride = max(1, source.shape[1 - axis] // SAMPLED_LINES)
    return source[::stride] if axis else np.ascontiguousarray(source[:, ::stride].T)


def mapped(source: Source) -> NDArray[Any]:
    """An array for loops that take it whole: itself, or its file as if it were in memory.

    Loops over many parts keep to the memory that they may take if each part lies together.
    """
    return source.mapped if isinstance(source, StoredArray) else source


def most_together(source: Source) -> float:
    """So many places of an array may one part of a loop touch, see `parallel.blocks`."""
    return _SCATTERED if isinstance(source, StoredArray) else math.inf


def drop_pages() -> None:
    """Give back the memory of all pages of mapped arrays that were touched; they stay on disk."""
    if not len(_pages):  # to walk through no pages takes 3 us, at the end of every loop
        return
    with _changing:
        held = list(_pages)
    for pages in held:
        pages.madvise(mmap.MADV_DONTNEED)


def each_block(source: Source, change: Callable[[Any], Any]) -> Any:
    """An array with every element changed, at once or as it is read."""
    return source.each(change) if isinstance(source, StoredArray) else change(source)


def array_of(blocks: Blocks, shape: tuple[int, int], like: Source) -> Source:
    """An array of blocks of whole rows, each with the number of its first row; on disk if another
    is."""
    if isinstance(like, StoredArray):
        kept = StoredArray(shape, np.float64)
        for first, rows in blocks:
            kept.write(first, rows)
        return kept
    array = np.empty(shape)
    for first, rows in blocks:
        array[first : first + len(rows)] = rows
    array.setflags(write=False)
    return array


class Sections:
    """An array (ny, nx) on disk that is written and read in parts of rows of sections of columns.

    Each section has `width` columns, the last one perhaps fewer; `columns` holds the first and
    one-past-last of each. The file is that of a `StoredArray`.
    """

    def __init__(
        self, shape: tuple[int, int], width: int, dtype: Any, folder: Path | None = None
    ) -> None:
        self.columns = spans(shape[1], width)
        self._rows, self._width = shape[0], min(width, shape[1])
        self._stored = StoredArray(
            (shape[0] * len(self.columns), self._width), dtype, dtype, folder
        )

    def write(self, section: int, first: int, values: NDArray[Any]) -> None:
        """Put rows of a section in, from row `first` on."""
        short = self._width - values.shape[1]
        whole = np.pad(values, ((0, 0), (0, short))) if short else values
        self._stored.write(section * self._rows + first, whole)

    def write_rows(self, first: int, values: NDArray[Any]) -> None:
        """Put whole rows in, from row `first` on."""
        for section, columns in enumerate(self.columns):
            self.write(section, first, values[:, slice(*columns)])

    def read(self, section: int, first: int = 0, last: int | None = None) -> NDArray[Any]:
        """Rows of a section from `first` to `last`, all by default."""
        last, (left, right) = self._rows if last is None else last, self.columns[section]
        rows = self._stored[section * self._rows + first : section * self._rows + last]
        return rows[:, : right - left]


def spans(count: int, step: int) -> list[Span]:
    """First and one-past-last numbers of parts of ``range(count)``."""
    return list(itertools.pairwise([*range(0, count, step), count]))
