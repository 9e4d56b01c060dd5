"""A map by blocks of rows: one block in memory, many from a file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from surfaces.heightmap import HeightMap, require_map
from surfaces.numerics import parallel

__all__ = [
    "MapFile",
    "Source",
    "heights_of",
    "over_present",
    "over_rows",
    "require_source",
    "rows_of",
]

Array = NDArray[np.float64]
Result = TypeVar("Result")


class MapFile(Protocol):
    """A map in a file that is read in parts: what `surfaces.SurfaceFile` offers."""

    shape: tuple[int, int]
    spacing: tuple[float, float]
    periodic: bool

    def heights(
        self, rows: tuple[int, int] | None = None, columns: tuple[int, int] | None = None
    ) -> NDArray[np.float64]:
        """Heights [m] of a region."""
        ...

    def blocks(self, rows: int | None = None) -> Iterator[tuple[int, NDArray[np.float64]]]:
        """Index of the first row and heights [m] of blocks of whole rows."""
        ...


Source = HeightMap | MapFile


def require_source(source: Source) -> None:
    """Refuse what is neither a height map nor a file of one."""
    if not hasattr(source, "blocks"):
        require_map(source)


def heights_of(
    source: Source, rows: tuple[int, int] | None = None, columns: tuple[int, int] | None = None
) -> NDArray[np.float64]:
    """Heights [m] of a region; the limits are the first and one past the last, None is all."""
    if not isinstance(source, HeightMap):
        return source.heights(rows, columns)
    return source.heights[slice(*(rows or (None,))), slice(*(columns or (None,)))]


def rows_of(source: Source) -> Iterator[Array]:
    """Heights [m] of whole rows, block after block."""
    if isinstance(source, HeightMap):
        yield source.heights
    else:
        yield from (block for _, block in source.blocks())


def over_rows(function: Callable[[Array], Result], source: Source) -> Iterator[Result]:
    """What a function finds in blocks of whole rows, in order; in threads if they are of a file."""
    parts = 1 if isinstance(source, HeightMap) else parallel.threads()
    for block in rows_of(source):
        yield from parallel.each(function, np.array_split(block, min(parts, len(block))))


def over_present(function: Callable[[Array], Result], source: Source) -> Iterator[Result]:
    """As `over_rows`, of the heights of the points present."""
    return over_rows(lambda block: function(block[np.isfinite(block)]), source)
