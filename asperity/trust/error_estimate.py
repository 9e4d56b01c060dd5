"""How far the microcontact model can be trusted at a load point, without boundary elements.

The estimate is a sum of terms, each of which grows with one known limit of the model; their
weights are quantiles fitted on synthetic surfaces of several families (``benchmarks/accuracy.py``,
``benchmarks/calibrate_estimate.py``) and checked on others: see ``docs/development/fits.md``.

Contacts that no law describes, which those surfaces hardly have, add terms of their own
(`outside_model_terms`). A law presses a summit that falls away on all sides. Where the highest
points of a basin have one height, contact begins on all of them; where the border cuts a contact,
there is no other side.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from asperity.errors import Flag
from asperity.interaction.population import PopulationState
from asperity.microcontact.basin_bem.press import EXPECTED_ERROR
from asperity.model.decomposition import Decomposition
from asperity.parameters import DEFAULTS
from asperity.parameters.constants import ErrorEstimate
from surfaces.heightmap import HeightMap

__all__ = [
    "CALIBRATED",
    "OUTSIDE_MODEL",
    "TERMS",
    "estimate",
    "nonrandomness",
    "outside_model_terms",
    "terms",
    "yielded_factor",
]


Array = NDArray[np.float64]

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
"""Names of the terms, see `terms`; their weights are those of `parameters.ErrorEstimate`."""

CALIBRATED = "auto", "ellipse"
"""Laws of which the weights tell; by others, the area is up to three times too large."""


OUTSIDE_MODEL = "flat_tops", "at_border", "unsure", "unresolved", "overshoot"
"""Names of the terms; their weights are those of `parameters.ErrorEstimate`."""


def terms(
    decomposition: Decomposition, state: PopulationState, nonrandom: float
) -> dict[str, float]:
    """Terms of the error estimate at a load point, each from 0; `nonrandom` is `nonrandomness`.

    Returns
    -------
    coarse_contacts
        One over the root of the number of pixels in the load-weighted mean contact: summits that
        the grid does not resolve.
    scatter
        Root of the sum of squared load shares of the contacts that have outgrown the expansion of
        their law: errors of few of them do not average out.
    odd_spread
        Oddness times the difference between the orders of the contact law, weighted by load.
    few_taken_out, coarse_taken_out
        Share of the squared slope in waves that act as a law, times the root of the sum of squared
        load shares of all contacts (one over the root of their effective number) and times
        `coarse_contacts`.
    few_elongated
        Logarithm of the ratio of a summit's curvatures, weighted by load, times that root.
    crowding
        Contact area over nominal area.
    long_crowding
        That logarithm times `crowding`.
    few_crowded
        That root times the root of `crowding`: few hills whose basins fill.
    """
    closed = np.flatnonzero(state.force > 0)
    if not closed.size:
        return dict.fromkeys(TERMS, 0.0)
    share = state.force[closed] / state.force.sum()
    table, depth = decomposition.population.table, state.approach[closed]
    outgrown = (table.flags_at(closed, depth) & Flag.BEYOND_RADIUS) > 0
    # with fine waves taken out, the contacts are those of the map that was solved
    law = decomposition.plan.sub_contact_law
    hm = decomposition.solved if law else decomposition.hm
    pixel = hm.area / math.prod(hm.shape)
    steep, shallow = decomposition.summits.curvature[closed].T
    ratio = np.log(steep / np.clip(shallow, 1e-3 * steep, None))
    crowding, long = state.contact_area / decomposition.hm.area, np.sum(share * ratio)
    few = np.sqrt(np.sum(share**2))
    pixels = np.sum(share * state.area[closed]) / pixel
    coarse = 1.0 / np.sqrt(max(pixels, np.finfo(float).tiny))
    taken = 0.0 if law is None else law.ratio / (1.0 + law.ratio)
    found = (
        coarse,
        np.sqrt(np.sum(share[outgrown] ** 2)),
        nonrandom * np.sum(share * np.abs(table.spread_at(closed, depth))),
        taken * few,
        taken * coarse,
        few * long,
        crowding,
        long * crowding,
        few * np.sqrt(crowding),
    )
    return {name: float(value) for name, value in zip(TERMS, found, strict=True)}


def nonrandomness(hm: HeightMap) -> float:
    """How far a map is from random waves: 0 where the kurtosis of its second differences is 3, 1
    from 4 on, as for spikes, worn plateaus, steps and fading borders."""
    return float(
        np.clip(np.log(np.mean(hm.roughness.kurtosis) / 3.0) / np.log(4.0 / 3.0), 0.0, 1.0)
    )


def estimate(
    values: dict[str, float],
    weights: tuple[float, ...],
    fitted: ErrorEstimate = DEFAULTS.error_estimate,
) -> float:
    """Weighted sum of the terms: the bound that nine errors in ten keep."""
    inside = sum(w * values[name] for name, w in zip(TERMS, weights, strict=True))
    outside = sum(getattr(fitted, name) * values.get(name, 0.0) for name in OUTSIDE_MODEL)
    return float(inside + outside)


def yielded_factor(plastic_share: Array, fitted: ErrorEstimate = DEFAULTS.error_estimate) -> Array:
    """Factor of the area's estimate where this share of the contact area is at the hardness."""
    slope, least = fitted.yielded
    return np.asarray(np.clip(slope * (1.0 - plastic_share), least, 1.0))


def outside_model_terms(decomposition: Decomposition, state: PopulationState) -> dict[str, float]:
    """Load on contacts that no law describes or no grid, at one load point; each term from 0.

    Returns
    -------
    flat_tops
        Share of the load on flat tops and ridges: of each contact as much as the top is of it; less
        the larger the part of these tops that is pressed alone.
    at_border
        Square of the share on contacts that the border of a finite punch cuts, as far as it does:
        a few among many do no harm, all of them leave little to trust.
    unsure
        Square of the share on contacts whose law expects an error of `unsure_error` and more of
        itself.
    unresolved
        One over the number of pixels of the contacts, less that of `resolved_pixels`, weighted by
        load; of the smaller pixels where a map whose waves reach the pixel is solved on those.
    overshoot
        How far summits stand above their highest pixels, over the approach and weighted by load,
        less `usual_overshoot`: the map does not tell where spikes, cliffs and sharp edges end.
    """
    bounds = decomposition.plan.parameters.error_estimate
    closed = np.flatnonzero(state.force > 0)
    if not closed.size:
        return dict.fromkeys(OUTSIDE_MODEL, 0.0)
    share = state.force[closed] / state.force.sum()
    area = np.maximum(state.area[closed], np.finfo(float).tiny)
    spread = np.abs(decomposition.population.table.spread_at(closed, state.approach[closed]))
    spans = decomposition.top_areas[closed]
    tops = np.minimum(spans, area)
    flat = share @ (tops / area)
    summits = decomposition.summits
    if flat > 0.0:
        alone = (summits.dip[closed] > summits.peaks.min_prominence) & (spread == EXPECTED_ERROR)
        alone &= spans < bounds.wide_top * decomposition.hm.area
        flat *= 1.0 - bounds.pressed * float(tops @ alone / tops.sum())
    cut = 0.0
    if decomposition.plan.boundary == "free":
        places = (at[closed] for at in decomposition.places)
        sides = [
            np.minimum(at, size - at) - 0.5 * step  # from the outermost points
            for at, size, step in zip(
                places, decomposition.hm.size, decomposition.hm.spacing, strict=True
            )
        ]
        inside = np.clip(np.minimum(*sides) / np.sqrt(area / np.pi), 0.0, 1.0)
        cut = share @ (1.0 - inside)
    unsure = share @ (spread >= bounds.unsure_error)
    pixels = area / min(np.prod(hm.spacing) for hm in (decomposition.hm, decomposition.solved))
    unresolved = share @ np.maximum(
        1.0 / np.maximum(pixels, bounds.fewest_pixels) - 1.0 / bounds.resolved_pixels, 0.0
    )
    above = (summits.height - summits.peaks.height)[closed] / state.approach[closed]
    return {
        "flat_tops": float(flat),
        "at_border": float(cut**2),
        "unsure": float(unsure**2),
        "unresolved": float(unresolved),
        "overshoot": max(float(share @ np.clip(above, 0.0, 1.0)) - bounds.usual_overshoot, 0.0),
    }
