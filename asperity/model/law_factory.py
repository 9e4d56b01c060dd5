"""The contact laws of the summits of one map, made when a contact is about to close."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.errors import ModelRangeError
from asperity.halfspace.flags import Flag
from asperity.microcontact.basin_bem.press import put
from asperity.microcontact.laws import tabulate
from surfaces.numerics import parallel

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.microcontact.law_table import LawTable
    from surfaces.heightmap import HeightMap
    from surfaces.peaks.profiles import Profiles
    from surfaces.peaks.summits import Summits

    from .load_shares import LoadShares

__all__ = ["LawFactory"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

TINY = float(np.finfo(float).tiny)

SHARP = 1.5
"""Ratio of f/r^2 at a tip and at the first node of its rays from which on the rays do not
resolve it: 12 and 4 of r and r^1.5 on 256 points, at most 2.3 on nine measured and random maps."""

MISSED = 0.05
"""Error of its force by that from which on a tip is pressed alone as a dominant contact may be."""


class LawFactory:
    """Laws of summits by their rows.

    Parameters
    ----------
    hm
        The whole map, whose digest is made meanwhile.
    summits
        Summits of the map that is solved, as `load_shares` has them where there is one.
    load_shares
        What tells the dominant contacts, which are pressed alone; None: the law alone counts.
    material
        Half-space.
    law
        Name of the law.
    seconds
        Time of each stage [s], to which that of profiles and laws is added.

    Attributes
    ----------
    without
        Summits asked for so far that have no contact by the law, and carry nothing.
    """

    def __init__(
        self,
        hm: HeightMap,
        summits: Summits,
        load_shares: LoadShares | None,
        material: HalfSpace,
        law: str,
        seconds: dict[str, float],
    ) -> None:
        self.hm, self.summits, self.load_shares = hm, summits, load_shares
        self.material, self.law, self.seconds = material, law, seconds
        self.without: set[int] = set()

    def table(self, rows: Rows) -> LawTable:
        """Laws of the summits `rows`, in that order."""
        begun = time.perf_counter()
        sampled = self.summits.rows(rows)
        between = time.perf_counter()
        table = tabulate(sampled, self.material, law=self.law)
        self._require_top(rows, table)
        _doubt_tips(sampled, table)
        if self.load_shares is not None:
            chosen = self.load_shares.dominant(rows, table)
            put(table, chosen, self.summits, rows[chosen], self.material)
        self.seconds["profiles"] += between - begun
        self.seconds["laws"] += time.perf_counter() - between
        hm = self.hm
        parallel.aside(lambda: hm.digest)  # wanted at the end; solving leaves a thread idle
        return table

    def _require_top(self, rows: Rows, table: LawTable) -> None:
        """Refuse a law that does not hold for the highest summit, without which nothing is told."""
        summits = self.summits
        none = rows[summits.valid[rows] & ~((table.reach > 0) & (table.force[:, -1] > 0))]
        self.without.update(none.tolist())
        top = int(np.argmax(np.where(summits.valid, summits.height, -np.inf)))
        if top in self.without:
            raise ModelRangeError(
                f"the law {self.law!r} has no contact for the highest summit, at x = "
                f"{summits.x[top]:.4g} m, y = {summits.y[top]:.4g} m, too sharp or too blunt "
                'for the points about it; take law="auto" (--law auto), more points or '
                "boundary elements"
            )


def _doubt_tips(profiles: Profiles, table: LawTable) -> None:
    """Raise the expected errors of contacts that reach little beyond a tip between two nodes, and
    mark them as beyond what the expansion describes."""
    tip, first = (profiles.q[:, :, node].mean(axis=1) for node in (0, 1))
    ratio = tip / np.maximum(first, TINY)
    sharp = np.flatnonzero(profiles.valid & (ratio > SHARP))
    if not sharp.size:
        return
    inner = np.pi * np.mean((profiles.t[1] * profiles.edge[sharp]) ** 2, axis=1)
    part = inner[:, None] / np.maximum(table.area[sharp], inner[:, None])
    missed = np.minimum((ratio[sharp, None] - 1.0) * part, 1.0)
    table.spread[sharp] = np.maximum(table.spread[sharp], missed)
    missed[:, 0] = 0.0
    table.flags[sharp] |= np.where(missed > MISSED, Flag.BEYOND_RADIUS, 0).astype(np.uint8)
