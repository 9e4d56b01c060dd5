"""Law of waves too short for contacts of their own."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .pixel_waves import Strength

__all__ = ["FineScales"]

Array = NDArray[np.float64]

SPREAD = 0.50
"""Share of the pressure of the fine waves in full contact that spreads the pressure of a contact
about to open, for few fine waves."""

MORE_SPREAD = 0.13
"""What is added to it where their slope is far above the others'."""

GRADED_SPREAD = (0.70, 0.55)
"""c1, c2: on a graded body times 1 - c1 m - c2 m^2 (|m| <= 0.5)."""

LAY_SPREAD = 0.7
"""With lay times 1 - c (1 - w), w the evenness of the slopes (lay of 2:1 to 8:1)."""

LIFT = 0.18
"""How far the flat is lifted at no contact, over the first-order value less one."""

LIFT_POWER = 5.0
"""It falls with this power of the share of the area that is not in contact."""

GRADED_LIFT = 1.2
"""`LIFT` on a graded body times 1 - c m."""

LAY_LIFT = 1.6
"""`LIFT` with lay times 1 - c (1 - w), and not below zero."""

SEEN = 1.0
"""Wave number times contact radius at which half the pressure of the fine waves parts a contact: a
longer wave only makes the summit higher or sharper. On seeds 1, 2 and 11 to 14
(docs/development/sub_contact_roughness.md) 0.9 to 1.5 hardly differ."""


@dataclass(frozen=True)
class FineScales:
    """Random waves too short for contacts of their own, within the contacts of the longer ones.

    Parameters
    ----------
    shortest
        Shortest wave [m] that was kept for contacts.
    ratio
        Variance of the pressure that presses the fine waves flat over that of the longer ones.
    variance
        The former, V [Pa^2].
    energy
        Elastic energy e per area [J/m^2] of the fine waves pressed flat.
    number
        Their mean wave number [1/m], that of their pressure over that of their energy.
    m
        Exponent of the grading of the body.
    evenness
        w = 2 s1 s2 / (s1^2 + s2^2) of the principal slopes s1, s2 of the fine waves: 1 without lay,
        8/17 for slopes of 4:1.
    strength
        Where on the map variance and energy are how many times those given.

    Notes
    -----
    In full contact a wave h_q has the pressure h_q / L(q), with the compliance L = c q^(m - 1) / E
    (docs/development/half_space.md; c = 2 for m = 0): V = <p^2> = sum |h_q|^2 / L^2, e = sum
    |h_q|^2 / 2 L, so for m = 0 V = E*^2/4 <|grad h|^2>. Fine waves spread the pressures of a
    contact, which leave it where they come to zero (Persson 2001). Those of a rough contact of mean
    pressure p follow Rayleigh's distribution of scale s = sqrt(2/pi) p; of its area there remains,
    and per area is stored,

        A/A0 = 1 / sqrt(1 + b),   Phi = e arsinh(sqrt(b)) / sqrt(b),   b = g V / s^2,

    Phi = int u dp being the complementary energy of the local gap u. Of the area of a contact of
    radius a the waves part it as if V were V x^2 / (x^2 + `SEEN`^2), x being a w times their number
    (with lay contacts are long, and the waves part them across). Contacts about to open spread less
    than V: g = g0 + (1 - g0) P^2, with P the share of the nominal area in contact, here the mean of
    that with and without the fine waves; Wang & Mueser (2017) have g0 = 5/9, boundary elements give
    0.50 to 0.63 (`SPREAD`), 0.4 to 0.66 for m = 0.3 to -0.3 and 0.35 to 0.45 for lay of 4:1. To
    first order in the fine waves a load F lifts the flat by d(sum Phi)/dF; boundary elements give
    the factor 1 + c (1 - P)^n, c = `LIFT`, n = `LIFT_POWER`. All were found without microcontacts,
    from the pressures of solutions of the longer waves, for Hurst exponents 0.5 to 0.9 and one to
    four octaves (docs/development/sub_contact_roughness.md).
    """

    shortest: float
    ratio: float
    variance: float
    energy: float
    number: float
    m: float = 0.0
    evenness: float = 1.0
    strength: Strength = field(default=Strength(), compare=False)

    @property
    def spread(self) -> float:
        """g0 [-]."""
        plain = SPREAD + MORE_SPREAD * self.ratio / (1.0 + self.ratio)
        graded = 1.0 - GRADED_SPREAD[0] * self.m - GRADED_SPREAD[1] * self.m**2
        return plain * graded * (1.0 - LAY_SPREAD * (1.0 - self.evenness))

    def remaining(
        self,
        pressure: ArrayLike,
        share: float,
        area: ArrayLike = np.inf,
        strong: float | Array = 1.0,
    ) -> Array:
        """Share of contacts of mean pressure p [Pa] and area [m^2] that stays closed; `share` is P.

        A contact is taken as far wider than the fine waves if no area is given; `strong` is their
        strength under it.
        """
        narrow = self.evenness * self.number
        unseen = SEEN**2 * np.pi / (narrow**2 * np.asarray(area, float))
        opening = self._opening(pressure, share, strong) ** 2 / (1.0 + unseen)
        return np.asarray(1.0 / np.sqrt(1.0 + opening))

    def stored(self, pressure: ArrayLike, share: float, strong: float | Array = 1.0) -> Array:
        """Complementary energy per area [J/m^2] of contacts of mean pressure p [Pa]."""
        root = self._opening(pressure, share, strong)
        return np.asarray(self.energy * strong * np.arcsinh(root) / root)

    def lift(self, share: float) -> float:
        """Factor over the first order of the lift where the share of area P is closed."""
        height = LIFT * (1.0 - GRADED_LIFT * self.m)
        height *= max(1.0 - LAY_LIFT * (1.0 - self.evenness), 0.0)
        return float(1.0 + height * (1.0 - share) ** LIFT_POWER)

    def _opening(self, pressure: ArrayLike, share: float, strong: float | Array) -> Array:
        """sqrt(b)."""
        spread = self.spread + (1.0 - self.spread) * share**2
        scale = np.sqrt(2.0 / np.pi) * np.maximum(np.asarray(pressure, float), 1e-300)
        return np.asarray(np.sqrt(spread * self.variance * strong) / scale)
