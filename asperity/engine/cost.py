"""Forecast of run times, from which the engine is chosen."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from asperity.model.plan import Plan
    from surfaces.heightmap import HeightMap

__all__ = ["ANCHORS", "forecast"]

ANCHORS = 4
"""Load points that are expected to be anchored."""

MODEL_SECONDS = 0.1, 1.0e-6
"""Seconds of a curve of the model: in any case, and per point of the grid that is solved."""

BEM_SECONDS = 1.1e-7, 1.0e-7
"""Seconds of boundary elements per point of a map of 512 x 512: of a curve, times the root of the
number of its loads; and of one load without a neighbor to start from."""

GROWTH = 0.3
"""Power of the number of points over 512 x 512 with which the seconds per point grow."""


def forecast(hm: HeightMap, plan: Plan, loads: int) -> tuple[float, float]:
    """Seconds of boundary elements at all loads, and of the model with a few anchors.

    Notes
    -----
    Measured on two cores (docs/development/verification.md); only the ratio decides.
    """
    points = hm.heights.size
    unit = points * max(1.0, points / 512**2) ** GROWTH
    grid = (plan.resampled or hm).heights.size
    model = MODEL_SECONDS[0] + MODEL_SECONDS[1] * grid
    return BEM_SECONDS[0] * unit * loads**0.5, model + BEM_SECONDS[1] * unit * ANCHORS
