"""The number of separate contact spots at a load point, without a map of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics.compiled import compiled
from surfaces.patches import root

if TYPE_CHECKING:
    from asperity.interaction.population import PopulationState
    from surfaces.peaks.summits import Summits

    from .decomposition import Decomposition
    from .load_point import LoadPoint

__all__ = ["joined_spots", "spot_count"]

Array = NDArray[np.float64]


def spot_count(decomposition: Decomposition, point: LoadPoint) -> int:
    """Number of separate spots.

    Parameters
    ----------
    decomposition
        The decomposed surface.
    point
        One load point.

    Notes
    -----
    Contacts of adjoining basins have joined where their mean approach is 1.6 times the mean depth
    of the pass under their summits (1.7 for two equal summits in a double well, boundary elements:
    docs/development/errors.md). Where the finest waves act as a law, contacts of the area A that
    stay closed on its share f and cover the share P of the map are parted into
    0.97 P^-0.15 (1 - f)/f more spots per wave, A (q/2 pi)^2 waves of the mean wave number q of the
    fine waves.
    The constants were found on seeds 1, 2 and 11 (docs/development/errors.md).
    """
    fitted = decomposition.plan.parameters.spots
    pairs, depth = decomposition.passes
    each = _each(decomposition.summits, point.state)
    count: float = joined_spots(pairs, 2.0 * fitted.joined * depth, *each)
    fine, area = decomposition.plan.sub_contact_law, point.state.contact_area
    if fine is not None and area > 0.0:
        closed = float(point.closed_area.sum()) / area
        share = (area / decomposition.hm.area) ** -fitted.crowding
        waves = area * (fine.number / (2.0 * np.pi)) ** 2
        count += fitted.parted * share * waves * (1.0 - closed) / closed
    return round(count)


def _each(summits: Summits, state: PopulationState) -> tuple[Array, Array]:
    """Approaches [m] and areas of all summits, (n,), some for those that were joined to others."""
    lost = np.flatnonzero(summits.owner != summits.single)
    into = summits.owner[lost]
    approach, area = state.approach.copy(), state.area.copy()
    approach[lost] = approach[into] - (summits.height[into] - summits.height[lost])
    area[lost] = np.where((summits.single[lost] == lost) & (approach[lost] > 0.0), area[into], 0.0)
    return approach, area


@compiled()
def joined_spots(pairs: NDArray[np.int64], depth: Array, approach: Array, area: Array) -> int:
    """Number of spots of contacts that have joined over the passes between them.

    Parameters
    ----------
    pairs
        Contacts on both sides of each pass, shape (k, 2).
    depth
        Sum of their approaches [m] from which on they have joined, shape (k,).
    approach, area
        Approaches [m] and areas [m^2] of the contacts, shape (n,).
    """
    parent = np.empty(area.size, np.int64)
    left = 0
    for i in range(area.size):
        parent[i] = i
        left += area[i] > 0.0
    for k in range(pairs.shape[0]):
        a = pairs[k, 0]
        b = pairs[k, 1]
        if area[a] <= 0.0 or area[b] <= 0.0 or approach[a] + approach[b] <= depth[k]:
            continue
        a, b = root(parent, a), root(parent, b)
        if a != b:
            parent[max(a, b)] = min(a, b)
            left -= 1
    return left
