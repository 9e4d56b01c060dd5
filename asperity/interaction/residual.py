"""How far a trial point is from balance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from . import _state_kernels
from .state import Problem, State

__all__ = ["Residual"]


class Residual:
    """How far a state is from balance, and the tangent data of its contacts.

    A contact about to close has no stiffness yet: it gets that at half the approach it wants, and
    counts with its force there. The extra compliance is what the growth of a contact's own
    footprint in the field of the others adds to its tangent, dv/dF dN/dm, with
    dv/dF = 5/3 (v - m)/F as for Hertz; only its positive part is kept, which leaves the matrix
    positive definite.
    """

    def __init__(self, problem: Problem, state: State, gap: NDArray[np.float64]) -> None:
        self.gap = gap
        self.wanted = gap - state.displacement
        self.error = self.wanted - state.approach
        closed = state.approach > 0
        problem.laws.expect(self.wanted)
        self.active = closed | ((self.wanted > 0) & problem.laws.usable)
        stiffness, growth, force = state.laws.stiffness, state.laws.growth, state.laws.force
        load = float(force.sum())
        error = float(_state_kernels.size(stiffness, self.error))
        fresh = np.flatnonzero(self.active & ~closed)
        if fresh.size:
            law = problem.laws.rows(fresh)(0.5 * self.wanted[fresh])
            stiffness, growth, force = stiffness.copy(), growth.copy(), force.copy()
            stiffness[fresh], growth[fresh], force[fresh] = law.stiffness, law.growth, law.force
            error += float(law.force.sum())
        self.relative = error / load if load > 0 else math.inf if error > 0 else 0.0
        pull = np.maximum(growth * state.field.slope, 0.0)
        self.stiffness, self.force = stiffness, force
        self.base = np.where(closed, state.approach, 0.5 * self.wanted)
        self.extra = np.divide(5 / 3 * pull, force, out=np.zeros(len(force)), where=force > 0)

    def raised(self, change: NDArray[np.float64] | float) -> None:
        """Take the same state with all summits higher by `change` [m]."""
        self.gap, self.wanted = self.gap + change, self.wanted + change
        self.error = self.error + change
