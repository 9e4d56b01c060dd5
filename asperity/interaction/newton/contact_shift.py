"""Contact shift: the slope of the neighbors' field moves a contact beside its summit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from asperity.halfspace.footprint import Footprints
from asperity.parameters import ContactShift
from surfaces.arrays import Array, Mask

from . import _newton_kernels
from .laws import Evaluated

__all__ = ["contact_shifts", "widened"]


def contact_shifts(
    footprints: Footprints,
    law: Evaluated,
    approach: Array,
    tilt: Array,
    radii: Array,
    largest: float,
) -> tuple[Array, Array, Array]:
    """Gain, shift and moment of each contact.

    Parameters
    ----------
    law, approach
        Laws at the approaches [m], shape (n,).
    tilt
        Gradient g [-] of the displacement of each contact by all others, shape (n, 2).
    radii
        Radii of curvature yy, xx, xy over those of round contacts (`Elongation`), shape (n, 3).
    largest
        Bound on the shift over the contact radius.

    Returns
    -------
    gain, shift, moment
        Height [m] that each contact gains by its shift, (n,), the shift [m], (n, 2), and the force
        times the shift [N m], (n, 2).

    Notes
    -----
    A force F_j tilts the surface at contact i: the displacement there is u + g.r. A paraboloid of
    radius of curvature R on the tilted plane has the contact of a level plane, but at -R g beside
    its summit, and deeper by R g^2 / 2. The position of every force is therefore one more freedom:
    the pair energy gains -1/2 sum_i F_i R_i |g_i|^2, g_i = sum_j F_j grad G_ij. Minus the
    derivative of this term by F_i is

        R_i |g_i|^2 / 2 - w_i,     w_i = sum_j p_j . grad_j G_ij,    p_j = -F_j R_j g_j,

    the gain of contact i, less the field of the moments p_j by which the other forces have moved
    away from it. R = a^2 / ((1+m) d) holds at the present approach d, with the punch radius a of
    the stiffness: the shift of a filled basin falls as d grows. `largest` a bounds the shift
    smoothly. Moments change heights, not the gradients of other contacts.
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
    approach: Array,
    tilt: Array,
    radii: Array,
    outgrown: Mask,
    fitted: ContactShift,
) -> Array:
    """Contact areas [m^2], shape (n,), of shifted contacts under their forces.

    The area grows for contacts that have `outgrown` the paraboloid of their summit, shape (n,);
    other arguments are those of `contact_shifts`.

    Notes
    -----
    A paraboloid is as curved beside its summit as on it. A rough summit is flatter beside its
    highest point, and a force spreads further there: on f = r^2/(2R) (1 - r^2/l^2) the mean
    curvature at the distance s is smaller by 4 s^2/l^2, and the area of a given force larger by
    (8/3) s^2/l^2. For contacts that have outgrown their expansion l is taken in proportion to the
    contact radius a: A' = A (1 + c (1 + m)^2 s^2/a^2). Boundary elements, contact by contact, give
    c = 1.2 to 1.9 for cut-offs from 4 to 16 pixels, and on one surface c (1 + m)^2 = 0.9 to 1, 1.3
    to 1.8 and 2.2 for m = -0.3, 0 and 0.3. The power of 1 + m follows from the tilt: (1 + m) s/a is
    a |g| / d, the difference of the field over the contact radius over the approach.
    """
    _, aside, _ = contact_shifts(footprints, law, approach, tilt, radii, fitted.largest)
    square = math.pi * footprints.power**2 * np.sum(aside * aside, axis=1)
    share = np.divide(square, law.area, out=np.zeros(len(square)), where=outgrown & (square > 0.0))
    return np.asarray(law.area * (1.0 + fitted.growth * share))
