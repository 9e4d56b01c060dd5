"""Table of the separate contact spots of one load point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.model.load_point import spot_count, spot_of_contacts
from asperity.results.storage import structured
from surfaces.arrays import Array, Index
from surfaces.patches import label_patches

from .fields import pressed_pixels

if TYPE_CHECKING:
    from asperity.model.decomposition import Decomposition
    from asperity.model.load_point import LoadPoint

__all__ = ["spot_table"]


def spot_table(decomposition: Decomposition, point: LoadPoint) -> NDArray[np.void]:
    """Table of the contact spots that hold a pixel; the column `contacts` of a curve counts all.

    Contacts that have joined over the passes between them are one spot
    (`asperity.model.load_point.spot_count`), whether or not the neck between them holds a pixel.
    With a sub-contact law spots are the patches of the contact map, whose pixels meet at an edge or
    a corner. There necks can be broken: if there are more patches than the curve counts spots, the
    weakest are assigned to the strongest patch of their contact.

    Returns
    -------
    Structured array, largest spot first, with x, y [m] (centre of the pressure), area [m^2],
    force [N], mean_pressure, peak_pressure [Pa] and pixels [-]. Forces add up to the load, areas to
    the contact area of the curve: the pixels of a contact share its area, so that a spot of a
    contact smaller than a pixel has a smaller area than its pixel. No spot bears more than the
    hardness.

    Notes
    -----
    The table has fewer rows than the curve counts spots, by those without a pixel of their own: low
    summits pressed as one contact with a higher one, and spots parted by fine waves that the map
    does not part (3 rows of 6 spots at light load, 76 of 84 later, map of 128^2). Against
    boundary elements on the pixels of the map (256 x 320 and 512 x 576, seeds 31, 51 and 77, 0.7 to
    10 % of contact, 15 spots and more) both are within 12 % rms where the spectrum is cut off at 8
    pixels, 18 % at 4 pixels, and 24 % (the table 17 %) where it reaches the pixel.
    """
    hm = decomposition.hm
    pixel, contact, pressure = pressed_pixels(decomposition, point)
    if decomposition.plan.sub_contact_law is None:
        spot = _joined(decomposition, point, pixel, contact)
    else:
        spot = _parted(decomposition, point, pixel, contact, pressure)
    own = np.unique(spot, return_inverse=True)[1]
    count = int(own.max(initial=-1)) + 1
    force = pressure * (hm.spacing[0] * hm.spacing[1])
    of_contact = np.bincount(contact, minlength=len(point.closed_area))
    even = point.closed_area[contact] / of_contact[contact]
    share = _shares(even, force / decomposition.material.hardness)

    def total(values: Array) -> Array:
        return np.bincount(own, weights=values, minlength=count).astype(float, copy=False)

    # strongest pixel of each spot, from which its other pixels are counted
    order = np.lexsort((force, own))
    top = order[np.searchsorted(own[order], np.arange(count), side="right") - 1]
    carried, area = total(force), total(share)
    peak = np.zeros(count)
    np.maximum.at(peak, own, np.bincount(pixel, weights=pressure)[pixel])
    mean = carried / area
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
            "mean_pressure": mean,
            "peak_pressure": np.maximum(peak, mean),  # spots may be smaller than their pixels
            "pixels": np.bincount(np.unique([own, pixel], axis=1)[0], minlength=count),
        }
    )
    return table[np.argsort(-area, kind="stable")]


def _shares(even: Array, least: Array) -> Array:
    """Areas [m^2] of pixels: `even`, changed so that none is below `least` and the sum stays."""
    share = np.maximum(even, least)
    spare = share - least
    excess = share.sum() - even.sum()
    return np.asarray(share - spare * (excess / max(spare.sum(), np.finfo(float).tiny)))


def _joined(decomposition: Decomposition, point: LoadPoint, pixel: Index, contact: Index) -> Index:
    """The spot of each pixel in contact: that of its contact, or of the summit in whose basin it
    lies where several summits were pressed as one contact."""
    summits, first = decomposition.summits, spot_of_contacts(decomposition, point)
    peak = decomposition.labels.flat[pixel]
    own = first[summits.single[peak]]
    parted = (peak >= 0) & (summits.owner[peak] == contact) & (own >= 0)
    return np.asarray(np.where(parted, own, first[contact]))


def _parted(
    decomposition: Decomposition, point: LoadPoint, pixel: Index, contact: Index, pressure: Array
) -> Index:
    """The spot of each pixel in contact where fine waves part the contacts."""
    touching = np.zeros(decomposition.hm.shape, bool)
    touching.flat[pixel] = True
    labels, count = label_patches(touching, periodic=decomposition.plan.boundary == "periodic")
    patch = labels.flat[pixel] - 1
    force = np.bincount(patch, weights=pressure, minlength=count)
    home, strongest = np.zeros(count, np.int64), np.zeros(int(contact.max(initial=0)) + 1, np.int64)
    rising = np.argsort(pressure, kind="stable")
    home[patch[rising]] = contact[rising]  # the contact of the strongest pixel, which comes last
    rising = np.argsort(force, kind="stable")
    strongest[home[rising]] = rising
    minor = rising[strongest[home[rising]] != rising]
    surplus = minor[: max(count - spot_count(decomposition, point), 0)]
    into = np.arange(count)
    into[surplus] = strongest[home[surplus]]
    return np.asarray(into[patch])
