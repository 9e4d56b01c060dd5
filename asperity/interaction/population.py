"""All summits of a surface under one plane: independent or elastically coupled."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from asperity.errors import InputError
from asperity.interaction.newton.laws import LEAST_BATCH
from surfaces.errors import as_number

from .contact_system import ContactSystem
from .coupled_solve import CROWDED_AREA, solve_at, start_of
from .population_state import Continuation, PopulationState

__all__ = ["Population", "PopulationState", "handed_on"]

LARGEST_AREA_FRACTION = 0.5
"""Area fraction beyond which a point is refused: separate contacts no longer describe the surface.
"""

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
one than in a curve, up to 0.5 of the stated error in load away, 1.3 at a separation. From these
shares the differences were 0.17 at most, in less time."""

MAX_SEARCH = 40
"""Separations tried to reach a mean pressure."""

SEARCH_TOLERANCE = 5e-3
"""Largest tolerance of a solve in the search for a mean pressure."""

LOAD_TOLERANCE = 1e-3
"""Relative error of the load at which the search ends. If rounding of the heights does not allow
that, half the tolerance of the solve is accepted."""

INDEPENDENT_LOAD_TOLERANCE = 1e-6
"""`LOAD_TOLERANCE` of independent contacts, whose steps cost no field."""


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
            If not just one of separation and mean pressure is given, or a number cannot be used.
        """
        if (separation is None) == (pressure is None):
            raise InputError("give either separation or pressure")
        if not as_number("tolerance", tolerance) > 0:
            raise InputError(f"tolerance must be positive, got {tolerance!r}")
        if separation is not None:
            separation = as_number("separation", separation)
            if not math.isfinite(separation):
                raise InputError(f"separation must be finite, got {separation!r} m")
        if pressure is not None:
            pressure = as_number("pressure", pressure)
            if not 0 <= pressure < math.inf:
                raise InputError(f"pressure must be finite and not negative, got {pressure:g} Pa")
        self.laws.foresee(None)
        if state is None and self.interaction:
            state = self._lighter(separation, pressure, tolerance)
        last = Continuation(self) if state is None else state.continuation
        if pressure is None:
            assert separation is not None
            return self._judged(solve_at(last, separation, tolerance))
        if heaviest is not None and state is not None and state.mean_pressure > 0:
            growth = heaviest / state.mean_pressure if heaviest > pressure else 0.0
            self.laws.foresee(self.by_height[: int(state.active * growth**CONTACTS_EXPONENT)])
        return self._judged(solve_under(last, pressure, tolerance, state))

    def _lighter(
        self, separation: float | None, pressure: float | None, tolerance: float
    ) -> PopulationState | None:
        """A state at a lighter load, to start from; None if nothing touches there, or if it did not
        converge."""
        nothing = Continuation(self)
        if pressure is not None:
            found = solve_under(nothing, LIGHTER_LOAD * pressure, tolerance, None)
        else:
            assert separation is not None
            depth = LIGHTER_DEPTH * (self.highest - separation)
            found = solve_at(nothing, self.highest - depth, tolerance)
        return found if found.converged and found.mean_pressure > 0 else None

    def _judged(self, state: PopulationState) -> PopulationState:
        share = state.contact_area / self.nominal_area
        if share > LARGEST_AREA_FRACTION:
            reason = (
                f"contacts fill {100 * share:.0f} % of the nominal area, more than the "
                f"{100 * LARGEST_AREA_FRACTION:.0f} % up to which separate contacts are a model"
            )
            return state.refused(reason)
        return state


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
    # a search for nearly the same pressure may return this state itself
    alike = pressure is not None and abs(state.mean_pressure - pressure) <= tolerance * pressure
    if not state.converged or alike or last.candidates is None:
        return state
    if separation is None and pressure:
        separation = last.predicted_separation(pressure)
    if separation is None or len(last.candidates.index) < LARGE_LIST:
        return state
    kept = start_of(last, separation, pressure, tolerance).candidates
    last = last.without_contacts() if kept is None else replace(last, candidates=kept)
    none = np.empty(0, np.int64)
    return replace(
        state, continuation=last, rows=none, listed=np.empty((4, 0)), tilt=np.empty((0, 2))
    )


def solve_under(
    last: Continuation, pressure: float, tolerance: float, state: PopulationState | None
) -> PopulationState:
    """State at a mean pressure [Pa].

    The Newton steps of coupled contacts have the separation as one more unknown. Where they fail,
    and for independent contacts, the separation is searched for. The solve starts from the
    continuation `last`, the search from the last `state`, if there is one; `tolerance` bounds the
    residual.
    """
    system = last.system
    if pressure == 0:
        return solve_at(last, system.highest, tolerance)
    if not system.interaction:
        return _searched(last, pressure, tolerance, state)
    guess = last.predicted_separation(pressure)
    if guess is None:
        guess = _independent_separation(system, pressure)
    found = solve_at(last, guess, tolerance, pressure)
    if found.converged or found.contact_area > CROWDED_AREA * system.nominal_area:
        return found
    searched = _searched(last, pressure, tolerance, state)
    return searched if searched.converged or searched.residual < found.residual else found


def _searched(
    last: Continuation, pressure: float, tolerance: float, state: PopulationState | None
) -> PopulationState:
    """State at a mean pressure [Pa], by a Newton iteration over the separation for the logarithm of
    the mean pressure, safeguarded by bisection. Arguments as in `solve_under`."""
    system = last.system
    top = system.highest
    tolerance = min(tolerance, SEARCH_TOLERANCE)  # no last Newton step reduces the residual here
    low, high, step = -math.inf, top, 0.1 * _relief(system)
    if state is None or not state.mean_pressure > 0:
        state = solve_at(last, _independent_separation(system, pressure), tolerance)
    bound = LOAD_TOLERANCE if system.interaction else INDEPENDENT_LOAD_TOLERANCE
    best, least = state, math.inf
    for _ in range(MAX_SEARCH):
        if not state.converged:
            return state
        error = math.log(state.mean_pressure / pressure) if state.mean_pressure > 0 else -1e3
        if abs(error) < least and state.residual <= tolerance:
            best, least = state, abs(error)
        if least <= bound:
            return best
        here = state.separation
        # within its residual a pressure does not tell on which side of the wanted one it lies
        if abs(error) > 5 * state.residual:
            low, high = (here, high) if error > 0 else (low, min(high, here))
        guess = high - step
        if state.mean_pressure > 0:
            guess = here + error * state.mean_pressure / state.normal_stiffness
        if not low < guess < high:
            guess = 0.5 * (low + high) if math.isfinite(low) else high - step
        step *= 2
        # far from the wanted pressure a rough solve is enough
        rough = SEARCH_TOLERANCE if abs(error) > 10 * SEARCH_TOLERANCE else tolerance
        state = solve_at(state.continuation, guess, rough)
    if least <= 0.5 * tolerance:  # rounding of the heights allows no smaller error
        return best
    return state.refused(
        f"{MAX_SEARCH} separations did not bring the mean pressure to {pressure:g} Pa"
    )


def _relief(system: ContactSystem) -> float:
    """Positive length [m] of the order of the height differences of the summits."""
    spread, level = float(np.ptp(system.height)), abs(system.highest)
    return spread or level or 1e-6 * math.sqrt(system.nominal_area)


def _independent_separation(system: ContactSystem, pressure: float) -> float:
    """Separation [m] at which independent contacts would carry the pressure [Pa], within a few per
    cent."""
    summits, height = system.by_height, system.height
    system.laws.rows(summits[:LEAST_BATCH]).make()  # a batch costs less than single laws

    def carried(separation: float) -> float:
        above = system.above(separation)
        laws = system.laws.rows(above)
        laws.make()
        return float(laws(height[above] - separation).force.sum()) / system.nominal_area

    # doubles the number of summits, not the depth: below one summit that stands far above the rest
    # the first step in depth could pass thousands of them
    high, end = system.highest, LEAST_BATCH
    width = 0.01 * _relief(system)
    low = float(height[summits[min(end, len(summits) - 1)]])
    for _ in range(MAX_DOUBLINGS):
        if not carried(low) < pressure:
            break
        high, end, width = low, 2 * end, 2 * width
        low = float(height[summits[end]]) if end < len(summits) else low - width
    for _ in range(8):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if carried(middle) > pressure else (low, middle)
    return 0.5 * (low + high)
