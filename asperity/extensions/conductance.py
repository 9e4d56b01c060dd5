"""Electrical and thermal constriction conductance from the contact curve."""

from __future__ import annotations

import numpy as np

from asperity.errors import InputError, cautious
from asperity.results.curve import ContactCurve
from asperity.results.interface_law import warn_of_free_punch
from asperity.results.table import require_curve
from surfaces.arrays import Array
from surfaces.errors import as_positive, as_sizes

__all__ = ["constriction_conductance", "total_resistivity"]


@cautious
def constriction_conductance(
    curve: ContactCurve, *, resistivity: tuple[float, float], modulus: float | None = None
) -> Array:
    """Conductance of the interface per nominal area at each load point.

    Parameters
    ----------
    curve
        Contact curve with its stiffness.
    resistivity
        Resistivities of both bodies: [Ohm m] gives [S/m^2], thermal [m K/W] gives [W/(m^2 K)].
    modulus
        Composite modulus E* [Pa] of the curve, where its settings do not state it.

    Returns
    -------
    Conductance per nominal area, shape (n,); NaN where a point did not converge.

    Raises
    ------
    InputError
        If the curve was made for a graded half-space, the modulus is not positive, or of the
        resistivities one is negative or both are zero.

    Notes
    -----
    The incremental contact problem and the constriction of a current through the same spots are
    the same potential problem (Barber 2003): ``C = 2 k / (E* (rho_1 + rho_2))`` with the
    normal stiffness k of spots that keep their size. One circular spot gives Holm's
    ``4 a / (rho_1 + rho_2)``. Contacts that have yielded keep it as the load begins to fall: of a
    curve with a hardness k is its column `unloading_stiffness`. That of a free map holds the
    spreading under the whole map too: a warning says how much.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> curve = asperity.contact_curve(hm, steel, pressures=[1e8, 1e9])
    >>> found = asperity.constriction_conductance(curve, resistivity=(1e-7, 1e-7))
    >>> bool(0 < found[0] < found[1])
    True
    """
    require_curve(curve)
    if curve.settings.get("m", 0.0) != 0.0:
        raise InputError("the conductance analogy holds for homogeneous half-spaces, m = 0")
    if modulus is None:
        modulus = curve.settings.get("modulus")
    modulus = as_positive("the composite modulus", modulus)
    stiffness = curve.stiffness
    if curve.settings.get("hardness", np.inf) < np.inf:
        if "unloading_stiffness" not in curve.extra:
            raise InputError(
                "the curve does not tell how spots that have yielded answer a falling load: it is "
                "from an older version; make it anew"
            )
        stiffness = curve.extra["unloading_stiffness"]
    warn_of_free_punch(curve, stiffness, "resistance")
    return np.asarray(2.0 * stiffness / (modulus * total_resistivity(resistivity)))


def total_resistivity(resistivity: tuple[float, float]) -> float:
    """Sum of the resistivities of both bodies, checked."""
    both = as_sizes("resistivity", resistivity)
    if both.shape != (2,):
        raise InputError(f"resistivity is {resistivity!r}; give one number for each of two bodies")
    total = float(both.sum())
    if not (both.min() >= 0 and total > 0):
        raise InputError("resistivities must not be negative, their sum positive")
    return total
