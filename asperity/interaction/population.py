"""All summits of a surface under one plane: independent or elastically coupled."""

from __future__ import annotations

import math

from asperity.errors import InputError

from .contact_system import ContactSystem
from .continuation import Continuation
from .coupled_solve import solve_at
from .load_search import solve_under
from .population_state import PopulationState

__all__ = ["Population", "PopulationState"]

LARGEST_AREA = 0.5
"""Contact area over nominal area beyond which separate contacts have lost their meaning."""

SPREADING = 0.7
"""Power of the load with which the number of contacts grows (0.6 to 0.9 below 10 % of contact): of
the highest summits, so many, about nine in ten touch then."""


class Population(ContactSystem):
    """Summits that a flat is pressed on; parameters and attributes are those of `ContactSystem`.

    Notes
    -----
    Contact i has the approach d_i = z_i - s - u_i. The displacement u_i by all other contacts (and
    by the images of its own force in a periodic cell) is taken over the footprint of the contact:
    `asperity.interaction` has the formulation.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine(
    ...     (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
    ... )
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
    >>> state.converged, f"{state.force.sum() / hm.area:.1e}"
    (True, '4.6e+09')
    """

    def solve(
        self,
        *,
        separation: float | None = None,
        mean_pressure: float | None = None,
        state: PopulationState | None = None,
        tolerance: float = 2e-3,
        heaviest: float | None = None,
    ) -> PopulationState:
        """Contacts at a separation or at a mean pressure.

        Parameters
        ----------
        separation
            Distance of the flat from the mean plane [m].
        mean_pressure
            Load over nominal area [Pa], in place of the separation.
        state
            A state of this population at a near separation, to start from.
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
        if (separation is None) == (mean_pressure is None):
            raise InputError("give either separation or mean_pressure")
        if not tolerance > 0:
            raise InputError(f"tolerance must be positive, got {tolerance!r}")
        last = Continuation(self) if state is None else state.continuation
        self.laws.foresee(None)
        if separation is not None:
            found = solve_at(last, _finite(separation, "separation"), tolerance)
            return self._judged(found)
        pressure = _finite(mean_pressure, "mean_pressure")
        if pressure < 0:
            raise InputError(f"mean_pressure must not be negative, got {pressure:g} Pa")
        if heaviest is not None and state is not None and state.mean_pressure > 0:
            growth = heaviest / state.mean_pressure if heaviest > pressure else 0.0
            self.laws.foresee(self.by_height[: int(state.active * growth**SPREADING)])
        return self._judged(solve_under(last, pressure, tolerance, state))

    def _judged(self, state: PopulationState) -> PopulationState:
        share = state.contact_area / self.nominal_area
        if share > LARGEST_AREA:
            reason = (
                f"contacts fill {100 * share:.0f} % of the nominal area, more than the "
                f"{100 * LARGEST_AREA:.0f} % up to which separate contacts are a model"
            )
            return state.refused(reason)
        return state


def _finite(value: float | None, name: str) -> float:
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"{name} must be a finite number, got {value!r}")
    return number
