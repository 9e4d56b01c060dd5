"""What the contacts do to each other from afar, by cells: it helps conjugate gradients."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .operator import Interaction

__all__ = ["Afar"]

CELLS = 10
"""Cells along each side."""

FINER = 8
"""Waves per cell along each side of which the kernel between cells is made."""

MANY = 5_000
"""Points from which on cells pay."""


class Afar:
    """The points of a plan by cells, for `conjugate_gradients`.

    Of the tangent matrix A = D + G, D diagonal, the own compliance of the contacts alone is a poor
    guess where many push each other down over long waves. A_c = P' D^-1 (D + P G_c P') D^-1 P is
    the matrix for forces that share one displacement within each cell, with K = P' D^-1 P the
    stiffness of the cells and G_c the kernel between uniform pressures on them. The inverse used is
    D^-1 + D^-1 P E P' D^-1, E = A_c^-1 - K^-1 = -(1 + G_c K)^-1 G_c: positive definite, and right
    for those forces.

    Parameters
    ----------
    plan
        Interaction of the points.

    Attributes
    ----------
    cell
        Cell of each point, int32, shape (n,).
    """

    def __init__(self, plan: Interaction) -> None:
        n = len(plan.y)
        # not the plan itself, whose memory should be free as soon as it is not used
        self.body, self.wrap = plan.footprints, plan.wrap
        self.sides = plan.size[0] * plan.eta, plan.size[1] * plan.eta
        self.count = CELLS if n >= MANY else 1
        self.cell = np.zeros(n, np.int32)
        if self.count > 1:
            row, column = (
                np.minimum((place * (self.count / size)).astype(np.int32), self.count - 1)
                for place, size in zip((plan.y, plan.x), plan.size, strict=True)
            )
            self.cell = row * np.int32(self.count) + column

    @cached_property
    def kernel(self) -> NDArray[np.float64]:
        """G_c [m/N], shape (cells, cells): on a free half-space that of a cell of twice the size,
        which repeats."""
        body, repeats = self.body, 1 if self.wrap else 2
        count = self.count * repeats
        waves = np.fft.fftfreq(count * FINER, 1 / (count * FINER))
        sides = [side * repeats for side in self.sides]
        q = np.hypot(*np.meshgrid(*(2 * np.pi * waves / side for side in sides), indexing="ij"))
        q[0, 0] = np.inf if self.wrap else q[0, 1]
        evened = np.sinc(waves / count) ** 2
        symbol = body.symbol * q ** (body.m - 1) * np.multiply.outer(evened, evened)
        value = np.fft.ifft2(symbol).real[::FINER, ::FINER] * (len(waves) ** 2 / np.prod(sides))
        row, column = np.divmod(np.arange(self.count**2), self.count)
        apart = (np.subtract.outer(place, place) % count for place in (row, column))
        return np.asarray(value[tuple(apart)])

    def inverse(
        self, cell: NDArray[np.int32], stiffness: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """E [m/N], shape (cells, cells), and K [N/m], (cells,), of points in these cells."""
        if self.count == 1:
            return np.zeros((1, 1)), np.array([stiffness.sum()])
        total = np.asarray(np.bincount(cell, stiffness, self.count**2), float)
        matrix = self.kernel * total
        matrix[np.diag_indices(len(total))] += 1.0
        return np.linalg.solve(matrix, -self.kernel), total
