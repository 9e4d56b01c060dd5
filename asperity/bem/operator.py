"""The exact half-space operator: surface displacement of a pressure on the whole grid."""

from __future__ import annotations

import numpy as np
import scipy.fft

from asperity.halfspace.influence import compliance, influence, symbol_quadrant
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import Boundary
from surfaces.arrays import Array
from surfaces.numerics.parallel import threads

from . import convolution

__all__ = ["HalfSpaceOperator"]


class HalfSpaceOperator:
    """Displacement of an elastic half-space under a pressure that is constant on each pixel of a
    grid (ny, nx).

    Periodic: the cell repeats, and u has zero mean, ``u^(q) = Lambda(q) p^(q)`` with
    ``Lambda ~ |q|**(m-1)`` and ``Lambda(0) = 0``. Free: the half-space is at rest at infinity and
    carries no pressure outside the grid; exact cell-integrated influence, convolved by zero padding
    (docs/development/half_space.md).

    Attributes
    ----------
    pressure, displacement
        Pressure p~, which `apply` reads, and the displacement [m] that it found last: ny rows, nx
        or more columns.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        material: HalfSpace,
        boundary: Boundary = "periodic",
    ) -> None:
        self.shape = shape
        self.spacing = spacing
        self.m = float(material.m)
        self.boundary = boundary
        self.compliance = compliance(spacing, material)
        self.pairs = 0
        self.padded = shape
        if boundary != "periodic":  # fast even lengths that keep all points clear of their images
            ny, nx = (2 * scipy.fft.next_fast_len(n, real=True) for n in shape)
            self.padded = (ny, nx)
        self.symbol = self._scaled_symbol()
        self._convolution = convolution.plan(shape, self.padded)
        self.pressure = self._convolution.values
        self.displacement = self._convolution.grid

    def _scaled_symbol(self) -> Array:
        """Quadrant of the dimensionless symbol, divided by the number of points of the transform.

        The influence is even along both axes, so that its transform is a cosine transform of one
        quadrant.
        """
        points = self.padded[0] * self.padded[1]
        if self.boundary == "periodic":
            return symbol_quadrant(self.shape, self.spacing, self.m - 1.0, 1.0 / points)
        ny, nx = self.padded
        quadrant = influence((ny // 2 + 1, nx // 2 + 1), self.spacing, self.m, 1.0 / points)
        values = scipy.fft.dctn(quadrant, type=1, workers=threads(), overwrite_x=True)
        return np.asarray(values)

    def apply(self) -> Array:
        """Displacement [m] of the pressure p~ in `pressure`: a buffer of ny rows, nx or more wide.

        p~ [m] is the pressure times `compliance`; columns of `pressure` beyond nx must be zero.
        """
        self._convolution.apply(self.symbol)
        self.pairs += 1
        return self.displacement
