"""The coupled problem and a trial point of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.elongation import Elongation
from asperity.interaction.ewald.operator import Field, Interaction

from . import _state_kernels
from .contact_shift import contact_shifts
from .laws import Evaluated, Laws

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
    contact_shift
        Whether contacts shift under the slope of the field (`contact_shifts`).
    elongation
        Their elongation in the same order; None: round.
    """

    height: NDArray[np.float64]
    laws: Laws
    plan: Interaction
    contact_shift: bool = False
    elongation: Elongation | None = None

    def rounded(self, some: NDArray[np.bool_]) -> Problem:
        """The same with round footprints of `some` contacts, shape (n,): long ones can overlap so
        far that their approximate sum has no solution."""
        if self.elongation is None:
            return self
        return replace(self, elongation=self.elongation.rounded(some))

    @property
    def form(self) -> NDArray[np.float64]:
        """Moments of the footprints over their variance, shape (n, 3); contacts that do not move
        aside are taken as round."""
        if self.elongation is None or not self.contact_shift:
            return self.plan.round
        return self.elongation.moments

    @property
    def radii(self) -> NDArray[np.float64]:
        """Radii of curvature over those of round contacts, shape (n, 3)."""
        return self.plan.round if self.elongation is None else self.elongation.radii


@dataclass(eq=False)
class State:
    """A trial point: approaches d >= 0, the laws there, and the field of the forces.

    Attributes
    ----------
    approach, laws, field
        d [m], the laws there, and the field of their forces.
    aside
        Shifts of the contacts [m] whose field was taken, shape (n, 2).
    gain, fresh
        Heights [m] gained by standing aside, and the shifts that belong to this field
        (`contact_shifts`).

    Notes
    -----
    With the pair energy F_i F_j N(r; m_i, m_j), the energy at separation s is
    E = sum_i [U*_i(F_i) - (z_i - s) F_i] + 1/2 sum_ij F_i F_j N_ij, U* = F d - U, and its gradient
    is dE/dF_i = d_i + u_i - (z_i - s), u_i = v0_i + growth_i v1_i: the growth of the footprint with
    its force is part of the gradient, so that the residual is that of one energy.
    """

    approach: NDArray[np.float64]
    laws: Evaluated
    field: Field
    aside: NDArray[np.float64]
    gain: NDArray[np.float64]
    fresh: NDArray[np.float64]

    @classmethod
    def at(
        cls, problem: Problem, approach: NDArray[np.float64], tilt: NDArray[np.float64]
    ) -> State:
        """The point with these approaches [m], its moments taken for the gradients `tilt` [-]."""
        laws = problem.laws(approach)
        approach = np.where(laws.force > 0, approach, 0.0)
        if not problem.contact_shift:
            field = problem.plan.field(laws.force, laws.moment)
            return cls(approach, laws, field, tilt, np.zeros(len(approach)), tilt)
        body, radii = problem.plan.footprints, problem.radii
        _, aside, moment = contact_shifts(body, laws, approach, tilt, radii)
        field = problem.plan.field(laws.force, laws.moment, laws.growth, moment, problem.form)
        gain, fresh, _ = contact_shifts(body, laws, approach, field.tilt, radii)
        return cls(approach, laws, field, aside, gain, fresh)

    @property
    def displacement(self) -> NDArray[np.float64]:
        """u [m]."""
        return self.field.value + self.laws.growth * self.field.slope

    @property
    def risen(self) -> NDArray[np.float64]:
        """Height [m] that each contact gains by its own shift and loses by those of the others."""
        return self.gain - self.field.moved

    @property
    def shift(self) -> NDArray[np.float64]:
        """Height [m] that each contact gains by its shift, less what it loses by the elongation
        of all."""
        return self.risen - self.field.longer

    @property
    def lag(self) -> float:
        """Share of the load that the difference between `aside` and `fresh` can make: that of the
        moments' work, times the weight of all contact shifts."""
        if self.fresh is self.aside:
            return 0.0
        return float(
            _state_kernels.lag(
                self.laws.force,
                self.laws.stiffness,
                self.field.tilt,
                self.aside,
                self.fresh,
                self.field.moved,
                self.gain,
            )
        )

    def fall(
        self, other: State, gap: NDArray[np.float64], error: NDArray[np.float64]
    ) -> tuple[float, float, float]:
        """From this point to another: change of energy [J] at the gaps z - s [m] that are held, the
        change that the errors here predict, and the size of the energies."""
        change, slope, scale = _state_kernels.fall(
            gap,
            error,
            *(
                part
                for state in (self, other)
                for part in (
                    state.laws.force,
                    state.approach,
                    state.field.value,
                    state.laws.energy,
                )
            ),
        )
        return change, slope, scale
