"""The input of a correction: the laws of some summits, and the load shares of all summits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from surfaces.arrays import Array, Index
from surfaces.peaks.peaks import SUMMIT

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.microcontact.law_table import LawTable
    from asperity.parameters import Parameters
    from surfaces.peaks.profiles import Profiles
    from surfaces.peaks.summits import Summits

__all__ = ["LawRows", "LoadShares"]


MOST_SUMMITS = 200
"""Highest summits whose loads are summed. Load shares are known while the flat stands above the
last of them; no correction looks at a contact below."""


@dataclass(frozen=True, eq=False)
class LawRows:
    """Laws of some summits, which a correction may change, and what they were made from.

    Attributes
    ----------
    table
        Laws of the summits `rows`. A correction changes this table in place.
    rows
        Index of each of these summits among all, shape (k,).
    profiles
        Sampled rays of the summits `rows`.
    summits, shares
        All summits of the map, and their load shares.
    material, parameters
        The half-space, and the constants of the model.
    """

    table: LawTable
    rows: Index
    profiles: Profiles
    summits: Summits
    shares: LoadShares
    material: HalfSpace
    parameters: Parameters


@dataclass(frozen=True, eq=False)
class LoadShares:
    """Share of the total load that each summit of a map carries.

    Attributes
    ----------
    weight
        Square root of the summit radius [m^1/2], shape (n,), to which a Hertz load is proportional.
    height, first
        Heights [m] and weights of the `MOST_SUMMITS` highest valid summits, from the highest down.

    Notes
    -----
    Every summit carries the load of an independent Hertz contact, F_i = (4/3) E* sqrt(R_i) d_i^1.5
    at the approach d_i; the common factor 4/3 E* cancels. A mean displacement of the body lowers
    all d_i alike, so the share of a contact at a given approach does not depend on it. The shares
    follow from the map alone: they do not depend on the loads that are asked for, so a curve has no
    steps where a contact passes a bound on its share.
    """

    weight: Array
    height: Array
    first: Array

    @classmethod
    def of(cls, summits: Summits, among: LoadShares | None = None) -> LoadShares:
        """Load shares of the summits of a map.

        The total load is that of these summits, or that of `among`, the summits of the whole map,
        if the map is a part of it.
        """
        weight = _weight(summits)
        if among is not None:
            return replace(among, weight=weight)
        rows = np.flatnonzero(summits.valid)
        highest = rows[np.argsort(-summits.height[rows], kind="stable")[:MOST_SUMMITS]]
        return cls(weight, summits.height[highest], weight[highest])

    def lowered(self, level: float) -> LoadShares:
        """These shares with `height` measured from the height `level` [m]."""
        return replace(self, height=self.height - level)

    @property
    def full(self) -> bool:
        """Whether `MOST_SUMMITS` summits are known: summits below them do not change the shares."""
        return len(self.height) == MOST_SUMMITS

    @property
    def lowest(self) -> float:
        """Lowest height [m] of the flat at which the total load is known."""
        return float(self.height[-1]) if self.full else -np.inf

    def load(self, flat: Array) -> Array:
        """Total load over (4/3) E*, in m^2, under flats at the heights `flat` [m]."""
        over = np.maximum(self.height - flat[..., None], 0.0)
        return np.asarray((over * np.sqrt(over)) @ self.first)


def _weight(summits: Summits) -> Array:
    """Square root of the summit radius [m^1/2], R = (k1 k2)^-1/2 of the principal curvatures.

    A peak without a summit (plateau, ridge) gets the median of the others.
    """
    weight = np.prod(summits.curvature, axis=1) ** -0.25
    none = summits.kinds != SUMMIT
    if none.any() and not none.all():
        weight[none] = np.median(weight[~none])
    return np.asarray(weight)
