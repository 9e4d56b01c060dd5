"""Table of the microcontacts of one load point, and their ellipses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.results.tables import structured

from .outlines import outlines

if TYPE_CHECKING:
    from asperity.interaction.population import PopulationState
    from asperity.model.decomposition import Decomposition
    from asperity.model.load_point import LoadPoint

__all__ = [
    "ellipses",
    "microcontacts",
]


def microcontacts(decomposition: Decomposition, point: LoadPoint) -> NDArray[np.void]:
    """Table of the contacts that carry load.

    Parameters
    ----------
    decomposition
        The decomposed surface.
    point
        One load point.

    Returns
    -------
    Structured array with x, y, height [m], approach [m], force [N], area [m^2], radius [m] (of the
    circle of equal area), semi_major, semi_minor [m], angle [rad] (of the long axis, from x
    towards y), mean_pressure [Pa], peak_pressure [Pa] (of the elliptic contact, (3 + m)/2 times
    the mean), peak (row in the segmentation), centre_x, centre_y [m] (of the contact, as its law
    gives it), flags (bits of `asperity.microcontact.Flag`), estimate (relative error of the force
    that the law expects of itself), filled (share of the directions in which the contact fills its
    basin), radii [m] (about the summit along 16 equispaced directions from x towards y, see
    `outlines`), closed_area [m^2] (what touches within the contact; less than its area
    where the finest waves act as a law of the contacts of the others, `asperity.multiscale`).
    """
    state = point.state
    active = np.flatnonzero(state.force > 0)
    profiles = decomposition.summits
    major, minor = _semi_axes(decomposition, state)
    area, approach = state.area[active], state.approach[active]
    table, depth = decomposition.population.table, np.maximum(approach, 0.0)
    offset_x, offset_y = table.centre_at(active, depth)
    sampled = profiles.rows(active)
    radii, filled = outlines(
        sampled, depth, area, decomposition.aspect[active], decomposition.material.m
    )
    return structured(
        {
            "x": _within(decomposition, profiles.x[active], 1),
            "y": _within(decomposition, profiles.y[active], 0),
            "height": decomposition.population.height[active],
            "approach": approach,
            "force": state.force[active],
            "area": area,
            "radius": np.sqrt(area / np.pi),
            "semi_major": major[active],
            "semi_minor": minor[active],
            "angle": profiles.angle[active],
            "mean_pressure": state.force[active] / area,
            "peak_pressure": 0.5 * (3.0 + decomposition.material.m) * state.force[active] / area,
            "peak": active,
            "centre_x": _within(decomposition, profiles.x[active] + offset_x, 1),
            "centre_y": _within(decomposition, profiles.y[active] + offset_y, 0),
            "flags": table.flags_at(active, depth),
            "estimate": np.abs(table.spread_at(active, depth)),
            "filled": filled,
            "radii": radii,
            "closed_area": point.closed_area[active],
        }
    )


def ellipses(
    decomposition: Decomposition, state: PopulationState
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Pixels of the solved grid under elliptic contacts, clipped to their basins.

    Returns
    -------
    pixel, own, distance
        Flat index of each pixel, whose contact it is, and its distance from the summit over the
        ellipse's radius there, < 1. A contact that covers no pixel's centre has that of its summit.
    """
    hm, profiles = decomposition.solved, decomposition.summits
    major, minor = _semi_axes(decomposition, state)
    labels = decomposition.peaks.labels
    peak = np.where(labels >= 0, profiles.owner[labels], 0)
    rows, cols = np.nonzero((labels >= 0) & (state.force[peak] > 0))
    own = peak[rows, cols]
    dy, dx = _offset(decomposition, hm.y[rows] - profiles.y[own], hm.x[cols] - profiles.x[own])
    distance = _scaled_distance(dy, dx, profiles.angle[own], major[own], minor[own])
    inside = distance < 1.0
    pixel, own, distance = (rows * hm.shape[1] + cols)[inside], own[inside], distance[inside]
    lost = np.setdiff1d(np.flatnonzero(state.force > 0), own)
    return (
        np.append(pixel, decomposition.summit_pixels(lost, hm)),
        np.append(own, lost),
        np.append(distance, np.zeros(len(lost))),
    )


def _offset(
    decomposition: Decomposition, dy: NDArray[np.float64], dx: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The shortest of the offsets [m] that a map without a border allows."""
    if not decomposition.wraps:
        return dy, dx
    ly, lx = decomposition.hm.size
    return dy - ly * np.round(dy / ly), dx - lx * np.round(dx / lx)


def _within(
    decomposition: Decomposition, place: NDArray[np.float64], axis: int
) -> NDArray[np.float64]:
    """Places [m] along an axis; where the map repeats, those in it of its summits and centres
    beyond the border."""
    return np.mod(place, decomposition.hm.size[axis]) if decomposition.wraps else place


def _scaled_distance(
    dy: NDArray[np.float64],
    dx: NDArray[np.float64],
    angle: NDArray[np.float64],
    major: NDArray[np.float64],
    minor: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Distance from the centre of an ellipse over the ellipse's radius in that direction."""
    c, s = np.cos(angle), np.sin(angle)
    return np.hypot((c * dx + s * dy) / major, (c * dy - s * dx) / minor)


def _semi_axes(
    decomposition: Decomposition, state: PopulationState
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Semi-axes [m] of the ellipse of each contact's area and its summit's direction."""
    scale = np.sqrt(np.maximum(state.area, np.finfo(float).tiny) / np.pi)
    return scale / np.sqrt(decomposition.aspect), scale * np.sqrt(decomposition.aspect)
