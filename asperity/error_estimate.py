"""How far the microcontact model can be trusted at a load point, without boundary elements.

The estimate is a sum of terms, each of which grows with one known weakness of the model; their
weights are quantiles fitted on synthetic surfaces of several families (``benchmarks/accuracy.py``,
``benchmarks/calibrate_estimate.py``) and checked on others: see ``docs/accuracy.md``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .curve import Asperities
    from .population import PopulationState

__all__ = ["AREA_WEIGHTS", "LOAD_WEIGHTS", "TERMS", "estimate", "terms"]

TERMS = (
    "few_contacts",
    "filled_share",
    "law_spread",
    "coarse_contacts",
    "crowding",
    "elongation",
)
"""Names of the terms, see `terms`."""

LOAD_WEIGHTS = (0.0, 0.368, 0.424, 0.0, 0.0915, 0.007)
"""Weights of the terms for the load at equal separation."""

AREA_WEIGHTS = (0.266, 0.0, 0.243, 0.0103, 0.0, 0.0086)
"""Weights of the terms for the contact area at equal load."""


def terms(bodies: Asperities, state: PopulationState) -> dict[str, float]:
    """Weaknesses of the model at one load point, each from 0 (none) upwards.

    Returns
    -------
    few_contacts
        One over the root of the number of contacts: errors of single contacts do not average out.
    filled_share
        Share of the load on contacts that have filled their basin.
    law_spread
        Difference between the orders of the contact law, weighted by load.
    coarse_contacts
        One over the root of the number of pixels in the load-weighted mean contact: summits that
        the grid does not resolve.
    crowding
        Contact area over nominal area.
    elongation
        Logarithm of the ratio of a summit's curvatures, weighted by load.
    """
    closed = np.flatnonzero(state.force > 0)
    if not closed.size:
        return dict.fromkeys(TERMS, 0.0)
    force = state.force[closed]
    spread = bodies.population.table.spread_at(closed, state.approach[closed])
    pixel = bodies.hm.area / bodies.hm.heights.size
    steep, shallow = bodies.profiles.curvature[closed].T
    ratio = np.log(steep / np.clip(shallow, 1e-3 * steep, None))
    mean_area = float(force @ state.area[closed] / force.sum())
    return {
        "few_contacts": 1.0 / np.sqrt(closed.size),
        "filled_share": state.filled_share,
        "law_spread": float(force @ np.abs(spread) / force.sum()),
        "coarse_contacts": float(np.sqrt(pixel / mean_area)),
        "crowding": state.contact_area / bodies.hm.area,
        "elongation": float(force @ ratio / force.sum()),
    }


def estimate(values: dict[str, float], weights: tuple[float, ...]) -> float:
    """Weighted sum of the terms: the bound that nine errors in ten keep."""
    return float(sum(w * values[name] for name, w in zip(TERMS, weights, strict=True)))
