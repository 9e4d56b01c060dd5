"""The coupled problem and a trial point of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .laws import Evaluated, Laws
from .operator import Interaction

__all__ = ["Problem", "State"]


@dataclass(frozen=True, eq=False)
class Problem:
    """Contacts that may close, their laws and their interaction.

    Attributes
    ----------
    height
        Summit heights z [m], shape (n,).
    laws, plan
        Laws and interaction in the same order.
    deflects
        Whether contacts move aside under the slope of the field (`deflection`).
    """

    height: NDArray[np.float64]
    laws: Laws
    plan: Interaction
    deflects: bool = False


@dataclass(eq=False)
class State:
    """A trial point: approaches d >= 0, the laws there, and the field of the forces.

    Notes
    -----
    With the pair energy F_i F_j N(r; m_i, m_j), the energy at separation s is
    E = sum_i [U*_i(F_i) - (z_i - s) F_i] + 1/2 sum_ij F_i F_j N_ij, U* = F d - U, and its gradient
    is dE/dF_i = d_i + u_i - (z_i - s), u_i = v0_i + growth_i v1_i: the growth of the footprint with
    its force is part of the gradient, so that the residual is that of one energy.
    """

    approach: NDArray[np.float64]
    laws: Evaluated
    value: NDArray[np.float64]
    slope: NDArray[np.float64]

    @property
    def displacement(self) -> NDArray[np.float64]:
        """u [m]."""
        return self.value + self.laws.growth * self.slope

    @classmethod
    def at(cls, problem: Problem, approach: NDArray[np.float64]) -> State:
        laws = problem.laws(approach)
        approach = np.where(laws.force > 0, approach, 0.0)
        return cls(approach, laws, *problem.plan.field(laws.force, laws.moment))

    def energy(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Energy of each contact [J]; `gap` is z - s."""
        force = self.laws.force
        return force * (self.approach + 0.5 * self.value - gap) - self.laws.energy
