"""Table of the microcontacts of one load point, and their ellipses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.elongation import ASPECT_EXPONENT
from asperity.interaction.population import PopulationState
from asperity.results.tables import structured

from .outlines import outlines

if TYPE_CHECKING:
    from asperity.model.decomposition import Asperities
    from surfaces.heightmap import HeightMap

__all__ = [
    "aspect_ratio",
    "ellipses",
    "microcontacts",
    "summit_pixel",
]


def microcontacts(bodies: Asperities, state: PopulationState) -> NDArray[np.void]:
    """Table of the contacts that carry load.

    Parameters
    ----------
    bodies
        The decomposed surface.
    state
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
    active = np.flatnonzero(state.force > 0)
    profiles = bodies.profiles
    major, minor = _semi_axes(bodies, state)
    area, approach = state.area[active], state.approach[active]
    table, depth = bodies.population.table, np.maximum(approach, 0.0)
    offset_x, offset_y = table.centre_at(active, depth)
    sampled = profiles.rows(active)
    radii, filled = outlines(sampled, depth, area, bodies.aspect[active], bodies.material.m)
    return structured(
        {
            "x": _within(bodies, profiles.x[active], 1),
            "y": _within(bodies, profiles.y[active], 0),
            "height": bodies.population.height[active],
            "approach": approach,
            "force": state.force[active],
            "area": area,
            "radius": np.sqrt(area / np.pi),
            "semi_major": major[active],
            "semi_minor": minor[active],
            "angle": profiles.angle[active],
            "mean_pressure": state.force[active] / area,
            "peak_pressure": 0.5 * (3.0 + bodies.material.m) * state.force[active] / area,
            "peak": active,
            "centre_x": _within(bodies, profiles.x[active] + offset_x, 1),
            "centre_y": _within(bodies, profiles.y[active] + offset_y, 0),
            "flags": table.flags_at(active, depth),
            "estimate": np.abs(table.spread_at(active, depth)),
            "filled": filled,
            "radii": radii,
            "closed_area": bodies.closed_area(state)[active],
        }
    )


def ellipses(
    bodies: Asperities, state: PopulationState
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Pixels of the solved grid under elliptic contacts, clipped to their basins.

    Returns
    -------
    pixel, own, distance
        Flat index of each pixel, whose contact it is, and its distance from the summit over the
        ellipse's radius there, < 1. A contact that covers no pixel's centre has that of its summit.
    """
    hm, profiles = bodies.solved, bodies.profiles
    major, minor = _semi_axes(bodies, state)
    labels = bodies.peaks.labels
    peak = np.where(labels >= 0, profiles.owner[labels], 0)
    rows, cols = np.nonzero((labels >= 0) & (state.force[peak] > 0))
    own = peak[rows, cols]
    dy, dx = _offset(bodies, hm.y[rows] - profiles.y[own], hm.x[cols] - profiles.x[own])
    distance = _scaled_distance(dy, dx, profiles.angle[own], major[own], minor[own])
    inside = distance < 1.0
    pixel, own, distance = (rows * hm.shape[1] + cols)[inside], own[inside], distance[inside]
    lost = np.setdiff1d(np.flatnonzero(state.force > 0), own)
    return (
        np.append(pixel, summit_pixel(bodies, lost, hm)),
        np.append(own, lost),
        np.append(distance, np.zeros(len(lost))),
    )


def summit_pixel(bodies: Asperities, peak: NDArray[np.int64], hm: HeightMap) -> NDArray[np.int64]:
    """Flat index of the pixel of a map in which a summit lies."""
    places = bodies.profiles.y[peak], bodies.profiles.x[peak]
    row, col = (
        np.clip(place / step, 0, count - 1).astype(np.int64)
        for place, step, count in zip(places, hm.spacing, hm.shape, strict=True)
    )
    return np.asarray(row * hm.shape[1] + col)


def aspect_ratio(curvature: NDArray[np.float64]) -> NDArray[np.float64]:
    """Short over long axis of the contacts on summits of the curvatures (n, 2) [1/m]."""
    steep, shallow = curvature.T
    return np.asarray(np.clip(shallow / steep, 1e-3, 1.0) ** ASPECT_EXPONENT)


def _offset(
    bodies: Asperities, dy: NDArray[np.float64], dx: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The shortest of the offsets [m] that a map without a border allows."""
    if not _repeats(bodies):
        return dy, dx
    ly, lx = bodies.hm.size
    return dy - ly * np.round(dy / ly), dx - lx * np.round(dx / lx)


def _within(bodies: Asperities, place: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    """Places [m] along an axis; where the map repeats, those in it of its summits and centres
    beyond the border."""
    return np.mod(place, bodies.hm.size[axis]) if _repeats(bodies) else place


def _repeats(bodies: Asperities) -> bool:
    return bodies.hm.periodic and bodies.plan.boundary == "periodic"


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
    bodies: Asperities, state: PopulationState
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Semi-axes [m] of the ellipse of each contact's area and its summit's direction."""
    scale = np.sqrt(np.maximum(state.area, np.finfo(float).tiny) / np.pi)
    return scale / np.sqrt(bodies.aspect), scale * np.sqrt(bodies.aspect)
