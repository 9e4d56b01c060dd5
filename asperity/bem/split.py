"""The split operator: a fitted stencil at the listed points and a smooth remainder, in float32.

It is close to the exact operator (relative symbol error below 2 %, below 5e-4 for long waves) and
costs as much as the list is long, not as the grid is large.
"""

from __future__ import annotations

import math

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

from surfaces.arrays import Array, Index
from surfaces.numerics import parallel

from . import _split_kernels, convolution
from ._split_kernels import COARSENING, TAPS
from ._stencil_kernels import LANES, RADIUS
from .contact_list import ContactList
from .operator import HalfSpaceOperator
from .stencil import fitted_stencil, precondition_stencil, stencil_symbol

__all__ = ["SplitOperator"]

_ASPECT_STEP = 0.03
"""Logarithmic step to which pixel aspect ratios are rounded, so that stencils are found again."""

_LEAST_PLACES = 500
"""Tiles that repay a thread."""


class SplitOperator:
    """Approximation of an exact operator."""

    aim = 0.0015
    """Largest reduction of the error that one solve with this operator is worth."""

    def __init__(self, exact: HalfSpaceOperator) -> None:
        self.shape = exact.shape
        self.periodic = exact.boundary == "periodic"
        aspect = exact.spacing[0] / exact.spacing[1]
        fit_aspect = math.exp(_ASPECT_STEP * round(math.log(aspect) / _ASPECT_STEP))
        stencil = fitted_stencil(fit_aspect, exact.m, not self.periodic)
        inverse = precondition_stencil(fit_aspect, exact.m)
        self._near, self._inverse = (s.astype(np.float32).ravel() for s in (stencil, inverse))
        ny, nx = self.shape
        self._grid = np.zeros((ny + 2 * RADIUS + 1, nx + 2 * LANES), np.float32)
        nyc, nxc = (scipy.fft.next_fast_len(-(-n // COARSENING), real=True) for n in exact.padded)
        self._remainder = convolution.plan((nyc, nxc), (nyc, nxc), dtype=np.float32)
        self._down, self._across = _taps(ny, exact.padded[0], nyc), _taps(nx, exact.padded[1], nxc)
        self._whole = exact.padded[1] == COARSENING * nxc
        self._up = _by_coarse_point(*self._down, nyc)
        self._symbol = _remainder(exact, stencil, (nyc, nxc))

    def bind(self, points: ContactList) -> None:
        """Choose the list."""
        self._grid[:] = 0.0
        self._list = points
        stride = self._grid.shape[1]
        self._tiles = _split_kernels.cut_tiles(points.start, points.columns, stride)

    def _stencil(
        self, values: NDArray[np.float32], weights: NDArray[np.float32], short: bool
    ) -> NDArray[np.float32]:
        result = np.empty_like(values)
        points, tiles = self._list, self._tiles
        _split_kernels.place(
            self._grid, self.shape, self.periodic, points.start, points.columns, values
        )

        def on_tiles(first: int, last: int) -> None:
            some = tiles[first:last]
            _split_kernels.near_tiles(self._grid, some, points.columns, weights, short, result)

        parallel.run(on_tiles, parallel.blocks(len(tiles), _LEAST_PLACES))
        return result

    def apply(self, pressure: NDArray[np.float32]) -> NDArray[np.float32]:
        """Displacement at the points of a pressure p~ on them, nearly."""
        result = self._stencil(pressure, self._near, False)
        coarse, points = self._remainder, self._list
        parallel.by_rows(
            _split_kernels.spread,
            coarse.values.shape,
            points.start,
            points.columns,
            pressure,
            *self._across,
            *self._up,
            self._whole,
            coarse.values,
        )
        coarse.apply(self._symbol)
        parallel.by_rows(
            _split_kernels.gather,
            self.shape,
            points.start,
            points.columns,
            coarse.grid,
            *self._down,
            *self._across,
            coarse.values.shape[1],
            self._whole,
            result,
        )
        return result

    def precondition(self, residual: NDArray[np.float32]) -> NDArray[np.float32]:
        """Residual filtered by a short stencil of |q|**(1-m)."""
        return self._stencil(residual, self._inverse, True)


def _taps(count: int, period: int, coarse: int) -> tuple[Index, NDArray[np.float32]]:
    """First coarse point, -1 or more, and weights (count, order) of each point of the fine grid on
    one axis; the coarse points repeat."""
    place = np.arange(count) * (coarse / period)
    first = np.floor(place - 0.5 * TAPS).astype(np.int64) + 1
    spline = BSpline.basis_element(np.arange(TAPS + 1) - 0.5 * TAPS)
    weights = spline(place[:, None] - (first[:, None] + np.arange(TAPS)))
    return first, weights.astype(np.float32)


def _by_coarse_point(
    first: Index, weights: NDArray[np.float32], coarse: int
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float32]]:
    """The weights of `_taps` by coarse point: bounds of those of each, fine points and weights."""
    target = (first[:, None] + np.arange(TAPS)) % coarse
    source = np.repeat(np.arange(first.size), TAPS)
    table = csr_array((weights.ravel(), (target.ravel(), source)), (coarse, first.size))
    table.eliminate_zeros()
    return table.indptr, table.indices, table.data


def _remainder(
    exact: HalfSpaceOperator, stencil: Array, coarse: tuple[int, int]
) -> NDArray[np.float32]:
    """Quadrant of the coarse symbol: what the stencil leaves, over the transfer of the splines."""
    ky, kx = np.arange(coarse[0] // 2 + 1), np.arange(coarse[1] // 2 + 1)
    points = exact.padded[0] * exact.padded[1]
    near = stencil_symbol(stencil, ky / exact.padded[0], kx / exact.padded[1]) / points
    left = exact.symbol[: ky.size, : kx.size] - near
    left /= (np.sinc(ky / coarse[0])[:, None] * np.sinc(kx / coarse[1])[None, :]) ** (2 * TAPS)
    left[2 * ky == coarse[0], :] = 0.0
    left[:, 2 * kx == coarse[1]] = 0.0
    return np.asarray(left, np.float32)
