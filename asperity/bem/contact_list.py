"""The points of a grid among which a contact is sought."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Index, Mask
from surfaces.numerics.parallel import by_rows

from ._grid_kernels import put, take

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

    start: Index
    columns: NDArray[np.int32]

    def __len__(self) -> int:
        return self.columns.size

    def where(self, kept: Mask) -> ContactList:
        """The entries that are kept, by a mask of shape (n,)."""
        before = np.append(0, np.cumsum(kept))
        return ContactList(before[self.start], self.columns[kept])

    def fill(self, grid: NDArray[Any], values: NDArray[Any]) -> None:
        """Write values (n,) at the points of a grid, zero elsewhere."""
        by_rows(put, (self.start.size - 1, grid.shape[1]), grid, self.start, self.columns, values)

    def read(self, grid: NDArray[Any], values: NDArray[Any]) -> None:
        """Read the points of a grid into values (n,)."""
        by_rows(take, (self.start.size - 1, grid.shape[1]), grid, self.start, self.columns, values)
