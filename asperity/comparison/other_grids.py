"""Boundary elements on other grids than that of the map: coarser ones at a loose tolerance, the
baseline of the comparison, and one twice as fine, which judges the reference."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

import surfaces
from asperity.bem.curve import SolvedLoad, bem_curve
from asperity.engine.resolution import between_grids
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import Boundary
from asperity.results.curve import ContactCurve
from asperity.results.storage import structured
from surfaces.arrays import Array
from surfaces.heightmap import HeightMap

__all__ = [
    "ERRORS",
    "LOOSE_TOLERANCE",
    "coarse_grids",
    "coarse_run",
    "error_table",
    "load_at_separation",
    "refined_run",
    "rms",
    "rms_errors",
]

LOOSE_TOLERANCE = 1e-2
"""Tolerance of the cheap boundary-element runs; looser saves little, tighter changes nothing."""

ERRORS: tuple[str, ...] = ("load_error", "area_error", "separation_error")
"""Columns of errors in the tables of a comparison."""

SMALLEST_GRID = 48
"""Coarse boundary-element grids stop here."""

REFINED_ACCURACY = 0.01
"""Accuracy in load and area on the refined grid."""


def coarse_grids(shape: tuple[int, int]) -> list[tuple[int, int]]:
    """The full grid and its halves, quarters, ... down to the smallest useful one."""
    grids = [shape]
    while min(grids[-1]) >= 2 * SMALLEST_GRID:
        grids.append((grids[-1][0] // 2, grids[-1][1] // 2))
    return grids


def load_at_separation(curve: ContactCurve, separation: Array) -> Array:
    """Mean pressure [Pa] of a curve at given separations [m], log-linear beyond its ends; of one
    point by its stiffness."""
    from scipy.interpolate import PchipInterpolator

    usable = curve.converged & (curve.mean_pressure > 0)
    order = np.flatnonzero(usable)[np.argsort(curve.separation[usable])]
    order = order[np.diff(curve.separation[order], prepend=-np.inf) > 0]
    if not order.size:
        return np.full(np.shape(separation), np.nan)
    knots, log_p = curve.separation[order], np.log(curve.mean_pressure[order])
    inside = np.clip(separation, knots[0], knots[-1])
    if len(order) > 1:
        spline = PchipInterpolator(knots, log_p)
        start, slope = spline(inside), spline.derivative()(inside)
    else:
        start, slope = log_p, -curve.stiffness[order] / curve.mean_pressure[order]
    with np.errstate(invalid="ignore"):  # full contact is infinitely stiff
        return np.asarray(np.exp(start + slope * (separation - inside)))


def error_table(
    model: ContactCurve, same: Array, reference: ContactCurve, pressures: Array, rms_height: float
) -> NDArray[np.void]:
    """Errors per load point, of the microcontact model or of another grid: `model` at the loads of
    the reference, pressures [Pa] `same` at its separations."""
    loaded = np.where(reference.mean_pressure > 0, 1.0, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        load_error = same / reference.mean_pressure - 1.0
        area_error = model.contact_area / reference.contact_area - 1.0
    apart = (model.separation - reference.separation) / rms_height
    return structured(
        {
            "mean_pressure": pressures,
            "area_bem": reference.area_fraction,
            "area_model": model.area_fraction,
            "separation_bem": reference.separation,
            "separation_model": model.separation,
            "load_error": loaded * load_error,
            "area_error": loaded * area_error,
            "separation_error": loaded * apart,
            "contacts_bem": reference.contacts,
            "contacts_model": model.contacts,
            "contact_pressure_bem": reference.mean_contact_pressure,
            "contact_pressure_model": model.mean_contact_pressure,
        }
    )


def coarse_run(
    hm: HeightMap,
    material: HalfSpace,
    grid: tuple[int, int],
    boundary: Boundary,
    reference: ContactCurve,
    pressures: Array,
) -> tuple[Any, ...]:
    """Row of the table of run times: boundary elements on a coarse grid at a loose tolerance, at
    the mean pressures [Pa] of the comparison."""
    start = time.perf_counter()
    pixel = (hm.size[0] / grid[0], hm.size[1] / grid[1])
    coarse = hm if grid == hm.shape else surfaces.resample(hm, pixel)
    curve = bem_curve(
        coarse,
        material,
        pressures=pressures,
        tolerance=LOOSE_TOLERANCE,
        boundary=boundary,
    )
    seconds = time.perf_counter() - start
    same = load_at_separation(curve, reference.separation)
    table = error_table(curve, same, reference, pressures, hm.rms_height)
    judged = reference.converged & curve.converged
    return ("bem", *grid, LOOSE_TOLERANCE, seconds, *rms_errors(table[judged]))


def refined_run(
    hm: HeightMap, material: HalfSpace, boundary: Boundary, reference: ContactCurve
) -> NDArray[np.void] | None:
    """Errors of the reference's own grid at its lightest and at its heaviest load, about the
    highest point of the map.

    Returns
    -------
    Structured array, a row per load: mean_pressure [Pa]; load_error, of the load at equal
    separation, and area_error, of the area at equal load, both relative and against a grid twice as
    fine; ny and nx of that grid. None if nothing touches there.
    """
    loads = reference.mean_pressure[reference.converged & (reference.mean_pressure > 0.0)]
    if not loads.size:
        return None
    seen = list[SolvedLoad]()
    bem_curve(
        hm,
        material,
        pressures=np.unique([loads.min(), loads.max()]),
        accuracy=REFINED_ACCURACY,
        boundary=boundary,
        progress=seen.append,
    )
    solved = [point for point in seen if point.part.pressure.any()]
    if not solved:
        return None
    load, area = np.expm1(between_grids(solved, REFINED_ACCURACY))
    ny, nx = solved[0].part.hm.shape
    return structured(
        {
            "mean_pressure": np.array([point.mean_pressure for point in solved]),
            "load_error": load,
            "area_error": area,
            "ny": np.full(len(solved), 2 * ny),
            "nx": np.full(len(solved), 2 * nx),
        }
    )


def rms_errors(table: NDArray[np.void]) -> list[float]:
    """Root mean square of each of the `ERRORS` of an `error_table`."""
    return [rms(table[name]) for name in ERRORS]


def rms(values: Array) -> float:
    """Root mean square of the finite values, NaN if there is none."""
    finite = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite**2))) if finite.size else float("nan")
