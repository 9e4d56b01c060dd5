"""The separate contact spots of one load point: their number, and their table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.results.storage import structured
from surfaces.numerics.compiled import compiled
from surfaces.patches import label_patches, root

from .fields import pressed_pixels

if TYPE_CHECKING:
    from asperity.interaction.population import PopulationState
    from asperity.model.decomposition import Decomposition
    from asperity.model.load_point import LoadPoint
    from surfaces.peaks.summits import Summits

__all__ = ["joined_spots", "spot_count", "spot_table"]


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


def spot_table(decomposition: Decomposition, point: LoadPoint) -> NDArray[np.void]:
    """Table of the spots of the contact map (edge neighbors, as for boundary elements).

    Parameters
    ----------
    decomposition, point
        As in `microcontacts`.

    Returns
    -------
    Structured array, largest spot first, with x, y [m] (centre of the pressure), area [m^2],
    force [N], mean_pressure, peak_pressure [Pa] and pixels [-]. Forces add up to the load, areas
    to the contact area of the curve: the pixels of a contact share its area, so that spots of
    contacts smaller than a pixel have less than one.
    """
    hm = decomposition.hm
    pixel, contact, pressure = pressed_pixels(decomposition, point)
    touching = np.zeros(hm.shape, bool)
    touching.flat[pixel] = True
    labels, count = label_patches(touching, periodic=decomposition.plan.boundary == "periodic")
    own, force = labels.flat[pixel] - 1, pressure * (hm.spacing[0] * hm.spacing[1])
    of_contact = np.bincount(contact, minlength=len(point.closed_area))
    share = point.closed_area[contact] / of_contact[contact]

    def total(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.bincount(own, weights=values, minlength=count).astype(float, copy=False)

    # strongest pixel of each spot, from which its other pixels are counted
    order = np.lexsort((force, own))
    top = order[np.searchsorted(own[order], np.arange(count), side="right") - 1]
    carried, area = total(force), total(share)
    peak = np.zeros(count)
    np.maximum.at(peak, own, np.bincount(pixel, weights=pressure)[pixel])
    places = []
    for step, shape, index in zip(hm.spacing, hm.shape, np.divmod(pixel, hm.shape[1]), strict=True):
        away = index - index[top][own]
        if decomposition.plan.boundary == "periodic":
            away -= np.rint(away / shape).astype(np.int64) * shape
        middle = index[top] + 0.5 + total(force * away) / carried
        places.append(step * (middle % shape))
    table = structured(
        {
            "x": places[1],
            "y": places[0],
            "area": area,
            "force": carried,
            "mean_pressure": carried / area,
            "peak_pressure": peak,
            "pixels": np.bincount(labels.ravel(), minlength=count + 1)[1:],
        }
    )
    return table[np.argsort(-area, kind="stable")]
