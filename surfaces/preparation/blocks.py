"""What the steps of a preparation ask of a map in blocks of rows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics.memory import room_for
from surfaces.numerics.stored_array import Sections, Source, array_of, spans, windows

__all__ = ["Blocks", "along_both", "blocks_of", "extremes", "middle", "replaced"]

Array = NDArray[np.float64]
Blocks = Iterable[tuple[int, Array]]
Change = Callable[[NDArray[Any]], NDArray[Any]]

_WORK = 96
"""Bytes for each element of a section: as it is read, transformed, weighed and written."""


def along_both(
    blocks: Blocks,
    shapes: tuple[tuple[int, int], tuple[int, int], tuple[int, int]],
    like: Source,
    rows: Change,
    columns: Callable[[slice, NDArray[Any]], NDArray[Any]],
    back: Change,
    tallest: int = 0,
) -> Source:
    """An array changed along its rows, then along its columns, then along its rows again; on disk
    if another is, and then by sections of columns.

    Parameters
    ----------
    blocks
        Blocks of whole rows, each with the number of its first row.
    shapes
        Rows and columns after each of the three changes.
    like
        The other array.
    rows, back
        Change whole rows.
    columns
        Changes whole columns, those of the slice.
    tallest
        Elements of a column while it is changed, if more than before and after.

    Raises
    ------
    InputError, SurfaceError
        If memory or disk have no room.
    """
    (count, width), (made, _), _ = shapes
    if isinstance(like, np.ndarray):
        changed = np.concatenate([rows(block) for _, block in blocks])
        changed = columns(slice(0, width), changed)
        found = back(changed)
        found.setflags(write=False)
        return found
    tall = _WORK * max(count, made, tallest)
    room = room_for(4 * tall, f"a filter of {count} x {width} waves")
    before: Sections | None = None
    for first, block in blocks:
        part = rows(block)
        before = before or Sections((count, width), room // tall, part.dtype)
        before.write_rows(first, part)
    assert before is not None
    after = Sections((made, width), room // tall, part.dtype)
    for number, place in enumerate(before.columns):
        after.write(number, 0, columns(slice(*place), before.read(number)))
    del before
    step = max(1, room // (_WORK * width))

    def changed_back() -> Iterator[tuple[int, Array]]:
        for first, last in spans(made, step):
            parts = [after.read(number, first, last) for number in range(len(after.columns))]
            yield first, back(np.concatenate(parts, axis=1))

    return array_of(changed_back(), shapes[2], like)


def blocks_of(source: Source) -> Blocks:
    """Blocks of whole rows, each with the number of its first row."""
    return ((begin, rows) for begin, _, rows, _ in windows(source))


def extremes(heights: Source) -> tuple[float, float]:
    """The lowest and the highest of the heights present."""
    low, high = np.nan, np.nan
    for _, _, rows, _ in windows(heights):
        low = np.fmin(low, np.fmin.reduce(rows, axis=None))
        high = np.fmax(high, np.fmax.reduce(rows, axis=None))
    return float(low), float(high)


def middle(heights: Source) -> float:
    """Median over the blocks of the medians of the heights present."""
    medians = []
    for _, _, rows, _ in windows(heights):
        present = rows[~np.isnan(rows)]
        if present.size:
            medians.append(float(np.median(present)))
    return float(np.median(medians))


def replaced(
    source: Source, places: NDArray[np.int64], heights: Array
) -> Iterator[tuple[int, Array]]:
    """Blocks of rows with other heights at some places, numbers in scan order that rise."""
    for begin, _, window, _ in windows(source):
        rows = window.copy()
        start = begin * rows.shape[1]
        part = slice(*np.searchsorted(places, (start, start + rows.size)))
        rows.flat[places[part] - start] = heights[part]
        yield begin, rows
