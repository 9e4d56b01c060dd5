"""Contacts pushed aside by the slope of their neighbors' field."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asperity.halfspace.footprint import Footprints
from asperity.parameters import ContactShift

from . import _newton_kernels
from .laws import Evaluated

__all__ = ["contact_shifts", "widened"]


def contact_shifts(
    footprints: Footprints,
    law: Evaluated,
    approach: NDArray[np.float64],
    tilt: NDArray[np.float64],
    radii: NDArray[np.float64],
    largest: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Height [m] that each contact gains by moving aside, shape (n,), its shift [m], (n, 2), and
    its force times that [N m].

    The laws are those at the approaches [m], shape (n,); `tilt` is the gradient [-] of the
    displacement by all others, (n, 2); `radii` are radii of curvature yy, xx, xy over those of
    round contacts (`Elongation`), (n, 3); `largest` bounds the shift over the contact radius.

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
    smoothly by `largest` a. Moments act on heights, not on each other's gradients.
    """
    gain, (aside, moment) = np.empty(len(approach)), np.empty((2, len(approach), 2))
    body = footprints.modulus, footprints.power, largest
    tilt = np.ascontiguousarray(tilt)
    kernel: Any = _newton_kernels.shift_contacts
    kernel(law.force, law.stiffness, approach, tilt, radii, *body, gain, aside, moment)
    return gain, aside, moment


def widened(
    footprints: Footprints,
    law: Evaluated,
    approach: NDArray[np.float64],
    tilt: NDArray[np.float64],
    radii: NDArray[np.float64],
    outgrown: NDArray[np.bool_],
    fitted: ContactShift,
) -> NDArray[np.float64]:
    """Contact areas [m^2] beside the summits, shape (n,), wider where contacts have `outgrown` the
    paraboloid of their summit, shape (n,); other arguments are those of `contact_shifts`.

    Notes
    -----
    A paraboloid is as curved beside its summit as on it; a rough summit is flatter there, and the
    same force spreads further. To second order the growth is that of the square of the shift: of
    f = r^2/(2R) (1 - r^2/l^2) the mean curvature at distance s falls by 4 s^2/l^2, and with it the
    area rises by (8/3) s^2/l^2. Among contacts that have outgrown their expansion the scale l goes
    with the contact radius, and the growth was found from boundary elements, contact by contact:
    1.2 to 1.9 times the square for cut-offs from 4 to 16 pixels; on one surface 0.9 to 1, 1.3 to
    1.8 and 2.2 for m = -0.3, 0 and 0.3. It goes with (1 + m)^2: 1 + m times the shift over the
    radius is the fall of the field over the radius of the contact, over its approach.
    """
    _, aside, _ = contact_shifts(footprints, law, approach, tilt, radii, fitted.largest)
    square = math.pi * footprints.power**2 * np.sum(aside * aside, axis=1)
    share = np.divide(square, law.area, out=np.zeros(len(square)), where=outgrown & (square > 0.0))
    return np.asarray(law.area * (1.0 + fitted.growth * share))
