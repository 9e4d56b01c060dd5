"""Which contacts carry so much of the load that their law has to be exact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .microcontact.flags import Flag

if TYPE_CHECKING:
    from surfaces.summits import Summits

    from .microcontact.table import LawTable

__all__ = ["SHARE", "Ranking"]

Rows = NDArray[np.int64]

SHARE = 0.01
"""Share of the load of a contact about to outgrow its expansion from which on it is dominant."""

MOST = 400
"""Summits above the flat at which no contact is looked at any more."""


class Ranking:
    """Summits in the order in which a flat meets them, with the loads that they then carry.

    Parameters
    ----------
    summits
        Summits of a map.

    Notes
    -----
    The loads are those of independent Hertz contacts. A mean displacement of the body moves all
    summits alike and leaves the shares of the load at a given depth of one contact as they are.
    The choice follows from the map alone: it does not depend on the loads that are asked for, and a
    curve has no steps where contacts enter or leave it.
    """

    def __init__(self, summits: Summits) -> None:
        usable = np.flatnonzero(summits.valid & ~summits.border)
        order = usable[np.argsort(-summits.height[usable], kind="stable")]
        self._usable = np.zeros(len(summits), bool)
        self._usable[usable] = True
        self._height = summits.height[order[:MOST]]
        self._weight = _weight(summits, order[:MOST])
        self._summits = summits

    def dominant(self, rows: Rows, table: LawTable) -> Rows:
        """Slots of a law table of the summits `rows` whose law has to be exact."""
        beyond = (table.flags & Flag.BEYOND_RADIUS) > 0
        first = beyond.argmax(axis=1)
        slots = np.flatnonzero(beyond.any(axis=1) & (table.reach > 0) & self._usable[rows])
        depth = table.reach[slots] * (first[slots] / table.nodes) ** 2
        flat = self._summits.height[rows[slots]] - depth
        near = np.searchsorted(-self._height, -flat) < MOST
        slots, depth, flat = slots[near], depth[near], flat[near]
        total = np.maximum(self._height - flat[:, None], 0.0) ** 1.5 @ self._weight
        own = _weight(self._summits, rows[slots]) * depth**1.5
        return np.asarray(slots[own > SHARE * total])


def _weight(summits: Summits, rows: Rows) -> NDArray[np.float64]:
    """Root of the mean radius [m^1/2] of summits."""
    return np.asarray(np.prod(summits.curvature[rows], axis=1) ** -0.25)
