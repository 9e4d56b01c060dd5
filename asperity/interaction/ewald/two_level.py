"""Points by coarse cells: the second level of the conjugate gradients of the contacts."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.footprint import Footprints
from surfaces.arrays import Array

from . import _near_kernels

__all__ = ["TwoLevelPreconditioner"]

MOST_CELLS = 10
"""Most cells along each side."""

POINTS_PER_CELL = 100
"""Points of a cell, on average."""

FEWEST_POINTS = 1_000
"""Points up to which cells do not pay."""

WAVES_PER_CELL = 8
"""Waves per cell along each side of which the kernel between cells is made."""


class TwoLevelPreconditioner:
    """The points by cells, as a second level for `conjugate_gradients`.

    Of the tangent matrix A = D + G, D diagonal, the own compliance of the contacts alone is a poor
    guess where many push each other down over long waves. A_c = P' D^-1 (D + P G_c P') D^-1 P is
    the matrix for forces that share one displacement within each cell, with K = P' D^-1 P the
    stiffness of the cells and G_c the kernel between uniform pressures on them. The inverse used is
    D^-1 + D^-1 P E P' D^-1, E = A_c^-1 - K^-1 = -(1 + G_c K)^-1 G_c: positive definite, and right
    for those forces.

    The places y, x of the points, shape (n,), lie in a cell with the sides `size` in their unit and
    `sides` in [m], which repeats if `wrap`.

    Attributes
    ----------
    cell
        Cell of each point, int32, shape (n,).
    """

    def __init__(
        self,
        y: Array,
        x: Array,
        size: tuple[float, float],
        sides: tuple[float, float],
        wrap: bool,
        footprints: Footprints,
    ) -> None:
        n = len(y)
        self.body, self.wrap, self.sides = footprints, wrap, sides
        self.count = min(MOST_CELLS, math.isqrt(n // POINTS_PER_CELL)) if n >= FEWEST_POINTS else 1
        self.cell = np.zeros(n, np.int32)
        if self.count > 1:
            row, column = (
                np.minimum((place * (self.count / size)).astype(np.int32), self.count - 1)
                for place, size in zip((y, x), size, strict=True)
            )
            self.cell = row * np.int32(self.count) + column

    @property
    def kernel(self) -> Array:
        """G_c [m/N], shape (cells, cells)."""
        return _kernel(self.body, self.sides, self.wrap, self.count)

    def inverse(self, cell: NDArray[np.int32], stiffness: Array) -> tuple[Array, Array]:
        """E [m/N], shape (cells, cells), and K [N/m], (cells,), of points in these cells."""
        if self.count == 1:
            return np.zeros((1, 1)), np.array([stiffness.sum()])
        total = np.asarray(np.bincount(cell, stiffness, self.count**2), float)
        coarse = -self.kernel
        # LAPACK wakes its own threads for this, which then keep a processor from ours for 30 ms
        _near_kernels.stiffened(coarse, total, np.empty(len(total)))
        return coarse, total


@lru_cache(maxsize=16)
def _kernel(body: Footprints, sides: tuple[float, float], wrap: bool, count: int) -> Array:
    """`TwoLevelPreconditioner.kernel`: on a free half-space that of a cell of twice the size, which
    repeats."""
    lines = count if wrap else 2 * count
    waves = np.fft.fftfreq(lines * WAVES_PER_CELL, 1 / (lines * WAVES_PER_CELL))
    extent = [side * lines / count for side in sides]
    q = np.hypot(*np.meshgrid(*(2 * np.pi * waves / side for side in extent), indexing="ij"))
    q[0, 0] = np.inf if wrap else q[0, 1]
    evened = np.sinc(waves / lines) ** 2
    symbol = body.symbol * q ** (body.m - 1) * np.multiply.outer(evened, evened)
    value = np.fft.ifft2(symbol).real[::WAVES_PER_CELL, ::WAVES_PER_CELL]
    value *= len(waves) ** 2 / math.prod(extent)
    row, column = np.divmod(np.arange(count**2), count)
    apart = (np.subtract.outer(place, place) % lines for place in (row, column))
    return np.asarray(value[tuple(apart)])
