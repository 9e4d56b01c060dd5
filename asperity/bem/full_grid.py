"""Operator and preconditioner on a contact list by transforms of the whole grid, in float32.

It serves small grids, where a list saves nothing, and loads that the split operator is not sharp
enough for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.influence import symbol_quadrant

from . import convolution
from .contact_list import ContactList
from .operator import HalfSpaceOperator

__all__ = ["FullGridOperator"]


class FullGridOperator:
    """An exact operator in single precision on a contact list."""

    aim = 1e-3
    """Largest reduction of the error that one solve with this operator is worth."""

    def __init__(self, exact: HalfSpaceOperator) -> None:
        ny, nx = self._shape = exact.shape
        self._forward = self._backward = convolution.plan(
            exact.shape, exact.padded, dtype=np.float32
        )
        if exact.padded != exact.shape:
            self._backward = convolution.plan(exact.shape, exact.shape, dtype=np.float32)
        self._symbol = exact.symbol.astype(np.float32)
        inverse = symbol_quadrant(exact.shape, exact.spacing, 1.0 - exact.m, 1.0 / (ny * nx))
        inverse[0, 0] = 0.5 * min(inverse[0, 1], inverse[1, 0])
        self._inverse = inverse.astype(np.float32)

    def bind(self, points: ContactList) -> None:
        """Choose the list."""
        self._list = points

    def _filtered(
        self,
        whole: convolution.Convolution,
        factor: NDArray[np.float32],
        values: NDArray[np.float32],
    ) -> NDArray[np.float32]:
        self._list.fill(whole.values, values)
        whole.apply(factor)
        found = np.empty_like(values)
        self._list.read(whole.grid, found)
        return found

    def apply(self, pressure: NDArray[np.float32]) -> NDArray[np.float32]:
        """Displacement at the points of a pressure p~ on them."""
        return self._filtered(self._forward, self._symbol, pressure)

    def precondition(self, residual: NDArray[np.float32]) -> NDArray[np.float32]:
        """Residual filtered by |q|**(1-m), the inverse of the operator without constraints."""
        return self._filtered(self._backward, self._inverse, residual)
