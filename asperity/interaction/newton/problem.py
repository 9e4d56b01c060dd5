"""The coupled problem: contacts that may close, their laws and their interaction."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.elongation import Elongation
from asperity.interaction.ewald.operator import Interaction

from .laws import Laws

__all__ = ["Problem"]


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
        """The problem with round footprints of `some` contacts, shape (n,): long footprints can
        overlap so far that their approximate sum has no solution."""
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
