"""Projected conjugate gradients: the contact problem on a list of points."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from surfaces.arrays import Array

from . import _list_kernels

if TYPE_CHECKING:
    from .full_grid import FullGridOperator
    from .split import SplitOperator

__all__ = ["SPARE_LOAD", "solve_on_list"]

SPARE_LOAD = 1.05
"""Load that the listed points could bear at the cap, over the prescribed load: lists hold at least
as many points as that takes."""

_MAX_ITERATIONS = 200
"""Most iterations on a list."""

_SHORTEST_STEP = 1e-3
"""Share of a step, or of the cap if the step is longer, below which a shortened step is replaced by
one of steepest descent."""

_ENERGY_NOISE, _LOOSEST_NOISE = 0.1, 1e-3
"""Largest rise of the energy that counts as rounding, over tolerance times load times length scale;
and the largest tolerance in this bound. After a larger rise the iteration could cycle."""

_STUCK = 0.02
"""Share of a step that the bounds leave, below which the next one would be cut too, if the energy
does not fall: a step of steepest descent follows."""


def solve_on_list(
    operator: SplitOperator | FullGridOperator,
    pressure: Array,
    gap: Array,
    *,
    scale: float,
    tolerance: float,
    total: float | None,
    cap: float,
) -> int:
    """Solve the contact problem on a list of points, in place; returns the number of iterations, at
    most `_MAX_ITERATIONS`.

    Parameters
    ----------
    operator
        Bound to the list.
    pressure
        Start p~ [m], shape (n,), and the result; values below 0 or above the cap are repaired.
    gap
        u - h at the start [m], from the exact operator, shape (n,).
    scale, tolerance
        Length [m], and the error to reach over it: the largest of complementarity, penetration and
        lift.
    total
        Prescribed sum of p~ [m], positive; None: the gap in the contact is prescribed to be zero.
    cap
        Largest p~ [m]; n times the cap exceeds the load.

    Notes
    -----
    Projected conjugate gradients (Polonsky & Keer 1999). Active points are all but those held at a
    bound, {p = 0, g >= 0} and {p = cap, g <= 0}. Each iteration

    1. takes a preconditioned conjugate-gradient step on the active points, to the minimum along the
       direction; p may leave its bounds;
    2. cuts the pressures at the bounds, and shifts those between by one value until they bear the
       load: this is the nearest pressure within the bounds that does;
    3. shortens the step if it raised the energy, so that the iteration cannot cycle;
    4. finds the active points anew.

    Directions stay conjugate when the active points change (Polak-Ribiere): with a new start at
    each change they would be those of steepest descent wherever many points change. A step that the
    bounds cut to next to nothing is followed by one of steepest descent that no bound cuts. Else
    few points that bear the load of many would be cut again and again, and their load shared among
    all. Only changes of the pressure and of the gap are in single precision.
    """
    state = _State(operator, pressure, gap, total, cap)
    accepted, wanted = np.empty_like(pressure), np.empty_like(pressure)
    lowest_energy, last_energy, share = math.inf, math.inf, 1.0
    carried = pressure.sum() if total is None else total
    margin = _ENERGY_NOISE * min(tolerance, _LOOSEST_NOISE) * scale * carried
    plain = False
    for iterations in range(1, _MAX_ITERATIONS + 1):
        if state.renew() / scale <= tolerance or iterations == _MAX_ITERATIONS:
            break
        if state.energy > lowest_energy + margin:
            # under a low cap longer steps go from bound to bound, whatever part of them is taken
            reach = min(1.0, cap / max(np.abs(wanted - accepted).max(), np.finfo(float).tiny))
            share = 0.5 * min(share, reach)
            if share < _SHORTEST_STEP * reach:
                if plain:
                    pressure[:] = accepted
                    break
                plain, share = True, 0.0
            pressure[:] = accepted + share * (wanted - accepted)
            state.forget()
            if share == 0.0:
                lowest_energy, last_energy, share = math.inf, math.inf, 1.0
            continue
        stuck = state.energy >= last_energy and bool(
            np.abs(pressure - accepted).sum() <= _STUCK * np.abs(wanted - accepted).sum()
        )
        if stuck and plain:
            break
        plain = stuck or (plain and math.isinf(lowest_energy))  # once: the step before has done
        # by less than the margin each, many steps would raise it without end
        lowest_energy, last_energy = min(lowest_energy, state.energy), state.energy
        share = 1.0
        accepted[:] = pressure
        if not state.step(plain):
            if plain or not state.step(True):
                break
            plain = True
        wanted[:] = pressure
    return iterations


class _State:
    """Vectors of one contact list."""

    def __init__(
        self,
        operator: SplitOperator | FullGridOperator,
        pressure: Array,
        gap: Array,
        total: float | None,
        cap: float,
    ) -> None:
        n = pressure.size
        self.operator, self.pressure, self.cap = operator, pressure, cap
        self.held = total is None
        self.total = math.nan if total is None else total
        self.base, self.start_gap = pressure.copy(), gap
        self.moved, self.change, self.residual, self.before, self.direction = (
            np.zeros(n, np.float32) for _ in range(5)
        )
        self.active = np.ones(n, np.bool_)
        self.count = 0
        self.energy = 0.0
        self._norm, self._inside = 0.0, False
        self._reference: float | None = None

    def renew(self) -> float:
        """Make the pressure feasible and measure it; returns its error [m]."""
        leveled = (0.0, 1.0) if self.held else self._leveled()
        if _list_kernels.cut(self.pressure, self.base, self.moved, leveled, self.cap) == 0.0:
            self.change[:] = 0.0
        elif not self._inside:
            self.change = self.operator.apply(self.moved)
        level, error, self.count, energy, shift = _list_kernels.measure(
            self.pressure,
            self.moved,
            self.start_gap,
            self.change,
            self.active,
            self.residual,
            self.cap,
            self.held,
        )
        if self._reference is None:
            self._reference = level
        self.energy = energy - self._reference * shift
        return float(error)

    def _leveled(self) -> tuple[float, float]:
        """What restores the load, added to all that is under pressure, and a factor.

        Points of lowest gap are brought in if those cannot bear the load.
        """
        loaded = self.pressure > 0.0
        count, needed = np.count_nonzero(loaded), self.total / self.cap
        if count <= needed:
            # a step leaves the displacement of pressures beyond their bounds, far beyond low caps
            _list_kernels.cut(self.pressure, self.base, self.moved, (0.0, 1.0), self.cap)
            gap = np.where(loaded, np.inf, self.start_gap + self.operator.apply(self.moved))
            more = max(math.ceil(SPARE_LOAD * needed - count), 1)
            lowest = np.argsort(gap)[:more]
            # hardly more than is missing: what a step moved to the cap would be shifted back
            least = min(self.cap * (needed - count + SPARE_LOAD - 1.0) / more, self.total)
            self.pressure[lowest] = np.maximum(self.pressure[lowest], least)
        found: tuple[float, float]
        found = _list_kernels.leveling(self.pressure, self.total, self.cap)
        return found

    def _free(self) -> None:
        """Take out the points that the step would move out of bounds.

        The step is the residual less its mean over the active points. Only without such points
        does it keep the load, and lower the energy if it is short enough.
        """
        while self.count:
            mean = 0.0 if self.held else float(self.residual[self.active].mean())
            out = (self.pressure <= 0.0) & (self.residual > mean)
            out |= (self.pressure >= self.cap) & (self.residual < mean)
            out &= self.active
            if not out.any():
                return
            self.active &= ~out
            self.residual[out] = 0.0
            self.count = int(np.count_nonzero(self.active))

    def forget(self) -> None:
        """Take the next direction without the last, after the pressure was changed from outside."""
        self._norm, self._inside = 0.0, False

    def step(self, plain: bool) -> bool:
        """One conjugate-gradient step on the active points; False if there is none to take.

        `plain` takes the residual itself as the direction: it must lower the energy if any does.
        """
        if plain:
            self.forget()
            self._free()
        if self.count == 0:
            return False
        count = math.inf if self.held else float(self.count)
        z = self.residual if plain else self.operator.precondition(self.residual)
        self._norm = _list_kernels.turn(
            self.active, count, z, self.residual, self.before, self.direction, self._norm
        )
        beyond = _list_kernels.advance(
            self.active,
            count,
            self.pressure,
            self.change,
            self.residual,
            self.direction,
            self.operator.apply(self.direction),
            self.cap,
        )
        if beyond < 0:
            return False
        self.before, self.residual = self.residual, self.before  # `measure` writes all of it anew
        self._inside = beyond == 0
        return True
