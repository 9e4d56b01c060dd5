"""Forecast of run times, by which `solve` chooses the engine."""

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
"""Expected number of anchors."""

MODEL_SECONDS = 0.06, 3e-5
"""Seconds of a curve of the model: constant part, and part per peak that may touch."""

BEM_SECONDS = 0.03, 2.0e-7, 1.3e-7
"""Seconds of boundary elements: constant part; per point of a map of 512 x 512, that of a curve
over the square root of its number of loads; that of one load without a neighbor to start from."""

FREE, YIELDED = 2.0, 1.5
"""Factors on these seconds: without periodicity, where transforms have four times the points; and
with a hardness, where loads take more steps and the unloading stiffness is solved too."""

PARTS, BESIDE = 1.5, 1.2
"""For the engine "sampled": number of parts expected to be solved by boundary elements, over the
number of parts along a side; seconds besides these and the curve of the model (models of the parts,
one load on the whole map)."""

WORTH = 0.75
"""An engine that uses the model is chosen if its forecast is less than this share of that of
boundary elements: on surfaces that the model describes badly the time of both is spent."""

GROWTH = 0.2
"""Seconds per point grow with this power of the number of points over 512 x 512."""


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
    """Whether a few anchors are likely to be enough: on random waves (`repeats_itself`) without a
    sub-contact law."""
    return plan.sub_contact_law is None and repeats_itself(hm)


def cheapest(seconds: dict[str, float]) -> str:
    """The engine to choose by the `forecast` of each."""
    name = min(seconds, key=lambda name: seconds[name])
    return name if seconds[name] < WORTH * seconds["bem"] else "bem"


def _curve(points: float, loads: int, dearer: float) -> float:
    """Seconds of a curve by boundary elements."""
    return BEM_SECONDS[0] + BEM_SECONDS[1] * dearer * _unit(points) * math.sqrt(loads)


def _unit(points: float) -> float:
    """Number of points of a grid, times the cost of a point over that of a grid of 512 x 512."""
    return points * float(max(1.0, points / 512**2) ** GROWTH)
