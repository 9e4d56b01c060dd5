"""The coupled problem of the candidates, their values, and a trial state with its balance of
displacements.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.elongation import Elongation
from asperity.interaction.ewald.operator import ROUND, Interaction
from asperity.parameters import ContactShift
from surfaces.arrays import Array, Index, Mask

from .contact_shift import contact_shifts
from .laws import Laws

__all__ = ["CandidateValues", "Problem", "State"]


@dataclass(frozen=True, eq=False)
class Problem:
    """Heights z [m] of the candidates, (n,), their laws and their interaction, in one order.

    With `contact_shift` contacts shift under the slope of the field (`contact_shifts`), bounded by
    `fitted`. Footprints are round if `elongation` is None.
    """

    height: Array
    laws: Laws
    coupling: Interaction
    fitted: ContactShift
    contact_shift: bool = False
    elongation: Elongation | None = None

    @functools.cached_property
    def radii(self) -> Array:
        """Radii of curvature over those of round contacts, shape (n, 3); zero without contact
        shift."""
        if self.contact_shift and self.elongation is not None:
            return self.elongation.radii
        return np.tile(float(self.contact_shift) * ROUND, (len(self.height), 1))


class CandidateValues(NamedTuple):
    """Solved or predicted values of some candidates; the first axis runs over the candidates.

    Attributes
    ----------
    interference
        Interference z - s - u [m] with the flat: the approach of a closed contact, minus the gap of
        an open one.
    force
        Force [N].
    tilt
        Gradients [-] of the displacement along y and x, shape (n, 2).
    response
        Approach that a contact gains per fall of the flat [-].
    """

    interference: Array
    force: Array
    tilt: Array
    response: Array

    @classmethod
    def of(cls, interference: Array) -> CandidateValues:
        """The values of contacts of which no more is known than a guess of the interference [m]."""
        count = len(interference)
        return cls(interference, np.zeros(count), np.zeros((count, 2)), np.zeros(count))

    def rows(self, index: Index | NDArray[np.int32]) -> CandidateValues:
        """The values of the candidates `index`."""
        return CandidateValues(*(array.take(index, axis=0) for array in self))

    @classmethod
    def weighted(
        cls, weights: Array, parts: list[CandidateValues], known: Mask, others: CandidateValues
    ) -> CandidateValues:
        """The sum of the `parts`, each times its weight, for the candidates `known`; `others` for
        the rest."""
        found, rest = [], ~known
        for other, arrays in zip(others, zip(*parts, strict=True), strict=True):
            total = np.asarray(sum(w * array for w, array in zip(weights, arrays, strict=True)))
            total[rest] = other[rest]
            found.append(total)
        return cls(*found)


class State:
    """A trial state: approaches d >= 0, their laws, the field of their forces, and the residual.

    Attributes
    ----------
    problem
        Contacts.
    approach, laws, field
        Approaches d [m], the laws at d, and the field of the forces.
    shift, next_shift
        Contact shifts [m] that the field was computed with, and those that follow from the slope of
        this field (`contact_shifts`), shape (n, 2).
    gain
        Heights [m] gained by `next_shift`, shape (n,).
    separation
        Separation s [m] of `balance`, which sets this and the attributes below.
    gap, interference, error
        z - s, the interference z - s - u, and z - s - u - d [m], shape (n,).
    active
        Whether each contact is closed or about to close, shape (n,).
    stiffness, growth, force, base
        Laws of the active contacts, and the approach [m] at which they were evaluated, shape (n,).
    relative
        Residual: sum |error_i| k_i over sum F_i.

    Notes
    -----
    With the pair energy F_i F_j N(r; m_i, m_j) of footprints of moments m, the energy at the
    separation s is

        E = sum_i [U*_i(F_i) - (z_i - s) F_i] + 1/2 sum_ij F_i F_j N_ij,   U* = F d - U,

    and its gradient is dE/dF_i = d_i + u_i - (z_i - s), u_i = v0_i + growth_i v1_i with v0, v1 the
    `value` and `slope` of the field. The second term is the growth of the footprint with its force:
    with it the residual is the gradient of one energy.
    """

    def __init__(self, problem: Problem, approach: Array, tilt: Array) -> None:
        laws = problem.laws(approach)
        self.problem, self.laws = problem, laws
        self.approach = np.where(laws.force > 0, approach, 0.0)
        body, bounds = problem.coupling.footprints, (problem.radii, problem.fitted.largest)
        _, self.shift, moment = contact_shifts(body, laws, self.approach, tilt, *bounds)
        self.field = problem.coupling.field(laws.force, laws.moment, laws.growth, moment)
        self.gain, self.next_shift, _ = contact_shifts(
            body, laws, self.approach, self.field.tilt, *bounds
        )

    @property
    def risen(self) -> Array:
        """Height [m] that each contact gains by its own shift, less what the shifts of the others
        take from it."""
        return self.gain - self.field.moved

    @property
    def lag(self) -> float:
        """Share of the load by which the step from `shift` to `next_shift` can still change it.

        The relative change of the work of the moments, sum F |g| |ds| / sum F |g| |s|, times the
        load that all contact shifts make: the larger of sum k |moved| and sum 2 k gain.
        """
        law, pull = self.laws, self.laws.force * np.hypot(*self.field.tilt.T)
        whole = float(np.sum(pull * np.hypot(*self.next_shift.T)))
        if not whole > 0.0:
            return 0.0
        change = float(np.sum(pull * np.hypot(*(self.next_shift - self.shift).T)))
        others = float(np.sum(law.stiffness * np.abs(self.field.moved)))
        own = 2.0 * float(np.sum(law.stiffness * self.gain))
        return change / whole * max(others, own) / float(law.force.sum())

    def balance(self, separation: float, balanced: bool) -> None:
        """Compute the residual at a separation [m], and linearize about it.

        If `balanced`, the separation is first changed so that the sum of error times stiffness over
        the closed contacts is zero. Laws that are missing are made.
        """
        law, field = self.laws, self.field
        gap = self.problem.height - separation + self.gain - field.moved - field.longer
        interference = gap - field.value - law.growth * field.slope
        error = interference - self.approach
        total = float(law.stiffness.sum()) if balanced else 0.0
        rise = float(np.sum(law.stiffness * error)) / total if total > 0.0 else 0.0
        self.gap, self.interference, self.error = gap - rise, interference - rise, error - rise
        self.separation = separation + rise
        self.problem.laws.make_closing(self.interference)
        self._linearize()

    def _linearize(self) -> None:
        """Set the stiffness, growth, force and base of the active contacts, whose laws are made.

        A contact about to close has no stiffness yet. It is linearized at half of its interference,
        and its force there counts as an error.
        """
        law, self.active = self.laws, self.approach > 0.0
        error, load = float(np.sum(law.stiffness * np.abs(self.error))), float(law.force.sum())
        stiffness, growth, force, base = law.stiffness, law.growth, law.force, self.approach
        closing = np.flatnonzero((self.interference > 0.0) & ~self.active)
        fresh = closing[self.problem.laws.rows(closing).usable]
        if fresh.size:
            self.active[fresh] = True
            half = 0.5 * self.interference[fresh]
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
    def extra(self) -> Array:
        """Extra compliance [m/N] of each contact, shape (n,), by the growth of its footprint in the
        field of the others: dv/dF dN/dm with dv/dF = 5/3 (v - m)/F of a Hertz contact. Only its
        positive part is kept, which leaves the tangent matrix positive definite."""
        pull, force = np.maximum(self.growth * self.field.slope, 0.0), self.force
        return np.divide(5 / 3 * pull, force, out=np.zeros(len(force)), where=force > 0)

    def raised(self, change: Array | float) -> None:
        """Raise the summits by `change` [m]: changes gap, interference and error."""
        self.gap, self.interference = self.gap + change, self.interference + change
        self.error = self.error + change

    def energy_change(self, other: State) -> tuple[float, float, float]:
        """Change of energy [J] from this state to another at the gaps of this one, the change to
        first order in the forces, and the sum of the absolute energies of this state."""
        before, after = (
            state.laws.force * (state.approach + 0.5 * state.field.value - self.gap)
            - state.laws.energy
            for state in (self, other)
        )
        slope = -np.sum(self.error * (other.laws.force - self.laws.force))
        return float(np.sum(after - before)), float(slope), float(np.sum(np.abs(before)))
