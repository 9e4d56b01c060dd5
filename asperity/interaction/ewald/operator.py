"""Displacements of many footprints by each other, at nearly linear cost: Ewald split, with the
smooth part on a B-spline mesh (smooth particle-mesh Ewald method, Essmann et al. 1995).
"""

from __future__ import annotations

import copy
import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.footprint import Footprints, pair_table, smooth_part, smooth_polynomials
from surfaces.arrays import Array
from surfaces.numerics.parallel import each

from . import _mesh_kernels, _near_kernels, _pair_kernels
from ._pair_block_kernels import VARIANCE_CAP
from .mesh import Mesh, SmoothField, mesh_of
from .near_pairs import (
    CUT_OVER_SPLIT_LENGTH,
    NearPairs,
    chunks,
    least_cut,
    near_pairs,
    split_length,
    total,
)
from .two_level import TwoLevelPreconditioner

__all__ = ["ROUND", "Field", "Interaction"]

PAIRS_ASIDE = 40_000
"""Least number of near pairs that are summed on another thread than the mesh."""

NODES_PER_SPLIT_LENGTH = 1.7
"""Mesh nodes per split length."""

TANGENT_NODES = 0.7
"""Mesh nodes of tangents over those of fields, each way: their products differ by 0.1 % then."""

ROUND = np.array([1.0, 1.0, 0.0])
"""Components yy, xx, xy of what is alike in all directions."""

BEADS = np.stack(np.polynomial.hermite_e.hermegauss(4)).astype(np.float32)
BEADS[1] /= BEADS[1].sum()
"""Gauss nodes and weights along an elongated footprint."""


class Field(NamedTuple):
    """Displacement by forces, with its derivatives, at each point.

    Attributes
    ----------
    value
        v0_i = sum_j F_j N(r_ij; m_i, m_j) [m], with its own images, shape (n,).
    slope
        v1_i = sum_j F_j dN/dm_i [1/m], shape (n,).
    tilt
        Gradient [-] of the displacement by all others, shape (n, 2); footprints receive with their
        variance and `growth`.
    moved
        Displacement [m] by the moments, shape (n,).
    longer
        Displacement [m] by elongated footprints less that by round ones of their mean moment,
        shape (n,).
    """

    value: Array
    slope: Array
    tilt: Array
    moved: Array
    longer: Array


class Interaction:
    """Near pairs and mesh of the interaction among points at fixed places.

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
    form
        Second moments yy, xx, xy of the footprints over their variance, shape (n, 3); round if
        None.
    widest
        Variance [m^2] that few footprints exceed; the split length is kept well above its root.

    Attributes
    ----------
    order
        Points sorted by cell list, shape (n,): every vector given later, or returned, is
        `vector[order]`.
    near, pairs
        The near pairs, and their number.
    kernel
        What loops over near pairs read of the kernel: its tables (`_tables`), `BEADS`
        and the exponent of its decay.
    two_level
        The points by cells.
    unit
        Force [N] of which single precision holds small parts and multiples on maps of any size: the
        power of two near that which displaces by the split length there.
    smooth
        Mesh part of the last field; None before the first.
    form
        Mean moment of each footprint over its variance, (n,), which all pairs use; for near pairs
        also half the difference of its principal moments over that, (n,), and its moments yy, xx,
        xy over that, (3, n).

    Notes
    -----
    Ewald split. With m_i the variance of the footprint of force F_i, the pair energy is
    F_i F_j N(r_ij; m_i, m_j). Its smooth part is a mesh convolution between
    (1 + m_i/2 Laplacian) F_i delta(r - r_i), the moments being taken in the deposit and gather
    weights. The near part, within the cut-off, is
    g(r; m_i + m_j) - [1 + (m_i + m_j)/2 Laplacian + m_i m_j/4 Laplacian^2] f(r), exact there;
    beyond it (m_i^2 + m_j^2)/8 Laplacian^2 of the point kernel is left out. An elongated footprint
    is round with its mean moment in all of this; what it lacks then is added to near pairs.
    """

    def __init__(
        self,
        y: Array,
        x: Array,
        cell: tuple[float, float],
        boundary: str,
        footprints: Footprints,
        *,
        form: Array | None = None,
        widest: float = 0.0,
    ) -> None:
        self.footprints = footprints
        periodic = boundary == "periodic"
        self.origin = (0.0, 0.0) if periodic else (float(y.min()), float(x.min()))
        if periodic:
            size = (float(cell[0]), float(cell[1]))
            y, x = _inside(y, size[0], True), _inside(x, size[1], True)
        else:
            small = 1e-9 * math.hypot(*cell)
            y, x = y - self.origin[0], x - self.origin[1]
            size = (float(y.max()) + small, float(x.max()) + small)
        self.eta = split_length(len(y), size, periodic, widest)
        self.sides = size
        size = (size[0] / self.eta, size[1] / self.eta)
        y, x = y / self.eta, x / self.eta
        ny, nx = (int(side / CUT_OVER_SPLIT_LENGTH) for side in size)
        cells = (ny if ny >= 3 else 1, nx if nx >= 3 else 1)
        self.order = np.empty(len(y), np.int64)
        start = np.empty(cells[0] * cells[1] + 1, np.int64)
        _near_kernels.by_cell(y, x, size, cells, self.order, start)
        self.y, self.x = y[self.order], x[self.order]
        self.size, self.wrap = size, periodic

        def pairs() -> NearPairs:
            return near_pairs(self.y, self.x, start, cells, size, periodic)

        def meshes() -> tuple[Mesh, Mesh]:
            coarse = TANGENT_NODES * NODES_PER_SPLIT_LENGTH
            return (
                mesh_of(footprints, size, periodic, NODES_PER_SPLIT_LENGTH, np.float64),
                mesh_of(footprints, size, periodic, coarse, np.float32),
            )

        near, mesh = each(lambda part: part(), (pairs, meshes))
        self.near: NearPairs = near
        self.mesh: Mesh = mesh[0]
        self.tangent_mesh: Mesh = mesh[1]
        self.two_level = TwoLevelPreconditioner(
            self.y, self.x, size, self.sides, periodic, footprints
        )
        self.value_table, *tables = _tables(footprints.m, CUT_OVER_SPLIT_LENGTH**2)
        self.kernel = (*tables, BEADS, footprints.power)
        self.own = tuple(float(v[0]) for v in smooth_part(footprints.m, np.zeros(1))[:3])
        self.scale = footprints.point * self.eta**-footprints.power
        self.unit = math.ldexp(1.0, math.frexp(self.eta / self.scale)[1])
        self.scales = self.scale * self.unit * np.array([1.0, self.eta**-2, 1 / self.eta])
        counts = np.diff(near.ptr, axis=1)[:, 0]
        self.pairs = int(counts.sum())
        self.rows = chunks(counts)
        self.part = np.zeros((len(self.rows), len(y), 6))
        self.masses = np.zeros(self.mesh.shape)
        self.aside = np.zeros(self.mesh.shape, np.float32)
        self.tangent_col = np.empty(len(near.col) + 1, np.int32)
        self.tangent_value = np.empty(len(near.col) + 1, np.float32)
        self.smooth: SmoothField | None = None
        form = np.tile(ROUND, (len(y), 1)) if form is None else form[self.order]
        mean = 0.5 * (form[:, 0] + form[:, 1])
        parts = form.T / mean
        skew = np.hypot(0.5 * (parts[1] - parts[0]), parts[2])
        self.form = mean, skew, parts.astype(np.float32, order="C")

    def field(
        self,
        force: Array,
        variance: Array,
        growth: Array | None = None,
        moment: Array | None = None,
    ) -> Field:
        """Displacement by forces [N], shape (n,), spread with their variances per axis [m^2], shape
        (n,).

        `growth` is the variance [m^2] by which the footprint of an increment exceeds that of the
        whole force, shape (n,), and `moment` force times shift [N m] of those that have moved,
        shape (n, 2); both zero if None.
        """
        n, (size, skew, parts) = len(force), self.form
        force = force / self.unit
        dipole = np.zeros((n, 2)) if moment is None else moment / self.unit / self.eta
        square = size * (1.0 / self.eta**2)
        m = square * variance
        broad = m if growth is None else m + 0.5 * square * growth
        record = np.stack((m, broad, broad * skew, np.minimum(m, VARIANCE_CAP)), axis=1)
        wide = broad.astype(np.float32)
        found = Field(np.empty(n), np.empty(n), np.empty((n, 2)), np.empty(n), np.empty(n))

        def far() -> tuple[NDArray[np.floating], NDArray[np.floating]]:
            place = self.y, self.x, force, m, dipole, self.mesh.per_step
            _mesh_kernels.deposit(*place, self.masses, self.aside)
            return self.mesh.convolve(self.masses), self.mesh.single.convolve(self.aside)

        def near(c: int) -> None:
            _pair_kernels.near_fields(
                self.rows[c],
                force,
                record,
                wide,
                parts,
                dipole,
                self.near,
                self.kernel,
                self.value_table,
                self.part[c],
            )

        def receivers(c: int) -> None:
            rows = self.rows[c]
            place = self.y, self.x, force, m, self.own, self.mesh.per_step
            near = total(self.part, rows)
            _mesh_kernels.gather(rows, *place, self.scales, size, smooth, other, near, found)

        work: list[Callable[[], Any]] = [
            far,
            *(functools.partial(near, c) for c in range(len(self.rows))),
        ]
        if self.pairs > PAIRS_ASIDE:
            (smooth, other), *_ = each(lambda part: part(), work)
        else:
            (smooth, other), *_ = [part() for part in work]
        frame = self.origin, self.eta, self.size, self.wrap, self.mesh.per_step, self.scales[0]
        self.smooth = SmoothField(*frame, smooth)
        each(receivers, range(len(self.rows)))
        return found

    def holds(self, widest: float) -> bool:
        """Whether the split length is long enough for footprints of the variance `widest` [m^2], or
        the largest for this number of points."""
        least = least_cut(len(self.order), self.sides, self.wrap, widest)
        return CUT_OVER_SPLIT_LENGTH * self.eta >= (1 - 1e-9) * least

    def moved(self, dy: Array, dx: Array) -> Interaction:
        """The interaction of these pairs with its points moved a little, by `dy` and `dx` [m],
        shape (n,) in its order. Both share their working arrays."""
        other = copy.copy(self)
        steps = dy / self.eta, dx / self.eta
        other.y, other.x = (
            _inside(place + step, size, self.wrap)
            for place, step, size in zip((self.y, self.x), steps, self.size, strict=True)
        )
        ptr, col, pair = self.near
        row = np.repeat(np.arange(len(dy)), np.diff(ptr[:, 0], append=len(col)))
        change = [(step[row] - step[col]).astype(np.float32) for step in steps]
        other.near = NearPairs(ptr, col, pair + np.stack(change))
        return other


def _inside(place: Array, size: float, wrap: bool) -> Array:
    """Coordinates moved into the cell: by whole periods if it is periodic, else to its border."""
    if not wrap:
        return np.clip(place, 0.0, size)
    if place.min() >= 0.0 and place.max() < size:
        return place
    place = np.mod(place, size)
    return np.where(place < size, place, 0.0)


@functools.lru_cache(maxsize=16)
def _tables(m: float, limit: float) -> tuple[Array, NDArray[np.float32], NDArray[np.float32]]:
    """Tables of the kernel for the near pairs.

    The first column of `pair_table` in double precision, followed by its rise from node to node,
    shape (2, nodes + 1); all in single, each number with its rise, (3, nodes + 1, 2); and
    `smooth_polynomials` in single precision, followed by a row that starts with the place about
    which they are expanded.
    """
    table = pair_table(m).T
    rise = np.diff(table, axis=1, append=table[:, -1:])
    both = np.stack((table, rise), axis=-1)
    value = both[0].T.copy()
    smooth = smooth_polynomials(m, limit)
    smooth = np.concatenate((smooth, np.full((1, smooth.shape[1]), limit / 2)))
    return value, both.astype(np.float32, order="C"), smooth.astype(np.float32)
