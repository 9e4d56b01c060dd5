"""Contacts that no law describes: on flat tops and ridges, and cut by the border of a punch.

A law presses a summit that falls away on all sides. Where the highest points of a basin have one
height, contact begins on all of them; where the border cuts a contact, there is no other side.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asperity.microcontact.basin_bem.press import SPREAD

if TYPE_CHECKING:
    from asperity.interaction.population import PopulationState
    from asperity.model.decomposition import Decomposition

__all__ = ["OUTSIDE_MODEL", "outside_model_terms"]

OUTSIDE_MODEL = "flat_tops", "at_border", "unsure", "unresolved"
"""Names of the terms; their weights are those of `parameters.ErrorEstimate`."""


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
    if flat > 0.0:
        summits = decomposition.summits
        alone = (summits.dip[closed] > summits.peaks.min_prominence) & (spread == SPREAD)
        alone &= spans < bounds.wide_top * decomposition.hm.area
        flat *= 1.0 - bounds.pressed * float(tops @ alone / tops.sum())
    cut = 0.0
    if decomposition.plan.boundary == "free":
        places = decomposition.summits.y[closed], decomposition.summits.x[closed]
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
    return {
        "flat_tops": float(flat),
        "at_border": float(cut**2),
        "unsure": float(unsure**2),
        "unresolved": float(unresolved),
    }
