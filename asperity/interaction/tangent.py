"""The tangent matrix of the closed contacts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import _kernels
from .operator import CAP, Interaction, mesh_field, run

__all__ = ["Tangent"]


class Tangent:
    """The matrix diag(1/k + extra) + g_ij(v_i + v_j), i != j, plus self-images.

    Positive definite for any set of contacts: `Footprints` has the proof. All vectors run over the
    active points in the order of the plan. The newest tangent of a plan is the valid one: its
    values lie in the work space of the plan.

    Parameters
    ----------
    plan
        Interaction of all points.
    active
        Points of the matrix, bool, shape (n,).
    stiffness
        k [N/m], shape (n,), positive at the active points.
    extra
        Compliance [m/N] added to that of the points, not negative, shape (n,) or scalar.
    """

    def __init__(
        self,
        plan: Interaction,
        active: NDArray[np.bool_],
        stiffness: NDArray[np.float64],
        extra: NDArray[np.float64] | float = 0.0,
    ) -> None:
        self.plan = plan
        self.index = np.flatnonzero(active)
        n = len(self.index)
        rank = np.full(len(active), -1, np.int32)
        rank[self.index] = np.arange(n, dtype=np.int32)
        variance = plan.footprints.variance(np.where(active, stiffness, 0.0)) / plan.eta**2
        self.ptr = np.zeros((n, 2), np.int64)
        self.col, self.value = plan.tangent_col, plan.tangent_value
        run(
            lambda c, rows: _kernels.tangent_list(
                rows,
                plan.ptr,
                plan.col,
                plan.pair,
                rank,
                variance,
                CAP,
                plan.shape,
                plan.footprints.power,
                plan.ptr[rows[0]],
                self.ptr,
                self.col,
                self.value,
            ),
            plan.rows,
        )
        self.y, self.x = plan.y[self.index], plan.x[self.index]
        self.variance = variance[self.index]
        self.compliance = (
            1 / stiffness[self.index] + np.broadcast_to(extra, active.shape)[self.index]
        )
        f0, f1, f2 = plan.own
        held = np.minimum(self.variance, CAP)
        self.held = held
        self.diagonal = self.compliance / plan.scale - f0 - held * (f1 + 0.25 * held * f2)
        self.rows = np.searchsorted(self.index, plan.rows)
        self.grids = np.zeros((len(self.rows), *plan.mesh.shape), np.float32)
        self.part = np.zeros((len(self.rows), n))
        self.out = np.empty((n, 2))

    def __len__(self) -> int:
        return len(self.index)

    def __call__(self, vector: NDArray[np.float64]) -> NDArray[np.float64]:
        """Matrix times vector [m] for forces `vector` [N], shape (len(self),)."""
        out = self.out

        def near(c: int, rows: NDArray[np.int64]) -> None:
            _kernels.near_tangent(rows, self.ptr, self.col, self.value, vector, self.part[c])

        mesh_field(
            self.plan, self.rows, self.y, self.x, vector, self.variance, self.grids, near, out
        )
        total = self.diagonal * vector + out[:, 0] + self.held * out[:, 1]
        for part in self.part:
            total += part
        total *= self.plan.scale
        return np.asarray(total)
