"""A large array of complex numbers in a file, for transforms of maps that memory does not hold."""

from __future__ import annotations

import itertools
import math
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surfaces.errors import InputError

__all__ = ["Scratch", "spans"]

Span = tuple[int, int]


class Scratch:
    """Complex numbers, shape (ny, nx), in sections of columns in a file without a name.

    Sections are written and read in parts of whole rows. The file goes with the object.

    Parameters
    ----------
    shape
        Rows and columns.
    width
        Columns of a section.
    folder
        Folder of the file; that of temporary files if None.
    """

    def __init__(self, shape: tuple[int, int], width: int, folder: Path | None = None) -> None:
        self.shape = shape
        self.sections = spans(shape[1], width)
        self._folder = folder or Path(tempfile.gettempdir())
        self._file = tempfile.TemporaryFile(dir=self._folder)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()

    def write(self, section: Span, row: int, values: NDArray[np.complex128]) -> None:
        """Write rows of a section, from a first one on.

        Raises
        ------
        InputError
            If there is no room for the file.
        """
        self._seek(section, row)
        try:
            values.tofile(self._file)
        except OSError as error:
            raise InputError(
                f"{self._folder}: a temporary file of {16e-9 * math.prod(self.shape):.3g} GB "
                f"cannot be written ({error.strerror or error}); make room for it"
            ) from error

    def read(self, section: Span, rows: Span) -> NDArray[np.complex128]:
        """Rows of a section."""
        self._seek(section, rows[0])
        shape = rows[1] - rows[0], section[1] - section[0]
        return np.fromfile(self._file, np.complex128, shape[0] * shape[1]).reshape(shape)

    def _seek(self, section: Span, row: int) -> None:
        self._file.seek(16 * (self.shape[0] * section[0] + row * (section[1] - section[0])))


def spans(count: int, step: int) -> list[Span]:
    """First and one-past-last numbers of parts of ``range(count)``."""
    return list(itertools.pairwise([*range(0, count, step), count]))
