"""How a contact answers as its load begins to fall: elastically, with the area that it has."""

from __future__ import annotations

import math

import numpy as np

from . import _grid_kernels
from .active_set import ContactList
from .correction import Level

__all__ = ["unloading_stiffness"]

RESIDUAL = 1e-3
"""Preconditioned residual at which the solve ends: the stiffness is off by its square."""

MAX_STEPS = 60
"""Conjugate-gradient steps."""


def unloading_stiffness(level: Level) -> float:
    """Mean of p~ over the lift of the flat, with the contact that the pressure of a level has.

    What has yielded does so no more as the load begins to fall: points in contact keep together,
    and their pressures fall by q with (G q) = 1 on them. Without a hardness this is the slope of
    the curve, as points of the edge come and go without a pressure. Where nothing touches it is
    zero; a periodic cell that touches all over has no gap left, and no finite stiffness.

    Notes
    -----
    Preconditioned conjugate gradients minimize ``<q, G q>/2 - <q, 1>``, whose least value is half
    the stiffness.
    """
    rows, columns = np.nonzero(level.pressure)
    if rows.size == level.heights.size and level.exact.boundary == "periodic":
        return math.inf
    start = np.searchsorted(rows, np.arange(level.heights.shape[0] + 1))
    points = ContactList(start.astype(np.int64), columns.astype(np.int32))
    held = level.pressure[rows, columns]
    operator = level.operator(len(points))
    operator.bind(points)
    q, residual = np.zeros(len(points)), np.ones(len(points), np.float32)
    ahead = filtered = operator.precondition(residual)
    first = size = float(np.dot(residual, filtered))
    for _ in range(MAX_STEPS):
        if not size > RESIDUAL**2 * first:
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
    _grid_kernels.put(level.exact.pressure, points.start, points.columns, held)
    level.exact.apply()  # the next load starts from pressure and displacement
    return float(q.sum()) / level.heights.size
