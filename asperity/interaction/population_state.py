"""State of a population at one separation, and the continuation that predicts the next state."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from asperity.interaction.ewald.tangent import Tangent
from asperity.interaction.newton.state import CandidateValues
from asperity.interaction.newton.step import conjugate_gradients
from surfaces.arrays import Array, Index

if TYPE_CHECKING:
    from asperity.interaction.ewald.mesh import SmoothField
    from asperity.interaction.newton.final_step import Solution

    from .candidates import CandidateList
    from .contact_system import ContactSystem

__all__ = ["Contacts", "Continuation", "Point", "PopulationState", "weights"]

UNLOADING_TOLERANCE = 0.03
"""Relative accuracy of the linear solve for the unloading stiffness."""

POINTS_KEPT = 3
"""Number of solved points from which the next is extrapolated."""

LARGEST_WEIGHT = 6.0
"""Largest weight of one point in an extrapolation from three. Larger weights would magnify the
errors of the points; the last two points are then taken."""

SINKING_SHARE = 0.995
"""Share of the contacts that sink at least by `Continuation.rise`. With 0.98 one list in four was
made twice; with 1 a third more summits are listed at the largest loads."""


@dataclass(frozen=True, eq=False)
class Point:
    """One solved point.

    Attributes
    ----------
    separation, pressure
        Separation [m] and mean pressure [Pa].
    rows
        Candidates of the point, shape (m,).
    values
        Values of these candidates.
    """

    separation: float
    pressure: float
    rows: Index
    values: CandidateValues


def predict(points: tuple[Point, ...], separation: float, count: int) -> CandidateValues:
    """Predict the values of the candidates of the last point at a separation [m].

    Each of the `count` summits is extrapolated from the last points that have it as a candidate;
    the response stays. From one point closed contacts follow their response."""
    last = points[-1]
    if len(points) == 1:
        before, fall = last.values.interference, last.separation - separation
        gained = np.where(before > 0, last.values.response * fall, 0.0)
        return last.values._replace(interference=before + gained)
    values, known, parts = last.values, np.ones(len(last.rows), bool), [last.values]
    for back, other in enumerate(reversed(points[:-1]), start=2):
        part = other.values
        if other.rows is not last.rows:
            place = np.full(count, -1, np.int32)
            place[other.rows] = np.arange(len(other.rows), dtype=np.int32)
            place = place.take(last.rows)
            known &= place >= 0
            part = part.rows(place)
        parts.insert(0, part)
        share = weights(separation, [point.separation for point in points[-back:]])
        values = CandidateValues.weighted(share, parts, known, values)
    return values._replace(response=last.values.response)


def weights(place: float, known: list[float]) -> Array:
    """Weights of the values at two or three abscissas `known` in the extrapolated value at `place`.

    The weights are Lagrange's for the parabola through three points. If one exceeds
    `LARGEST_WEIGHT`, or there are two points, they are those of the line through the last two,
    extrapolated by at most 1.5 of their distance.
    """
    count = len(known)
    if count > 2 and len(set(known)) == count:
        share = np.array([math.prod((place - b) / (a - b) for b in known if b != a) for a in known])
        if np.abs(share).max() <= LARGEST_WEIGHT:
            return share
    before, last = known[-2:]
    ratio = 0.0 if before == last else (place - last) / (last - before)
    ratio = min(max(ratio, -1.5), 1.5)
    return np.array([0.0] * (count - 2) + [-ratio, 1.0 + ratio])


@dataclass(frozen=True, eq=False)
class Continuation:
    """What one load point hands to the next: the last points, the candidates and the field.

    Attributes
    ----------
    system
        Summits, laws and half-space.
    candidates
        Candidates of the last point; None if there is no point, or if the list was freed.
    field
        Smooth part of the last field, if any.
    points
        Points to predict the next from, in the order in which they were solved.
    heaviest
        Separation [m] and mean pressure [Pa] of the largest load that was solved.
    solution, slope
        The last solution; where it is not kept, `slope` is its `normal_stiffness` [Pa/m].
    """

    system: ContactSystem
    candidates: CandidateList | None = None
    field: SmoothField | None = None
    points: tuple[Point, ...] = ()
    heaviest: tuple[float, float] | None = None
    solution: Solution | None = None
    slope: float = math.nan

    def without_contacts(self) -> Continuation:
        """The continuation for a next solve that makes a new list of candidates."""
        return replace(self, candidates=None, solution=None, slope=self.normal_stiffness)

    def after(self, solution: Solution, candidates: CandidateList) -> Continuation:
        """The continuation with one more point, a solution for these candidates."""
        pressure = solution.load / self.system.nominal_area
        point = Point(solution.separation, pressure, candidates.index, solution.values)
        heaviest = self.heaviest
        if not solution.reason and (heaviest is None or pressure > heaviest[1]):
            heaviest = solution.separation, pressure
        return replace(
            self,
            candidates=candidates,
            field=candidates.problem.coupling.smooth,
            points=(*self.points[1 - POINTS_KEPT :], point),
            heaviest=heaviest,
            solution=solution,
        )

    def predicted(self, separation: float, pressure: float | None) -> tuple[Index, CandidateValues]:
        """Predicted candidates, and the values of each, at a separation or mean pressure."""
        system = self.system
        if self.points:
            # at a separation a line is enough: `corrected_prediction` mends what it misses
            known = self.points[-2:] if pressure is None else self.points
            return self.points[-1].rows, predict(known, separation, len(system))
        rows = system.above(separation)
        return rows, CandidateValues.of(0.5 * (system.height[rows] - separation))

    def rise(self, separation: float, values: CandidateValues) -> float:
        """How far [m] nearly all closed contacts of a free half-space sink as the flat moves from
        the last point to a separation, where they are predicted to have `values`.

        A contact sinks by the fall of the flat less the approach that it gains. Under ten times the
        load a free body sinks by many times its roughness; candidates are therefore sought at a
        separation raised by this amount. It is zero in a periodic cell, whose mean does not move.
        """
        if self.system.boundary == "periodic" or not self.points:
            return 0.0
        last = self.points[-1]
        before = last.values.interference
        gained = (values.interference - before)[before > 0]
        if not gained.size:
            return 0.0
        most = int(SINKING_SHARE * (gained.size - 1))
        return max(0.0, last.separation - separation - float(np.partition(gained, most)[most]))

    @property
    def under_load(self) -> tuple[Point, ...]:
        """The points that carry a load."""
        return tuple(point for point in self.points if point.pressure > 0)

    def predicted_separation(self, pressure: float) -> float | None:
        """Separation [m] extrapolated to a mean pressure [Pa], over the logarithm of the pressure;
        None without points under load."""
        known = self.under_load
        if not known:
            return None
        if len(known) == 1:
            stiffness = self.normal_stiffness
            if not stiffness > 0:  # of a failed solve
                return None
            rise = math.log(pressure / known[0].pressure) * known[0].pressure
            return known[0].separation - rise / stiffness
        share = weights(math.log(pressure), [math.log(point.pressure) for point in known])
        return float(np.dot(share, [point.separation for point in known]))

    @property
    def normal_stiffness(self) -> float:
        """Minus the slope of mean pressure over separation [Pa/m] at the last point."""
        if self.solution is None:
            return self.slope
        return self.solution.tangent[0] / self.system.nominal_area


class Contacts(NamedTuple):
    """Approach [m], force [N], stiffness [N/m] and area [m^2] of some contacts, shape (k,) each;
    zero for open contacts."""

    approach: Array
    force: Array
    stiffness: Array
    area: Array


@dataclass(frozen=True, eq=False)
class PopulationState:
    """Contacts of a population at one separation.

    Attributes
    ----------
    separation
        Distance of the rigid flat from the mean plane [m]: of the deformed surface for a periodic
        cell (mean gap), of the surface at rest for a free half-space.
    approach, force, stiffness, area
        Approach [m], force [N], stiffness [N/m] and contact area [m^2] of each summit, shape (n,);
        zero for open contacts.
    mean_pressure
        Load over nominal area [Pa].
    contact_area
        Sum of the contact areas [m^2].
    active
        Number of contacts that carry load.
    filled_share
        Share of the load on contacts that cover more than half of their basin [-].
    residual
        Upper estimate of the relative error of the load that the Newton steps have left [-].
    converged, reason
        Whether the point can be used, and one sentence if it cannot.
    iterations
        Number of Newton steps.
    lowest_candidate
        Height [m] below which no summit can touch in the field of the others.
    rows, contacts
        Candidates, shape (k,), and the contact of each.
    tilt
        Gradients [-] of the displacement of each candidate by all others, along y and x, (k, 2).
    continuation
        Start of the next solve.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> state = asperity.solve_contacts(hm, steel, pressures=[1e8]).points[0].state
    >>> state.active == int((state.force > 0).sum())
    True
    """

    separation: float
    mean_pressure: float
    contact_area: float
    active: int
    filled_share: float
    residual: float
    converged: bool
    reason: str
    iterations: int
    lowest_candidate: float
    rows: Index = field(repr=False)
    contacts: Contacts = field(repr=False)
    tilt: Array = field(repr=False)
    continuation: Continuation = field(repr=False)

    def refused(self, reason: str) -> PopulationState:
        """This state marked as not converged, for a `reason`."""
        return replace(self, converged=False, reason=reason)

    @functools.cached_property
    def approach(self) -> Array:
        """Approaches [m] of all summits."""
        return self._of_all(self.contacts.approach)

    @functools.cached_property
    def force(self) -> Array:
        """Forces [N] of all summits."""
        return self._of_all(self.contacts.force)

    @functools.cached_property
    def stiffness(self) -> Array:
        """Stiffnesses [N/m] of all summits."""
        return self._of_all(self.contacts.stiffness)

    @functools.cached_property
    def area(self) -> Array:
        """Contact areas [m^2] of all summits."""
        return self._of_all(self.contacts.area)

    def _of_all(self, listed: Array) -> Array:
        found = np.zeros(len(self.continuation.system))
        found[self.rows] = listed
        return found

    @property
    def normal_stiffness(self) -> float:
        """Minus the slope of mean pressure over separation [Pa/m], from the tangent matrix."""
        return self.continuation.normal_stiffness

    @property
    def unloading_stiffness(self) -> float:
        """Minus the slope of mean pressure over separation [Pa/m] as the load begins to fall.

        Contacts that have yielded keep their areas: it is that of coupled elastic contacts."""
        last, closed = self.continuation, self.contacts.force > 0.0
        stiffness = np.ones(closed.size)
        approach = self.contacts.approach[closed]
        elastic = last.system.table.elastic_at(self.rows[closed], approach)
        stiffness[closed] = elastic[1]
        load = stiffness[closed]
        if last.candidates is not None and closed.any():
            problem = last.candidates.problem
            tangent = Tangent(problem.coupling, closed, stiffness)
            ones = np.ones(len(tangent.index))
            load = conjugate_gradients(tangent, ones, tolerance=UNLOADING_TOLERANCE).solution
        return float(load.sum()) / last.system.nominal_area

    @property
    def response(self) -> Array:
        """Approach [m] that each contact gains as the flat falls by 1 m, shape (n,)."""
        last = self.continuation
        response = np.ones(len(last.system))
        if last.points and last.solution is not None:
            response[last.points[-1].rows] = last.solution.tangent[1]
        return response
