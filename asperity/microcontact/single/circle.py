"""Laws "paper" and "harmonic" of one contact: first-order solutions about the circle.

"paper" is that of Popov, Li & Willert (2023), whose equations are cited here; "harmonic" resolves
every harmonic.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import betainc

from asperity.errors import Flag
from asperity.halfspace.footprint import Footprints
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.ray_laws import bounded, expected_error
from surfaces.arrays import Array, Index, Mask
from surfaces.polar import PolarProfile, PowerSumProfile

from .basis import (
    Basis,
    PowerBasis,
    basis_of,
    radii_looked_at,
    radius_at,
    samples,
    synthesis,
    turning_radius,
)
from .indentation import Indentation, contour_flags, profile_flags
from .pressure import axisymmetric, history, of_harmonics

__all__ = ["Expansion", "indent"]


_ANGLES = 720
"""Angles at which the flags look at a contour."""

_DOUBTFUL = 0.5
"""Relative error expected of the force beyond which a contour is doubtful: near m = 1 that of a
long contact deviates too little from a circle to be seen."""

_CLOSED = 2048
"""Angles at which the area of a contour is taken."""


@dataclass(frozen=True, eq=False)
class Expansion:
    """Quantities of the expansion at radii a, shape (k,).

    Attributes
    ----------
    approach
        D(a) [m] (equations 22, 49).
    slope
        a D'(a) [m].
    first, second
        Force [N] of the mean profile (equations 23, 49), and its second-order part F2.
    second_slope
        a dF2/da [N].
    amplitudes
        Edge amplitudes e_n [m], n = 1, 2, ..., shape (k, harmonics).
    """

    a: Array
    material: HalfSpace
    orders: Index
    approach: Array
    slope: Array
    first: Array
    second: Array
    second_slope: Array
    amplitudes: NDArray[np.complex128]

    @classmethod
    def at(cls, basis: Basis, a: Array, material: HalfSpace, *, published: bool) -> Expansion:
        """Evaluate at the radii `a`, all positive."""
        m, modulus = material.m, material.modulus
        approach, slope, curve = (basis.depth(a, order) for order in (0, 1, 2))
        scale = modulus * a ** (1 + m)
        first = 2 * scale * (approach / (1 + m) - basis.gap(a))
        e, de = (basis.amplitudes(a, order, published=published) for order in (0, 1))
        square = np.sum(np.abs(e) ** 2, axis=1) / 2
        change = np.sum((e * de.conj()).real, axis=1)
        second = scale * square / slope
        second_slope = scale / slope * ((1 + m) * square + change - square * curve / slope)
        return cls(a, material, basis.orders, approach, slope, first, second, second_slope, e)

    def boundary(self, edge: Array) -> Array:
        """First-order contour [m] for the edge amplitude `edge` [m], shape (k, phi.size)."""
        return np.asarray(self.a[:, None] - (self.a / self.slope)[:, None] * edge)

    def second_order_area(self) -> Array:
        """Area [m^2] to second order."""
        return np.asarray(np.pi * (self.a**2 + 2 * self.a * self.mean_shift() + self.variance()))

    def resolved_area(self) -> Array:
        """Area [m^2] to second order, bounded as in the law tables."""
        return bounded(self.second_order_area(), np.pi * self.a**2)

    def resolved_boundary(self, phi: Array) -> Array:
        """Contour [m] of the resolved law, shape (k, phi.size): it encloses `resolved_area`.

        Written as ``exp(da/a)``, which is the first-order contour to first order, stays positive
        and is closer to the true one (the contour of an ellipse bends the same way).
        """
        grown = np.exp(np.minimum(2 * samples(self.ratios(), _CLOSED), 20.0)).mean(axis=1)
        scale = np.sqrt(self.resolved_area() / (np.pi * grown))
        deviation = np.minimum(-self.edge(phi) / self.slope[:, None], 10.0)
        return np.asarray(scale[:, None] * np.exp(deviation))

    def ratios(self) -> NDArray[np.complex128]:
        """First-order amplitudes of the contour over a, shape (k, harmonics)."""
        return np.asarray(-self.amplitudes / self.slope[:, None])

    def edge(self, phi: Array) -> Array:
        """Edge amplitude e(phi) [m], shape (k, phi.size)."""
        return synthesis(self.amplitudes, phi)

    def variance(self) -> Array:
        """Mean square of the first-order deviation of the contour [m^2]."""
        return np.asarray(
            np.sum(np.abs(self.amplitudes) ** 2, axis=1) / 2 * (self.a / self.slope) ** 2
        )

    def mean_shift(self) -> Array:
        """Second-order change of the mean radius [m]."""
        m = self.material.m
        growth = self.second_slope / (2 * self.material.modulus * self.a**m * self.slope)
        weight = (m + (1 - m) * self.orders) / 4
        ratio = np.abs(self.amplitudes / self.slope[:, None]) ** 2
        return np.asarray(growth - self.a * (ratio @ weight))


def indent(
    profile: PowerSumProfile | PolarProfile, material: HalfSpace, approach: Array, *, law: str
) -> Indentation:
    """Solution by the laws "paper" and "harmonic"; see `asperity.indent`."""
    basis = basis_of(profile, material.m)
    a = radius_at(basis, approach)
    known = np.isfinite(a) & (a > 0)
    harmonic, published = (
        Expansion.at(basis, a[known], material, published=published) for published in (False, True)
    )
    one = published if law == "paper" else harmonic
    force, stiffness = one.first, Footprints(material.modulus, material.m).punch(one.a)
    area = np.pi * (one.a**2 + one.variance())
    if law == "harmonic":
        force = force + one.second
        free = stiffness + one.second_slope / one.slope
        stiffness = bounded(free, stiffness)
        area = one.resolved_area()

    def filled(values: Array) -> Array:
        """Rows for all approaches: zero without contact, NaN without solution."""
        rows = np.repeat(np.where(approach > 0, np.nan, 0.0)[:, None], values.shape[1], axis=1)
        rows[known] = values
        return rows

    def everywhere(values: Array) -> Array:
        return filled(values[:, None])[:, 0]

    def boundary(state: Expansion, phi: Array) -> Array:
        if law == "paper":
            return state.boundary(basis.published(state.a, phi))
        return state.resolved_boundary(phi)

    def contour(phi: Array) -> Array:
        return filled(boundary(one, phi))

    def scaled(r: Array, phi: Array) -> Array:
        """Axisymmetric pressure stretched to the contour [Pa], shape (approaches, points)."""
        edge = boundary(one, phi)
        if one.a.size == 0:
            return filled(edge)
        inside = edge > 0
        stretched = np.where(inside, one.a[:, None] * r / np.where(inside, edge, 1.0), np.inf)
        values = axisymmetric(basis, material, stretched, one.a)
        if law == "harmonic":
            for i, ratios in enumerate(one.ratios()):
                values[i] += of_harmonics(
                    basis, material, stretched[i], phi, float(one.a[i]), ratios
                )
            values = np.maximum(values, 0.0)  # what is left of higher orders at corners
        return filled(values)

    def earlier(radii: Array) -> Expansion:
        return Expansion.at(basis, radii, material, published=law == "paper")

    def by_history(r: Array, phi: Array) -> Array:
        """Pressure by the history integral [Pa], shape (approaches, points)."""
        ratios = (lambda radii: earlier(radii).ratios()) if law == "harmonic" else None
        rows = [
            history(
                basis, material, lambda radii, phi: boundary(earlier(radii), phi), ratios, a, r, phi
            )
            for a in one.a.tolist()
        ]
        return filled(np.reshape(rows, (one.a.size, phi.size)))

    phi = 2 * np.pi * np.arange(_ANGLES) / _ANGLES
    first_order = boundary(one, phi) if law == "paper" else one.boundary(one.edge(phi))
    flags = contour_flags(a, filled(first_order))
    flags |= profile_flags(profile, approach, phi, contour(phi))
    error = everywhere(expected_error(one.first, harmonic.second, published.second, law))
    doubtful, apart = np.uint8(Flag.CONTOUR_DOUBTFUL), _pierced(basis, a, approach)
    error[apart] = np.nan
    if law == "harmonic":
        cut = (area != one.second_order_area()) | (stiffness != free)
        flags[np.flatnonzero(known)[cut]] |= doubtful
    flags[apart | (error > _DOUBTFUL)] |= doubtful
    flags[~np.isfinite(a)] |= np.uint8(Flag.TURNING)
    similar = isinstance(basis, PowerBasis) and basis.powers.size == 1
    return Indentation(
        law=law,
        material=material,
        approach=approach,
        force=everywhere(force),
        contact_area=everywhere(area),
        radius=everywhere(one.a),
        stiffness=everywhere(stiffness),
        flags=flags,
        error_estimate=error,
        contour_function=contour,
        pressure_function=scaled if law == "paper" or similar else by_history,
        history_function=by_history,
    )


def _pierced(basis: Basis, a: Array, approach: Array) -> Mask:
    """Whether the mean profile of a table pierces the free surface beside circles of radius `a`
    [m]: a flat part farther out touches before the contact has grown to it.

    Notes
    -----
    The gap at r > a is ``c int_a^r (D(x) - d) x^m (r^2 - x^2)^(-(1+m)/2) dx`` with a positive c.
    """
    looked_at = radii_looked_at(basis)
    if isinstance(basis, PowerBasis) or turning_radius(basis) == looked_at[-1]:
        return np.zeros(a.shape, dtype=bool)
    r = looked_at[looked_at <= basis.nodes[-1]]
    ends = np.minimum(np.append(0.0, r) / r[:, None], 1.0)
    weight = np.diff(betainc((1 + basis.m) / 2, (1 - basis.m) / 2, ends**2), axis=1)
    middle = r - np.diff(r, prepend=0.0) / 2
    above = np.where(middle > a[:, None], basis.depth(middle) - approach[:, None], 0.0)
    return np.asarray(np.any(above @ weight.T < 0, axis=1))
