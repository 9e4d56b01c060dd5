"""Waves too short for contacts of their own: their law, and the whole surface at a state of the
contacts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from asperity.parameters import DEFAULTS
from asperity.parameters.constants import SubContact

if TYPE_CHECKING:
    from asperity.interaction.population import Population, PopulationState

__all__ = ["SubContactLaw", "SurfacePoint", "closed_areas", "surface_point"]


Array = NDArray[np.float64]


LOAD_STEP = 0.02
"""Change of the load, relative, over which energies are compared."""

MOST_CLOSED = 0.9
"""Share of the map up to which the bearing curve is followed, which has no end at full contact:
load points beyond half of it are refused, but a search may pass through them."""


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
    rms
        Rms height [m] of the longer waves, and of all.
    hardness
        Pressure [Pa] that the contacts bear at most.
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
    0.66 for m = 0.3 to -0.3. All were found without microcontacts, from the pressures of solutions
    of the longer waves, for Hurst exponents 0.5 to 0.9 and one to four octaves
    (docs/development/sub_contact_roughness.md). To first order in the fine waves a load F lifts the
    flat by d(sum Phi)/dF; boundary elements give

        (1 + c (1 - P)^n) d(sum Phi)/dF + c' max(z - z0, 0) (rms of all - rms of the longer waves),

    where a normal variable exceeds z with the probability P: few, light contacts meet the fine
    waves as heights. c = `fitted.lift`, n = `fitted.lift_power`, c' = `fitted.tops`, z0 =
    `fitted.tops_from`.

    With a hardness H contacts keep p/H of their area at least, and c with 1 - c^3 = (1 - e^3)
    (1 - (p/H)^3) in all, e being the share above. Of the lift of elastic contacts of the same areas
    there remains the load over that of elastic contacts which close as much: F/F_e e/c, F_e being
    the load of the former and e what these close. The longer waves may still be elastic (F = F_e)
    where the fine ones have yielded (e < c). In place of the rest stands the lift of the bearing
    curve of a random surface, z times the difference of both rms heights. As the load falls, spots
    that have yielded answer as elastic ones of their areas, whose load is larger by c/e.
    """

    shortest: float
    ratio: float
    variance: float
    energy: float
    number: float
    m: float = 0.0
    rms: tuple[float, float] = (1.0, 1.0)
    hardness: float = np.inf
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
        closed = self.elastic_share(pressure, share, area) ** 3
        yielded = np.minimum(np.asarray(pressure) / self.hardness, 1.0) ** 3
        return np.asarray(np.cbrt(closed + yielded * (1.0 - closed)))

    def elastic_share(self, pressure: ArrayLike, share: float, area: ArrayLike = np.inf) -> Array:
        """`remaining` without a hardness."""
        unseen = self.fitted.seen**2 * np.pi / (self.number**2 * np.asarray(area, float))
        opening = self._opening(pressure, share) ** 2 / (1.0 + unseen)
        return np.asarray(1.0 / np.sqrt(1.0 + opening))

    def stored(self, pressure: ArrayLike, share: float) -> Array:
        """Complementary energy per area [J/m^2] of contacts of mean pressure p [Pa]."""
        root = self._opening(pressure, share)
        return np.asarray(self.energy * np.arcsinh(root) / root)

    def lift(self, first: float, share: float) -> float:
        """Lift [m] of elastic contacts, `first` to first order, where the share P is closed."""
        fitted = self.fitted
        height = fitted.lift * (1.0 - fitted.graded_lift * self.m)
        tops = fitted.tops * (1.0 - fitted.graded_tops * self.m)
        light = max(-float(ndtri(share)) - fitted.tops_from, 0.0)
        longer, whole = self.rms
        more = height * (1.0 - share) ** fitted.lift_power
        return float((1.0 + more) * first + tops * light * (whole - longer))

    def bearing_lift(self, share: float) -> float:
        """Height [m] by which the fine waves raise the bearing curve where it is the share P."""
        longer, whole = self.rms
        return float(-ndtri(min(share, MOST_CLOSED)) * (whole - longer))

    def _opening(self, pressure: ArrayLike, share: float) -> Array:
        """sqrt(b)."""
        spread = self.spread + (1.0 - self.spread) * share**2
        scale = np.sqrt(2.0 / np.pi) * np.maximum(np.asarray(pressure, float), 1e-300)
        return np.asarray(np.sqrt(spread * self.variance) / scale)


@dataclass(frozen=True)
class SurfacePoint:
    """A load point of the whole surface.

    Attributes
    ----------
    separation
        Distance of the flat from the mean plane [m].
    contact_area
        Contact area [m^2].
    stiffness
        Minus the slope of mean pressure over separation [Pa/m].
    unloading
        The same as the load begins to fall; with a hardness contacts then keep their areas.
    """

    separation: float
    contact_area: float
    stiffness: float
    unloading: float


def surface_point(
    population: Population,
    law: SubContactLaw | None,
    state: PopulationState,
    area: float,
    highest: float,
) -> SurfacePoint:
    """The point of the whole surface that belongs to a state of its contacts, those of all waves if
    there is no law of finer ones.

    The fine waves leave an area [m^2] closed. The flat stands no higher than the highest point of
    the whole surface above its mean plane [m].

    Notes
    -----
    The lift d(sum Phi)/dF is taken along the answer of all contacts to a small fall of the flat
    (the tangent of the coupled problem), by central differences. It falls as the load grows. Of a
    rough solve the differences can say otherwise: contacts that its last step has opened are left
    at no approach, where half a step on all of them bear and half a step back none.
    """
    stiffness = unloading = state.normal_stiffness
    hard = population.material.hardness < np.inf
    if hard and stiffness > 0.0:
        unloading = max(state.unloading_stiffness, stiffness)
    if law is None:
        return SurfacePoint(state.separation, state.contact_area, stiffness, unloading)
    closed = np.flatnonzero(state.force > 0)
    if not closed.size:
        top = population.highest
        separation = max(state.separation, highest + state.separation - top)
        return SurfacePoint(separation, 0.0, 0.0, 0.0)
    nominal, contacts = population.nominal_area, population.laws.rows(closed)
    share = 0.5 * (state.contact_area + area) / nominal
    gained = state.response[closed]
    if not stiffness > 0.0:  # a failed solve, marked as such
        return SurfacePoint(state.separation, area, stiffness, stiffness)
    fall = LOAD_STEP * state.mean_pressure / stiffness

    def twin(step: float) -> tuple[float, float, float, float]:
        """Energy stored by the fine waves in elastic contacts of the same areas, their load, that
        of the contacts, and the share of what these leave closed that the elastic ones would."""
        approach = np.maximum(state.approach[closed] + step * gained, 0.0)
        here = contacts(approach)
        kept = here.force > 0
        force, width = here.force[kept], here.area[kept]
        elastic, intact = force, 1.0
        if hard:
            elastic = force / population.table.elastic_at(closed[kept], approach[kept])[0]
            spots = width @ law.elastic_share(elastic / width, share, width)
            intact = float(spots / (width @ law.remaining(force / width, share, width)))
        stored = law.stored(elastic / width, share)
        return float(np.sum(width * stored)), float(elastic.sum()), float(force.sum()), intact

    low, middle, high = (twin(step) for step in (-fall, 0.0, fall))
    gain = 0.5 * (high[2] - low[2]) / middle[2]

    def raised(before: tuple[float, ...], after: tuple[float, ...], wider: float) -> float:
        first = (after[0] - before[0]) / (after[1] - before[1])
        return law.lift(first, min(share * (1.0 + wider), 1.0))

    elastic = middle[2] / middle[1] * middle[3]
    lift = elastic * raised(low, high, 0.0)
    bend = min(raised(middle, high, 0.5 * gain) - raised(low, middle, -0.5 * gain), 0.0)
    change = elastic * bend
    if elastic < 1.0:
        part = state.contact_area / nominal
        lift += (1.0 - elastic) * law.bearing_lift(part)
        wider = part * (1.0 + gain)
        change += (1.0 - elastic) * (law.bearing_lift(wider) - law.bearing_lift(part))
    compliance = 1.0 / stiffness - change / (0.5 * (high[2] - low[2])) * nominal
    softer = 1.0 / unloading - middle[3] * bend / (0.5 * (high[1] - low[1])) * nominal
    separation = min(state.separation + lift, highest)
    loading = 1.0 / compliance
    return SurfacePoint(separation, area, loading, max(1.0 / softer, loading) if hard else loading)


def closed_areas(population: Population, law: SubContactLaw, state: PopulationState) -> Array:
    """Area [m^2] of each contact that the fine waves leave closed, shape (n,)."""
    closed, nominal = np.flatnonzero(state.force > 0), population.nominal_area
    area = np.zeros(len(state.force))
    whole = state.area[closed]
    pressure = state.force[closed] / whole
    share = state.contact_area / nominal
    for _ in range(2):
        area[closed] = whole * law.remaining(pressure, share, whole)
        share = 0.5 * (state.contact_area + float(area.sum())) / nominal
    return area
