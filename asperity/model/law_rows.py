"""The laws of some summits of a map, as corrections see them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.microcontact.law_table import LawTable
    from asperity.parameters import Parameters
    from surfaces.peaks.profiles import Profiles
    from surfaces.peaks.summits import Summits

    from .load_shares import LoadShares

__all__ = ["LawRows"]


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
