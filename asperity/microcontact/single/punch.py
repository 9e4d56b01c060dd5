"""Rigid flat punches of star-shaped planform (Popov, Li & Willert 2023, equations 7, 8, 12, 14)."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace, require_half_space
from surfaces.arrays import Array
from surfaces.errors import LARGEST_NUMBER, as_numbers, as_places, shown

from .basis import corner_rule

__all__ = ["FlatPunch", "flat_punch"]


_PANEL = 32
"""Gauss nodes between two corners of a punch."""

_ANGLES, _MOST_ANGLES = 4096, 2**21
"""Angles of a punch without corners, doubled until its integrals settle; the most of them."""

_SETTLED = 1e-5
"""Relative change of an integral that has settled."""


@dataclass(frozen=True, eq=False)
class FlatPunch:
    """Flat punch of the planform r < a(phi), pressed by a unit distance at a time.

    Attributes
    ----------
    material
        The half-space.
    edge
        Boundary a(phi) [m] as a function of the angle [rad].
    contact_area
        Area A of the planform [m^2].
    stiffness
        ``dF/dd = 4 E_m* A / ((1+m) J_m)`` [N/m].
    moment
        ``J_m = int a(phi)^(1-m) dphi`` [m^(1-m)].

    Notes
    -----
    Fabrikant's field about the chosen origin: exact for ellipses about their centre and for every
    m, an estimate for any other planform (1.5 % low for a square, m = 0), and it depends on the
    origin. Put the origin at the centroid.

    Examples
    --------
    >>> import math
    >>> import asperity
    >>> punch = asperity.flat_punch(1e-3, asperity.HalfSpace.from_modulus(1e9))
    >>> f"{punch.contact_area / (math.pi * 1e-6):.6f}"
    '1.000000'
    """

    material: HalfSpace
    edge: Callable[[Array], Array]
    contact_area: float
    stiffness: float
    moment: float

    def force(self, approach: ArrayLike) -> Array:
        """Normal force [N] at the approach [m]; none at or below zero."""
        return np.asarray(self.stiffness * np.maximum(as_numbers("approach", approach), 0.0))

    def pressure(self, x: ArrayLike, y: ArrayLike, approach: float = 1.0) -> Array:
        """Pressure [Pa] at the points (x, y) [m] (broadcast), infinite at the edge."""
        x, y = as_places(x, y)
        depth = as_numbers("approach", approach)
        m = self.material.m
        rho = np.hypot(x, y) / self.edge(np.arctan2(y, x))
        inside = np.where(rho < 1, (1 - rho) * (1 + rho), 1.0)
        field = 2 * self.material.modulus / self.moment * inside ** ((m - 1) / 2)
        values = np.where(rho < 1, field, np.where(rho == 1, np.inf, 0.0))
        none = np.zeros(np.broadcast_shapes(depth.shape, rho.shape))
        return np.multiply(depth, values, out=none, where=depth > 0)


def flat_punch(
    edge: Callable[[Array], ArrayLike] | ArrayLike, material: HalfSpace, *, corners: ArrayLike = ()
) -> FlatPunch:
    """Flat punch with the boundary `edge`.

    Parameters
    ----------
    edge
        a(phi) [m]: a vectorized function, a number, or values at equispaced angles.
    material
        Half-space, any m.
    corners
        Angles [rad] at which a(phi) has a kink; the integrals are then exact between them.

    Raises
    ------
    InputError
        If the planform does not contain the origin, or is too slender for its integrals (an
        ellipse of 10^5:1).

    Examples
    --------
    >>> import math
    >>> import asperity
    >>> punch = asperity.flat_punch(1e-3, asperity.HalfSpace.from_modulus(1e9))  # a disc
    >>> f"{punch.stiffness / (2 * 1e9 * 1e-3):.4f}"
    '1.0000'
    """
    require_half_space(material)
    function, m = _boundary(edge), material.m
    kinks = as_numbers("corners", corners).ravel()
    if kinks.size:
        moment, twice = _integrals(function, m, *corner_rule(kinks, _PANEL))
    else:
        moment, twice = _settled(function, m)
    area = twice / 2
    stiffness = 4 * material.modulus * area / ((1 + m) * moment)
    return FlatPunch(material, function, area, stiffness, moment)


def _integrals(
    function: Callable[[Array], Array], m: float, phi: Array, weight: Array
) -> tuple[float, float]:
    """Integrals of a(phi)^(1-m) and a(phi)^2 by a rule of angles and weights."""
    a = function(phi.ravel())
    if not np.all((a >= 1 / LARGEST_NUMBER) & (a <= LARGEST_NUMBER)):
        raise InputError("the planform must contain the origin: a(phi) > 0 at every angle")
    return float(weight.ravel() @ a ** (1 - m)), float(weight.ravel() @ a**2)


def _settled(function: Callable[[Array], Array], m: float) -> tuple[float, float]:
    """`_integrals` over as many equispaced angles as a slender planform needs."""
    known, count = (np.inf, np.inf), _ANGLES
    while count <= _MOST_ANGLES:
        phi, weight = 2 * np.pi * np.arange(count) / count, np.full(count, 2 * np.pi / count)
        found = _integrals(function, m, phi, weight)
        if np.allclose(found, known, rtol=_SETTLED, atol=0.0):
            return found
        known, count = found, 2 * count
    raise InputError("the planform is too slender or rough for its integrals; name its corners")


def _boundary(edge: Callable[[Array], ArrayLike] | ArrayLike) -> Callable[[Array], Array]:
    if callable(edge):
        return functools.partial(_radii, edge)
    values = np.atleast_1d(as_numbers("edge", edge))
    if values.ndim > 1 or not values.size:
        raise InputError(
            f"edge is {shown(edge)}; give a radius, several at equispaced angles, or a function"
        )
    turn = 2 * np.pi * np.arange(values.size) / values.size
    return lambda phi: np.interp(phi, turn, values, period=2 * np.pi)


def _radii(edge: Callable[[Array], ArrayLike], phi: Array) -> Array:
    """The radii [m] that a function gives at angles [rad]."""
    radii = as_numbers("edge", edge(phi), finite=False)
    try:
        return np.broadcast_to(radii, phi.shape)
    except ValueError:
        raise InputError(
            f"edge gives radii of shape {radii.shape} at angles of shape {phi.shape}; give one each"
        ) from None
