"""Displacements of many footprints by each other, at nearly linear cost."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from surfaces._threads import each

from ..threads import threads
from . import _dipole_kernels, _kernels
from .footprint import Footprints, far_table, pair_table, smooth_part
from .mesh import Mesh

__all__ = ["CAP", "Interaction", "mesh_field", "run"]

NEIGHBOURS = 30
"""Neighbours within the cut-off, on average."""

CUT = 2.0
"""Cut-off of the near pairs over the split length eta."""

WIDEST = 2.0
"""Least split length over the root of the widest variance: moments must stay an expansion."""

CAP = 0.35
"""Largest variance over the squared split length that the expansion takes; wider footprints keep
this second moment beyond the cut-off."""

PAIRS_PER_THREAD = 60_000
"""Pairs that repay a thread."""

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
        Variance [m^2] that few footprints exceed; the split length is kept well above its root.
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
        ny, nx = int(size[0] / cut), int(size[1] / cut)
        cells = (ny if ny >= 3 else 1, nx if nx >= 3 else 1)
        place = np.minimum((y / size[0] * cells[0]).astype(np.int64), cells[0] - 1) * cells[1]
        place += np.minimum((x / size[1] * cells[1]).astype(np.int64), cells[1] - 1)
        self.order = np.argsort(place, kind="stable")
        self.y, self.x = y[self.order], x[self.order]
        start = np.searchsorted(place[self.order], np.arange(cells[0] * cells[1] + 1))
        self.ptr, self.col, self.pair = _near_pairs(
            self.y, self.x, start, cells, size, periodic, cut, footprints.m
        )
        self.size, self.wrap, self.cut = size, periodic, cut
        self.mesh = Mesh(footprints, size, periodic=periodic, nodes=nodes)
        self.shape = pair_table(footprints.m)
        self.own = tuple(float(v[0]) for v in smooth_part(footprints.m, np.zeros(1))[:3])
        self.scale = footprints.point * self.eta**-footprints.power
        self.rows = _chunks(self.ptr, len(self.col))
        self.part = np.zeros((len(self.rows), len(y), 2))
        self.grids = np.zeros((len(self.rows), *self.mesh.shape))
        self.tangent_col = np.empty(len(self.col), np.int32)
        self.tangent_value = np.empty(len(self.col), np.float32)
        self.smooth = self.grids[0]
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
        out = np.empty((len(force), 2))
        p, pairs = self.footprints.power, (self.ptr, self.col, self.pair)

        def near(c: int, rows: NDArray[np.int64]) -> None:
            _kernels.near_field(rows, force, m, CAP, *pairs, self.shape, p, self.part[c])

        self.smooth = mesh_field(self, self.rows, self.y, self.x, force, m, self.grids, near, out)
        self.lowest = self.scale * min(0.0, float(self.smooth.min()))
        f0, f1, f2 = self.own
        held = np.minimum(m, CAP)
        value = out[:, 0] + held * out[:, 1] - force * (f0 + held * (f1 + 0.25 * held * f2))
        slope = np.where(m < CAP, out[:, 1] - force * (0.5 * f1 + 0.25 * held * f2), 0.0)
        for part in self.part:
            value += part[:, 0]
            slope += part[:, 1]
        return self.scale * value, self.scale / self.eta**2 * slope

    def gradient(
        self,
        force: NDArray[np.float64],
        moment: NDArray[np.float64],
        growth: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Gradient [-] of the displacement by all others at each loaded point, shape (n, 2).

        For the forces and moments of the last call of `field`; footprints receive with
        `moment` + `growth`.
        """
        m, spread = moment / self.eta**2, (moment + 0.5 * growth) / self.eta**2
        far = far_table(self.footprints.m, self.cut * self.cut)
        scale = (len(far) - 1) / self.cut**2
        self.pull = np.empty(len(self.col), np.float32)
        out = np.empty((len(force), 2))
        run(
            lambda _, rows: _dipole_kernels.mesh_gradient(
                rows, self.y, self.x, self.mesh.per_step, self.smooth, out
            ),
            self.rows,
        )
        run(
            lambda c, rows: _dipole_kernels.near_gradient(
                rows,
                self.y,
                self.x,
                self.size,
                self.wrap,
                force,
                spread,
                np.minimum(m, CAP),
                self.ptr,
                self.col,
                self.pair,
                self.shape,
                self.footprints.power,
                far,
                scale,
                self.pull,
                self.part[c],
            ),
            self.rows,
        )
        for part in self.part:
            out += part
        return np.asarray(self.scale / self.eta * out)

    def dipoles(self, moment: NDArray[np.float64]) -> NDArray[np.float64]:
        """Displacement [m] by forces times shifts [N m], shape (n, 2), after `gradient`."""
        p = moment / self.eta
        run(
            lambda c, rows: _dipole_kernels.deposit_dipoles(
                rows, self.y, self.x, p, self.mesh.per_step, self.grids[c]
            ),
            self.rows,
        )
        smooth = self.mesh.convolve(self.grids.sum(axis=0))
        mesh, part = np.empty((len(p), 2)), np.empty((len(self.rows), len(p)))
        run(
            lambda _, rows: _kernels.gather(rows, self.y, self.x, self.mesh.per_step, smooth, mesh),
            self.rows,
        )
        run(
            lambda c, rows: _dipole_kernels.near_dipoles(
                rows,
                self.y,
                self.x,
                self.size,
                self.wrap,
                p,
                self.ptr,
                self.col,
                self.pull,
                part[c],
            ),
            self.rows,
        )
        return np.asarray(self.scale * (mesh[:, 0] + part.sum(axis=0)))


def run(loop: Callable[[int, NDArray[np.int64]], None], rows: NDArray[np.int64]) -> None:
    """Call loop(c, rows[c]) for every chunk of rows, on as many threads."""
    each(lambda c: loop(c, rows[c]), range(len(rows)))


def mesh_field(
    plan: Interaction,
    rows: NDArray[np.int64],
    y: NDArray[np.float64],
    x: NDArray[np.float64],
    force: NDArray[np.float64],
    variance: NDArray[np.float64],
    grids: NDArray[np.floating],
    near: Callable[[int, NDArray[np.int64]], None],
    out: NDArray[np.float64],
) -> NDArray[np.floating]:
    """Potential of the mesh part, and into `out` (n, 2) its value and half its Laplacian; the
    independent loop `near` runs in the same chunks as the deposit."""
    per_step = plan.mesh.per_step

    def first(c: int, part: NDArray[np.int64]) -> None:
        _kernels.deposit(part, y, x, force, variance, CAP, per_step, grids[c])
        near(c, part)

    run(first, rows)
    smooth = plan.mesh.convolve(grids[0] if len(grids) == 1 else grids.sum(axis=0))
    run(lambda _, part: _kernels.gather(part, y, x, per_step, smooth, out), rows)
    return smooth


def _near_pairs(
    y: NDArray[np.float64],
    x: NDArray[np.float64],
    start: NDArray[np.int64],
    cells: tuple[int, int],
    size: tuple[float, float],
    wrap: bool,
    cut: float,
    m: float,
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float32]]:
    """Pairs i < j within the cut-off: CSR bounds (n + 1,), columns, and the data of each pair."""
    far = far_table(m, cut * cut)
    scale = (len(far) - 1) / cut**2
    ptr = np.zeros(len(y) + 1, np.int64)
    col, pair = np.empty(0, np.int32), np.empty((0, 4), np.float32)
    count = max(1, min(threads(), len(y) // 2000, cells[0]))
    edges = np.linspace(0, cells[0], count + 1).astype(np.int64)
    rows = np.stack((edges[:-1], edges[1:]), axis=1)

    def find(_: int, part: NDArray[np.int64]) -> None:
        _kernels.half_list(
            y, x, start, cells, size, wrap, cut * cut, part, ptr, far, scale, col, pair
        )

    run(find, rows)
    np.cumsum(ptr, out=ptr)
    if ptr[-1]:
        col, pair = np.empty(ptr[-1], np.int32), np.empty((ptr[-1], 4), np.float32)
        run(find, rows)
    return ptr, col, pair


def _chunks(ptr: NDArray[np.int64], pairs: int) -> NDArray[np.int64]:
    """Runs of rows with about equal work, one for each thread, shape (chunks, 2)."""
    count = max(1, min(threads(), pairs // PAIRS_PER_THREAD))
    work = ptr + 8 * np.arange(len(ptr))
    inner = np.searchsorted(work, work[-1] * np.arange(1, count) / count)
    edges = np.concatenate(([0], inner, [len(ptr) - 1])).astype(np.int64)
    return np.stack((edges[:-1], edges[1:]), axis=1)
