"""Forecast of run times, from which the engine is chosen."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .parts import LOADS, parts_along

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.model.plan import Plan
    from surfaces.heightmap import HeightMap

__all__ = ["forecast"]

ANCHORS = 4
"""Load points that are expected to be anchored."""

MODEL_SECONDS = 0.1, 1.0e-6
"""Seconds of a curve of the model: in any case, and per point of the grid that is solved."""

BEM_SECONDS = 1.0e-7, 0.5e-7
"""Seconds of boundary elements per point of a map of 512 x 512: of a curve, times the root of the
number of its loads; and of one load without a neighbor to start from."""

FREE, YIELDED = 2.0, 1.5
"""Factors of these seconds: on a map that is not periodic, whose transforms have four times its
points, and under a hardness, where loads take more steps and a stiffness of unloading is found."""

PARTS = 2.3
"""Parts that are expected to be solved, some of them at few loads, over those along a side."""

GROWTH = 0.4
"""Power of the number of points over 512 x 512 with which the seconds per point grow."""


def forecast(hm: HeightMap, material: HalfSpace, plan: Plan, loads: int) -> dict[str, float]:
    """Seconds of boundary elements at all loads ("bem"), and of the model with a few anchors
    ("anchored") or checked on parts of the map ("sampled").

    Notes
    -----
    Measured on two cores (docs/development/verification.md); only the ratios decide. Parts are
    periodic and elastic, whatever the map is.
    """
    points, side = math.prod(hm.shape), parts_along(hm, plan)
    dearer = FREE if plan.boundary == "free" else 1.0
    dearer *= YIELDED if material.hardness < math.inf else 1.0
    model = MODEL_SECONDS[0] + MODEL_SECONDS[1] * math.prod((plan.resampled or hm).shape)
    return {
        "bem": BEM_SECONDS[0] * dearer * _unit(points) * loads**0.5,
        "anchored": model + BEM_SECONDS[1] * dearer * _unit(points) * ANCHORS,
        "sampled": 2.0 * model
        + BEM_SECONDS[0] * PARTS * side * _unit(points / side**2) * LOADS**0.5,
    }


def _unit(points: float) -> float:
    """Points of a grid, each weighted by what it costs over those of 512 x 512."""
    return points * float(max(1.0, points / 512**2) ** GROWTH)
