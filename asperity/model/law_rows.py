"""The laws of some summits of a map, as corrections see them, and the loads that summits carry."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from surfaces.peaks.peaks import SUMMIT

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.microcontact.law_table import LawTable
    from asperity.parameters import Parameters
    from surfaces.peaks.profiles import Profiles
    from surfaces.peaks.summits import Summits

__all__ = ["LawRows", "LoadShares"]

Array = NDArray[np.float64]

MOST_SUMMITS = 200
"""Summits above the flat at which no contact is looked at any more."""


@dataclass(frozen=True, eq=False)
class LawRows:
    """Laws of some summits, which a correction may change, and what they were made from.

    Attributes
    ----------
    table
        The laws, which nobody else holds.
    rows
        Summits that they belong to, shape (k,).
    profiles
        Their rays.
    summits, shares, material, parameters
        All summits, the loads that they carry, the half-space, and the constants of the model.
    """

    table: LawTable
    rows: NDArray[np.int64]
    profiles: Profiles
    summits: Summits
    shares: LoadShares
    material: HalfSpace
    parameters: Parameters


@dataclass(frozen=True, eq=False)
class LoadShares:
    """The highest summits of a map, with the loads that they carry under a flat.

    Attributes
    ----------
    weight
        Load of each summit over its approach to the power 3/2, but for a common factor, shape (n,).
    height, first
        Heights [m] of the `MOST_SUMMITS` highest valid summits, from the highest down, and their
        weights.

    Notes
    -----
    The loads are those of independent Hertz contacts. A mean displacement of the body moves all
    summits alike and leaves the shares of the load at a given depth of one contact as they are.
    The shares follow from the map alone: they do not depend on the loads that are asked for, and a
    curve has no steps where contacts enter or leave them.
    """

    weight: Array
    height: Array
    first: Array

    @classmethod
    def of(cls, summits: Summits, among: LoadShares | None = None) -> LoadShares:
        """The shares of the summits of a map: of their own load, or of that of those `among` which
        they stand."""
        weight = _weight(summits)
        if among is not None:
            return replace(among, weight=weight)
        rows = np.flatnonzero(summits.valid)
        highest = rows[np.argsort(-summits.height[rows], kind="stable")[:MOST_SUMMITS]]
        return cls(weight, summits.height[highest], weight[highest])

    def lowered(self, level: float) -> LoadShares:
        """The same with heights above another level [m]."""
        return replace(self, height=self.height - level)

    @property
    def full(self) -> bool:
        """Whether there are so many summits that a lower one cannot change the shares."""
        return len(self.height) == MOST_SUMMITS

    @property
    def lowest(self) -> float:
        """Height [m] of the flat down to which loads are known."""
        return float(self.height[-1]) if self.full else -np.inf

    def load(self, flat: Array) -> Array:
        """Load of all summits under flats at heights [m], in the unit of `weight`."""
        over = np.maximum(self.height - flat[..., None], 0.0)
        return np.asarray((over * np.sqrt(over)) @ self.first)


def _weight(summits: Summits) -> Array:
    """Root of the mean radius [m^1/2] of summits, of peaks without one that of the others."""
    weight = np.prod(summits.curvature, axis=1) ** -0.25
    none = summits.kinds != SUMMIT
    if none.any() and not none.all():
        weight[none] = np.median(weight[~none])
    return np.asarray(weight)
