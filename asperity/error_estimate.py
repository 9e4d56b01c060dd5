"""How far the microcontact model can be trusted at a load point, without boundary elements.

The estimate is a sum of terms, each of which grows with one known weakness of the model; their
weights are quantiles fitted on synthetic surfaces of several families (``benchmarks/accuracy.py``,
``benchmarks/calibrate_estimate.py``) and checked on others: see ``docs/accuracy.md``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .microcontact.flags import Flag
from .scales.pixel_waves import fineness

if TYPE_CHECKING:
    from surfaces.heightmap import HeightMap

    from .asperities import Asperities
    from .population.population import PopulationState

__all__ = ["AREA_WEIGHTS", "LOAD_WEIGHTS", "TERMS", "estimate", "terms"]

TERMS = (
    "few_contacts",
    "coarse_contacts",
    "crowding",
    "scatter",
    "fineness",
    "fine_crowding",
    "odd_spread",
    "odd_scatter",
    "few_taken_out",
    "coarse_taken_out",
    "few_elongated",
    "graded_crowding",
)
"""Names of the terms, see `terms`."""

LOAD_WEIGHTS = (0.0159, 0.0, 0.1589, 0.0765, 0.0, 0.0, 2.3643, 0.0488, 0.0, 0.5428, 0.0, 0.0)
"""Weights of the terms for the load at equal separation."""

AREA_WEIGHTS = (
    *(0.1084, 0.0685, 0.0, 0.0256, 0.0367, 1.4528),
    *(3.36, 0.0919, 0.6165, 0.8916, 0.0216, 0.7126),
)
"""Weights of the terms for the contact area at equal load."""


def terms(bodies: Asperities, state: PopulationState, odd: float) -> dict[str, float]:
    """Weaknesses of the model at one load point, each from 0 (none) upwards; `odd` is `oddness`.

    Returns
    -------
    few_contacts
        Root of the sum of squared load shares, one over the root of the effective number of
        contacts: errors of single contacts do not average out.
    coarse_contacts
        One over the root of the number of pixels in the load-weighted mean contact: summits that
        the grid does not resolve.
    crowding
        Contact area over nominal area.
    scatter
        `few_contacts`, of those contacts alone that have outgrown the expansion of their law.
    fineness
        Share of the squared slope that is lost when heights are taken two pixels apart, not one
        (`pixel_waves.fineness`).
    fine_crowding
        `fineness` times the root of `crowding`.
    odd_spread, odd_scatter
        Oddness times the difference between the orders of the contact law, weighted by load, and
        times `scatter`.
    few_taken_out, coarse_taken_out
        Share of the squared slope in waves that act as a law, times `few_contacts` and times
        `coarse_contacts`.
    few_elongated
        Logarithm of the ratio of a summit's curvatures, weighted by load, times `few_contacts`.
    graded_crowding
        Size of the exponent of the grading times the root of `crowding`.
    """
    closed = np.flatnonzero(state.force > 0)
    if not closed.size:
        return dict.fromkeys(TERMS, 0.0)
    share = state.force[closed] / state.force.sum()
    table, depth = bodies.population.table, state.approach[closed]
    outgrown = (table.flags_at(closed, depth) & Flag.BEYOND_RADIUS) > 0
    # with fine waves taken out, the contacts are those of the map that was solved
    law = bodies.plan.fine
    hm = (bodies.plan.resampled if law else None) or bodies.hm
    pixel = hm.area / hm.heights.size
    steep, shallow = bodies.profiles.curvature[closed].T
    ratio = np.log(steep / np.clip(shallow, 1e-3 * steep, None))
    crowding, fine = state.contact_area / bodies.hm.area, fineness(hm)
    few, coarse = np.sqrt(share @ share), np.sqrt(pixel / (share @ state.area[closed]))
    scatter = np.sqrt(share[outgrown] @ share[outgrown])
    taken = 0.0 if law is None else law.ratio / (1.0 + law.ratio)
    found = (
        few,
        coarse,
        crowding,
        scatter,
        fine,
        fine * np.sqrt(crowding),
        odd * (share @ np.abs(table.spread_at(closed, depth))),
        odd * scatter,
        taken * few,
        taken * coarse,
        few * (share @ ratio),
        abs(bodies.material.m) * np.sqrt(crowding),
    )
    return {name: float(value) for name, value in zip(TERMS, found, strict=True)}


def oddness(hm: HeightMap) -> float:
    """How far a map is from random waves: 0 where the kurtosis of its second differences is 3, 1
    from 4 on, as for spikes, worn plateaus, steps and fading borders."""
    return float(
        np.clip(np.log(np.mean(hm.roughness.kurtosis) / 3.0) / np.log(4.0 / 3.0), 0.0, 1.0)
    )


def estimate(values: dict[str, float], weights: tuple[float, ...]) -> float:
    """Weighted sum of the terms: the bound that nine errors in ten keep."""
    return float(sum(w * values[name] for name, w in zip(TERMS, weights, strict=True)))
