"""Forecast of run times, by which `solve` chooses the engine."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from asperity.model.plan import peaks_above
from asperity.parameters import ENGINE

from .parts import parts_along, statistically_homogeneous

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.halfspace.scene import Boundary
    from asperity.model.plan import Plan
    from surfaces.heightmap import HeightMap

__all__ = ["can_anchor", "cheapest", "forecast"]

RUN_TIMES = ENGINE.run_times


def forecast(
    hm: HeightMap, material: HalfSpace, boundary: Boundary, loads: int, plan: Plan | None = None
) -> dict[str, float]:
    """Seconds of boundary elements at all loads ("bem"), and of the model with a few anchors
    ("anchored") or checked on parts of the map ("sampled"): the least of any plan if None is given.

    Notes
    -----
    Parts are periodic and elastic, whatever the map is.
    """
    points, model, parts = math.prod(hm.shape), RUN_TIMES.model[0], 0.0
    fine = 1.0 + (peaks_above(hm, None) / (RUN_TIMES.fine * points)) ** 2
    dearer = fine * (RUN_TIMES.free if boundary == "free" else 1.0)
    dearer *= RUN_TIMES.yielded if material.hardness < math.inf else 1.0
    if plan is not None:
        solved = plan.solved(hm)
        side = parts_along(hm, solved)
        model += RUN_TIMES.model[1] * peaks_above(solved, plan.above)
        parts = RUN_TIMES.parts * side * _curve(points / side**2, ENGINE.parts.loads, fine)
    each = RUN_TIMES.bem[2] * dearer * _unit(points)
    return {
        "bem": _curve(points, loads, dearer),
        "anchored": model + RUN_TIMES.bem[0] + each * min(RUN_TIMES.anchors, loads),
        "sampled": RUN_TIMES.beside + model + parts,
    }


def can_anchor(hm: HeightMap, plan: Plan) -> bool:
    """Whether a few anchors are likely to be enough: on a map that is `statistically_homogeneous`,
    without a sub-contact law."""
    return plan.sub_contact_law is None and statistically_homogeneous(hm, plan)


def cheapest(seconds: dict[str, float]) -> str:
    """The engine to choose by the `forecast` of each."""
    name = min(seconds, key=lambda name: seconds[name])
    return name if seconds[name] < RUN_TIMES.worth * seconds["bem"] else "bem"


def _curve(points: float, loads: int, dearer: float) -> float:
    """Seconds of a curve by boundary elements."""
    return RUN_TIMES.bem[0] + RUN_TIMES.bem[1] * dearer * _unit(points) * math.sqrt(loads)


def _unit(points: float) -> float:
    """Number of points of a grid, times the cost of a point over that of a grid of 512 x 512."""
    return points * float(max(1.0, points / 512**2) ** RUN_TIMES.growth)
