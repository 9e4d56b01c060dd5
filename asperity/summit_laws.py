"""The contact laws of the summits of one map, made when a contact is about to close."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from surfaces import _threads

from .dominant import Ranking
from .microcontact.elements import put
from .microcontact.laws import tabulate

if TYPE_CHECKING:
    from surfaces.heightmap import HeightMap
    from surfaces.peaks.summits import Summits

    from .material import HalfSpace
    from .microcontact.table import LawTable

__all__ = ["SummitLaws"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

PASSED = 0.2
"""Depth of a hollow under a contact that leans, over its approach, beyond which it ends there (0.1
to 0.4 hardly differ; seeds 1, 2, 11 and 12)."""


class SummitLaws:
    """Laws of summits by their rows, and the areas of contacts that lean.

    Parameters
    ----------
    hm
        The whole map, whose digest is made meanwhile.
    summits
        Summits of the map that is solved, as `ranking` has them where there is one.
    ranking
        What tells the dominant contacts, which are pressed alone; None: the law alone counts.
    material
        Half-space.
    law
        Name of the law.
    seconds
        Time of each stage [s], to which that of profiles and laws is added.
    """

    def __init__(
        self,
        hm: HeightMap,
        summits: Summits,
        ranking: Ranking | None,
        material: HalfSpace,
        law: str,
        seconds: dict[str, float],
    ) -> None:
        self.hm, self.summits, self.ranking = hm, summits, ranking
        self.material, self.law, self.seconds = material, law, seconds

    def table(self, rows: Rows) -> LawTable:
        """Laws of the summits `rows`, in that order."""
        begun = time.perf_counter()
        sampled = self.summits.rows(rows)
        between = time.perf_counter()
        table = tabulate(sampled, self.material, law=self.law)
        if self.ranking is not None:
            chosen = self.ranking.dominant(rows, table)
            put(table, chosen, self.summits, rows[chosen], self.material)
        self.seconds["profiles"] += between - begun
        self.seconds["laws"] += time.perf_counter() - between
        hm = self.hm
        _threads.aside(lambda: hm.digest)  # wanted at the end; solving leaves a thread idle
        return table

    def leaning(self, rows: Rows, tilt: Array, approach: Array, force: Array) -> Array:
        """Areas [m^2] of contacts whose basins are tilted, (k,), as `Population` asks for them."""
        summits = self.summits.leaning(rows, tilt, PASSED * approach)
        area = np.zeros(len(rows))
        alone = np.flatnonzero(summits.valid[rows] & np.isinf(summits.floor[rows]))
        if alone.size:
            table = tabulate(summits.rows(rows[alone]), self.material, law="ellipse")
            area[alone] = table.area_under(force[alone])
        return area
