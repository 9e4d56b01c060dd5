"""How far the reference itself is off: its grid against one twice as fine."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import surfaces
from asperity.bem.curve import bem_curve
from asperity.bem.memory import fits
from asperity.engine.resolution import representative_part
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import Boundary
from asperity.results.curve import ContactCurve
from asperity.results.storage import structured
from surfaces.heightmap import HeightMap

from .coarse_bem import load_at_separation

__all__ = ["refined_run"]

LARGEST = 1024
"""Points along a side up to which the whole map is refined; of a larger one a part is."""

TOLERANCE = 1e-3
"""Tolerance on the refined grid: it changes load and area by less than 0.1 %."""


def refined_run(
    hm: HeightMap, material: HalfSpace, boundary: Boundary, reference: ContactCurve
) -> NDArray[np.void] | None:
    """Errors of the reference's own grid at its lightest and at its heaviest load.

    Returns
    -------
    Structured array, a row per load: mean_pressure [Pa]; load_error, of the load at equal
    separation, and area_error, of the area at equal load, both relative and against a grid twice as
    fine; ny and nx of that grid. None if no such grid fits into memory, or nothing touches.
    """
    usable = np.flatnonzero(reference.converged & (reference.mean_pressure > 0.0))
    if not usable.size:
        return None
    order = usable[np.argsort(reference.mean_pressure[usable])]
    own = reference.select(order[[0, -1][: len(order)]])
    part = hm if max(hm.shape) <= LARGEST else representative_part(hm)
    finer = surfaces.resample(part, (part.spacing[0] / 2, part.spacing[1] / 2))
    if not fits(finer.shape, boundary, 1):
        return None
    if part is not hm:
        reference = bem_curve(
            part, material, pressures=reference.mean_pressure[order], boundary=boundary
        )
        own = reference.select([0, -1][: len(reference)])
    fine = bem_curve(
        finer, material, pressures=own.mean_pressure, tolerance=TOLERANCE, boundary=boundary
    )
    good = own.converged & fine.converged
    load = load_at_separation(reference, fine.separation) / fine.mean_pressure - 1.0
    return structured(
        {
            "mean_pressure": own.mean_pressure,
            "load_error": np.where(good, load, np.nan),
            "area_error": np.where(good, own.contact_area / fine.contact_area - 1.0, np.nan),
            "ny": np.full(len(own), finer.shape[0]),
            "nx": np.full(len(own), finer.shape[1]),
        }
    )
