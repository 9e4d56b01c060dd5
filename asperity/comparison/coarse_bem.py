"""Baseline of the comparison: boundary elements on coarser grids at a loose tolerance."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

import surfaces
from asperity.bem.curve import bem_curve
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import Boundary
from asperity.results.curve import ContactCurve
from surfaces.heightmap import HeightMap

__all__ = ["LOOSE_TOLERANCE", "coarse_grids", "coarse_run", "load_at_separation", "rms"]

LOOSE_TOLERANCE = 1e-2
"""Tolerance of the cheap boundary-element runs; looser saves little, tighter changes nothing."""

SMALLEST_GRID = 48
"""Coarse boundary-element grids stop here."""


def coarse_grids(shape: tuple[int, int]) -> list[tuple[int, int]]:
    """The full grid and its halves, quarters, ... down to the smallest useful one."""
    grids = [shape]
    while min(grids[-1]) >= 2 * SMALLEST_GRID:
        grids.append((grids[-1][0] // 2, grids[-1][1] // 2))
    return grids


def load_at_separation(curve: ContactCurve, separation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean pressure [Pa] of a curve at given separations [m], log-linear beyond its ends."""
    from scipy.interpolate import PchipInterpolator

    usable = curve.converged & (curve.mean_pressure > 0)
    order = np.flatnonzero(usable)[np.argsort(curve.separation[usable])]
    order = order[np.diff(curve.separation[order], prepend=-np.inf) > 0]
    if len(order) < 2:
        return np.full(np.shape(separation), np.nan)
    knots, log_p = curve.separation[order], np.log(curve.mean_pressure[order])
    spline = PchipInterpolator(knots, log_p)
    inside = np.clip(separation, knots[0], knots[-1])
    slope = spline.derivative()(inside)
    return np.asarray(np.exp(spline(inside) + slope * (separation - inside)))


def coarse_run(
    hm: HeightMap,
    material: HalfSpace,
    grid: tuple[int, int],
    boundary: Boundary,
    reference: ContactCurve,
    pressures: NDArray[np.float64],
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
    loaded = reference.converged & (reference.mean_pressure > 0)
    judged = loaded & curve.converged
    area = curve.contact_area[judged] / reference.contact_area[judged] - 1.0
    separation = (curve.separation - reference.separation)[judged] / hm.rms_height
    shifted = load_at_separation(curve, reference.separation[loaded])
    load = shifted / reference.mean_pressure[loaded] - 1.0
    errors = (rms(load), rms(area), rms(separation))
    return ("bem", *grid, LOOSE_TOLERANCE, seconds, *errors)


def rms(values: NDArray[np.float64]) -> float:
    """Root mean square of the finite values, NaN if there is none."""
    finite = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite**2))) if finite.size else float("nan")
