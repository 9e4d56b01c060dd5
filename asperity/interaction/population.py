"""All summits of a surface under one plane: independent or elastically coupled."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.errors import InputError
from asperity.halfspace.boundary import known_boundary
from asperity.interaction.newton.laws import Laws
from asperity.microcontact.lazy_table import GrowingTable

from .candidates import Falling
from .continuation import Trail
from .elongation import Elongation
from .footprint import Footprints
from .population_state import PopulationState

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.microcontact.law_table import LawTable

__all__ = ["Population", "PopulationState"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

LARGEST_AREA = 0.5
"""Contact area over nominal area beyond which separate contacts have lost their meaning."""

SPREADING = 0.7
"""Power of the load with which the number of contacts grows (0.6 to 0.9 below 10 % of contact): of
the highest summits, so many, about nine in ten touch then."""


class Population:
    """Summits with their laws, their places and the body that couples them.

    Parameters
    ----------
    x, y
        Places of the summits [m], shape (n,).
    height
        Heights [m] above the mean plane of the map, shape (n,).
    table
        Contact laws of the summits, or a growing table that makes those that are needed.
    cell
        Nominal area (Ly, Lx) [m].
    boundary
        "periodic" or "free".
    material
        Elastic half-space.
    interaction
        False: the classical sum of independent contacts.
    deflection
        Whether coupled contacts stand at the centres that their laws give, and move aside under
        the slope of their neighbors' field; otherwise they stay at their summits.
    curvature, angle
        Principal curvatures [1/m], (n, 2), the larger first, and directions of the long axis [rad],
        (n,), of the summits; round footprints if not given.

    Raises
    ------
    InputError
        If lengths disagree or a value is not usable.

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

    def __init__(
        self,
        *,
        x: ArrayLike,
        y: ArrayLike,
        height: ArrayLike,
        table: LawTable | GrowingTable,
        cell: tuple[float, float],
        boundary: str,
        material: HalfSpace,
        interaction: bool = True,
        deflection: bool = True,
        curvature: ArrayLike | None = None,
        angle: ArrayLike | None = None,
    ) -> None:
        self.x, self.y, self.height = (
            _column(value, name) for value, name in ((x, "x"), (y, "y"), (height, "height"))
        )
        rows = len(table) if isinstance(table, GrowingTable) else len(table.reach)
        if not len(self.x) == len(self.y) == len(self.height) == rows:
            raise InputError(
                f"x, y, height and table have {len(self.x)}, {len(self.y)}, {len(self.height)} "
                f"and {rows} rows; they must agree"
            )
        if len(self.x) == 0:
            raise InputError("the population has no summit; lower the height to segment above")
        if not (len(cell) == 2 and min(cell) > 0 and math.isfinite(max(cell))):
            raise InputError(f"cell must be two positive lengths, got {cell!r}")
        self.boundary, self.material = known_boundary(boundary), material
        self._table = table
        self.cell = (float(cell[0]), float(cell[1]))
        self.interaction = interaction and (boundary == "periodic" or len(self.height) > 1)
        self.deflection = deflection
        self.footprints = Footprints(material.modulus, material.m)
        self.elongation: Elongation | None = None
        if curvature is not None and angle is not None:
            self.elongation = Elongation.of(
                np.asarray(curvature, float), np.asarray(angle, float), self.footprints
            )
        self.laws = Laws(table, self.footprints)
        usable = np.flatnonzero(self.laws.usable)
        if len(usable) == 0:
            raise InputError("no summit of the population has a usable contact law")
        self.falling = usable[np.argsort(-self.height[usable], kind="stable")]
        places = self.y[self.falling], self.x[self.falling]
        self.fallen = Falling(self.falling, *places, -self.height[self.falling])

    def __len__(self) -> int:
        return len(self.height)

    @property
    def table(self) -> LawTable:
        """Contact laws of the summits; of a growing table, those made so far."""
        return self._table.table if isinstance(self._table, GrowingTable) else self._table

    @property
    def centred(self) -> bool:
        """Whether contacts stand at the centres that their laws give."""
        return self.deflection and getattr(self.table, "centre", None) is not None

    @property
    def nominal_area(self) -> float:
        """Area of the cell [m^2]."""
        return self.cell[0] * self.cell[1]

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
        trail = Trail(self) if state is None else state._trail
        self.laws.foresee(None)
        if separation is not None:
            return self._judged(trail.at(_finite(separation, "separation"), tolerance))
        pressure = _finite(mean_pressure, "mean_pressure")
        if pressure < 0:
            raise InputError(f"mean_pressure must not be negative, got {pressure:g} Pa")
        if heaviest is not None and state is not None and state.mean_pressure > 0:
            growth = heaviest / state.mean_pressure if heaviest > pressure else 0.0
            self.laws.foresee(self.falling[: int(state.active * growth**SPREADING)])
        return self._judged(trail.under(pressure, tolerance, state))

    def _judged(self, state: PopulationState) -> PopulationState:
        share = state.contact_area / self.nominal_area
        if share > LARGEST_AREA:
            reason = (
                f"contacts fill {100 * share:.0f} % of the nominal area, more than the "
                f"{100 * LARGEST_AREA:.0f} % up to which separate contacts are a model"
            )
            return replace(state, converged=False, reason=reason)
        return state


def _column(value: ArrayLike, name: str) -> NDArray[np.float64]:
    array = np.ascontiguousarray(value, dtype=float)
    if array.ndim != 1:
        raise InputError(f"{name} must be one-dimensional, got shape {array.shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{name} holds values that are not finite")
    return array


def _finite(value: float | None, name: str) -> float:
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"{name} must be a finite number, got {value!r}")
    return number
