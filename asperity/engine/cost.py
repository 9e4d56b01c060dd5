"""Forecast of run times, from which the engine is chosen."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from asperity.model.plan import peaks_above
from asperity.parameters import DEFAULTS

from .parts import parts_along, repeats_itself

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.model.plan import Plan
    from surfaces.heightmap import HeightMap

__all__ = ["can_anchor", "cheapest", "forecast"]

ANCHORS = 4
"""Load points that are expected to be anchored."""

MODEL_SECONDS = 0.06, 3e-5
"""Seconds of a curve of the model: in any case, and per peak that may touch."""

BEM_SECONDS = 0.03, 2.0e-7, 1.3e-7
"""Seconds of boundary elements: in any case, and per point of a map of 512 x 512, of a curve, times
the root of the number of its loads, and of one load without a neighbor to start from."""

FREE, YIELDED = 2.0, 1.5
"""Factors of these seconds: on a map that is not periodic, whose transforms have four times its
points, and under a hardness, where loads take more steps and a stiffness of unloading is found."""

PARTS, BESIDE = 1.5, 1.2
"""Parts expected to be solved by boundary elements over those along a side, and seconds beside
these and a curve of the model (models of parts, a load on the whole map), where parts tell of it.
"""

WORTH = 0.75
"""Time of an engine that uses the model, over that of boundary elements, from which on it is not
worth a try: on surfaces that the model describes badly both are spent."""

GROWTH = 0.2
"""Power of the number of points over 512 x 512 with which the seconds per point grow."""


def forecast(hm: HeightMap, material: HalfSpace, plan: Plan, loads: int) -> dict[str, float]:
    """Seconds of boundary elements at all loads ("bem"), and of the model with a few anchors
    ("anchored") or checked on parts of the map ("sampled").

    Notes
    -----
    Measured on two cores (docs/development/verification.md); only the ratios decide. Parts are
    periodic and elastic, whatever the map is.
    """
    points, side = math.prod(hm.shape), parts_along(hm, plan.solved(hm))
    peaks = peaks_above(plan.solved(hm), plan.above)
    model = MODEL_SECONDS[0] + MODEL_SECONDS[1] * peaks
    dearer = FREE if plan.boundary == "free" else 1.0
    dearer *= YIELDED if material.hardness < math.inf else 1.0
    each = BEM_SECONDS[2] * dearer * _unit(points)
    part = _curve(points / side**2, DEFAULTS.parts.loads, 1.0)
    return {
        "bem": _curve(points, loads, dearer),
        "anchored": model + BEM_SECONDS[0] + each * min(ANCHORS, loads),
        "sampled": BESIDE + model + PARTS * side * part,
    }


def can_anchor(hm: HeightMap, plan: Plan) -> bool:
    """Whether a few anchors are likely to do: on a map that repeats itself, none of whose waves act
    as a law of the contacts of the others."""
    return plan.sub_contact_law is None and repeats_itself(hm)


def cheapest(seconds: dict[str, float]) -> str:
    """The engine to take by such a forecast."""
    name = min(seconds, key=lambda name: seconds[name])
    return name if seconds[name] < WORTH * seconds["bem"] else "bem"


def _curve(points: float, loads: int, dearer: float) -> float:
    """Seconds of a curve by boundary elements."""
    return BEM_SECONDS[0] + BEM_SECONDS[1] * dearer * _unit(points) * math.sqrt(loads)


def _unit(points: float) -> float:
    """Points of a grid, each weighted by what it costs over those of 512 x 512."""
    return points * float(max(1.0, points / 512**2) ** GROWTH)
