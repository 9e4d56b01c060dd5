"""How far the microcontact model can be trusted at a load point, without boundary elements.

The estimate is a sum of terms, each of which grows with one known limit of the model; their
weights are quantiles fitted on synthetic surfaces of several families (``benchmarks/accuracy.py``,
``benchmarks/calibrate_estimate.py``) and checked on others: see ``docs/development/fits.md``.
Contacts that no law describes, which those surfaces hardly have, add terms of their own
(`asperity.trust.outside_model`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asperity.halfspace.flags import Flag
from asperity.parameters import DEFAULTS
from asperity.parameters.constants import ErrorEstimate

from .outside_model import OUTSIDE_MODEL

if TYPE_CHECKING:
    from asperity.interaction.population import PopulationState
    from asperity.model.decomposition import Decomposition
    from surfaces.heightmap import HeightMap

__all__ = [
    "CALIBRATED",
    "TERMS",
    "estimate",
    "nonrandomness",
    "terms",
]

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
    hm = (decomposition.plan.resampled if law else None) or decomposition.hm
    pixel = hm.area / hm.heights.size
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
