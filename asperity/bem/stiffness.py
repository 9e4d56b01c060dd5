"""How a contact answers as its load begins to change: the slope of the curve, and of unloading."""

from __future__ import annotations

import math

import numpy as np

from .certificate import Reading
from .correction import NestedGrid

__all__ = ["contact_stiffness"]

STIFFNESS_RESIDUAL = 0.02
"""Preconditioned residual at which the solve ends: the stiffness is off by about its square, and by
up to 1 % on bodies of m < -0.3, for which the preconditioner is less exact."""

MAX_GRADIENT_STEPS = 60
"""Conjugate-gradient steps."""


def contact_stiffness(grid: NestedGrid, reading: Reading, *, unloading: bool = False) -> float:
    """Slope of the mean of p~ over the level of the contact [-], the contact as it is.

    Points of the edge come and go without a pressure, so that this is the slope of the curve:
    points in contact keep together, and their pressures change by q with (G q) = 1 on them. Where
    nothing touches it is zero; a periodic cell that touches all over has no gap left, and no finite
    stiffness. What has reached the hardness keeps its pressure as the load grows, and yields no
    more as the load begins to fall: `unloading` counts it in.

    Notes
    -----
    Preconditioned conjugate gradients minimize ``<q, G q>/2 - <q, 1>``, whose least value is half
    the stiffness.
    """
    pressed, held, _ = grid.select(reading, -math.inf)
    points = pressed if unloading or not reading.held else pressed.where(held < grid.cap)
    if len(points) == 0:
        return 0.0
    if len(points) == grid.heights.size and grid.exact.boundary == "periodic":
        return math.inf
    operator = grid.operator(points)
    q, residual = np.zeros(len(points)), np.ones(len(points), np.float32)
    ahead = filtered = operator.precondition(residual)
    first = size = float(np.dot(residual, filtered))
    for _ in range(MAX_GRADIENT_STEPS):
        if not size > STIFFNESS_RESIDUAL**2 * first:
            break
        answer = operator.apply(ahead)
        bend = float(np.dot(ahead, answer))
        if not bend > 0.0:  # rounding: nothing is left to gain
            break
        step = np.float32(size / bend)
        q += step * ahead
        residual = residual - step * answer
        filtered = operator.precondition(residual)
        size, before = float(np.dot(residual, filtered)), size
        ahead = filtered + np.float32(size / before) * ahead
    return float(q.sum()) / grid.heights.size
