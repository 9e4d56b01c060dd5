"""Contacts that carry much of the load where their expansion no longer holds: boundary elements
press their basins alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asperity.errors import Flag
from asperity.microcontact.basin_bem.press import put
from surfaces.arrays import Index
from surfaces.peaks.peaks import SUMMIT

if TYPE_CHECKING:
    from asperity.model.law_rows import LawRows

__all__ = ["correct", "pressed_slots"]

NODES_BEYOND = np.array([0, 1, 3, 6])
"""Nodes after the first one beyond the expansion, at which the load share is compared."""


def correct(laws: LawRows) -> None:
    """Replace the laws of contacts of large load share by those of basins pressed alone."""
    slots = pressed_slots(laws)
    put(laws.table, slots, laws.summits, laws.rows[slots], laws.material)


def pressed_slots(laws: LawRows) -> Index:
    """Rows of the table whose law boundary elements make: joined summits, and contacts whose load
    share exceeds its bound at one of the nodes beyond the expansion."""
    bounds, shares, table = laws.parameters.pressed_basins, laws.shares, laws.table
    summits, rows = laws.summits, laws.rows
    beyond = (table.flags & Flag.BEYOND_RADIUS) > 0
    slots = np.flatnonzero(beyond.any(axis=1) & (table.reach > 0) & summits.valid[rows])
    first = beyond[slots].argmax(axis=1)
    nodes = np.minimum(first[:, None] + NODES_BEYOND, table.nodes)
    depth = table.reach[slots, None] * (nodes / table.nodes) ** 2
    top = summits.height[rows[slots]]
    near = top - depth[:, 0] > shares.lowest
    flat = (top[:, None] - depth)[near]
    slots, depth, first = slots[near], depth[near], first[near]
    steep, shallow = summits.curvature[rows[slots]].T
    rough = (steep > bounds.ridge * shallow) | (first <= bounds.rough_node)
    share = np.where(rough, bounds.ridge_share, bounds.round_share)[:, None]
    none = summits.kinds[rows[slots], None] != SUMMIT
    share = np.where(none, bounds.plateau_share, share)
    load = shares.weight[rows[slots], None] * depth**1.5
    known = flat > shares.lowest
    chosen = np.isfinite(summits.floor[rows]) & (table.reach > 0)
    chosen[slots[(known & (load > share * shares.load(flat))).any(axis=1)]] = True
    return np.flatnonzero(chosen)
