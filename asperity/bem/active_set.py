"""Inexact primal-dual active set: the contact problem on a list of points."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["ListOperator", "solve_on_list"]

DROP = 0.3
NEGATIVE_SHARE = 0.02
LONGEST_RUN = 12


class ListOperator(Protocol):
    """Operator and preconditioner on the points of a list."""

    def apply(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Displacement at the points of a pressure on them."""

    def precondition(self, residual: NDArray[np.float64]) -> NDArray[np.float64]:
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
) -> tuple[NDArray[np.float64], int]:
    """Pressure that closes the gap on its contact, and iterations spent.

    Parameters
    ----------
    operator
        Bound to the list.
    pressure
        Start p~ [m], shape (n,); negative values are repaired.
    gap
        u - h at `pressure` [m], from the exact operator, shape (n,).
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
    then negative pressures are cut, the load is restored, and A is formed anew.
    """
    base, start_gap = pressure, gap
    pressure, moved = _feasible(pressure, total)
    change = operator.apply(pressure - base) if moved else np.zeros_like(gap)
    pressure = pressure.copy()
    iterations = 0
    while True:
        gap = start_gap + change
        error, level = list_error(pressure, gap, scale)
        if error <= tolerance or iterations >= longest:
            return pressure, iterations
        active = (pressure > 0.0) | (gap < level)
        steps = _conjugate_gradients(operator, active, pressure, gap, change, level)
        if steps == 0:
            return pressure, iterations
        iterations += steps
        pressure, moved = _feasible(pressure, total)
        if moved:
            change = operator.apply(pressure - base)


def list_error(
    pressure: NDArray[np.float64], gap: NDArray[np.float64], scale: float
) -> tuple[float, float]:
    """Largest relative error on the list, and the gap level of the contact."""
    level = float(gap[pressure > 0.0].mean())
    lowest = float(gap.min())
    work = float(np.vdot(pressure, gap)) / float(pressure.sum()) - lowest
    return max(work, level - lowest) / scale, level


def _feasible(pressure: NDArray[np.float64], total: float) -> tuple[NDArray[np.float64], bool]:
    """Pressure without negative values and with the prescribed sum; whether it changed."""
    sum_now = float(pressure.sum())
    if not (pressure < 0.0).any() and abs(sum_now / total - 1.0) < 1e-15:
        return pressure, False
    cut = np.maximum(pressure, 0.0)
    cut *= total / cut.sum()
    return cut, True


def _conjugate_gradients(
    operator: ListOperator,
    active: NDArray[np.bool_],
    pressure: NDArray[np.float64],
    gap: NDArray[np.float64],
    change: NDArray[np.float64],
    level: float,
) -> int:
    """Loose solve of gap = level on the active points; changes the three fields in place."""
    count = int(np.count_nonzero(active))
    residual = np.where(active, gap - level, 0.0)
    before = np.zeros_like(residual)
    direction = np.zeros_like(residual)
    norm = start = np.inf
    for step in range(LONGEST_RUN):
        z = np.where(active, operator.precondition(residual), 0.0)
        z[active] -= z.sum() / count
        old, norm = norm, float(np.vdot(z, residual))
        start = norm if step == 0 else start
        if step and norm < DROP**2 * start:
            return step
        slope = max(0.0, (norm - float(np.vdot(z, before))) / old) if step else 0.0
        direction = z + slope * direction
        response = operator.apply(direction)
        restricted = np.where(active, response, 0.0)
        restricted[active] -= restricted.sum() / count
        curvature = float(np.vdot(direction, restricted))
        if not curvature > 0.0:
            return step
        length = float(np.vdot(direction, residual)) / curvature
        pressure -= length * direction
        change -= length * response
        gap -= length * response
        before = residual
        level = float(gap[active].mean())
        residual = np.where(active, gap - level, 0.0)
        if np.count_nonzero(pressure < 0.0) > NEGATIVE_SHARE * count:
            return step + 1
    return LONGEST_RUN
