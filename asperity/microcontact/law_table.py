"""Force, stiffness and area of many contacts, tabulated over their approach; made when needed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import InputError

__all__ = ["LawTable", "joined", "monotone"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

TOGETHER = 4096
"""Rows of a lazy table that are made at a time: their rays take more memory than their laws."""

NO_FOOTPRINT = 0.0, 1.0
"""Factor and exponent of the variance of a force that is not spread."""


@dataclass(eq=False)
class LawTable:
    """The law of n contacts at the approaches ``reach * (j / K)^2``, j = 0 ... K.

    Parameters
    ----------
    reach
        Approach [m] of the last node, shape (n,): there the contact fills its basin, or the law
        ends. Zero marks a contact without a usable law (it never carries load).
    force, stiffness, area
        Normal force [N], dF/dd [N/m] and contact area [m^2] at the nodes, shape (n, K + 1).
    flags
        Bits of `Flag` at the nodes, uint8, shape (n, K + 1).
    spread
        Relative difference of the force to that of the next law (error estimate), (n, K + 1).
    exponent
        Power p of u = sqrt(d/reach) in F = u^p s(u), p = 3 + m: then a paraboloid has constant s.
    law
        Name of the law.
    centre
        Centre (x, y) [m] of the contact relative to the summit at the nodes, shape
        (n, K + 1, 2); None if the law keeps every contact about its summit.
    bearing
        Area [m^2] of the unloaded summit above the flat at the nodes, shape (n, K + 1); None where
        no hardness asks for it.
    elastic
        The force over that of the contact of the same area without a hardness, and the stiffness of
        that one [N/m], shape (n, K + 1, 2); None without one.
    hardness
        Pressure [Pa] that the contacts bear at most; where it bounds their laws these need not be
        convex.
    make
        Table of the contacts whose rows are given, in that order, of a lazy table (`lazy`).

    Attributes
    ----------
    ready
        Rows that have been made, bool, shape (n,); of a lazy table those asked for (`ensure`), the
        others being zero, as without a usable law.

    Notes
    -----
    Between the nodes s is a cubic Hermite polynomial in u and area/u^2 is linear in u
    (`law_kernels`), so that a Hertzian contact is exact and the stiffness is the derivative of the
    force. Beyond the reach the basin is filled: a flat punch, force linear with the last stiffness,
    area constant.
    """

    reach: Array
    force: Array
    stiffness: Array
    area: Array
    flags: NDArray[np.uint8]
    spread: Array
    exponent: float = 3.0
    law: str = ""
    centre: Array | None = None
    bearing: Array | None = None
    elastic: Array | None = None
    hardness: float = math.inf
    make: Callable[[Rows], LawTable] | None = None
    ready: NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        n, nodes = self.force.shape
        if nodes < 3:
            raise InputError(f"a law table needs at least 3 nodes, got {nodes}")
        for name in ("stiffness", "area", "flags", "spread"):
            if getattr(self, name).shape != (n, nodes):
                raise InputError(f"{name} must have the shape of force, {(n, nodes)}")
        if self.reach.shape != (n,):
            raise InputError(f"reach must have the shape ({n},), got {self.reach.shape}")
        if self.centre is not None and self.centre.shape != (n, nodes, 2):
            raise InputError(f"centre must have the shape {(n, nodes, 2)}, got {self.centre.shape}")
        self.ready = np.full(n, self.make is None)

    @classmethod
    def lazy(cls, count: int, make: Callable[[Rows], LawTable]) -> LawTable:
        """A table of `count` contacts whose rows are made in blocks, when they are first needed.

        At light loads most summits never touch; their laws would cost more than all the rest.
        """
        force, stiffness, area, spread = np.zeros((4, count, 3))
        flags = np.zeros((count, 3), np.uint8)
        return cls(np.zeros(count), force, stiffness, area, flags, spread, make=make)

    def __len__(self) -> int:
        return int(self.reach.size)

    @property
    def nodes(self) -> int:
        """Number K of intervals."""
        return int(self.force.shape[1]) - 1

    def ensure(self, rows: Rows) -> None:
        """Make the rows that are missing among `rows`."""
        missing = np.unique(rows[~self.ready[rows]])
        for start in range(0, missing.size, TOGETHER):
            self._make(missing[start : start + TOGETHER])

    def _make(self, missing: Rows) -> None:
        assert self.make is not None  # else all rows are ready
        block, first = self.make(missing), not self.ready.any()
        for column in fields(LawTable):
            values = getattr(block, column.name)
            if isinstance(values, np.ndarray) and column.init:
                if first:
                    empty = np.zeros((len(self), *values.shape[1:]), values.dtype)
                    setattr(self, column.name, empty)
                getattr(self, column.name)[missing] = values
        self.exponent, self.law, self.hardness = block.exponent, block.law, block.hardness
        self.ready[missing] = True

    def rows(self, index: Rows) -> LawTable:
        """The laws of the contacts `index`, which are made if they are missing."""
        self.ensure(index)
        columns: dict[str, Any] = {"make": None}
        for column in fields(LawTable):
            values = getattr(self, column.name)
            if isinstance(values, np.ndarray) and column.init:
                columns[column.name] = values[index]
        return replace(self, **columns)

    def approach(self) -> Array:
        """Approaches [m] of the nodes, shape (n, K + 1)."""
        u = np.linspace(0.0, 1.0, self.nodes + 1)
        return self.reach[:, None] * u * u

    def evaluate(self, index: ArrayLike, approach: ArrayLike) -> tuple[Array, Array, Array]:
        """Force [N], stiffness [N/m] and area [m^2] of the contacts `index` at `approach` [m].

        Parameters
        ----------
        index
            Rows of the table, shape broadcastable with `approach`.
        approach
            Approach [m]; contacts at or below zero carry nothing.

        Returns
        -------
        force, stiffness, area
            Of the broadcast shape.
        """
        from .law_kernels import empty_columns, evaluate, tabulate

        rows, depth = np.broadcast_arrays(
            np.asarray(index, dtype=np.int64), np.asarray(approach, dtype=float)
        )
        rows, depth = np.array(rows), np.array(depth)  # broadcast arrays cannot be written
        asked = np.zeros(len(self), bool)
        asked[rows] = True
        place = np.cumsum(asked, dtype=np.int32) - 1
        nodes = [array[asked] for array in (self.reach, self.force, self.stiffness, self.area)]
        columns, tips = empty_columns(len(nodes[0]), self.nodes)
        tabulate(*nodes, self.exponent, *NO_FOOTPRINT, False, columns, tips)
        values = np.empty((6, rows.size))
        evaluate(
            (0, rows.size),
            rows.ravel(),
            depth.ravel(),
            self.reach,
            self.exponent,
            place,
            columns,
            tips,
            *values,
        )
        force, stiffness, area = (value.reshape(rows.shape) for value in values[:3])
        return force, stiffness, area

    def centre_at(self, index: NDArray[np.int64], approach: Array) -> tuple[Array, Array]:
        """Centres x, y [m] of the contacts `index` relative to their summits, shape (n,)."""
        if self.centre is None:
            return np.zeros(approach.size), np.zeros(approach.size)
        x, y = self._between(self.centre, index, approach)
        return x, y

    def elastic_at(self, index: NDArray[np.int64], approach: Array) -> tuple[Array, Array]:
        """Of elastic contacts with the areas of the contacts `index`, of a table with a hardness:
        what their force is the share of, and their stiffness [N/m], shape (n,) each."""
        assert self.elastic is not None
        share, stiffness = self._between(self.elastic, index, approach)
        return share, stiffness

    def _between(self, pairs: Array, index: NDArray[np.int64], approach: Array) -> Array:
        """Pairs at the nodes (n, K + 1, 2), linear between them, shape (2, n)."""
        reach = np.where(self.reach[index] > 0, self.reach[index], np.inf)
        u = np.sqrt(np.clip(approach / reach, 0.0, 1.0)) * self.nodes
        low = np.minimum(u.astype(np.int64), self.nodes - 1)
        share = (u - low)[:, None]
        return np.asarray(((1 - share) * pairs[index, low] + share * pairs[index, low + 1]).T)

    def flags_at(self, index: ArrayLike, approach: ArrayLike) -> NDArray[np.uint8]:
        """Flags of the node at or above `approach`; the last node's beyond the reach."""
        return np.asarray(self.flags[self._node(index, approach)])

    def spread_at(self, index: ArrayLike, approach: ArrayLike) -> Array:
        """Error estimate of the node at or above `approach`; the last node's beyond the reach."""
        return np.asarray(self.spread[self._node(index, approach)])

    def _node(
        self, index: ArrayLike, approach: ArrayLike
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        rows = np.asarray(index, dtype=np.int64)
        reach = self.reach[rows]
        share = np.asarray(approach, dtype=float) / np.where(reach > 0, reach, np.inf)
        u = np.sqrt(np.minimum(np.maximum(share, 0.0), 1.0))
        return rows, np.ceil(u * self.nodes).astype(np.int64)


def joined(tables: Sequence[LawTable]) -> LawTable:
    """One table of the rows of several of one law."""
    if len(tables) == 1:
        return tables[0]
    columns: dict[str, Any] = {}
    for column in fields(LawTable):
        values = [getattr(table, column.name) for table in tables]
        if isinstance(values[0], np.ndarray) and column.init:
            columns[column.name] = np.concatenate(values)
    return replace(tables[0], **columns)


def monotone(
    places: NDArray[np.int64], count: NDArray[np.int64], values: Array, at: ArrayLike
) -> Array:
    """Values of monotone piecewise cubics (Fritsch and Butland 1984) through rows of points.

    Parameters
    ----------
    places
        Abscissae that rise along each row, shape (n, k).
    count
        Points of each row that count, the first ones, shape (n,), at least 3.
    values
        Ordinates, shape (n, k, columns).
    at
        Abscissae at which all rows are wanted, shape (m,); beyond its last point a row goes on as
        its last piece.

    Returns
    -------
    Array of shape (n, m, columns).

    Notes
    -----
    As `scipy.interpolate.PchipInterpolator`, which takes one set of abscissae at a time and a third
    of a millisecond for it.
    """
    row, last, at = np.arange(len(places)), count - 1, np.asarray(at, float)
    known = np.arange(places.shape[1]) <= last[:, None]
    x = np.where(known, places, 0.0)
    step = np.where(known[:, 1:], np.diff(x, axis=1), 1.0)[:, :, None]
    rise = np.diff(values, axis=1) / step
    before, after = rise[:, :-1], rise[:, 1:]
    one, two = 2.0 * step[:, 1:] + step[:, :-1], step[:, 1:] + 2.0 * step[:, :-1]
    same = before * after > 0.0
    mean = one / np.where(same, before, 1.0) + two / np.where(same, after, 1.0)
    slope = np.zeros_like(values)
    slope[:, 1:-1] = np.where(same, (one + two) / np.where(same, mean, 1.0), 0.0)
    slope[:, 0] = _end(step[:, 0], step[:, 1], rise[:, 0], rise[:, 1])
    near, far = (row, last - 1), (row, last - 2)
    slope[row, last] = _end(step[near], step[far], rise[near], rise[far])
    piece = np.sum((at[:, None] >= x[:, None, 1:]) & known[:, None, 1:], axis=2)
    piece = np.minimum(piece, last[:, None] - 1)
    here = row[:, None], piece
    way, width = (at - x[here])[:, :, None], step[here]
    bend = (3.0 * rise[here] - 2.0 * slope[here] - slope[row[:, None], piece + 1]) / width
    twist = (slope[here] + slope[row[:, None], piece + 1] - 2.0 * rise[here]) / width**2
    return np.asarray(values[here] + way * (slope[here] + way * (bend + way * twist)))


def _end(near: Array, far: Array, rise: Array, next_rise: Array) -> Array:
    """Slope at an end, from the lengths and the rises of the two pieces there."""
    slope = ((2.0 * near + far) * rise - near * next_rise) / (near + far)
    steep = (rise * next_rise <= 0.0) & (np.abs(slope) > 3.0 * np.abs(rise))
    return np.where(slope * rise <= 0.0, 0.0, np.where(steep, 3.0 * rise, slope))
