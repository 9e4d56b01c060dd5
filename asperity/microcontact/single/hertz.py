"""Law "hertz" of one contact: the paraboloid of its summit."""

from __future__ import annotations

import numpy as np

from asperity.errors import ModelRangeError
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.hertz import elliptic_contact
from surfaces.arrays import Array
from surfaces.polar import PolarProfile, PowerSumProfile

from . import circle
from .basis import PowerBasis, basis_of
from .indentation import Indentation, profile_flags

__all__ = ["indent"]


def indent(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, approach: Array
) -> Indentation:
    """Hertz contact of the curvatures at the summit; see `asperity.indent`."""
    k1, k2, along = _summit(profile, material.m)
    depth = np.maximum(approach, 0.0)
    contact = elliptic_contact(k1, k2, depth, material)
    major, minor = contact.semi_major, contact.semi_minor

    def contour(phi: Array) -> Array:
        turn = phi - along
        ratio = major / np.where(minor > 0, minor, 1.0)
        return major[:, None] / np.hypot(np.cos(turn), ratio[:, None] * np.sin(turn))

    def pressure(r: Array, phi: Array) -> Array:
        edge = contour(phi)
        rho = np.minimum(r / np.where(edge > 0, edge, 1.0), 1.0)
        inside = np.where(edge > 0, (1 - rho) * (1 + rho), 0.0)
        return np.asarray(contact.peak_pressure[:, None] * inside ** ((1 + material.m) / 2))

    phi = 2 * np.pi * np.arange(180) / 180
    return Indentation(
        law="hertz",
        material=material,
        approach=approach,
        force=contact.force,
        contact_area=np.asarray(np.pi * major * minor),
        radius=np.sqrt(major * minor),
        stiffness=contact.stiffness,
        flags=profile_flags(profile, depth, phi, contour(phi)),
        error_estimate=_difference(profile, material, depth, contact.force),
        contour_function=contour,
        pressure_function=pressure,
    )


def _difference(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, depth: Array, force: Array
) -> Array:
    """Relative difference of the force to the harmonic-resolved law, plus what that errs by.

    NaN where that law has no solution.
    """
    one = circle.indent(profile, material, depth, law="harmonic")
    touching = depth > 0
    change = np.abs(force - one.force) / np.where(touching, one.force, 1.0)
    return np.asarray(np.where(touching, change + one.error_estimate, 0.0))


def _summit(profile: PowerSumProfile | PolarProfile, m: float) -> tuple[float, float, float]:
    """Principal curvatures [1/m] at the summit, largest first, and the long axis [rad]."""
    basis = basis_of(profile, m)
    if isinstance(basis, PowerBasis):
        present = (basis.means != 0) | np.any(basis.harmonics != 0, axis=1)
        lowest = np.min(basis.powers[present], initial=np.inf)
        if np.any(present) and lowest != 2:
            raise ModelRangeError(
                f"the summit grows as r^{lowest:g}, not as r^2: it has no curvature for the law "
                "'hertz'; use 'harmonic'"
            )
        first = present & (basis.powers == 2)
        mean, wave = basis.means[first].sum(), basis.harmonics[first, 1].sum()
    else:
        mean, wave = basis.summit()
    high, low = 2 * (mean + abs(wave)), 2 * (mean - abs(wave))
    if not low > 0:
        raise ModelRangeError("the summit is a saddle or flat; the law 'hertz' needs a convex one")
    return float(high), float(low), float((np.pi - np.angle(wave)) / 2)
