"""Table of the separate contact spots of one load point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.results.storage import structured
from surfaces.patches import label_patches

from .fields import pressed_pixels

if TYPE_CHECKING:
    from asperity.model.decomposition import Decomposition
    from asperity.model.load_point import LoadPoint

__all__ = ["spot_table"]


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
