"""Partial slip under constant friction (Jaeger-Ciavarella superposition).

Of one contact, and of a whole rough surface from its normal contact curve alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import InputError, ModelRangeError
from asperity.halfspace.material import HalfSpace, require_half_space
from asperity.microcontact.single.indent import indent
from asperity.microcontact.single.indentation import Indentation
from asperity.results.curve import ContactCurve
from asperity.results.interpolation import END_SLACK
from asperity.results.table import require_curve
from surfaces.arrays import Array, Mask
from surfaces.errors import as_count, as_positive, as_sizes
from surfaces.polar import PolarProfile, PowerSumProfile

__all__ = ["FrictionCurve", "PartialSlip", "friction_curve", "partial_slip", "tangential_modulus"]


ELASTIC_ALONE = "partial slip is of elastic contacts alone; leave the hardness out"


def tangential_modulus(first: HalfSpace, second: HalfSpace | None = None) -> float:
    """G* [Pa] with ``1/G* = (2-nu_1)/(4 G_1) + (2-nu_2)/(4 G_2)``; a missing body is rigid.

    Raises
    ------
    InputError
        If E and nu of a body are not known, or the body is graded.

    Examples
    --------
    >>> import asperity
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> f"{steel.modulus / asperity.tangential_modulus(steel):.3f}"
    '1.214'
    """
    total = 0.0
    for body in (first, second) if second is not None else (first,):
        require_half_space(body)
        if body.E is None or body.nu is None:
            raise InputError("the tangential modulus needs E and nu of each body")
        if body.m != 0:
            raise InputError("the tangential modulus of a graded body is not known")
        shear = body.E / (2 * (1 + body.nu))
        total += (2 - body.nu) / (4 * shear)
    return 1 / total


@dataclass(frozen=True, eq=False)
class PartialSlip:
    """State of a contact pressed by d and then pushed sideways, at one or several pushes.

    Attributes
    ----------
    full, stick
        Normal solutions at the approach d (one) and at the approaches d* whose contact areas are
        the stick regions (one per push).
    friction
        Coefficient of friction.
    tangential_force
        F_x [N]; mu F_N at gross slip.
    displacement
        Tangential displacement u_x [m]; NaN at gross slip, where it is not determined.
    slipping
        True at gross slip.

    Examples
    --------
    >>> import asperity, surfaces
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> ball = surfaces.PowerLawProfile(2.0, 50.0)
    >>> push = asperity.partial_slip(
    ...     ball, steel, 1e-6, friction=0.3, modulus_ratio=1.2, tangential_force=1.0
    ... )
    >>> bool(0.0 < push.stick_area < push.full.contact_area)
    True
    """

    full: Indentation
    stick: Indentation
    friction: float
    tangential_force: Array
    displacement: Array
    slipping: Mask

    @property
    def stick_area(self) -> Array:
        """Area [m^2] of the stick region."""
        return self.stick.contact_area

    def traction(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Tangential traction [Pa] at points, shape `(*pushes, *points.shape)`."""
        whole = self.full.pressure(x, y)
        inner = self.stick.pressure(x, y)
        return np.asarray(self.friction * (whole - inner))


def partial_slip(
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    approach: float,
    *,
    friction: float,
    modulus_ratio: float,
    displacement: ArrayLike | None = None,
    tangential_force: ArrayLike | None = None,
    law: str = "harmonic",
) -> PartialSlip:
    """Push a pressed contact sideways, from rest, by a displacement or a force.

    Parameters
    ----------
    profile, material, approach, law
        Normal contact, see `asperity.indent`; the half-space must be homogeneous.
    friction
        Coefficient of friction mu, positive.
    modulus_ratio
        E*/G*, see `tangential_modulus`.
    displacement, tangential_force
        u_x [m] or F_x [N], one of them, non-negative.

    Returns
    -------
    PartialSlip

    Raises
    ------
    InputError
        If the arguments are out of range, or the body is graded.
    ModelRangeError
        If the force is above mu F_N, or the law has no solution at this approach.

    Notes
    -----
    ``tau = mu [p(d) - p(d*)]``, ``F_x = mu [F(d) - F(d*)]``, ``u_x = mu (E*/G*) (d - d*)``.
    One loading from rest, elastically similar bodies (or one rigid and nu = 1/2), constant mu.
    For nu that differ, or spots that are not round, it is the Cattaneo-Mindlin approximation.

    Examples
    --------
    >>> import asperity, surfaces
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> ball = surfaces.PowerLawProfile(2.0, 50.0)
    >>> one = asperity.indent(ball, steel, 1e-6)
    >>> half = 0.5 * 0.3 * float(one.force)
    >>> push = asperity.partial_slip(
    ...     ball, steel, 1e-6, friction=0.3, modulus_ratio=1.2, tangential_force=half
    ... )
    >>> f"{push.stick_area / one.contact_area:.4f}"  # (1 - 0.5) ** (2 / 3), Cattaneo and Mindlin
    '0.6300'
    """
    require_half_space(material)
    if material.m != 0:
        raise InputError("partial slip needs a homogeneous half-space, m = 0")
    if material.hardness < np.inf:
        raise InputError(ELASTIC_ALONE)
    depth, friction = as_positive("approach", approach), as_positive("friction", friction)
    ratio = as_positive("modulus_ratio", modulus_ratio)
    if (displacement is None) == (tangential_force is None):
        raise InputError("give either displacement or tangential_force")
    full = indent(profile, material, depth, law=law)
    if np.isnan(full.force):
        raise ModelRangeError(
            f"the law {law!r} has no solution at an approach of {depth:.4g} m; give a smaller one"
        )
    if displacement is not None:
        moved = _push("displacement", displacement)
        sticking = depth - moved / (friction * ratio)
    else:
        lost = _push("tangential_force", tangential_force) / friction
        sticking = np.minimum(_stick_depth(profile, material, full, lost, law), depth)
        moved = np.where(sticking > 0, friction * ratio * (depth - sticking), np.nan)
    slipping = sticking <= 0
    stick = indent(profile, material, np.maximum(sticking, 0.0), law=law)
    if tangential_force is None:
        lost = np.maximum(full.force - np.where(slipping, 0.0, stick.force), 0.0)
    force = friction * np.minimum(lost, full.force)
    return PartialSlip(full, stick, friction, force, moved, slipping)


def _push(name: str, values: ArrayLike | None) -> Array:
    array = as_sizes(name, values)
    if array.ndim > 1 or np.any(array < 0):
        raise InputError(f"{name} must be a number or one axis of them, not negative")
    return array


def _stick_depth(
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    full: Indentation,
    lost: Array,
    law: str,
) -> Array:
    """Approach d* at which the normal force is F(d) minus `lost`."""
    rest = np.asarray(full.force - lost)
    scale = float(full.force)
    if np.any(rest < -1e-12 * scale):
        raise ModelRangeError(
            "the tangential force exceeds the friction coefficient times the normal force of "
            f"{scale:.4g} N: the contact slides; give a smaller one"
        )
    sticks = rest > 1e-12 * scale
    depth = np.zeros(rest.shape)
    if np.any(sticks):
        depth[sticks] = indent(profile, material, load=rest[sticks], law=law).approach
    return depth


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

    displacement: Array
    shear: Array
    stick_area_fraction: Array
    slip_shear: float


def friction_curve(
    curve: ContactCurve,
    pressure: float,
    *,
    friction: float,
    modulus_ratio: float,
    points: int = 50,
) -> FrictionCurve:
    """Shear against tangential displacement at constant normal load.

    Parameters
    ----------
    curve
        Normal contact curve that reaches from light load to `pressure`.
    pressure
        Normal load over nominal area [Pa].
    friction, modulus_ratio
        As in `partial_slip`.
    points
        Number of points; the last has the lightest load of the curve as its stick region.

    Raises
    ------
    InputError
        If an argument is out of range, or the curve does not begin below `pressure` or does
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
    pressure, friction = as_positive("pressure", pressure), as_positive("friction", friction)
    ratio, count = as_positive("modulus_ratio", modulus_ratio), as_count("points", points, 2)
    if curve.settings.get("m", 0.0) != 0.0:
        raise InputError("partial slip needs homogeneous half-spaces, m = 0")
    if "hardness" in curve.settings:
        raise InputError(ELASTIC_ALONE)
    whole = curve.at(pressure=pressure)
    lightest = float(curve.mean_pressure[curve.converged & (curve.mean_pressure > 0)].min())
    if not lightest < (1 - END_SLACK) * pressure:
        raise InputError(
            f"the curve begins at {lightest:.4g} Pa, not below {pressure:.4g} Pa; "
            "partial slip needs lighter load points as well"
        )
    share = np.linspace(0.0, 1.0, count)
    asked = pressure * (lightest / pressure) ** share
    stick = curve.at(pressure=asked)
    return FrictionCurve(
        displacement=friction * ratio * (stick.separation - whole.separation),
        shear=friction * (pressure - asked),
        stick_area_fraction=stick.area_fraction,
        slip_shear=friction * pressure,
    )
