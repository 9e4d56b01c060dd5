"""How far a trial point is from balance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from . import _state_kernels
from .problem import Problem, State

__all__ = ["Residual"]


class Residual:
    """How far a state is from balance, and the tangent data of its contacts.

    A contact about to close has no stiffness yet: it gets that at half the approach it wants, and
    counts with its force there. The extra compliance is what the growth of a contact's own
    footprint in the field of the others adds to its tangent, dv/dF dN/dm, with
    dv/dF = 5/3 (v - m)/F as for Hertz; only its positive part is kept, which leaves the matrix
    positive definite.

    Parameters
    ----------
    problem, state
        Contacts, and where they are.
    separation
        Separation [m] at which they are judged.
    balanced
        Whether it is moved first to where the errors of the closed contacts, times stiffness,
        cancel.

    Attributes
    ----------
    separation
        Separation [m] at which the contacts are judged.
    """

    def __init__(self, problem: Problem, state: State, separation: float, balanced: bool) -> None:
        law, field, n = state.laws, state.field, len(problem.height)
        self.gap, self.wanted, self.error = np.empty((3, n))
        self.active = np.empty(n, bool)
        closing = np.empty(n, np.int64)
        rise, error, load, count = _state_kernels.imbalance(
            problem.height,
            separation,
            balanced,
            state.gain,
            field.moved,
            field.longer,
            field.value,
            law.growth,
            field.slope,
            state.approach,
            law.force,
            law.stiffness,
            self.gap,
            self.wanted,
            self.error,
            self.active,
            closing,
        )
        self.separation = separation + rise
        problem.laws.expect(self.wanted)
        stiffness, growth, force, base = law.stiffness, law.growth, law.force, state.approach
        fresh = closing[:count]
        fresh = fresh[problem.laws.rows(fresh).usable]
        if fresh.size:
            self.active[fresh] = True
            half = 0.5 * self.wanted[fresh]
            law = problem.laws.rows(fresh)(half)
            stiffness, growth, force, base = (
                values.copy() for values in (stiffness, growth, force, base)
            )
            stiffness[fresh], growth[fresh] = law.stiffness, law.growth
            force[fresh], base[fresh] = law.force, half
            error += float(law.force.sum())
        self.stiffness, self.growth, self.force, self.base = stiffness, growth, force, base
        self.slope = field.slope
        self.relative = error / load if load > 0 else math.inf if error > 0 else 0.0

    @property
    def extra(self) -> NDArray[np.float64]:
        """Extra compliance [m/N], shape (n,)."""
        pull, force = np.maximum(self.growth * self.slope, 0.0), self.force
        return np.divide(5 / 3 * pull, force, out=np.zeros(len(force)), where=force > 0)

    def raised(self, change: NDArray[np.float64] | float) -> None:
        """Take the same state with all summits higher by `change` [m]."""
        self.gap, self.wanted = self.gap + change, self.wanted + change
        self.error = self.error + change
