"""Small maps, curves and displacements that tests store, prepare and read off."""

from __future__ import annotations

import numpy as np

import surfaces
from asperity.results.curve import ContactCurve

SPACING = (2e-6, 3e-6)
"""Pixel size of the maps [m]."""


def bumps(ny: int = 40, nx: int = 57) -> surfaces.HeightMap:
    """Noise with a missing point, a name and a history."""
    heights = np.random.default_rng(3).normal(0.0, 1e-7, (ny, nx))
    heights[5, 7] = np.nan
    steps = ({"step": "read", "file": "a.sur", "instrument": "stylus"},)
    return surfaces.HeightMap(heights, SPACING, periodic=True, name="bumps", history=steps)


def noise(ny: int = 60, nx: int = 84, seed: int = 1) -> surfaces.HeightMap:
    """White noise that is not periodic."""
    heights = np.random.default_rng(seed).normal(0.0, 1e-8, (ny, nx))
    return surfaces.HeightMap(heights, SPACING)


def form(hm: surfaces.HeightMap, slope: tuple, curvature: float, angle: float) -> np.ndarray:
    """Heights [m] of a tilted cylinder on the points of a map."""
    y, x = hm.y[:, None] - hm.size[0] / 2, hm.x[None, :] - hm.size[1] / 2
    across = x * np.cos(angle) + y * np.sin(angle)
    return slope[0] * y + slope[1] * x + 0.5 * curvature * across**2


def power_law_curve(n: int = 12, *, broken: int | None = None) -> ContactCurve:
    """Mean pressure p = exp(-s / s0): the exponential law of rough contact."""
    pressure = np.geomspace(1e4, 1e7, n)
    converged = np.ones(n, dtype=bool)
    if broken is not None:
        converged[broken] = False
    separation = -1e-6 * np.log(pressure / 1e8)
    return ContactCurve(
        separation=np.where(converged, separation, np.nan),
        mean_pressure=pressure,
        load=pressure * 1e-6,
        area_fraction=pressure / 1e8,
        contact_area=pressure / 1e8 * 1e-6,
        contacts=np.arange(n),
        stiffness=pressure / 1e-6,
        converged=converged,
        residual=np.full(n, 1e-9),
        error_estimate=np.full(n, np.nan),
        model="asperity",
        seconds={"contact": 0.5},
        settings={"law": "paper", "above": None, "modulus": np.float64(2e11)},
        extra={"filled_share": np.linspace(0, 0.1, n)},
        reasons=tuple("stopped" if i == broken else "" for i in range(n)),
    )


def displaced(operator, pressure):
    """Displacement [m] of a pressure [Pa], shape (ny, nx), by a `HalfSpaceOperator`."""
    nx = operator.shape[1]
    operator.pressure[:, :nx] = pressure
    operator.pressure *= operator.compliance
    return np.array(operator.apply()[:, :nx])
