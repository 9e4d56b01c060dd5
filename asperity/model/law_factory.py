"""The contact laws of the summits of one map, made when a contact is about to close."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.errors import ModelRangeError
from asperity.microcontact.capped_table import capped_table
from asperity.microcontact.law_table import LawTable, LazyTable, joined
from asperity.microcontact.laws import elastic_table
from surfaces.numerics.stored_array import StoredArray

from .corrections import pressed_basins, sharp_tips
from .law_rows import LawRows

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.parameters import Parameters
    from surfaces.peaks.summits import Summits

    from .law_rows import LoadShares

__all__ = ["LawFactory"]

Rows = NDArray[np.int64]

CORRECTIONS = {"sharp_tips": sharp_tips.correct, "pressed_basins": pressed_basins.correct}
"""What changes the laws of single contacts, in this order: switch (`parameters.Corrections`) and
function."""


class LawFactory:
    """Laws of summits by their rows; without `shares` they are not corrected. The time [s] of
    profiles and laws is added to `seconds`.

    Attributes
    ----------
    without
        Summits asked for so far that have no contact by the law, and carry nothing.
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
        self._elastic = self._table(self._without_hardness, material.hardness < math.inf)

    def of_hardness(self, material: HalfSpace, seconds: dict[str, float]) -> LawFactory:
        """A factory for another hardness, which takes the elastic laws from here."""
        other = copy.copy(self)
        other.material, other.seconds = material, seconds
        return other

    def all_laws(self) -> LazyTable:
        """A table of the laws of all summits, which are made when they are needed."""
        if self.material.hardness == math.inf:
            return self._elastic
        return self._table(self._with_hardness)

    def _table(self, make: Callable[[Rows], LawTable], whole: bool = False) -> LazyTable:
        """A table of all summits: on disk where their map is."""
        summits, stored = self.summits, isinstance(self.summits.hm.source, StoredArray)
        return LazyTable(len(summits), make, whole=whole, near=summits.near, stored=stored)

    def _with_hardness(self, rows: Rows) -> LawTable:
        """Laws with the hardness of the half-space of the summits `rows`, in that order."""
        elastic = joined([block for _, block in self._elastic.blocks(rows)])
        begun = time.perf_counter()
        table = capped_table(elastic, self.material)
        self.seconds["laws"] += time.perf_counter() - begun
        return table

    def _without_hardness(self, rows: Rows) -> LawTable:
        """Laws without a hardness of the summits `rows`, in that order."""
        begun = time.perf_counter()
        sampled = self.summits.rows(rows)
        between = time.perf_counter()
        table = elastic_table(sampled, self.material, law=self.law)
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
