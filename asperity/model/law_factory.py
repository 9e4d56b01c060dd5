"""The contact laws of the summits of one map, made when a contact is about to close."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from asperity.errors import ModelRangeError
from asperity.microcontact.capped_table import capped_table
from asperity.microcontact.law_table import LawTable, LazyTable
from asperity.microcontact.laws import elastic_table
from surfaces.arrays import Index
from surfaces.numerics.stored_array import StoredArray

from .corrections import pressed_basins, sharp_tips
from .law_rows import LawRows

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.parameters import Parameters
    from surfaces.peaks.summits import Summits

    from .law_rows import LoadShares

__all__ = ["LawFactory"]


CORRECTIONS = {"sharp_tips": sharp_tips.correct, "pressed_basins": pressed_basins.correct}
"""Corrections of single laws in the order in which they are applied: the switch in
`parameters.Corrections`, and the function."""


class LawFactory:
    """Makes the laws of the summits of one map.

    Laws are corrected only if there are load `shares`, that is with the law `auto`. The factory
    adds the time [s] of profiles and of laws to `seconds`.

    Attributes
    ----------
    without
        Summits for which the law gave no contact so far; they carry no load.
    """

    def __init__(
        self,
        summits: Summits,
        shares: LoadShares | None,
        material: HalfSpace,
        law: str,
        parameters: Parameters,
        seconds: dict[str, float],
    ) -> None:
        self.summits, self.shares = summits, shares
        self.material, self.law, self.parameters = material, law, parameters
        self.seconds = seconds
        self.without: set[int] = set()
        self._elastic = self._table(self._without_hardness)

    def of_hardness(self, material: HalfSpace, seconds: dict[str, float]) -> LawFactory:
        """A factory for another hardness, which shares the elastic laws of this one."""
        other = copy.copy(self)
        other.material, other.seconds = material, seconds
        return other

    def all_laws(self) -> LazyTable:
        """A lazy table of the laws of all summits: a law is made when it is needed."""
        if self.material.hardness == math.inf:
            return self._elastic
        return self._table(self._with_hardness)

    def _table(self, make: Callable[[Index], LawTable]) -> LazyTable:
        """A lazy table of all summits, on disk if their map is."""
        summits, stored = self.summits, isinstance(self.summits.hm.source, StoredArray)
        return LazyTable(len(summits), make, near=summits.near, stored=stored)

    def _with_hardness(self, rows: Index) -> LawTable:
        """Laws of the summits `rows`, in that order, capped by the hardness of the material."""
        elastic = self._elastic.laws(rows)
        begun = time.perf_counter()
        table = capped_table(elastic, self.material)
        self.seconds["laws"] += time.perf_counter() - begun
        return table

    def _without_hardness(self, rows: Index) -> LawTable:
        """Elastic laws of the summits `rows`, in that order, with their corrections."""
        begun = time.perf_counter()
        sampled = self.summits.rows(rows)
        between = time.perf_counter()
        choice = self.parameters.law_choice
        table = elastic_table(sampled, self.material, law=self.law, choice=choice)
        self._require_top(rows, table)
        if self.shares is not None:
            laws = LawRows(
                table, rows, sampled, self.summits, self.shares, self.material, self.parameters
            )
            for name, correct in CORRECTIONS.items():
                if getattr(self.parameters.corrections, name):
                    correct(laws)
        self.seconds["profiles"] += between - begun
        self.seconds["laws"] += time.perf_counter() - between
        return table

    def _require_top(self, rows: Index, table: LawTable) -> None:
        """Record the summits `rows` without a contact; refuse the law if the highest is one: a
        curve without it would be wrong from the first touch on."""
        summits = self.summits
        none = rows[summits.valid[rows] & ~((table.reach > 0) & (table.force[:, -1] > 0))]
        self.without.update(none.tolist())
        top = int(np.argmax(np.where(summits.valid, summits.height, -np.inf)))
        if top in self.without:
            cure = "" if self.law == "auto" else 'law="auto" (--law auto), '
            raise ModelRangeError(
                f"the law {self.law!r} has no contact for the highest summit, at x = "
                f"{summits.x[top]:.4g} m, y = {summits.y[top]:.4g} m, too sharp or too blunt "
                f"for the points about it; take {cure}more points or boundary elements"
            )
