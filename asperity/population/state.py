"""The contacts of a population at one separation."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .trail import Trail

__all__ = ["PopulationState"]


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
        Number of closed contacts.
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
    """

    separation: float
    approach: NDArray[np.float64]
    force: NDArray[np.float64]
    stiffness: NDArray[np.float64]
    area: NDArray[np.float64]
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
    _trail: Trail = field(repr=False)
    _answer: Callable[[], tuple[float, NDArray[np.float64]]] = field(repr=False)

    @functools.cached_property
    def _answered(self) -> tuple[float, NDArray[np.float64]]:
        return self._answer()

    @property
    def normal_stiffness(self) -> float:
        """Minus the slope of mean pressure over separation [Pa/m], by the tangent matrix."""
        return self._answered[0]

    @property
    def response(self) -> NDArray[np.float64]:
        """Approach that each contact gains per fall of the flat [-], shape (n,)."""
        gained = np.ones(len(self.force))
        if self._trail.points:
            gained[self._trail.points[-1].rows] = self._answered[1]
        return gained
