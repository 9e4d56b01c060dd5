"""Partial slip of a whole rough surface, from its normal contact curve alone."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from asperity.errors import InputError
from asperity.results.curve import ContactCurve, require_curve
from asperity.results.interpolation import SLACK

__all__ = ["FrictionCurve", "friction_curve"]


@dataclass(frozen=True, eq=False)
class FrictionCurve:
    """Tangential loading of a pressed surface, from rest towards gross slip.

    Attributes
    ----------
    displacement
        Relative tangential displacement [m], shape (n,), from 0 upwards.
    shear
        Tangential force over nominal area [Pa], shape (n,).
    stick_area_fraction
        Share of the nominal area that sticks [-], shape (n,).
    slip_shear
        Shear at gross slip, mu times the mean pressure [Pa].

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> curve = asperity.contact_curve(hm, steel, pressures=[1e7, 1e8, 1e9])
    >>> slip = asperity.friction_curve(curve, 1e9, friction=0.3, modulus_ratio=1.2)
    >>> bool(slip.stick_area_fraction[0] > slip.stick_area_fraction[-1])
    True
    """

    displacement: NDArray[np.float64]
    shear: NDArray[np.float64]
    stick_area_fraction: NDArray[np.float64]
    slip_shear: float


def friction_curve(
    curve: ContactCurve,
    mean_pressure: float,
    *,
    friction: float,
    modulus_ratio: float,
    points: int = 50,
) -> FrictionCurve:
    """Shear against tangential displacement at constant normal load.

    Parameters
    ----------
    curve
        Normal contact curve that reaches from light load to `mean_pressure`.
    mean_pressure
        Normal load over nominal area [Pa].
    friction
        Coefficient of friction mu, positive.
    modulus_ratio
        E*/G* of the bodies, see `asperity.extensions.partial_slip.tangential_modulus`.
    points
        Number of points; the last has the lightest load of the curve as its stick region.

    Raises
    ------
    InputError
        If an argument is out of range, or the curve does not begin below `mean_pressure` or does
        not reach it.

    Notes
    -----
    ``tau = mu [p(s) - p(s*)]``, ``u_x = mu (E*/G*) (s* - s)``: the stick region is the contact at
    the larger separation s* (Ciavarella 1998, Jaeger 1998, for any set of contacts on elastically
    similar half-spaces). One loading from rest, constant mu, homogeneous bodies.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> curve = asperity.contact_curve(hm, steel, pressures=[1e7, 1e8, 1e9])
    >>> slip = asperity.friction_curve(curve, 1e9, friction=0.3, modulus_ratio=1.2)
    >>> f"{slip.slip_shear:.1e}"
    '3.0e+08'
    """
    require_curve(curve)
    given = friction, modulus_ratio, mean_pressure, points
    if not all(isinstance(value, Real) and 0 < float(value) < np.inf for value in given):
        raise InputError(
            f"friction, modulus_ratio, mean_pressure and points are {given}; give positive numbers"
        )
    if points < 2 or points != int(points):
        raise InputError(f"points is {points}; give a whole number, at least 2")
    if curve.settings.get("m", 0.0) != 0.0:
        raise InputError("partial slip needs homogeneous half-spaces, m = 0")
    whole = curve.at(pressure=mean_pressure)
    lightest = float(curve.mean_pressure[curve.converged & (curve.mean_pressure > 0)].min())
    if not lightest < (1 - SLACK) * mean_pressure:
        raise InputError(
            f"the curve begins at {lightest:.4g} Pa, not below {mean_pressure:.4g} Pa; "
            "partial slip needs lighter load points as well"
        )
    share = np.linspace(0.0, 1.0, int(points))
    asked = mean_pressure * (lightest / mean_pressure) ** share
    stick = curve.at(pressure=asked)
    return FrictionCurve(
        displacement=friction * modulus_ratio * (stick.separation - whole.separation),
        shear=friction * (mean_pressure - asked),
        stick_area_fraction=stick.area_fraction,
        slip_shear=friction * mean_pressure,
    )
