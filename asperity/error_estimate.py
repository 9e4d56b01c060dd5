"""How far the microcontact model can be trusted at a load point, without boundary elements.

The estimate is a sum of terms, each of which grows with one known weakness of the model; their
weights are quantiles fitted on synthetic surfaces of several families (``benchmarks/accuracy.py``,
``benchmarks/calibrate_estimate.py``) and checked on others: see ``docs/accuracy.md``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .microcontact.flags import Flag
from .pixel_waves import fineness

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
    "extrapolated",
    "scatter",
    "fineness",
    "fine_crowding",
)
"""Names of the terms, see `terms`."""

LOAD_WEIGHTS = (0.0258, 0.0811, 0.7111, 0.0, 0.0542, 0.0, 0.0, 0.089, 0.227, 0.5864)
"""Weights of the terms for the load at equal separation."""

AREA_WEIGHTS = (0.1656, 0.0197, 0.2648, 0.0, 0.0, 0.0001, 0.065, 0.0415, 0.0, 2.1687)
"""Weights of the terms for the contact area at equal load."""


def terms(bodies: Asperities, state: PopulationState) -> dict[str, float]:
    """Weaknesses of the model at one load point, each from 0 (none) upwards.

    Returns
    -------
    few_contacts
        Root of the sum of squared load shares, one over the root of the effective number of
        contacts: errors of single contacts do not average out.
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
    extrapolated
        Share of the load on contacts that have outgrown the expansion of their law.
    scatter
        `few_contacts`, of those contacts alone.
    fineness
        Share of the squared slope that is lost when heights are taken two pixels apart, not one
        (`pixel_waves.fineness`).
    fine_crowding
        `fineness` times the root of `crowding`.
    """
    closed = np.flatnonzero(state.force > 0)
    if not closed.size:
        return dict.fromkeys(TERMS, 0.0)
    share = state.force[closed] / state.force.sum()
    table, depth = bodies.population.table, state.approach[closed]
    outgrown = (table.flags_at(closed, depth) & Flag.BEYOND_RADIUS) > 0
    # with fine waves taken out, the contacts are those of the map that was solved
    hm = (bodies.plan.resampled if bodies.plan.fine else None) or bodies.hm
    pixel = hm.area / hm.heights.size
    steep, shallow = bodies.profiles.curvature[closed].T
    ratio = np.log(steep / np.clip(shallow, 1e-3 * steep, None))
    crowding, fine = state.contact_area / bodies.hm.area, fineness(hm)
    return {
        "few_contacts": float(np.sqrt(share @ share)),
        "filled_share": state.filled_share,
        "law_spread": float(share @ np.abs(table.spread_at(closed, depth))),
        "coarse_contacts": float(np.sqrt(pixel / (share @ state.area[closed]))),
        "crowding": crowding,
        "elongation": float(share @ ratio),
        "extrapolated": float(share[outgrown].sum()),
        "scatter": float(np.sqrt(share[outgrown] @ share[outgrown])),
        "fineness": fine,
        "fine_crowding": fine * float(np.sqrt(crowding)),
    }


def estimate(values: dict[str, float], weights: tuple[float, ...]) -> float:
    """Weighted sum of the terms: the bound that nine errors in ten keep."""
    return float(sum(w * values[name] for name, w in zip(TERMS, weights, strict=True)))
