"""Law tables: force, stiffness and area of many contacts over their approach, and lazy tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import InputError
from surfaces.arrays import Array, Index
from surfaces.numerics import parallel
from surfaces.numerics.memory import zeros

__all__ = ["INTERVALS", "LawTable", "LazyTable"]


INTERVALS = 24
"""Intervals of the tables of contacts of a map."""

ROWS_TOGETHER = 4096
"""Rows of a lazy table made at a time: the sampled rays of more would fill the memory."""

MAPPED_LAWS = 2**14
"""Number of laws on disk whose pages are in memory together."""

NO_FOOTPRINT = 0.0, 1.0
"""Factor and exponent of the variance of a point force (`law_kernels.tabulate`)."""


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
        Expected relative error of the force (error estimate), shape (n, K + 1).
    exponent
        Power p of u = sqrt(d/reach) in F = u^p s(u), p = 3 + m: then a paraboloid has constant s.
    centre
        Centre (x, y) [m] of the contact relative to the summit at the nodes, shape
        (n, K + 1, 2); None if the law keeps every contact about its summit.
    bearing
        Area [m^2] of the unloaded summit above the flat at the nodes, shape (n, K + 1); None where
        no hardness asks for it.
    elastic
        With a hardness, of the elastic contact of the same area: force of the table over its force,
        and its stiffness [N/m], shape (n, K + 1, 2). None without a hardness.
    hardness
        Largest pressure [Pa] that the contacts bear. With a hardness laws need not be convex.

    Notes
    -----
    Between the nodes s is a cubic Hermite polynomial in u and area/u^2 is linear in u, as far as
    the area does not fall (`law_kernels`): a Hertzian contact is exact, and the stiffness is the
    derivative of the force. Beyond the reach the basin is filled: a flat punch, force linear with
    the last stiffness, area constant.
    """

    reach: Array
    force: Array
    stiffness: Array
    area: Array
    flags: NDArray[np.uint8]
    spread: Array
    exponent: float = 3.0
    centre: Array | None = None
    bearing: Array | None = None
    elastic: Array | None = None
    hardness: float = math.inf

    def __post_init__(self) -> None:
        n, nodes = self.force.shape
        if nodes < 3:
            raise InputError(f"a law table needs at least 3 nodes, got {nodes}")
        other = {"reach": (n,), "centre": (n, nodes, 2), "elastic": (n, nodes, 2)}
        for name, values in self.columns.items():
            shape = other.get(name, (n, nodes))
            if values.shape != shape:
                raise InputError(f"{name} must have the shape {shape}, not {values.shape}")

    @classmethod
    def empty(cls, count: int, intervals: int, exponent: float = 3.0) -> LawTable:
        """Table of contacts without a law, to be filled."""
        force, stiffness, area, spread = np.zeros((4, count, intervals + 1))
        flags = np.zeros(force.shape, np.uint8)
        return cls(np.zeros(count), force, stiffness, area, flags, spread, exponent)

    def __len__(self) -> int:
        return int(self.reach.size)

    @property
    def nodes(self) -> int:
        """Number K of intervals."""
        return int(self.force.shape[1]) - 1

    @property
    def columns(self) -> dict[str, NDArray[Any]]:
        """Arrays over the contacts, by name."""
        named = ((column.name, getattr(self, column.name)) for column in fields(self))
        return {name: values for name, values in named if isinstance(values, np.ndarray)}

    def rows(self, index: Index) -> LawTable:
        """The laws of the contacts `index`."""
        taken: dict[str, Any] = {name: values[index] for name, values in self.columns.items()}
        return replace(self, **taken)

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


class LazyTable:
    """The laws of n contacts, made in blocks when they are first needed.

    At light loads most summits never touch; their laws would cost more than all the rest.

    Parameters
    ----------
    count
        Number n of contacts.
    make
        Function of some rows that makes their law table, in that order.
    near
        Function of some rows that gives an order in which neighbors on the map follow each other;
        None leaves the order as it is.
    stored
        Whether the kept columns are on disk. They are read in parts; rows of neighbors are read
        from few pages.

    Attributes
    ----------
    ready
        Whether the law of each contact has been made, shape (n,).
    held
        The kept columns: row 0 is zero, as for a contact without a law, and the laws follow in the
        order in which they were made.
    place
        Row of `held` of each contact, shape (n,); 0 until its law is made.
    """

    def __init__(
        self,
        count: int,
        make: Callable[[Index], LawTable],
        *,
        near: Callable[[Index], Index] | None = None,
        stored: bool = False,
    ) -> None:
        self.make, self.near, self.stored = make, near, stored
        self.ready, self.place = np.zeros(count, bool), np.zeros(count, np.int64)
        self.held = LawTable.empty(1, 2)

    @classmethod
    def of(cls, table: LawTable) -> LazyTable:
        """A lazy table whose laws, those of `table`, are all made."""
        lazy = cls(len(table), table.rows)
        lazy.place[:], lazy.ready[:] = np.arange(len(table)), True
        lazy.held = table.rows(lazy.place)
        return lazy

    def __len__(self) -> int:
        return len(self.ready)

    def blocks(self, rows: Index) -> Iterator[tuple[Index, LawTable]]:
        """The laws of some contacts in the order of `near`, `ROWS_TOGETHER` at a time."""
        rows = rows if self.near is None else rows[self.near(rows)]
        for start in range(0, rows.size, ROWS_TOGETHER):
            part = rows[start : start + ROWS_TOGETHER]
            yield part, self.laws(part)

    def laws(self, rows: Index) -> LawTable:
        """The laws of some contacts, in that order; those that are missing are made."""
        missing = rows[~self.ready[rows]]
        if missing.size:
            block = self.make(missing)
            self._hold(missing, block)
            if missing.size == rows.size:
                return block
        return self.held.rows(self.place[rows])

    def _hold(self, rows: Index, block: LawTable) -> None:
        given, made = block.columns, int(np.count_nonzero(self.ready))
        if not made:
            # room for all contacts: memory pages that are never written cost nothing
            rooms = {name: (len(self) + 1, *values.shape[1:]) for name, values in given.items()}
            kept: dict[str, Any] = {
                name: zeros(room, given[name].dtype, self.stored and len(room) > 1)
                for name, room in rooms.items()
            }
            self.held = replace(block, **kept)
        new = np.flatnonzero(~self.ready[rows])
        last = made + 1 + new.size
        self.place[rows[new]] = np.arange(made + 1, last)
        self.ready[rows] = True
        for name, values in self.held.columns.items():
            values[made + 1 : last] = given[name][new]

    @property
    def hardness(self) -> float:
        """`LawTable.hardness`, once a law has been made."""
        return self.held.hardness

    @property
    def has_centres(self) -> bool:
        """Whether laws give the centres of their contacts, once a law has been made."""
        return self.held.centre is not None

    def centre_at(self, index: Index, approach: Array) -> Array:
        """Centres x, y [m] of the contacts `index` relative to their summits, shape (2, n)."""
        if self.held.centre is None:
            return np.zeros((2, approach.size))
        return self._read(self.held.centre, _between, index, approach)

    def elastic_at(self, index: Index, approach: Array) -> Array:
        """The column `elastic` of a table with a hardness, for the contacts `index` at `approach`,
        shape (2, n)."""
        assert self.held.elastic is not None
        return self._read(self.held.elastic, _between, index, approach)

    def flags_at(self, index: Index, approach: Array) -> NDArray[np.uint8]:
        """Flags of the node at or above `approach`; the last node's beyond the reach."""
        return self._read(self.held.flags, _at_or_above, index, approach)

    def spread_at(self, index: Index, approach: Array) -> Array:
        """Error estimate of the node at or above `approach`; the last node's beyond the reach."""
        return self._read(self.held.spread, _at_or_above, index, approach)

    def together(self, count: int) -> float:
        """Number of contacts, of `count` evenly spread ones, that may be read at a time."""
        return max(1.0, MAPPED_LAWS * count / len(self)) if self.stored else math.inf

    def _read(
        self,
        column: NDArray[Any],
        read: Callable[[NDArray[Any], Index, Array], NDArray[Any]],
        index: Index,
        approach: Array,
    ) -> NDArray[Any]:
        """Values of a column for the contacts `index` at `approach` [m], by the function `read` of
        column, rows and fractional node. From disk, rows are read in their order."""
        rows = self.place[index]
        reach = self.held.reach[rows]
        share = np.asarray(approach, dtype=float) / np.where(reach > 0, reach, np.inf)
        node = np.sqrt(np.minimum(np.maximum(share, 0.0), 1.0)) * self.held.nodes
        if not self.stored:
            return read(column, rows, node)
        order = np.argsort(rows)
        rows, node = rows[order], node[order]
        parts = parallel.run(
            lambda a, b: read(column, rows[a:b], node[a:b]),
            parallel.blocks(rows.size, rows.size, self.together(rows.size)),
        )
        return np.asarray(np.concatenate(parts, axis=-1)[..., np.argsort(order)])


def _between(pairs: Array, rows: Index, node: Array) -> Array:
    """Pairs at the nodes (n, K + 1, 2), linear between them, shape (2, n)."""
    low = np.minimum(node.astype(np.int64), pairs.shape[1] - 2)
    share, at = (node - low)[:, None], rows * pairs.shape[1] + low
    flat = pairs.reshape(-1, 2)  # one index per pair is twice as fast as two
    return np.asarray(((1 - share) * flat.take(at, axis=0) + share * flat.take(at + 1, axis=0)).T)


def _at_or_above(values: NDArray[Any], rows: Index, node: Array) -> NDArray[Any]:
    """Values at the nodes (n, K + 1), each of the node at or above, shape (n,)."""
    return np.asarray(values[rows, np.ceil(node).astype(np.int64)])
