"""Contacts pushed aside by the slope of their neighbors' field."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .laws import Laws
from .operator import Interaction
from .state import State

__all__ = ["LARGEST_SHIFT", "deflection"]

LARGEST_SHIFT = 0.7
"""Bound of the shift over the contact radius: farther off the paraboloid is no guide."""


def deflection(laws: Laws, plan: Interaction, state: State) -> NDArray[np.float64]:
    """Height [m] that each contact gains by moving aside, shape (n,).

    Notes
    -----
    A force F_j tilts the surface at contact i: its displacement there is u + g.r. A paraboloid of
    radius of curvature R presses on a tilted plane as on a level one, but beside its summit, at
    -R g, and deeper by R g^2 / 2. In terms of energy every force gets one more freedom, its
    place: the pair energy gains -1/2 sum_i F_i R_i |g_i|^2, g_i = sum_j F_j grad G_ij. Its
    derivative by F_i is minus

        R_i |g_i|^2 / 2 - w_i,     w_i = sum_j p_j . grad_j G_ij,    p_j = -F_j R_j g_j,

    the gain of contact i and the field of the moments p_j by which the other forces have moved
    away from it. R is that of the contact at its present depth, R = a^2 / ((1+m) d) with the punch
    radius a of its stiffness, so that a filled basin moves less and less; the shift is bounded
    smoothly by `LARGEST_SHIFT` a. Moments act on heights, not on each other's gradients.
    """
    law, f = state.laws, plan.footprints
    p = f.power
    radius2 = (p * law.stiffness / (2 * f.modulus)) ** (2 / p)
    bend = np.divide(radius2, p * state.approach, out=np.zeros_like(radius2), where=law.force > 0)
    slope = plan.gradient(law.force, law.moment, law.growth)
    gain = 0.5 * bend * np.sum(slope * slope, axis=1)
    bound = 0.5 * LARGEST_SHIFT**2 * p * state.approach
    bounded = np.divide(bound, bound + gain, out=np.zeros_like(gain), where=law.force > 0)
    moment = -(law.force * bend * bounded)[:, None] * slope
    return np.asarray(gain * bounded - plan.dipoles(moment))
