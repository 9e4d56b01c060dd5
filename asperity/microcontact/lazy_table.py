"""Law tables made in blocks, when their contacts are first needed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .law_table import LawTable

__all__ = ["LazyTable"]

Rows = NDArray[np.int64]


class LazyTable:
    """The law table of n contacts, of which only the rows asked for are made.

    At light loads most summits never touch; their laws would cost more than all the rest.

    Parameters
    ----------
    count
        Number n of contacts.
    make
        Table of the contacts whose rows are given, in that order.

    Attributes
    ----------
    ready
        Rows that have been made, bool, shape (n,).
    """

    def __init__(self, count: int, make: Callable[[Rows], LawTable]) -> None:
        self.ready = np.zeros(count, bool)
        self._make = make
        self._table: LawTable | None = None

    def __len__(self) -> int:
        return len(self.ready)

    @property
    def table(self) -> LawTable:
        """The table of all contacts; rows that are not ready are zero, as without a usable law."""
        if self._table is None:
            self.ensure(np.zeros(1, np.int64))
        assert self._table is not None
        return self._table

    def ensure(self, rows: Rows) -> Rows:
        """Make the rows that are missing among `rows`, and return them."""
        missing = np.unique(rows[~self.ready[rows]])
        if not missing.size:
            return missing
        block = self._make(missing)
        if self._table is None:
            self._table = self._empty(block)
        for field in fields(LawTable):
            values = getattr(block, field.name)
            if isinstance(values, np.ndarray):
                getattr(self._table, field.name)[missing] = values
        self.ready[missing] = True
        return missing

    def _empty(self, block: LawTable) -> LawTable:
        """A table of zeros for all contacts, of the kind of one block."""
        made: dict[str, Any] = {}
        for field in fields(LawTable):
            value = getattr(block, field.name)
            if isinstance(value, np.ndarray):
                value = np.zeros((len(self), *value.shape[1:]), value.dtype)
            made[field.name] = value
        return LawTable(**made)
