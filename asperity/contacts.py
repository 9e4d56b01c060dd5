"""The microcontacts of one load point: a table, and the map of where they lie."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .curve import Asperities
from .population import PopulationState
from .tables import structured

__all__ = ["contact_map", "microcontacts"]

ASPECT_EXPONENT = 0.63
"""Axis ratio of an elliptic contact from the ratio of curvatures, b/a = (k2/k1)^0.63: fits exact
Hertz (theory 7.2) within 3 % up to a curvature ratio of 30."""


def microcontacts(bodies: Asperities, state: PopulationState) -> NDArray[np.void]:
    """Table of the contacts that carry load.

    Parameters
    ----------
    bodies
        The surface taken apart.
    state
        One load point.

    Returns
    -------
    Structured array with x, y, height [m], approach [m], force [N], area [m^2], radius [m] (of the
    circle of equal area), semi_major, semi_minor [m], angle [rad] (of the long axis, from x
    towards y), mean_pressure [Pa], peak (row in the segmentation).
    """
    active = np.flatnonzero(state.force > 0)
    profiles = bodies.profiles
    major, minor = _semi_axes(bodies, state)
    area = state.area[active]
    return structured(
        {
            "x": profiles.x[active],
            "y": profiles.y[active],
            "height": bodies.population.height[active],
            "approach": state.approach[active],
            "force": state.force[active],
            "area": area,
            "radius": np.sqrt(area / np.pi),
            "semi_major": major[active],
            "semi_minor": minor[active],
            "angle": profiles.angle[active],
            "mean_pressure": state.force[active] / area,
            "peak": active,
        }
    )


def contact_map(bodies: Asperities, state: PopulationState) -> NDArray[np.bool_]:
    """Pixels in contact, shape (ny, nx): an ellipse for each contact, clipped to its basin."""
    hm, profiles = bodies.hm, bodies.profiles
    major, minor = _semi_axes(bodies, state)
    labels = bodies.peaks.labels
    rows, cols = np.nonzero(labels >= 0)
    peak = labels[rows, cols]
    loaded = state.force[peak] > 0
    rows, cols, peak = rows[loaded], cols[loaded], peak[loaded]
    dx, dy = hm.x[cols] - profiles.x[peak], hm.y[rows] - profiles.y[peak]
    if hm.periodic:
        dx -= hm.size[1] * np.round(dx / hm.size[1])
        dy -= hm.size[0] * np.round(dy / hm.size[0])
    c, s = np.cos(profiles.angle[peak]), np.sin(profiles.angle[peak])
    inside = ((c * dx + s * dy) / major[peak]) ** 2 + ((c * dy - s * dx) / minor[peak]) ** 2 <= 1.0
    touching = np.zeros(hm.shape, dtype=bool)
    touching[rows[inside], cols[inside]] = True
    return touching


def _semi_axes(
    bodies: Asperities, state: PopulationState
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Semi-axes [m] of the ellipse of each contact's area and its summit's direction."""
    steep, shallow = bodies.profiles.curvature.T
    aspect = np.clip(shallow / steep, 1e-3, 1.0) ** ASPECT_EXPONENT
    scale = np.sqrt(np.maximum(state.area, np.finfo(float).tiny) / np.pi)
    return scale / np.sqrt(aspect), scale * np.sqrt(aspect)
