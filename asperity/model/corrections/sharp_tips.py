"""Tips narrower than the first step of their rays: their laws state larger errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asperity.errors import Flag

if TYPE_CHECKING:
    from asperity.model.law_rows import LawRows

__all__ = ["correct"]


def correct(laws: LawRows) -> None:
    """Raise the expected error of contacts on such tips, and flag them `BEYOND_RADIUS`.

    A tip is sharp if q at node 0 of the rays (the limit of the gap over r^2) exceeds `ratio` times
    q at node 1. The missed share of the force is taken as (q0/q1 - 1) times the area within node 1
    over the contact area.
    """
    bounds, profiles, table = laws.parameters.sharp_tips, laws.profiles, laws.table
    tip, first = (profiles.q[:, :, node].mean(axis=1) for node in (0, 1))
    ratio = tip / np.maximum(first, np.finfo(float).tiny)
    sharp = np.flatnonzero(profiles.valid & (ratio > bounds.ratio))
    if not sharp.size:
        return
    inner = np.pi * np.mean((profiles.t[1] * profiles.edge[sharp]) ** 2, axis=1)
    share = inner[:, None] / np.maximum(table.area[sharp], inner[:, None])
    missed = np.minimum((ratio[sharp, None] - 1.0) * share, 1.0)
    table.spread[sharp] = np.maximum(table.spread[sharp], missed)
    missed[:, 0] = 0.0
    flags = np.where(missed > bounds.error, Flag.BEYOND_RADIUS, 0)
    table.flags[sharp] |= flags.astype(np.uint8)
