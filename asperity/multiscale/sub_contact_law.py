"""Law of waves too short for contacts of their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.parameters import DEFAULTS
from asperity.parameters.constants import SubContact

__all__ = ["SubContactLaw"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SubContactLaw:
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
    fitted
        Constants of the law.

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
    radius a the waves part it as if V were V x^2 / (x^2 + `fitted.seen`^2), x being a times their
    number. Contacts about to open spread less than V: g = g0 + (1 - g0) P^2, with P the share of
    the nominal area in contact, here the mean of that with and without the fine waves; Wang &
    Mueser (2017) have g0 = 5/9, boundary elements give 0.50 to 0.63 (`fitted.spread`) and 0.4 to
    0.66 for m = 0.3 to -0.3. To first order in the fine waves a load F lifts the flat by d(sum
    Phi)/dF; boundary elements give the factor 1 + c (1 - P)^n, c = `fitted.lift`, n =
    `fitted.lift_power`. All were found without microcontacts, from the pressures of solutions of
    the longer waves, for Hurst exponents 0.5 to 0.9 and one to four octaves
    (docs/development/sub_contact_roughness.md).
    """

    shortest: float
    ratio: float
    variance: float
    energy: float
    number: float
    m: float = 0.0
    fitted: SubContact = DEFAULTS.sub_contact

    @property
    def spread(self) -> float:
        """g0 [-]."""
        fitted = self.fitted
        plain = fitted.spread + fitted.more_spread * self.ratio / (1.0 + self.ratio)
        graded = 1.0 - fitted.graded_spread[0] * self.m - fitted.graded_spread[1] * self.m**2
        return plain * graded

    def remaining(self, pressure: ArrayLike, share: float, area: ArrayLike = np.inf) -> Array:
        """Share of contacts of mean pressure p [Pa] and area [m^2] that stays closed; `share` is P.

        A contact is taken as far wider than the fine waves if no area is given.
        """
        unseen = self.fitted.seen**2 * np.pi / (self.number**2 * np.asarray(area, float))
        opening = self._opening(pressure, share) ** 2 / (1.0 + unseen)
        return np.asarray(1.0 / np.sqrt(1.0 + opening))

    def stored(self, pressure: ArrayLike, share: float) -> Array:
        """Complementary energy per area [J/m^2] of contacts of mean pressure p [Pa]."""
        root = self._opening(pressure, share)
        return np.asarray(self.energy * np.arcsinh(root) / root)

    def lift(self, share: float) -> float:
        """Factor over the first order of the lift where the share of area P is closed."""
        fitted = self.fitted
        height = fitted.lift * (1.0 - fitted.graded_lift * self.m)
        return float(1.0 + height * (1.0 - share) ** fitted.lift_power)

    def _opening(self, pressure: ArrayLike, share: float) -> Array:
        """sqrt(b)."""
        spread = self.spread + (1.0 - self.spread) * share**2
        scale = np.sqrt(2.0 / np.pi) * np.maximum(np.asarray(pressure, float), 1e-300)
        return np.asarray(np.sqrt(spread * self.variance) / scale)
