"""All summits of a surface under one plane: independent or elastically coupled."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from asperity.errors import InputError
from asperity.halfspace.scene import checked_load
from asperity.interaction.newton.laws import LEAST_BATCH
from surfaces.errors import as_number

from .contact_system import ContactSystem
from .coupled_solve import solve_at, start_of
from .population_state import Contacts, Continuation, PopulationState

__all__ = ["Population", "PopulationState", "handed_on"]

CONTACTS_EXPONENT = 0.7
"""Number of contacts ~ load^0.7, to forecast which laws will be needed (boundary elements: 0.6 to
0.9 below 10 % of contact). About nine in ten of that many highest summits touch then."""

LARGE_LIST = 20_000
"""Number of candidates from which on the memory of a list is freed before the next is made."""

MAX_DOUBLINGS = 100
"""Doublings of the depth in the search for the separation of independent contacts."""

LIGHTER_LOAD, LIGHTER_DEPTH = 0.5, 0.8
"""Share of the load, or of the depth below the highest summit, at which a solve without an earlier
state begins. Footprints that overlap have several states: from a guess 3 of 24 maps found another
one than in a curve, up to 0.5 of the stated error in load away. From these shares the differences
were 0.17 at most, in less time."""

MAX_SOLVES = 8
"""Solves for one point, those of points between included."""

LOAD_TOLERANCE = 1e-3
"""Largest relative error of the load of independent contacts; rounding of the heights bounds it."""


class Population(ContactSystem):
    """Summits that a flat is pressed on; parameters and attributes are those of `ContactSystem`.

    Notes
    -----
    Contact i has the approach d_i = z_i - s - u_i, with the height z_i of its summit and the
    separation s. u_i is the displacement by all other contacts (and by the images of its own force
    in a periodic cell), averaged over the footprint of the contact
    (docs/development/interaction.md).

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> fit = surfaces.fit_profiles(hm, surfaces.segment(hm))
    >>> table = asperity.microcontact.tabulate(fit, steel, law="hertz")
    >>> population = asperity.Population(
    ...     x=fit.x,
    ...     y=fit.y,
    ...     height=fit.height,
    ...     table=table,
    ...     cell=hm.size,
    ...     boundary="periodic",
    ...     material=steel,
    ... )
    >>> state = population.solve(separation=0.0)
    >>> state.converged, f"{state.force.sum() / hm.area:.0e}"
    (True, '5e+09')
    """

    def solve(
        self,
        *,
        separation: float | None = None,
        pressure: float | None = None,
        state: PopulationState | None = None,
        tolerance: float = 2e-3,
        heaviest: float | None = None,
    ) -> PopulationState:
        """Contacts at a separation or at a mean pressure.

        Parameters
        ----------
        separation
            Distance of the flat from the mean plane [m].
        pressure
            Load over nominal area [Pa], in place of the separation.
        state
            A state of this population at a near separation, to start from. None: one at a lighter
            load is solved first.
        tolerance
            Bound on the residual, and on the relative error of the mean pressure.
        heaviest
            Largest mean pressure [Pa] that will be asked for, if known: laws are then made in few
            large blocks, which takes less time.

        Returns
        -------
        PopulationState
            Marked as not converged, with the reason, where the solve failed or the contacts fill
            more of the nominal area than the model can describe.

        Raises
        ------
        InputError
            If not just one of separation and mean pressure is given, a number cannot be used, or
            the state is that of another population.
        """
        kind, goal = checked_load(pressure, separation)
        if not as_number("tolerance", tolerance) > 0:
            raise InputError(f"tolerance must be positive, got {tolerance!r}")
        last = Continuation(self) if state is None else getattr(state, "continuation", None)
        if last is None or last.system is not self:
            raise InputError("the state is not one of this population; solve one with it")
        with self.laws.store.turn:  # solves in two threads share the laws
            self.laws.foresee(None)
            loaded = kind == "pressure"
            if loaded and heaviest is not None and state is not None and state.mean_pressure > 0:
                growth = heaviest / state.mean_pressure if heaviest > goal else 0.0
                self.laws.foresee(self.by_height[: int(state.active * growth**CONTACTS_EXPONENT)])
            if loaded and goal == 0:
                found = solve_at(last, self.highest, tolerance)
            elif loaded and not self.interaction:
                found = independent(last, goal)
            else:
                found = reached(last, goal, tolerance, loaded=loaded)
        share, most = found.contact_area / self.nominal_area, self.parameters.limits.area
        if share > most:
            return found.refused(
                f"contacts fill {100 * share:.0f} % of the nominal area, more than the "
                f"{100 * most:.0f} % up to which separate contacts are a model"
            )
        return found


def handed_on(
    state: PopulationState,
    *,
    separation: float | None = None,
    pressure: float | None = None,
    tolerance: float = 2e-3,
) -> PopulationState:
    """The part of a state that `Population.solve`, called with the other arguments, starts from.

    The list of candidates is most of the memory of a solve. A long list that does not serve the
    next point is left out, so that it can be freed before the next list is made.
    """
    last = state.continuation
    if not state.converged or last.candidates is None:
        return state
    if separation is None and pressure:
        separation = last.predicted_separation(pressure)
    if separation is None or len(last.candidates.index) < LARGE_LIST:
        return state
    kept = start_of(last, separation, pressure, tolerance).candidates
    last = last.without_contacts() if kept is None else replace(last, candidates=kept)
    none, no_contacts = np.empty(0, np.int64), Contacts(*np.empty((4, 0)))
    return replace(state, continuation=last, rows=none, contacts=no_contacts, tilt=np.empty((0, 2)))


def reached(
    last: Continuation, goal: float, tolerance: float, *, loaded: bool = False
) -> PopulationState:
    """State at the separation `goal` [m] or, if `loaded`, at the mean pressure `goal` [Pa].

    Without an earlier point under load a lighter one is solved first. Contacts that do not settle
    from the last point may do so from a point between. The solve starts from the continuation
    `last`; `tolerance` bounds the residual.
    """
    system = last.system
    first = system.interaction and not last.under_load
    crowded = system.parameters.limits.unsettled_area * system.nominal_area
    target = _before(last, goal, loaded) if first else goal
    for left in reversed(range(MAX_SOLVES)):
        if not left:  # the goal is then answered from the last point, as well as it can be
            target = goal
        guess = last.predicted_separation(target) if loaded else target
        if guess is None:
            guess = independent_separation(system, target)
        pressure = target if loaded else None
        found = solve_at(last, guess, tolerance, pressure, settled=left > 0)
        if found.converged:
            last = found.continuation
        elif found.contact_area <= crowded:
            target = _before(last, target, loaded)
            continue
        if target == goal:
            break
        target = goal
    return found


def _before(last: Continuation, target: float, loaded: bool) -> float:
    """A load [Pa] or separation [m] between the last point, or first touch, and the target."""
    if last.under_load:
        before = last.under_load[-1]
        return math.sqrt(target * before.pressure) if loaded else 0.5 * (target + before.separation)
    top = last.system.highest
    return LIGHTER_LOAD * target if loaded else top - LIGHTER_DEPTH * (top - target)


def independent(last: Continuation, pressure: float) -> PopulationState:
    """State of independent contacts at a mean pressure [Pa]."""
    separation = independent_separation(last.system, pressure)
    found = solve_at(last, separation, 0.0)
    missed = abs(found.mean_pressure / pressure - 1.0)
    if missed <= LOAD_TOLERANCE:
        return found
    return found.refused(
        f"the nearest separation misses the pressure of {pressure:g} Pa by {100 * missed:.2g} %"
    )


def _relief(system: ContactSystem) -> float:
    """Positive length [m] of the order of the height differences of the summits."""
    spread, level = float(np.ptp(system.height)), abs(system.highest)
    return spread or level or 1e-6 * math.sqrt(system.nominal_area)


def independent_separation(system: ContactSystem, pressure: float) -> float:
    """Separation [m] at which independent contacts carry the pressure [Pa]."""
    summits, height = system.by_height, system.height
    system.laws.rows(summits[:LEAST_BATCH]).make()  # a batch costs less than single laws

    def excess(separation: float) -> float:
        above = system.above(separation)
        laws = system.laws.rows(above)
        laws.make()
        return float(laws(height[above] - separation).force.sum()) / system.nominal_area - pressure

    # doubles the number of summits, not the depth: below one summit that stands far above the rest
    # the first step in depth could pass thousands of them
    high, end = system.highest, LEAST_BATCH
    width = 0.01 * _relief(system)
    low = float(height[summits[min(end, len(summits) - 1)]])
    for _ in range(MAX_DOUBLINGS):
        if excess(low) >= 0:
            return float(brentq(excess, low, high, xtol=1e-14 * (high - low)))
        high, end, width = low, 2 * end, 2 * width
        low = float(height[summits[end]]) if end < len(summits) else low - width
    return low
