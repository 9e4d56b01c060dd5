"""Error estimate of the microcontact model at a load point, made without boundary elements.

The estimate is a weighted sum of terms, each of which grows with one known limit of the model
(`TERMS`). The weights are quantiles fitted on synthetic surfaces of several families
(``benchmarks/accuracy.py``, ``benchmarks/calibrate_estimate.py``) and checked on others: see
``docs/development/fits.md``.

Those surfaces have hardly any contacts outside the model: flat tops, ridges of one height, contacts
cut by the border. These add terms of their own (`OUTSIDE_MODEL`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from asperity.errors import Flag
from asperity.microcontact.basin_bem.press import EXPECTED_ERROR
from asperity.model.decomposition import Decomposition
from asperity.model.load_point import LoadPoint
from asperity.parameters import ErrorEstimate
from surfaces.arrays import Array
from surfaces.heightmap import HeightMap

__all__ = ["CALIBRATED", "OUTSIDE_MODEL", "TERMS", "estimate", "nonrandomness", "terms"]


TERMS = (
    "coarse_contacts",
    "scatter",
    "odd_spread",
    "few_taken_out",
    "coarse_taken_out",
    "few_elongated",
    "crowding",
    "long_crowding",
    "few_crowded",
)
"""Names of the terms of limits of the model, in the order of the weights in
`parameters.ErrorEstimate`."""

CALIBRATED = "auto", "ellipse"
"""Laws for which the weights were fitted; with others the area is up to three times too large."""


OUTSIDE_MODEL = "flat_tops", "at_border", "unsure", "unresolved", "overlap", "overshoot"
"""Names of the terms of contacts outside the model or not resolved by the map, and of their
weights in `parameters.ErrorEstimate`."""


def terms(decomposition: Decomposition, point: LoadPoint, nonrandom: float) -> dict[str, float]:
    """Terms of the error estimate at a load point, zero or more; `nonrandom` is `nonrandomness`.

    With the load shares w_i of the contacts, sum w_i = 1, two measures occur in several terms:
    few = sqrt(sum w_i^2), one over the square root of the effective number of contacts, and
    long = sum w_i ln(k1_i/k2_i), the mean logarithm of the ratio of the summits' curvatures.

    Returns
    -------
    coarse_contacts
        One over sqrt(number of pixels in the load-weighted mean contact): summits that the grid
        does not resolve.
    scatter
        sqrt(sum w_i^2) over the contacts that have outgrown the expansion of their law: the errors
        of few such contacts do not average out.
    odd_spread
        Nonrandomness times the mean expected error of the laws (`LawTable.spread`), weighted by
        load.
    few_taken_out, coarse_taken_out
        Share of the squared slope in the waves of the sub-contact law, times few, and times
        `coarse_contacts`.
    few_elongated
        few times long.
    crowding
        Contact area over nominal area.
    long_crowding
        long times `crowding`.
    few_crowded
        few times sqrt(`crowding`): few hills whose basins fill.
    flat_tops
        Share of the load on flat tops and ridges: that of each contact times the part of its area
        that is a flat top. The term is smaller if these tops are pressed alone.
    at_border
        Square of the share of the load on contacts that the border of a finite punch cuts, each by
        the part of its radius that is cut off: a few cut contacts among many do little harm.
    unsure
        Square of the share of the load on contacts whose law expects an error of `unsure_error` or
        more.
    unresolved
        1/n - 1/`resolved_pixels`, zero or more, weighted by load, for contacts of n pixels; pixels
        of the finer of both grids if the map is solved on another one.
    overlap
        `LoadPoint.overlap`: ground beside the contacts, of which no summit tells.
    overshoot
        Height of summits above their highest pixels, over the approach and weighted by load, less
        `usual_overshoot`: the map does not tell where spikes, cliffs and sharp edges end.
    """
    state = point.state
    closed = np.flatnonzero(state.force > 0)
    if not closed.size:
        return dict.fromkeys((*TERMS, *OUTSIDE_MODEL), 0.0)
    share = state.force[closed] / state.force.sum()
    table, depth = decomposition.population.table, state.approach[closed]
    spread = np.abs(table.spread_at(closed, depth))
    outgrown = (table.flags_at(closed, depth) & Flag.BEYOND_RADIUS) > 0
    # with a sub-contact law the contacts are those of the coarser grid
    law = decomposition.plan.sub_contact_law
    hm = decomposition.solved if law else decomposition.hm
    pixel = hm.area / math.prod(hm.shape)
    summits = decomposition.summits
    steep, shallow = summits.curvature[closed].T
    ratio = np.log(steep / np.clip(shallow, 1e-3 * steep, None))
    crowding, long = state.contact_area / decomposition.hm.area, np.sum(share * ratio)
    few = np.sqrt(np.sum(share**2))
    pixels = np.sum(share * state.area[closed]) / pixel
    coarse = 1.0 / np.sqrt(max(pixels, np.finfo(float).tiny))
    taken = 0.0 if law is None else law.ratio / (1.0 + law.ratio)
    bounds = decomposition.plan.parameters.error_estimate
    area = np.maximum(state.area[closed], np.finfo(float).tiny)
    finest = min(np.prod(grid.spacing) for grid in (decomposition.hm, decomposition.solved))
    resolved = np.maximum(area / finest, bounds.fewest_pixels)
    above = (summits.height - summits.peaks.height)[closed] / depth
    found = {
        "coarse_contacts": coarse,
        "scatter": np.sqrt(np.sum(share[outgrown] ** 2)),
        "odd_spread": nonrandom * np.sum(share * spread),
        "few_taken_out": taken * few,
        "coarse_taken_out": taken * coarse,
        "few_elongated": few * long,
        "crowding": crowding,
        "long_crowding": long * crowding,
        "few_crowded": few * np.sqrt(crowding),
        "flat_tops": _on_flat_tops(decomposition, closed, share, area, spread),
        "at_border": _cut_by_border(decomposition, closed, share, area) ** 2,
        "unsure": (share @ (spread >= bounds.unsure_error)) ** 2,
        "unresolved": share @ np.maximum(1.0 / resolved - 1.0 / bounds.resolved_pixels, 0.0),
        "overlap": point.overlap,
        "overshoot": max(share @ np.clip(above, 0.0, 1.0) - bounds.usual_overshoot, 0.0),
    }
    return {name: float(value) for name, value in found.items()}


def _on_flat_tops(
    decomposition: Decomposition, closed: NDArray[np.intp], share: Array, area: Array, spread: Array
) -> float:
    """Share of the load on flat tops, less a part of it if these are pressed alone."""
    bounds, summits = decomposition.plan.parameters.error_estimate, decomposition.summits
    spans = decomposition.top_areas[closed]
    tops = np.minimum(spans, area)
    flat = float(share @ (tops / area))
    if flat > 0.0:
        alone = (summits.dip[closed] > summits.peaks.min_prominence) & (spread == EXPECTED_ERROR)
        alone &= spans < bounds.wide_top * decomposition.hm.area
        flat *= 1.0 - bounds.pressed * float(tops @ alone / tops.sum())
    return flat


def _cut_by_border(
    decomposition: Decomposition, closed: NDArray[np.intp], share: Array, area: Array
) -> float:
    """Share of the load on contacts that the border of a finite punch cuts."""
    if decomposition.plan.boundary != "free":
        return 0.0
    places = (at[closed] for at in decomposition.places)
    sides = [
        np.minimum(at, size - at) - 0.5 * step  # distance to the outermost points of the map
        for at, size, step in zip(
            places, decomposition.hm.size, decomposition.hm.spacing, strict=True
        )
    ]
    inside = np.clip(np.minimum(*sides) / np.sqrt(area / np.pi), 0.0, 1.0)
    return float(share @ (1.0 - inside))


def nonrandomness(hm: HeightMap) -> float:
    """Distance of a map from random waves: ln(K/3)/ln(4/3), between 0 and 1, of the kurtosis K of
    its second differences. K is 3 for random waves, and above 4 for spikes, worn plateaus, steps
    and fading borders."""
    return float(
        np.clip(np.log(np.mean(hm.roughness.kurtosis) / 3.0) / np.log(4.0 / 3.0), 0.0, 1.0)
    )


def estimate(
    values: dict[str, Array],
    weights: tuple[float, ...],
    fitted: ErrorEstimate,
    plastic_share: Array | float = 0.0,
) -> Array:
    """Error estimates of n load points, shape (n,), of which nine in ten are not exceeded: weighted
    sums of the terms.

    That of the area is given its `plastic_share`: the part that bears the hardness is load over
    hardness. Contacts outside the model may bear less than the model tells, and keep their terms.
    """
    slope, least = fitted.yielded
    left = np.clip(slope * (1.0 - np.asarray(plastic_share)), least, 1.0)
    inside = sum(w * values[name] for name, w in zip(TERMS, weights, strict=True))
    outside = sum(getattr(fitted, name) * values.get(name, 0.0) for name in OUTSIDE_MODEL)
    return np.asarray(left * inside + outside)
