"""Sub-contact roughness: the law of waves too short for contacts of their own, and the load point
of the whole surface at a state of the contacts of the longer waves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from asperity.parameters import SubContact
from surfaces.arrays import Array

if TYPE_CHECKING:
    from asperity.interaction.population import Population, PopulationState

__all__ = ["SubContactLaw", "SurfacePoint", "closed_areas", "surface_point"]


LOAD_STEP = 0.02
"""Relative change of the load for the central differences of `surface_point`."""

MOST_CLOSED = 0.9
"""Area fraction up to which the bearing curve is evaluated; at 1 it is infinite. Load points beyond
0.5 are refused, but a search may pass through them."""


@dataclass(frozen=True)
class SubContactLaw:
    """Law of random fine waves within the contacts of the longer waves.

    Parameters
    ----------
    shortest
        Length [m] of the shortest of the longer waves.
    ratio
        Variance of the pressure that presses the fine waves flat, over that of the longer waves.
    variance
        Variance V [Pa^2] of the pressure that presses the fine waves flat.
    energy
        Elastic energy e per area [J/m^2] of the fine waves pressed flat.
    number
        Mean wave number [1/m] of the fine waves: the ratio of their V to their e, as of one wave.
    m
        Exponent of the grading of the body.
    rms
        Rms height [m] of the longer waves, and of all waves.
    fitted
        Constants of the law.

    Notes
    -----
    In full contact a wave h_q has the pressure h_q / L(q), with the compliance L = c q^(m - 1) / E
    (docs/development/half_space.md; c = 2 for m = 0): V = <p^2> = sum |h_q|^2 / L^2, e = sum
    |h_q|^2 / 2 L, so for m = 0 V = E*^2/4 <|grad h|^2>.

    *Area.* Fine waves spread the distribution of the pressures of a contact; the contact opens
    where the pressure would be zero (Persson 2001). The pressures of a rough contact of mean
    pressure p have a Rayleigh distribution of scale s = sqrt(2/pi) p. The share of its area that
    stays closed, and the complementary energy Phi = int u dp of the local gap u per area, are

        A/A0 = 1 / sqrt(1 + b),   Phi = e arsinh(sqrt(b)) / sqrt(b),   b = g V / s^2.

    In a contact of radius a, x = a times the mean wave number, V acts on the area as
    V x^2 / (x^2 + `fitted.seen`^2). Contacts about to open spread less than V: g = g0 + (1 - g0)
    P^2, where P is the area fraction (here the mean of those with and without the fine waves). Wang
    & Mueser (2017) have g0 = 5/9; boundary elements give 0.50 to 0.63 (`fitted.spread`), and 0.4 to
    0.66 for m = 0.3 to -0.3. All was fitted without microcontacts, to the pressures of solutions of
    the longer waves, for Hurst exponents 0.5 to 0.9 and one to four octaves
    (docs/development/sub_contact_roughness.md).

    *Lift.* To first order in the fine waves a load F lifts the flat by d(sum Phi)/dF. Boundary
    elements give

        (1 + c (1 - P)^n) d(sum Phi)/dF + c' max(z - z0, 0) (rms of all - rms of the longer waves),

    where a normal variable exceeds z with the probability P: few, light contacts meet the fine
    waves as heights. c = `fitted.lift`, n = `fitted.lift_power`, c' = `fitted.tops`, z0 =
    `fitted.tops_from`.

    *Hardness.* With a hardness H contacts keep at least p/H of their area. If elastic ones keep the
    share e, these keep c with 1 - c^3 = (1 - e^3) (1 - (p/H)^3). The elastic part of the lift is
    (F/F_e) (e/c), where F_e is the load of elastic contacts of the areas of the longer waves. The
    longer waves may still be elastic (F = F_e) where the fine ones have yielded (e < c). The rest
    of the lift is that of the bearing curve of a random surface: z times the difference of the rms
    heights. As the load falls, yielded spots respond as elastic spots of their areas, whose load is
    larger by c/e.
    """

    shortest: float
    ratio: float
    variance: float
    energy: float
    number: float
    m: float
    rms: tuple[float, float]
    fitted: SubContact

    @property
    def spread(self) -> float:
        """g0 of the notes [-]."""
        fitted = self.fitted
        plain = fitted.spread + fitted.more_spread * self.ratio / (1.0 + self.ratio)
        graded = 1.0 - fitted.graded_spread[0] * self.m - fitted.graded_spread[1] * self.m**2
        return plain * graded

    def remaining(
        self, pressure: ArrayLike, share: float, area: ArrayLike = np.inf, hardness: float = np.inf
    ) -> Array:
        """Share c of the area of contacts that stays closed, at their mean `pressure` p [Pa].

        `share` is P. Without an `area` [m^2] contacts are much wider than the fine waves; without a
        `hardness` [Pa] they are elastic.
        """
        closed = self.elastic_share(pressure, share, area) ** 3
        yielded = np.minimum(np.asarray(pressure) / hardness, 1.0) ** 3
        return np.asarray(np.cbrt(closed + yielded * (1.0 - closed)))

    def elastic_share(self, pressure: ArrayLike, share: float, area: ArrayLike) -> Array:
        """Share e of the area of elastic contacts that stays closed; arguments of `remaining`."""
        unseen = self.fitted.seen**2 * np.pi / (self.number**2 * np.asarray(area, float))
        opening = self._opening(pressure, share) ** 2 / (1.0 + unseen)
        return np.asarray(1.0 / np.sqrt(1.0 + opening))

    def stored(self, pressure: ArrayLike, share: float) -> Array:
        """Complementary energy per area [J/m^2] of contacts of mean pressure p [Pa]."""
        root = self._opening(pressure, share)
        return np.asarray(self.energy * np.arcsinh(root) / root)

    def lift(self, first: float, share: float) -> float:
        """Lift [m] of elastic contacts at the area fraction P; `first` is d(sum Phi)/dF [m]."""
        fitted = self.fitted
        height = fitted.lift * (1.0 - fitted.graded_lift * self.m)
        tops = fitted.tops * (1.0 - fitted.graded_tops * self.m)
        light = max(-float(ndtri(share)) - fitted.tops_from, 0.0)
        longer, whole = self.rms
        more = height * (1.0 - share) ** fitted.lift_power
        return float((1.0 + more) * first + tops * light * (whole - longer))

    def bearing_lift(self, share: float) -> float:
        """Height [m] by which the fine waves raise the bearing curve at the area fraction P."""
        longer, whole = self.rms
        return float(-ndtri(min(share, MOST_CLOSED)) * (whole - longer))

    def _opening(self, pressure: ArrayLike, share: float) -> Array:
        """sqrt(b) of the notes."""
        spread = self.spread + (1.0 - self.spread) * share**2
        scale = np.sqrt(2.0 / np.pi) * np.maximum(np.asarray(pressure, float), 1e-300)
        return np.asarray(np.sqrt(spread * self.variance) / scale)


@dataclass(frozen=True)
class SurfacePoint:
    """Load point of the whole surface, with all its waves.

    Attributes
    ----------
    separation
        Distance of the flat from the mean plane [m].
    contact_area
        Contact area [m^2].
    stiffness
        Minus the slope of mean pressure over separation [Pa/m].
    unloading
        Stiffness [Pa/m] as the load begins to fall; contacts at the hardness keep their areas.
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
    """Load point of the whole surface at a state of the contacts.

    Without a `law` the contacts are those of all waves, and the state is that of the surface.
    `area` [m^2] is what the fine waves leave closed. The flat stands no higher than `highest` [m],
    the height of the highest point of the whole surface above its mean plane.

    Notes
    -----
    d(sum Phi)/dF is a central difference along the response of all contacts to a small fall of the
    flat (the tangent of the coupled problem). The lift falls as the load grows; a change of the
    other sign (`bend`) is set to zero. It can come from a rough solve: contacts that its last step
    has opened have no approach, so that all of them bear a step further and none a step back.
    """
    stiffness = unloading = state.normal_stiffness
    hardness = population.material.hardness
    hard = hardness < np.inf
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
    response = state.response[closed]
    if not stiffness > 0.0:  # a failed solve, marked as such
        return SurfacePoint(state.separation, area, stiffness, stiffness)
    fall = LOAD_STEP * state.mean_pressure / stiffness

    def after_fall(step: float) -> tuple[float, float, float, float]:
        """After a fall of the flat by `step` [m]: sum Phi [J] and load [N] of elastic contacts of
        the same areas, load [N] of the contacts, and e/c."""
        approach = np.maximum(state.approach[closed] + step * response, 0.0)
        here = contacts(approach)
        kept = here.force > 0
        force, width = here.force[kept], here.area[kept]
        elastic, intact = force, 1.0
        if hard:
            elastic = force / population.table.elastic_at(closed[kept], approach[kept])[0]
            spots = width @ law.elastic_share(elastic / width, share, width)
            closed_share = law.remaining(force / width, share, width, hardness)
            intact = float(spots / (width @ closed_share))
        stored = law.stored(elastic / width, share)
        return float(np.sum(width * stored)), float(elastic.sum()), float(force.sum()), intact

    low, middle, high = (after_fall(step) for step in (-fall, 0.0, fall))
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
    """Area [m^2] that the fine waves leave closed in each contact, shape (n,)."""
    closed, nominal = np.flatnonzero(state.force > 0), population.nominal_area
    area, hardness = np.zeros(len(state.force)), population.material.hardness
    whole = state.area[closed]
    pressure = state.force[closed] / whole
    share = state.contact_area / nominal
    for _ in range(2):
        area[closed] = whole * law.remaining(pressure, share, whole, hardness)
        share = 0.5 * (state.contact_area + float(area.sum())) / nominal
    return area
