"""Structured arrays from named columns, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["columns", "structured"]


def structured(columns: Mapping[str, Any]) -> NDArray[np.void]:
    """One structured array from columns of equal length."""
    arrays = {name: np.asarray(column) for name, column in columns.items()}
    rows = len(next(iter(arrays.values())))
    table = np.empty(rows, [(name, a.dtype, a.shape[1:]) for name, a in arrays.items()])
    for name, array in arrays.items():
        table[name] = array
    return table


def columns(table: NDArray[np.void]) -> dict[str, NDArray[Any]]:
    """The named columns of a structured array."""
    return {name: table[name] for name in table.dtype.names or ()}
