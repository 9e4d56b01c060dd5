"""Table of the microcontacts of one load point, their outlines, and the distribution of sizes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import InputError
from asperity.halfspace.transforms import edge_weights, kappa
from asperity.microcontact.hertz import axis_ratios
from asperity.results.storage import structured
from surfaces.arrays import Array
from surfaces.errors import as_count, as_numbers

if TYPE_CHECKING:
    from asperity.model.decomposition import Decomposition
    from asperity.model.load_point import LoadPoint
    from surfaces.peaks.profiles import Profiles

__all__ = ["DIRECTIONS", "microcontacts", "outlines", "size_distribution"]


DIRECTIONS = 16
"""Directions of an outline, equispaced from the x axis towards y."""

_ROUNDS = 6
"""Iterations that scale an outline, held to its basin, to its area."""


def microcontacts(decomposition: Decomposition, point: LoadPoint) -> NDArray[np.void]:
    """Table of the contacts that carry load.

    Returns
    -------
    Structured array with x, y, height [m], approach [m], force [N], area [m^2], radius [m] (of the
    circle of equal area), semi_major, semi_minor [m], angle [rad] (of the long axis, from x
    towards y), mean_pressure [Pa], peak_pressure [Pa] (of the elliptic contact, (3 + m)/2 times
    the mean, the hardness at most), peak (row in the segmentation), centre_x, centre_y [m] (of the
    contact, as its law gives it), flags (bits of `asperity.microcontact.Flag`), estimate (relative
    error of the force that the law expects of itself), filled (share of the directions in which the
    contact fills its basin), radii_0 to radii_15 [m] (about the summit along 16 equispaced
    directions from x towards y, see `outlines`), closed_area [m^2] (what touches within the
    contact; less than its area where the finest waves act as a law of the contacts of the others,
    `asperity.multiscale`).
    """
    state, body = point.state, decomposition.material
    active = np.flatnonzero(state.force > 0)
    profiles, (y, x) = decomposition.summits, decomposition.places
    area, approach = state.area[active], state.approach[active]
    radius = np.sqrt(area / np.pi)
    aspect = axis_ratios(decomposition.curvature[active], body.m)
    table, depth = decomposition.population.table, np.maximum(approach, 0.0)
    offset_x, offset_y = table.centre_at(active, depth)
    sampled = profiles.rows(active)
    radii, filled = outlines(sampled, depth, area, decomposition.aspect[active], body.m)
    return structured(
        {
            "x": _within(decomposition, x[active], 1),
            "y": _within(decomposition, y[active], 0),
            "height": decomposition.population.height[active],
            "approach": approach,
            "force": state.force[active],
            "area": area,
            "radius": radius,
            "semi_major": radius / np.sqrt(aspect),
            "semi_minor": radius * np.sqrt(aspect),
            "angle": decomposition.angle[active],
            "mean_pressure": state.force[active] / area,
            "peak_pressure": np.minimum(
                0.5 * (3.0 + body.m) * state.force[active] / area, body.hardness
            ),
            "peak": active,
            "centre_x": _within(decomposition, x[active] + offset_x, 1),
            "centre_y": _within(decomposition, y[active] + offset_y, 0),
            "flags": table.flags_at(active, depth),
            "estimate": np.abs(table.spread_at(active, depth)),
            "filled": filled,
            "radii": radii,
            "closed_area": point.closed_area[active],
        }
    )


def _within(decomposition: Decomposition, place: Array, axis: int) -> Array:
    """Places [m] along an axis; where the map repeats, those in it of its summits and centres
    beyond the border."""
    return np.mod(place, decomposition.hm.size[axis]) if decomposition.wraps else place


def outlines(
    profiles: Profiles, approach: Array, area: Array, aspect: Array, m: float
) -> tuple[Array, Array]:
    """Radii [m] of contacts about their summits, shape (n, DIRECTIONS), and the share of their rays
    that fill the basin, (n,).

    `approach` [m], contact `area` [m^2] and `aspect`, short over long axis of the ellipse on each
    summit, have the shape (n,).

    Notes
    -----
    Every ray ends where its own edge operator (docs/development/laws.md, n = 0) reaches the
    approach. This radius over that of the summit's paraboloid is the factor by which the outline
    deviates from the ellipse; it is scaled to the area and held to the basin. Against `indent`
    on summits of self-affine maps the radii err by 2 to 10 % (rms; the ellipses by 7 to 20 %), on
    maps four times longer than wide by 6 to 14 % (ellipses 10 to 17 %).
    """
    span = profiles.phi - profiles.angle[:, None]
    ellipse = _ellipse(span, area, aspect)
    steep, shallow = profiles.curvature.T[:, :, None]
    curvature = (steep * np.sin(span) ** 2 + shallow * np.cos(span) ** 2) / 2
    free = np.sqrt(approach[:, None] / (curvature * float(kappa(m, 2.0))))
    weights = edge_weights(m, profiles.t.size, 0)
    share = np.linspace(0.0, 1.0, len(weights))
    root = np.sqrt(np.maximum.accumulate(np.maximum(profiles.q @ weights.T * share**2, 0), axis=2))
    reached = _crossing(root, np.sqrt(approach)[:, None] / profiles.edge) * profiles.edge
    shape = ellipse * reached / free
    scale = np.ones(len(area))
    for _ in range(_ROUNDS):
        radii = np.minimum(shape * scale[:, None], profiles.edge)
        enclosed = np.sum(profiles.weight * radii**2, axis=1) / 2
        scale *= np.sqrt(area / enclosed)
    filled = np.sum(profiles.weight * (radii >= profiles.edge), axis=1) / (2 * np.pi)
    turn = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    out = _ellipse(turn - profiles.angle[:, None], area, aspect)
    for row, phi, ratio in zip(out, profiles.phi, radii / ellipse, strict=True):
        row *= np.interp(turn, phi, ratio, period=2 * np.pi)
    return out, filled


def _ellipse(span: Array, area: Array, aspect: Array) -> Array:
    """Radii of the ellipses of an area at the angles `span` from their long axes."""
    flat = aspect[:, None]
    square = flat * np.cos(span) ** 2 + np.sin(span) ** 2 / flat
    return np.asarray(np.sqrt(area[:, None] / np.pi / square))


def _crossing(rising: Array, level: Array) -> Array:
    """Share of the last axis at which `rising` reaches the level, 1 if it does not."""
    last = rising.shape[2] - 1
    above = np.clip(np.sum(rising < level[..., None], axis=2), 1, last)[..., None]
    high = np.take_along_axis(rising, above, axis=2)[..., 0]
    low = np.take_along_axis(rising, above - 1, axis=2)[..., 0]
    beyond = np.array(level > low, dtype=float)
    between = np.divide(level - low, high - low, out=beyond, where=high > low).clip(0.0, 1.0)
    return np.asarray((above[..., 0] - 1 + between) / last)


def size_distribution(area: ArrayLike, *, bins: int = 20) -> NDArray[np.void]:
    """Histogram of contact areas in logarithmic bins.

    Parameters
    ----------
    area
        Contact areas [m^2], shape (n,), positive: the column ``area`` of the table of
        microcontacts, or the spots of a boundary-element solution.
    bins
        Number of bins between the smallest and the largest area, at least 1.

    Returns
    -------
    Structured array, one row per bin: lower, upper [m^2], contacts [-], and area_share [-], the
    share of these contacts in the whole contact area. No row without contacts.

    Raises
    ------
    InputError
        If an area is not positive and finite, or `bins` no whole number above 0.

    Examples
    --------
    >>> import asperity
    >>> sizes = asperity.size_distribution([1.0, 2.0, 4.0, 4.0], bins=2)
    >>> int(sizes["contacts"].sum())
    4
    """
    sizes, rows = as_numbers("the column of areas", area).ravel(), as_count("bins", bins, 1)
    if not (sizes > 0).all():
        raise InputError('contact areas must be positive: give the column table["area"]')
    edges = np.ones(1)
    if sizes.size:
        edges = np.geomspace(sizes.min() * (1 - 1e-9), sizes.max() * (1 + 1e-9), rows + 1)
    return structured(
        {
            "lower": edges[:-1],
            "upper": edges[1:],
            "contacts": np.histogram(sizes, edges)[0],
            "area_share": np.histogram(sizes, edges, weights=sizes / sizes.sum())[0],
        }
    )
