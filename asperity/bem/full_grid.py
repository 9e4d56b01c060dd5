"""The operator and its preconditioner on a contact list, by transforms of the whole grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import transform
from .kernel import symbol
from .operator import HalfSpaceOperator

__all__ = ["FullGridOperator"]


class FullGridOperator:
    """Exact operator restricted to a list of points: right at any filling, two FFTs each time.

    Parameters
    ----------
    exact
        Operator on the whole grid; its counter of transform pairs runs on.
    """

    exact = True

    def __init__(self, exact: HalfSpaceOperator) -> None:
        self._operator = exact
        self._grid = np.zeros(exact.shape)
        if exact.padded == exact.shape:
            self._transform = exact.transform
        else:
            self._transform = transform.plan(exact.shape, threads=exact.threads)
        self._inverse = symbol(exact.shape, exact.spacing, 1.0 - exact.m)
        self._inverse[0, 0] = 0.5 * min(self._inverse[0, 1], self._inverse[1, 0])
        self._inverse /= exact.shape[0] * exact.shape[1]
        self._points: NDArray[np.intp] = np.empty(0, np.intp)

    def bind(self, points: NDArray[np.intp]) -> None:
        """Choose the list: flat indices into the grid, ascending."""
        self._points = points
        self._grid[:] = 0.0

    def apply(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Displacement at the points of a pressure p~ on them."""
        self._grid.ravel()[self._points] = pressure
        return self._operator.displacement(self._grid)[np.divmod(self._points, self._grid.shape[1])]

    def precondition(self, residual: NDArray[np.float64]) -> NDArray[np.float64]:
        """Residual filtered by |q|**(1-m), the inverse of the operator without constraints."""
        ny, nx = self._grid.shape
        grid, spectrum = self._transform.grid, self._transform.spectrum
        values = grid[:ny, :nx]
        values[:] = 0.0
        rows, cols = np.divmod(self._points, nx)
        values[rows, cols] = residual
        self._transform.forward()
        spectrum = self._transform.spectrum
        np.multiply(spectrum, self._inverse, out=spectrum)
        self._transform.backward()
        return self._transform.grid[rows, cols]
