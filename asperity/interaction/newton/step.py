"""One Newton step of the contacts: from forces to approaches, with the laws at both ends."""

from __future__ import annotations

import copy

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.ewald.tangent import Tangent

from . import _state_kernels
from .conjugate_gradients import conjugate_gradients
from .problem import Problem, State
from .residual import Residual

__all__ = ["Step"]

Array = NDArray[np.float64]

SOFT = 1e6
"""Compliance, over that in the tangent, of contacts that a step has opened: they stay open while
their neighbors change."""


class Step:
    """The active contacts of a state, their displacement linear in the change of their forces.

    All arrays run over the points of the tangent matrix.

    Parameters
    ----------
    problem, state, residual
        Where the step starts.
    tangent
        Tangent matrix there; `refine` changes it.
    """

    def __init__(
        self, problem: Problem, state: State, residual: Residual, tangent: Tangent
    ) -> None:
        self.rows = rows = tangent.index
        self.tangent = tangent
        self.laws = problem.laws.rows(rows)
        self.before = state.laws.force[rows]
        self.wanted = residual.wanted[rows]
        self.own = self.stiffness = residual.stiffness[rows]
        self.base, self.force = residual.base[rows], residual.force[rows]
        approach = state.approach[rows]
        self.lower, self.upper = _bounds(approach, self.wanted, residual.error[rows])

    def approach(self, change: Array) -> Array:
        """Approach [m] after a change [N] of the forces, by the power law that a contact follows at
        its force and stiffness."""
        exponent = np.minimum(self.force / (self.stiffness * self.base), 1.0)
        grown = np.maximum((self.before + change) / self.force, 0.0)
        wanted: Array = self.base * grown**exponent
        return np.minimum(np.maximum(wanted, self.lower), self.upper)

    def wanted_after(self, constant: float, change: Array, image: Array) -> Array:
        """z - s - u [m] after a change of the separation [m] and of the forces [N], of which the
        tangent at the start makes the `image` [m]."""
        return self.wanted - constant - image + change / self.own

    def refine(
        self, change: Array, *, tolerance: float, load: float | None
    ) -> tuple[Step, Array, float, int]:
        """A second Newton step at the forces after `change` [N], with the laws there.

        Returns
        -------
        The step with these laws, the whole change of the forces, that of the separation [m], and
        products spent.

        Notes
        -----
        The laws bend much more than the displacements do, and contacts close and open: their part
        of the tangent is renewed, that of the displacements, which costs more, is kept.
        """
        after = copy.copy(self)
        approach = self.approach(change)
        found = self.laws(approach)
        change, closed = found.force - self.before, found.force > 0
        error = self.wanted_after(0.0, change, self.tangent(change)) - approach
        after.stiffness = np.where(closed, found.stiffness, self.stiffness)
        after.base = np.where(closed, approach, self.base)
        after.force = np.where(closed, found.force, self.force)
        after.lower, after.upper = _bounds(approach, approach + error, error)
        opened = ~closed & (error <= 0)
        own = 1 / after.stiffness
        own[opened] *= SOFT
        self.tangent.stiffen(own - 1 / self.stiffness)
        constant, start = 0.0, None
        if load is not None and closed.any():
            constant = float(_state_kernels.balance(found.stiffness, error))
            missing = load - float(found.force.sum())
            start = missing / float(found.stiffness.sum()) * found.stiffness
        error -= constant
        solved = conjugate_gradients(
            self.tangent,
            np.where(opened, 0.0, error),
            tolerance=tolerance,
            start=start,
            held=load is not None,
        )
        constant += solved.constant
        return after, change + solved.solution, constant, solved.products + 1


def _bounds(approach: Array, wanted: Array, error: Array) -> tuple[Array, Array]:
    """Approaches [m] within which a step stays: a contact that overlaps still keeps a tenth of its
    approach, one that does not may open."""
    lower = np.where(wanted > 0, 0.1 * approach, 0.0)
    return lower, approach + np.maximum(2 * approach, np.abs(error))
