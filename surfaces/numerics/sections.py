"""Arrays on disk in sections of columns, for transforms of maps that memory does not hold."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .memory import StoredArray

__all__ = ["Sections", "spans"]

Span = tuple[int, int]


class Sections:
    """An array (ny, nx) on disk that is written and read in parts of rows of sections of columns.

    Parameters
    ----------
    shape
        Rows and columns.
    width
        Columns of a section; the last one may have fewer.
    dtype
        Type of the numbers.
    folder
        Folder of the file; that of temporary files if None.

    Attributes
    ----------
    columns
        First and one-past-last column of each section.

    Raises
    ------
    SurfaceError
        If there is no room for the file.
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
