"""Inexact primal-dual active set: the contact problem on a list of points."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from . import _list_kernels

__all__ = ["ListOperator", "solve_on_list"]

DROP = 0.3
NEGATIVE_SHARE = 0.02
LONGEST_RUN = 12


class ListOperator(Protocol):
    """Operator and preconditioner on the points of a list."""

    aim: float

    def apply(self, pressure: NDArray[np.float32]) -> NDArray[np.float32]:
        """Displacement at the points of a pressure on them."""

    def precondition(self, residual: NDArray[np.float32]) -> NDArray[np.float32]:
        """Approximate inverse of the operator."""


def solve_on_list(
    operator: ListOperator,
    pressure: NDArray[np.float64],
    gap: NDArray[np.float64],
    *,
    scale: float,
    tolerance: float,
    longest: int,
    total: float,
) -> int:
    """Change the pressure until it closes the gap on its contact; returns the iterations spent.

    Parameters
    ----------
    operator
        Bound to the list.
    pressure
        Start p~ [m], shape (n,), and the result; negative values are repaired.
    gap
        u - h at the start [m], from the exact operator, shape (n,).
    scale
        Length that the tolerance is relative to [m].
    tolerance
        Error to reach: the larger of complementarity and penetration.
    longest
        Most iterations.
    total
        Prescribed sum of p~ [m], positive.

    Notes
    -----
    Active points are those under pressure or penetrating, A = {p > 0} U {g < 0}. On A the
    linear problem is solved loosely by preconditioned conjugate gradients (p may go negative),
    until the preconditioned residual fell by 0.3, 2 % of A turned negative, or 12 steps are done;
    then negative pressures are cut, the load is restored, and A is formed anew. Only changes of
    the pressure and of the gap are held in single precision.
    """
    n = pressure.size
    base = pressure.copy()
    change, residual, before, direction, moved = (np.zeros(n, np.float32) for _ in range(5))
    now = np.empty(n)
    active = np.empty(n, np.bool_)
    iterations = 0
    while True:
        if _list_kernels.cut(pressure, base, moved, total) > 0.0:
            change = operator.apply(moved)
        level, lowest, work, count = _list_kernels.measure(
            pressure, gap, change, now, active, residual
        )
        if max(work, level) - lowest <= tolerance * scale or iterations >= longest:
            return iterations
        norm = start = 0.0
        for step in range(LONGEST_RUN):
            z = operator.precondition(residual)
            norm = _list_kernels.turn(active, count, z, residual, before, direction, norm)
            if step == 0:
                start = norm
            elif norm < DROP**2 * start:
                break
            response = operator.apply(direction)
            negative = _list_kernels.advance(
                active, count, pressure, now, change, residual, before, direction, response
            )
            if negative < 0:
                if step == 0:
                    return iterations
                break
            iterations += 1
            if negative > NEGATIVE_SHARE * count:
                break
