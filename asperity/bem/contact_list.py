"""The points that may come into contact: row by row, without the rest of the grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["ContactList"]


@dataclass(frozen=True)
class ContactList:
    """Points of a grid in row order.

    Attributes
    ----------
    start
        First entry of each row, shape (ny + 1,).
    columns
        Column of each entry, shape (n,).
    """

    start: NDArray[np.int64]
    columns: NDArray[np.int32]

    @classmethod
    def empty(cls) -> ContactList:
        """A list without points."""
        return cls(np.zeros(1, np.int64), np.empty(0, np.int32))

    def __len__(self) -> int:
        return self.columns.size

    def flat(self, stride: int) -> NDArray[np.int64]:
        """Flat index of each entry in rows of `stride` values."""
        rows = np.repeat(np.arange(self.start.size - 1) * stride, np.diff(self.start))
        return rows + self.columns
