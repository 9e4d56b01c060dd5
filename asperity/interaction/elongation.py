"""Elongated contacts: second moments of their footprints, and their radii of curvature."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from scipy.special import ellipe, ellipk

from asperity.halfspace.footprint import Footprints
from asperity.microcontact.hertz import axis_ratios
from asperity.parameters import ElongationBounds
from surfaces.arrays import Array, Index

__all__ = ["Elongation"]


@dataclass(frozen=True, eq=False)
class Elongation:
    """Shapes of elongated footprints relative to round ones; arrays over the contacts.

    Parameters
    ----------
    moments
        Second moments yy, xx, xy of the footprint over the variance of the round footprint of the
        same compliance, shape (n, 3).
    radii
        Components yy, xx, xy of the radius of curvature over that of the round contact of the same
        stiffness and approach, shape (n, 3).

    Notes
    -----
    The flat punch over an ellipse and a Gaussian of elliptic contours depend on the ratio of their
    axes r in the same way. The rule of `Footprints`, that a footprint has the compliance of its
    contact, therefore holds with the moments v g r along and v g / r across, where v is the
    variance of the round footprint and
    g^(p/2) = mean over directions of (r cos^2 + sin^2 / r)^(-p/2) (p = 1: 2 K(e) / (pi sqrt(r))).
    By Jensen's inequality the mean of both moments is never below v: a round footprint of the mean
    moment leaves the tangent matrix positive definite.
    An elliptic Hertz contact of semi-axes a, b with r = a/b and e^2 = 1 - 1/r^2 at the approach d
    has the radii of curvature a^2 / (d c) along and b^2 / (d c') across, where
    c = 2 (K - E) / (e^2 K) and c + c' = 2 (Johnson, Contact Mechanics, 1985, section 4.2). The
    radius along is bounded (`parameters.ElongationBounds`).
    """

    moments: Array
    radii: Array

    @classmethod
    def of(
        cls, curvature: Array, angle: Array, footprints: Footprints, bounds: ElongationBounds
    ) -> Elongation:
        """Elongation of contacts on summits with principal curvatures [1/m], shape (n, 2), the
        larger first, and directions of the long axis [rad], (n,)."""
        ratio = np.minimum(1.0 / axis_ratios(curvature, footprints.m), bounds.aspect)
        place, known = _compliance(footprints.power, bounds.aspect)
        size = np.interp(np.log(ratio), place, known) ** (2 / footprints.power)  # g
        squared = np.maximum(1 - ratio**-2, 1e-9)  # e^2, the argument of SciPy's integrals
        k, e = ellipk(squared), ellipe(squared)
        c = 2 * (k - e) / (squared * k)
        far, near = np.minimum(ratio / c, bounds.radius), 1 / (ratio * (2 - c))
        return cls(_turned(size * ratio, size / ratio, angle), _turned(far, near, angle))

    @property
    def along(self) -> Array:
        """Second moment along each footprint over the variance of the round one, shape (n,)."""
        yy, xx, xy = self.moments.T
        return np.asarray(0.5 * (yy + xx) + np.hypot(0.5 * (yy - xx), xy))

    def rows(self, index: Index) -> Elongation:
        """Elongation of the contacts `index`."""
        return Elongation(self.moments[index], self.radii[index])


@functools.lru_cache(maxsize=16)
def _compliance(power: float, largest: float) -> tuple[Array, Array]:
    """g^(p/2) of `Elongation`, the self-compliance of an elliptic Gaussian over that of the round
    one of equal determinant, tabulated over the logarithm of the axis ratio."""
    place = np.linspace(0.0, np.log(largest), 65)
    angle = (np.arange(512) + 0.5) * np.pi / 1024
    ratio = np.exp(place)[:, None]
    square = ratio * np.cos(angle) ** 2 + np.sin(angle) ** 2 / ratio
    return place, np.mean(square ** (-0.5 * power), axis=1)


def _turned(along: Array, across: Array, angle: Array) -> Array:
    """Components yy, xx, xy of tensors with the principal values `along` at the angle [rad] from x
    to y, and `across`."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack(
        (along * s * s + across * c * c, along * c * c + across * s * s, (along - across) * s * c),
        axis=1,
    )
