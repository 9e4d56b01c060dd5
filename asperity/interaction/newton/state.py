"""The coupled problem of contacts that may close, and a trial point of it with its balance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.elongation import Elongation
from asperity.interaction.ewald.operator import Interaction
from asperity.parameters import DEFAULTS, ContactShift

from . import _newton_kernels
from .contact_shift import contact_shifts
from .laws import Laws

__all__ = ["Problem", "State"]


@dataclass(frozen=True, eq=False)
class Problem:
    """Contacts that may close, their laws and their interaction in the same order.

    Their summits have the heights z [m], shape (n,). With `contact_shift` they shift under the
    slope of the field (`contact_shifts`), as far as `fitted` says; their footprints are round if
    `elongation` is None.
    """

    height: NDArray[np.float64]
    laws: Laws
    plan: Interaction
    contact_shift: bool = False
    elongation: Elongation | None = None
    fitted: ContactShift = DEFAULTS.contact_shift

    @property
    def form(self) -> NDArray[np.float64]:
        """Moments of the footprints over their variance, shape (n, 3); contacts that do not move
        aside are taken as round."""
        if self.elongation is None or not self.contact_shift:
            return self.plan.round
        return self.elongation.moments

    @property
    def radii(self) -> NDArray[np.float64]:
        """Radii of curvature over those of round contacts, shape (n, 3); zero for contacts that do
        not move aside."""
        if not self.contact_shift:
            return np.zeros((len(self.height), 3))
        return self.plan.round if self.elongation is None else self.elongation.radii


class State:
    """A trial point: approaches d >= 0, the laws there, the field of the forces, and how far it is
    from balance.

    Attributes
    ----------
    problem
        Contacts.
    approach, laws, field
        d [m], the laws there, and the field of their forces.
    shift, next_shift
        Shifts of the contacts [m] whose field was taken, and those that belong to this field
        (`contact_shifts`), shape (n, 2).
    gain
        Heights [m] gained by `next_shift`, shape (n,).
    separation
        Separation [m] at which `balance` has judged the contacts; it sets all that follows.
    gap, wanted, error
        z - s, z - s - u, and by how much this exceeds the approach [m], shape (n,).
    closing, sums
        Contacts about to close, and the sums of |error| k and of the force over the closed ones.
    active
        Contacts that are closed or about to close, bool, shape (n,).
    stiffness, growth, force, base
        Laws of the active contacts, and the approach [m] where they were taken, shape (n,).
    relative
        sum |error_i| k_i over sum F_i.

    Notes
    -----
    With the pair energy F_i F_j N(r; m_i, m_j), the energy at separation s is
    E = sum_i [U*_i(F_i) - (z_i - s) F_i] + 1/2 sum_ij F_i F_j N_ij, U* = F d - U, and its gradient
    is dE/dF_i = d_i + u_i - (z_i - s), u_i = v0_i + growth_i v1_i: the growth of the footprint with
    its force is part of the gradient, so that the residual is that of one energy.
    """

    def __init__(
        self, problem: Problem, approach: NDArray[np.float64], tilt: NDArray[np.float64]
    ) -> None:
        laws = problem.laws(approach)
        self.problem, self.laws = problem, laws
        self.approach = np.where(laws.force > 0, approach, 0.0)
        body, bounds = problem.plan.footprints, (problem.radii, problem.fitted.largest)
        _, self.shift, moment = contact_shifts(body, laws, self.approach, tilt, *bounds)
        self.field = problem.plan.field(laws.force, laws.moment, laws.growth, moment, problem.form)
        self.gain, self.next_shift, _ = contact_shifts(
            body, laws, self.approach, self.field.tilt, *bounds
        )

    @property
    def risen(self) -> NDArray[np.float64]:
        """Height [m] that each contact gains by its own shift and loses by those of the others."""
        return self.gain - self.field.moved

    @property
    def lag(self) -> float:
        """Share of the load that the difference between `shift` and `next_shift` can make: that
        of the moments' work, times the weight of all contact shifts."""
        return float(
            _newton_kernels.lag(
                self.laws.force,
                self.laws.stiffness,
                self.field.tilt,
                self.shift,
                self.next_shift,
                self.field.moved,
                self.gain,
            )
        )

    def balance(self, separation: float, balanced: bool) -> None:
        """Judge the contacts at a separation [m]; `linearize` follows.

        If `balanced` it is moved first to where the errors of the closed contacts, times stiffness,
        cancel.
        """
        law, field = self.laws, self.field
        gap = self.problem.height - separation + self.gain - field.moved - field.longer
        wanted = gap - field.value - law.growth * field.slope
        error = wanted - self.approach
        total = float(law.stiffness.sum()) if balanced else 0.0
        rise = float(np.sum(law.stiffness * error)) / total if total > 0.0 else 0.0
        self.gap, self.wanted, self.error = gap - rise, wanted - rise, error - rise
        self.separation = separation + rise
        self.active = self.approach > 0.0
        self.closing = np.flatnonzero((self.wanted > 0.0) & ~self.active)
        wrong = float(np.sum(law.stiffness * np.abs(self.error)))
        self.sums = wrong, float(law.force.sum())

    def linearize(self) -> None:
        """Take the tangent data of the active contacts, whose laws are made by now.

        A contact about to close has no stiffness yet: it gets that at half the approach it wants,
        and counts with its force there.
        """
        law, (error, load) = self.laws, self.sums
        stiffness, growth, force, base = law.stiffness, law.growth, law.force, self.approach
        fresh = self.closing[self.problem.laws.rows(self.closing).usable]
        if fresh.size:
            self.active[fresh] = True
            half = 0.5 * self.wanted[fresh]
            law = self.problem.laws.rows(fresh)(half)
            stiffness, growth, force, base = (
                values.copy() for values in (stiffness, growth, force, base)
            )
            stiffness[fresh], growth[fresh] = law.stiffness, law.growth
            force[fresh], base[fresh] = law.force, half
            error += float(law.force.sum())
        self.stiffness, self.growth, self.force, self.base = stiffness, growth, force, base
        self.relative = error / load if load > 0 else math.inf if error > 0 else 0.0

    @property
    def extra(self) -> NDArray[np.float64]:
        """Extra compliance [m/N], shape (n,): what the growth of a contact's own footprint in the
        field of the others adds to its tangent, dv/dF dN/dm, with dv/dF = 5/3 (v - m)/F as for
        Hertz; only its positive part is kept, which leaves the matrix positive definite."""
        pull, force = np.maximum(self.growth * self.field.slope, 0.0), self.force
        return np.divide(5 / 3 * pull, force, out=np.zeros(len(force)), where=force > 0)

    def raised(self, change: NDArray[np.float64] | float) -> None:
        """Take the state with all summits higher by `change` [m]."""
        self.gap, self.wanted = self.gap + change, self.wanted + change
        self.error = self.error + change

    def energy_change(self, other: State) -> tuple[float, float, float]:
        """From this point to another: change of energy [J] at the gaps that are held, the change
        that the errors here predict, and the size of the energies."""
        before, after = (
            state.laws.force * (state.approach + 0.5 * state.field.value - self.gap)
            - state.laws.energy
            for state in (self, other)
        )
        slope = -np.sum(self.error * (other.laws.force - self.laws.force))
        return float(np.sum(after - before)), float(slope), float(np.sum(np.abs(before)))
