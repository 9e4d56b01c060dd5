"""The contacts of a population at one separation."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .continuation import Continuation

__all__ = ["PopulationState"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PopulationState:
    """Contacts of a population at one separation.

    Attributes
    ----------
    separation
        Distance of the rigid flat from the mean plane [m]: of the deformed surface for a periodic
        cell (mean gap), of the surface at rest for a free half-space.
    approach, force, stiffness, area
        Of each summit [m], [N], [N/m], [m^2], shape (n,); zero where it is open.
    mean_pressure
        Load over nominal area [Pa].
    contact_area
        Sum of the contact areas [m^2].
    active
        Number of contacts that carry load.
    filled_share
        Share of the load on contacts that cover more than half of their basin [-].
    residual
        Upper estimate of the relative error of the load by incomplete solution [-].
    converged, reason
        Whether the point can be used, and one sentence if it cannot.
    iterations, products
        Newton steps and applications of the interaction.
    lowest_candidate
        Height [m] above which a summit can touch in the field of the others.
    rows, listed
        Summits that were candidates, shape (k,), and approach, force, stiffness and area of each,
        shape (4, k).
    tilt
        Gradients [-] of the displacement of each candidate by all others, along y and x, (k, 2).
    continuation
        What the next solve starts from.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> run = asperity.solve_contacts(hm, steel, pressures=[1e8])
    >>> state = run.points[0].state
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
    products: int
    lowest_candidate: float
    rows: NDArray[np.int64] = field(repr=False)
    listed: Array = field(repr=False)
    tilt: Array = field(repr=False)
    continuation: Continuation = field(repr=False)

    def refused(self, reason: str) -> PopulationState:
        """The state, marked as one that cannot be used."""
        return replace(self, converged=False, reason=reason)

    @functools.cached_property
    def approach(self) -> Array:
        """Approaches [m] of all summits."""
        return self._of_all(0)

    @functools.cached_property
    def force(self) -> Array:
        """Forces [N] of all summits."""
        return self._of_all(1)

    @functools.cached_property
    def stiffness(self) -> Array:
        """Stiffnesses [N/m] of all summits."""
        return self._of_all(2)

    @functools.cached_property
    def area(self) -> Array:
        """Contact areas [m^2] of all summits."""
        return self._of_all(3)

    def _of_all(self, column: int) -> Array:
        values = np.zeros(len(self.continuation.system))
        values[self.rows] = self.listed[column]
        return values

    @property
    def normal_stiffness(self) -> float:
        """Minus the slope of mean pressure over separation [Pa/m], by the tangent matrix."""
        return self.continuation.normal_stiffness

    @property
    def response(self) -> Array:
        """Approach that each contact gains per fall of the flat [-], shape (n,)."""
        return self.continuation.response
