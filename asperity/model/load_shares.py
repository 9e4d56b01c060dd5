"""Which contacts carry so much of the load that their law has to be exact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.flags import Flag
from asperity.interaction.elongation import ASPECT_EXPONENT
from asperity.microcontact.basin_bem.press import press
from surfaces.peaks.summit_arrays import PLATEAU, RIM

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.microcontact.law_table import LawTable
    from surfaces.peaks.summits import Summits

__all__ = ["Ranking"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

SHARE = 0.03
"""Share of the load, beyond its expansion, from which on the contact on a ridge is dominant."""

SHARE_OF_NONE = 0.003
"""The same of a peak without a summit of its own between the pixels, of which no law holds."""

SHARE_OF_ROUND = 0.1
"""The same of a smooth, round summit, whose law is nearer."""

RIDGE = 5.0
"""Ratio of its curvatures up to which a summit is round."""

EARLY = 5
"""Node to which the expansion of a smooth summit holds at least."""

JOINED = 1.6
"""Approach over the depth of the pass at which two contacts have joined
(docs/development/errors.md)."""

SHARE_OF_PAIR = 0.2
"""Share of the load from which on two contacts that join are pressed as one."""

SLACK = 0.1
"""Part of the approach under the pass between them where the basins of both still hang together."""

LATER = np.array([0, 1, 3, 6])
"""Nodes of a table beyond the expansion at which the share is looked at."""

MOST = 200
"""Summits above the flat at which no contact is looked at any more."""


class Ranking:
    """Summits in the order in which a flat meets them, with the loads that they then carry.

    Parameters
    ----------
    summits
        Summits of a map.

    Attributes
    ----------
    summits
        As given.
    full
        Whether there are so many that a lower one cannot change the choice.
    curvature, angle
        What tells the forms of the contacts: principal curvatures [1/m], shape (n, 2), and
        direction of the long axis [rad], (n,), of the summits; of joined ones those of a summit
        with a contact of their moments.

    Notes
    -----
    The loads are those of independent Hertz contacts. A mean displacement of the body moves all
    summits alike and leaves the shares of the load at a given depth of one contact as they are.
    The choice follows from the map alone: it does not depend on the loads that are asked for, and a
    curve has no steps where contacts enter or leave it.
    """

    def __init__(self, summits: Summits) -> None:
        usable = np.flatnonzero(summits.valid & (summits.kinds != RIM))
        order = usable[np.argsort(-summits.height[usable], kind="stable")]
        self._usable = np.zeros(len(summits), bool)
        self._usable[usable] = True
        self._height = summits.height[order[:MOST]]
        self.full = len(self._height) == MOST
        self._lowest = self._height[-1] if self.full else -np.inf
        self._weight = _weight(summits)
        self._first = self._weight[order[:MOST]]
        steep, shallow = summits.curvature.T
        self._ridge = steep > RIDGE * shallow
        self.summits = summits
        self.curvature, self.angle = summits.curvature, summits.angle

    def joining(self) -> tuple[Rows, Array, Array]:
        """Pairs of summits, (k, 2), that join while they carry much of the load; the approaches [m]
        of both, (k, 2), and how far down [m] their basins hang together, (k,)."""
        summits = self.summits
        pairs = summits.owner[summits.peaks.neighbors]
        top, low = summits.height[pairs], summits.peaks.passes
        flat = low - (JOINED - 1.0) * (top.mean(axis=1) - low)
        some = self._usable[pairs].all(axis=1) & (pairs[:, 0] != pairs[:, 1])
        some &= (flat > self._lowest) & (flat < top.min(axis=1))
        pairs, low, approach = pairs[some], low[some], (top - flat[:, None])[some]
        over = np.maximum(self._height - flat[some, None], 0.0)
        own = np.sum(self._weight[pairs] * approach**1.5, axis=1)
        some = own > SHARE_OF_PAIR * ((over * np.sqrt(over)) @ self._first)
        pairs, approach, low = pairs[some], approach[some], low[some]
        return pairs, approach, low - SLACK * approach.mean(axis=1)

    def joined(self, material: HalfSpace) -> Ranking:
        """The same where those whose contacts join while they carry much of the load are one.

        Those that cannot be pressed as one, as they reach too far, stay apart.
        """
        pairs, approach, low = self.joining()
        if not len(pairs):
            return self
        one = self.summits.joined(pairs, low)
        roots, slot = np.unique(one.owner[pairs[:, 0]], return_inverse=True)
        depth = np.zeros(len(roots))
        np.maximum.at(depth, slot, approach.max(axis=1))
        depths = depth[:, None] * np.array([1.0, 2.0])
        found = press(one, roots, depths, material)[:, -1]
        pressed = found[:, 0] > 0.0
        if not pressed.all():
            one = self.summits.joined(pairs[pressed[slot]], low[pressed[slot]])
        ranking = Ranking(one)
        ranking.curvature, ranking.angle = _formed(one, roots[pressed], found[pressed, 4:].T)
        return ranking

    def dominant(self, rows: Rows, table: LawTable) -> Rows:
        """Slots of a law table of the summits `rows` whose law has to be exact: joined ones too."""
        beyond = (table.flags & Flag.BEYOND_RADIUS) > 0
        slots = np.flatnonzero(beyond.any(axis=1) & (table.reach > 0) & self._usable[rows])
        first = beyond[slots].argmax(axis=1)
        nodes = np.minimum(first[:, None] + LATER, table.nodes)
        depth = table.reach[slots, None] * (nodes / table.nodes) ** 2
        top = self.summits.height[rows[slots]]
        near = top - depth[:, 0] > self._lowest
        flat = (top[:, None] - depth)[near]
        slots, depth, first = slots[near], depth[near], first[near]
        over = np.maximum(self._height - flat[:, :, None], 0.0)
        total = (over * np.sqrt(over)) @ self._first
        own = self._weight[rows[slots], None] * depth**1.5
        seen = flat > self._lowest
        none = self.summits.kinds[rows[slots], None] == PLATEAU
        rough = self._ridge[rows[slots]] | (first <= EARLY)
        share = np.where(none, SHARE_OF_NONE, np.where(rough, SHARE, SHARE_OF_ROUND)[:, None])
        chosen = np.isfinite(self.summits.floor[rows]) & (table.reach > 0)
        chosen[slots[(seen & (own > share * total)).any(axis=1)]] = True
        return np.flatnonzero(chosen)


def _weight(summits: Summits) -> Array:
    """Root of the mean radius [m^1/2] of summits, of those that are none that of the others."""
    weight = np.prod(summits.curvature, axis=1) ** -0.25
    none = summits.kinds == PLATEAU
    if none.any() and not none.all():
        weight[none] = np.median(weight[~none])
    return np.asarray(weight)


def _formed(summits: Summits, rows: Rows, moments: Array) -> tuple[Array, Array]:
    """Principal curvatures [1/m] and directions [rad] of summits, where those of some have contacts
    of the moments yy, xx, yx, shape (3, k); their own where the moments are those of no area."""
    curvature, angle = summits.curvature.copy(), summits.angle.copy()
    yy, xx, yx = moments
    mean, skew = 0.5 * (yy + xx), np.hypot(0.5 * (yy - xx), yx)
    wide = mean > skew
    rows, yy, xx, yx, mean, skew = (array[wide] for array in (rows, yy, xx, yx, mean, skew))
    steep = ((mean + skew) / (mean - skew)) ** (0.25 / ASPECT_EXPONENT)
    middle = np.sqrt(np.prod(curvature[rows], axis=1))
    curvature[rows] = np.stack((middle * steep, middle / steep), axis=1)
    angle[rows] = 0.5 * np.arctan2(2.0 * yx, xx - yy)
    return curvature, angle
