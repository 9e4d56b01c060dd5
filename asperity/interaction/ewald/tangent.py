"""The tangent matrix of the closed contacts."""

from __future__ import annotations

import numpy as np

from surfaces.arrays import Array, Mask
from surfaces.numerics.parallel import each

from . import _mesh_kernels, _near_kernels
from .near_pairs import total
from .operator import Interaction

__all__ = ["Tangent"]


PAIRS_PER_THREAD = 40_000
"""Pairs whose part of a product repays a thread."""


class Tangent:
    """The matrix diag(1/k + extra) + g_ij(v_i + v_j), i != j, plus self-images.

    Positive definite for any set of contacts: `Footprints` has the proof. All vectors run over the
    active points in the order of the `coupling`. Its newest tangent is the valid one: the values
    lie in its work space.

    Of the n points of the coupling those that are `active` have a positive stiffness k [N/m]. To
    their compliance `extra` [m/N], not negative, is added, none if None.
    """

    def __init__(
        self, coupling: Interaction, active: Mask, stiffness: Array, extra: Array | None = None
    ) -> None:
        self.coupling = coupling
        n, body = int(np.count_nonzero(active)), coupling.footprints
        (factor, exponent), (size, skew, parts) = body.rule, coupling.form
        rank, narrow = np.empty(len(active), np.int32), np.empty((2, len(active)), np.float32)
        self.index, self.cell = np.empty(n, np.int64), np.empty(n, np.int32)
        variance, self.compliance, self.diagonal = np.empty((3, n))
        _near_kernels.active_points(
            active,
            stiffness,
            np.empty(0) if extra is None else extra,
            (factor / coupling.eta**body.power, exponent),
            coupling.own,
            coupling.scale,
            (size, skew),
            coupling.two_level.cell,
            (rank, narrow, self.index, variance, self.compliance, self.diagonal, self.cell),
        )
        single, skewed = narrow
        rows = np.searchsorted(self.index, coupling.rows)
        self.rows = (
            rows if n * coupling.pairs > PAIRS_PER_THREAD * len(active) else np.array([[0, n]])
        )
        self.pairs = np.zeros((n, 2), np.int64), coupling.tangent_col, coupling.tangent_value
        self.place, self.weight = np.empty((n, 2), np.int32), np.empty((n, 4, 4), np.float32)
        self.grids = np.empty((len(self.rows), *coupling.tangent_mesh.shape), np.float32)
        self.part = np.empty((len(self.rows), n))
        self._coarse: tuple[Array, Array] | None = None

        def rows_of(c: int) -> None:
            _mesh_kernels.spline(
                rows[c],
                self.index,
                coupling.y,
                coupling.x,
                variance,
                coupling.tangent_mesh.per_step,
                self.place,
                self.weight,
            )
            narrowed = rank, single, skewed, parts
            _near_kernels.tangent_list(
                coupling.rows[c], coupling.near, *narrowed, coupling.kernel, self.pairs
            )

        each(rows_of, range(len(rows)))

    def __len__(self) -> int:
        return len(self.index)

    def stiffen(self, change: Array) -> None:
        """Add `change` [m/N] to the own compliance of the points, shape (len(self),)."""
        self.compliance = self.compliance + change
        self.diagonal = self.diagonal + change / self.coupling.scale
        self._coarse = None

    @property
    def coarse(self) -> tuple[Array, Array]:
        """`TwoLevelPreconditioner.inverse` of the points by their own compliance."""
        if self._coarse is None:
            self._coarse = self.coupling.two_level.inverse(self.cell, 1 / self.compliance)
        return self._coarse

    def __call__(self, vector: Array) -> Array:
        """Matrix times vector [m] for forces `vector` [N], shape (len(self),)."""
        out, vector = np.empty(len(vector)), vector / self.coupling.unit
        chunks = range(len(self.rows))

        def sources(c: int) -> None:
            rows = self.rows[c]
            _mesh_kernels.spread(rows, self.place, self.weight, vector, self.grids[c])
            _near_kernels.near_tangent(rows, *self.pairs, vector, self.part[c])

        def receivers(c: int) -> None:
            rows = self.rows[c]
            _mesh_kernels.collect(
                rows,
                self.place,
                self.weight,
                vector,
                smooth,
                self.diagonal,
                total(self.part, rows),
                self.coupling.scales[0],
                out,
            )

        each(sources, chunks)
        smooth = self.coupling.tangent_mesh.convolve(total(self.grids))
        each(receivers, chunks)
        return out
