"""Contact laws in the form that the Newton solver needs: force, energy and footprint moment."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from asperity.errors import InputError
from asperity.halfspace.footprint import Footprints
from asperity.microcontact import law_kernels
from asperity.microcontact.law_table import LawTable, LazyTable
from surfaces.arrays import Array, Index, Mask
from surfaces.numerics.parallel import Turn, blocks, run

__all__ = ["FILLED_SHARE", "LARGEST_STIFFNESS", "LEAST_BATCH", "Evaluated", "Laws"]

LEAST_BATCH = 128
"""Least number of laws made at a time."""

LEAST_SPARE_LAWS = 64
"""Least number of laws made beyond those that are missing, if `Laws.foresee` has named the laws
that will be needed later. With 32 one more batch is made at the last load."""

CONTACTS_PER_THREAD = 10_000
"""Number of contacts whose evaluation is worth a thread."""

SMALL_REST = 400
"""Number of laws not yet made, up to which all are made at once: small batches would cost more."""

FILLED_SHARE = 0.5
"""Contact area over the area at reach (the whole basin) beyond which a contact counts as filled."""

LARGEST_STIFFNESS = 1.5
"""Largest stiffness over that of a round punch of the same area; an ellipse of 6:1 has 1.28."""

LEAST_STIFFNESS = 1e-3
"""Least stiffness of a contact under a hardness, over its largest stiffness."""

LEAST_FORCE = 1e-3
"""Least force over the force at reach: `LEAST_FORCE` times the square of approach over reach."""


class Evaluated(NamedTuple):
    """Values of the laws of some contacts at their approaches; arrays over the contacts.

    Attributes
    ----------
    force, stiffness
        F [N] and its slope k = dF/dd [N/m].
    area
        Contact area [m^2].
    energy
        U = int_0^d F dd [J].
    moment
        m = (1/F) int_0^F v(k) dF [m^2], the variance of the footprint of the whole force.
    growth
        F dm/dF = v - m [m^2]: the footprint of an increment of the force is wider by it.
    """

    force: Array
    stiffness: Array
    area: Array
    energy: Array
    moment: Array
    growth: Array


class Laws:
    """Force, energy and footprint moment of many contacts over their approach.

    The rows of the law table `nodes` are made when they are needed; `index`, shape (n,), holds the
    rows of these contacts.

    Notes
    -----
    `law_kernels` says what is tabulated, and how it is evaluated between the nodes.

    The coupled problem has one solution if forces and stiffnesses grow with the approach, and no
    stiffness exceeds that of a flat punch of the contact area, as in every exact law
    (docs/development/half_space.md). The force of a table that breaks this is replaced by its
    largest convex minorant, with slopes up to `LARGEST_STIFFNESS` times that of a round punch of
    the largest area; nodal stiffnesses are kept between those of the neighboring intervals. With a
    hardness the stiffness may fall, and only the force has to grow; a force beyond the reach acts
    at the hardness on more area.
    """

    def __init__(self, nodes: LawTable | LazyTable, footprints: Footprints) -> None:
        lazy = nodes if isinstance(nodes, LazyTable) else LazyTable.of(nodes)
        self.store = _Store(lazy, footprints)
        self.index = np.arange(len(lazy))
        if lazy is not nodes:
            self.make()

    def rows(self, index: Index) -> Laws:
        """The laws of the contacts `index` alone; the table is shared."""
        part = object.__new__(Laws)
        part.store, part.index = self.store, self.index[index]
        return part

    @property
    def table(self) -> LazyTable:
        """Law table of all contacts, without these changes."""
        return self.store.nodes

    @property
    def usable(self) -> Mask:
        """Contacts that can carry load, or whose law is not made yet, shape (n,)."""
        return self.store.usable[self.index]

    @property
    def ready(self) -> Mask:
        """Contacts whose law has been made, shape (n,)."""
        return self.store.ready[self.index]

    def __call__(self, approach: Array) -> Evaluated:
        """Evaluate the laws, which are made, at the approaches [m], shape (n,); the force is zero
        where an approach is not positive."""
        out, store = Evaluated(*np.empty((6, len(approach)))), self.store
        assert store.complete or store.ready[self.index[approach > 0]].all(), "laws are missing"
        run(
            lambda a, b: law_kernels.evaluate(
                (a, b),
                self.index,
                approach,
                store.reach,
                store.exponent,
                store.place,
                store.table,
                store.tips,
                *out,
            ),
            blocks(len(approach), CONTACTS_PER_THREAD, store.nodes.together(len(approach))),
        )
        hardness = store.nodes.hardness
        if hardness < math.inf:
            np.maximum(out.area, out.force / hardness, out=out.area)
        return out

    def foresee(self, rows: Index | None) -> None:
        """Name the contacts `rows` that will need their laws later: these are made with the next
        batch. None: unknown; batches are then larger."""
        self.store.ahead = None if rows is None else self.index[rows]

    def make(self, some: Mask | Index | None = None) -> None:
        """Make the laws of `some` of these contacts; of all if None."""
        if not self.store.complete:
            self.store.need(self.index if some is None else self.index[some])

    def make_closing(self, interference: Array) -> None:
        """Make the laws of contacts about to close, with those of contacts nearest to closing; none
        if no contact about to close lacks its law.

        The `interference` [m], shape (n,), is positive where a contact is about to close.
        """
        if self.store.complete:
            return
        missing = np.flatnonzero(~self.ready)
        lacking = int(np.count_nonzero(interference[missing] > 0))
        if not lacking:
            return
        block = lacking + max(lacking // 8, LEAST_SPARE_LAWS)
        if self.store.ahead is None:
            block = max(lacking + lacking // 8, LEAST_BATCH, int(self.store.ready.sum()) // 40)
        self.make(missing[np.argsort(-interference[missing], kind="stable")[:block]])

    def filled(self, law: Evaluated) -> Mask:
        """Whether each contact covers more than `FILLED_SHARE` of its area at reach."""
        return np.asarray(law.area > FILLED_SHARE * self.store.largest.take(self.index))


class _Store:
    """The table of `Laws`, made all at once or as rows are needed.

    Rows stand in the table in the order in which they are made, at `place`: most summits of a large
    surface never touch, and memory pages that are never written cost nothing. One thread at a time
    may make rows, or read them while others are made: the one whose `turn` it is.
    """

    def __init__(self, nodes: LazyTable, footprints: Footprints) -> None:
        self.footprints, self.nodes, n = footprints, nodes, len(nodes)
        self.reach, self.largest = np.zeros((2, n))
        self.usable, self.ready = np.ones(n, bool), np.zeros(n, bool)
        self.exponent = 3.0 + footprints.m
        self.table, self.tips = law_kernels.empty_columns(n, 0)
        self.place, self.made = np.zeros(n, np.int32), 0
        self.complete = False
        self.ahead: Index | None = None
        self.turn = Turn()

    def need(self, rows: Index) -> None:
        """Make those of the `rows` that are missing, and with them those needed later (`ahead`)."""
        rows = rows[~self.ready[rows]]
        if rows.size:
            left = np.flatnonzero(~self.ready)
            if self.ahead is not None:
                rows = np.append(rows, self.ahead[~self.ready[self.ahead]])
            rows = left if len(left) <= SMALL_REST else np.unique(rows)
            for part, nodes in self.nodes.blocks(rows):
                self._add(part, nodes)

    def _add(self, rows: Index, nodes: LawTable) -> None:
        names = "reach", "force", "stiffness", "area"
        reach, force, stiffness, area = (np.asarray(getattr(nodes, a), float) for a in names)
        for name, array in zip(names, (reach, force, stiffness, area), strict=True):
            if not np.isfinite(array).all():
                raise InputError(f"law table: {name} holds values that are not finite")
        if not self.made:
            self.exponent = float(nodes.exponent)
            self.table, self.tips = law_kernels.empty_columns(
                len(self.reach), force.shape[1] - 1, self.nodes.stored
            )
        self.ready[rows] = True
        self.complete = bool(self.ready.all())
        good = (reach > 0) & (force[:, -1] > 0)
        self.usable[rows] = good
        rows, reach, area = rows[good], reach[good], area[good]
        cap = LARGEST_STIFFNESS * self.footprints.punch(np.sqrt(area.max(axis=1) / np.pi))
        force, stiffness = force[good], stiffness[good]
        if nodes.hardness == math.inf:
            force, stiffness = _sound(reach, force, stiffness, cap)
        else:
            force, stiffness = _growing(force, stiffness, cap)
        self.reach[rows], self.largest[rows] = reach, area[:, -1]
        first, self.made = self.made, self.made + len(rows)
        self.place[rows] = np.arange(first, self.made)
        table, tips = self.table[first : self.made], self.tips[first : self.made]
        run(
            lambda a, b: law_kernels.tabulate(
                reach[a:b],
                force[a:b],
                stiffness[a:b],
                area[a:b],
                self.exponent,
                *self.footprints.rule,
                True,
                table[a:b],
                tips[a:b],
            ),
            blocks(len(rows), 1000),
        )


def _sound(reach: Array, force: Array, stiffness: Array, cap: Array) -> tuple[Array, Array]:
    """Nodal forces and stiffnesses of elastic laws, changed so that both grow (`Laws`)."""
    from scipy.optimize import isotonic_regression

    steps = force.shape[1] - 1
    slack = 1e-6 * stiffness[:, -1:]
    broken = (np.diff(stiffness, axis=1) < -slack).any(axis=1)
    broken |= (np.diff(force, axis=1) <= 0).any(axis=1)
    broken |= (stiffness > cap[:, None]).any(axis=1)
    u2 = _shares(steps)
    force, stiffness = force.copy(), stiffness.copy()
    raised, step = _rising(force[broken], u2), np.diff(u2)
    raised[:, 0] = 0.0
    # the slopes of the largest convex minorant are the isotonic regression of the secants
    slopes = [isotonic_regression(s, weights=step).x for s in np.diff(raised, axis=1) / step]
    depth = reach[broken, None] * step
    secant = np.minimum(np.reshape(slopes, depth.shape) / reach[broken, None], cap[broken, None])
    force[broken, 1:] = np.cumsum(secant * depth, axis=1)
    force[broken, 0] = 0.0
    above = np.concatenate((secant, secant[:, -1:]), axis=1)
    below = np.concatenate((np.zeros((len(secant), 1)), secant), axis=1)
    above[:, -1] = np.maximum(cap[broken], secant[:, -1])
    stiffness[broken] = np.clip(stiffness[broken], below, above)
    return force, stiffness


def _shares(steps: int) -> Array:
    """Approach over reach at the nodes."""
    return np.asarray((np.arange(steps + 1) / steps) ** 2)


def _rising(force: Array, u2: Array) -> Array:
    """Nodal forces at the approaches `u2` over the reach, raised to those of `LEAST_FORCE`: a law
    without a force at first would have an infinite compliance."""
    return np.maximum(force, LEAST_FORCE * force[:, -1:] * u2**2)


def _growing(force: Array, stiffness: Array, cap: Array) -> tuple[Array, Array]:
    """Nodal forces of laws with a hardness, changed so that they grow, and nodal stiffnesses, kept
    between `LEAST_STIFFNESS` of the largest and `cap`."""
    least = LEAST_STIFFNESS * stiffness.max(axis=1, keepdims=True)
    bounded = np.clip(stiffness, np.minimum(least, cap[:, None]), cap[:, None])
    grown = np.maximum.accumulate(_rising(force, _shares(force.shape[1] - 1)), axis=1)
    return grown, bounded
