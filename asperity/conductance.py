"""Electrical and thermal constriction conductance from the contact curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .results import ContactCurve

__all__ = ["constriction_conductance"]


def constriction_conductance(
    curve: ContactCurve, *, modulus: float, resistivity: tuple[float, float]
) -> NDArray[np.float64]:
    """Conductance of the interface per nominal area at each load point.

    Parameters
    ----------
    curve
        Contact curve with its stiffness.
    modulus
        Composite modulus E* [Pa] that the curve was made with (homogeneous bodies).
    resistivity
        Resistivities of both bodies: [Ohm m] gives [S/m^2], thermal [m K/W] gives [W/(m^2 K)].

    Returns
    -------
    Conductance per nominal area, shape (n,).

    Raises
    ------
    InputError
        If the curve was made for a graded half-space or a number is not positive.

    Notes
    -----
    The incremental contact problem and the constriction of a current through the same spots are
    the same potential problem (Barber 2003): ``C = 2 k / (E* (rho_1 + rho_2))`` with the
    normal stiffness k. One circular spot gives Holm's ``4 a / (rho_1 + rho_2)``.
    """
    if curve.settings.get("m", 0.0) != 0.0:
        raise InputError("the conductance analogy holds for homogeneous half-spaces, m = 0")
    total = float(sum(resistivity))
    if not (modulus > 0 and min(resistivity) >= 0 and total > 0 and np.isfinite(total)):
        raise InputError("modulus and the sum of the resistivities must be positive and finite")
    return 2.0 * curve.stiffness / (modulus * total)
