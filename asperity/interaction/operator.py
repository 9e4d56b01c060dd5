"""Displacements of many footprints by each other, at nearly linear cost."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from . import _kernels
from .footprint import Footprints, far_table, pair_table, smooth_part
from .mesh import Mesh

__all__ = ["Interaction", "Tangent"]

NEIGHBOURS = 30
"""Neighbours within the cut-off, on average."""

CUT = 2.0
"""Cut-off of the near pairs over the split length eta."""

WIDEST = 2.0
"""Least split length over the root of the widest variance: moments must stay an expansion."""

NODES = 2.2
"""Mesh nodes per split length."""


class Interaction:
    """Plan of the interaction among points at fixed places.

    Parameters
    ----------
    y, x
        Places [m], shape (n,); inside the cell if it is periodic.
    cell
        Nominal cell (Ly, Lx) [m].
    boundary
        "periodic": the zero-mean kernel of the cell, images and self-images included;
        "free": one half-space.
    footprints
        Kernel of the half-space.
    widest
        Largest variance [m^2] of a footprint that will be asked for; the split length is kept well
        above its root.
    neighbours, cut, nodes
        Accuracy against cost: mean number of near neighbours, cut-off over the split length,
        mesh nodes per split length.

    Attributes
    ----------
    order
        Points sorted by cell list, shape (n,): every vector given to or returned by the plan is
        `vector[order]`.

    Notes
    -----
    Ewald split. With m_i the variance of the footprint of force F_i, the pair energy is
    F_i F_j N(r_ij; m_i, m_j). Its smooth part is a mesh convolution between
    (1 + m_i/2 Laplacian) F_i delta(r - r_i), the moments being taken in the deposit and gather
    weights. The near part, within the cut-off, is
    g(r; m_i + m_j) - [1 + (m_i + m_j)/2 Laplacian + m_i m_j/4 Laplacian^2] f(r), exact there;
    beyond it (m_i^2 + m_j^2)/8 Laplacian^2 of the point kernel is left out.
    """

    def __init__(
        self,
        y: NDArray[np.float64],
        x: NDArray[np.float64],
        cell: tuple[float, float],
        boundary: str,
        footprints: Footprints,
        *,
        widest: float = 0.0,
        neighbours: float = NEIGHBOURS,
        cut: float = CUT,
        nodes: float = NODES,
    ) -> None:
        self.footprints = footprints
        periodic = boundary == "periodic"
        if periodic:
            size = (float(cell[0]), float(cell[1]))
            y, x = np.mod(y, size[0]), np.mod(x, size[1])
            y, x = np.where(y < size[0], y, 0.0), np.where(x < size[1], x, 0.0)
        else:
            small = 1e-9 * math.hypot(*cell)
            y, x = y - y.min(), x - x.min()
            size = (float(y.max()) + small, float(x.max()) + small)
        reach = math.sqrt(neighbours / math.pi * size[0] * size[1] / len(y))
        floor = cut * WIDEST * math.sqrt(widest)
        reach = max(reach, floor)
        if periodic:
            reach = min(reach, 0.499 * min(size))
        else:
            reach = max(min(reach, 1.01 * math.hypot(*size)), 0.02 * math.hypot(*size), floor)
        self.eta = reach / cut
        size = (size[0] / self.eta, size[1] / self.eta)
        y, x = y / self.eta, x / self.eta
        cells = tuple(n if n >= 3 else 1 for n in (int(size[0] / cut), int(size[1] / cut)))
        place = np.minimum((y / size[0] * cells[0]).astype(np.int64), cells[0] - 1) * cells[1]
        place += np.minimum((x / size[1] * cells[1]).astype(np.int64), cells[1] - 1)
        self.order = np.argsort(place, kind="stable")
        self.y, self.x = y[self.order], x[self.order]
        start = np.searchsorted(place[self.order], np.arange(cells[0] * cells[1] + 1))
        far = far_table(footprints.m, cut * cut)
        self.ptr, self.col, self.pair = _kernels.half_list(
            self.y, self.x, start, cells, size, periodic, far, (len(far) - 1) / cut**2
        )
        self.mesh = Mesh(footprints, size, periodic=periodic, nodes=nodes)
        self.shape = pair_table(footprints.m)
        self.own = tuple(float(v[0]) for v in smooth_part(footprints.m, np.zeros(1)))
        self.scale = footprints.point * self.eta**-footprints.power
        self.bounds = _chunks(self.ptr)
        self.grid = np.zeros(self.mesh.shape)
        self.part = np.zeros((len(self.bounds) - 1, len(y), 2))
        self.lowest = 0.0

    def field(
        self, force: NDArray[np.float64], variance: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Displacement by forces spread with their variances.

        Parameters
        ----------
        force
            Force [N] at each point, shape (n,).
        variance
            Variance per axis [m^2] of each footprint, shape (n,).

        Returns
        -------
        value
            v0_i = sum_j F_j N(r_ij; m_i, m_j) [m], with its own images, shape (n,).
        slope
            v1_i = sum_j F_j dN/dm_i [1/m], shape (n,).
        """
        m = variance / self.eta**2
        _kernels.deposit(self.y, self.x, force, m, self.mesh.per_step, self.grid)
        smooth = self.mesh.convolve(self.grid)
        out = np.empty((len(force), 2))
        _kernels.field(
            self.y,
            self.x,
            force,
            m,
            self.mesh.per_step,
            smooth,
            self.ptr,
            self.col,
            self.pair,
            self.bounds,
            self.shape,
            self.footprints.power,
            self.part,
            out,
        )
        f0, f1, f2 = self.own
        self.lowest = self.scale * min(0.0, float(smooth.min()))
        value = out[:, 0] - force * (f0 + m * (f1 + 0.25 * m * f2))
        slope = out[:, 1] - force * (0.5 * f1 + 0.25 * m * f2)
        return self.scale * value, self.scale / self.eta**2 * slope

    def tangent(
        self,
        active: NDArray[np.bool_],
        stiffness: NDArray[np.float64],
        extra: NDArray[np.float64] | float = 0.0,
    ) -> Tangent:
        """Tangent matrix of the active points, `stiffness` (n,) [N/m] positive there.

        `extra` (n,) [m/N], not negative, is added to the compliance of the points.
        """
        return Tangent(self, active, stiffness, np.broadcast_to(extra, stiffness.shape))


class Tangent:
    """The matrix diag(1/k + extra) + g_ij(v_i + v_j), i != j, plus self-images.

    Positive definite for any set of contacts: `Footprints` has the proof. All vectors run over the
    active points in the order of the plan.
    """

    def __init__(
        self,
        plan: Interaction,
        active: NDArray[np.bool_],
        stiffness: NDArray[np.float64],
        extra: NDArray[np.float64],
    ) -> None:
        self.plan = plan
        self.index = np.flatnonzero(active)
        n = len(self.index)
        rank = np.full(len(active), -1, np.int32)
        rank[self.index] = np.arange(n, dtype=np.int32)
        variance = plan.footprints.variance(np.where(active, stiffness, 0.0)) / plan.eta**2
        self.ptr = np.zeros(n + 1, np.int64)
        self.col = np.empty(len(plan.col), np.int32)
        self.value = np.empty(len(plan.col), np.float32)
        _kernels.tangent_list(
            plan.ptr,
            plan.col,
            plan.pair,
            rank,
            variance,
            plan.shape,
            plan.footprints.power,
            self.ptr,
            self.col,
            self.value,
        )
        self.y, self.x = plan.y[self.index], plan.x[self.index]
        self.variance = variance[self.index]
        self.compliance = 1 / stiffness[self.index] + extra[self.index]
        f0, f1, f2 = plan.own
        images = f0 + self.variance * (f1 + 0.25 * self.variance * f2)
        self.diagonal = self.compliance / plan.scale - images
        self.bounds = _chunks(self.ptr)
        self.grid = np.zeros(plan.mesh.shape, np.float32)
        self.part = np.zeros((len(self.bounds) - 1, n))

    def __len__(self) -> int:
        return len(self.index)

    def __call__(self, vector: NDArray[np.float64]) -> NDArray[np.float64]:
        """Matrix times vector [m] for forces `vector` [N], shape (len(self),)."""
        mesh = self.plan.mesh
        _kernels.deposit(self.y, self.x, vector, self.variance, mesh.per_step, self.grid)
        smooth = mesh.convolve(self.grid)
        out = np.empty(len(vector))
        _kernels.tangent(
            self.y,
            self.x,
            self.variance,
            mesh.per_step,
            smooth,
            self.ptr,
            self.col,
            self.value,
            self.bounds,
            self.diagonal,
            vector,
            self.part,
            out,
        )
        return self.plan.scale * out


def _chunks(ptr: NDArray[np.int64]) -> NDArray[np.int64]:
    """Bounds of runs of rows with about equal work, one for each thread."""
    work = ptr + 8 * np.arange(len(ptr))
    threads = numba.get_num_threads()
    inner = np.searchsorted(work, work[-1] * np.arange(1, threads) / threads)
    return np.concatenate(([0], inner, [len(ptr) - 1])).astype(np.int64)
