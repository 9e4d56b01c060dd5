"""A rough surface decomposed into asperities: peaks, contact laws and their interaction."""

from __future__ import annotations

import copy
import functools
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.contacts.table import aspect_ratio
from asperity.interaction.population import Population, PopulationState
from asperity.microcontact.lazy_table import GrowingTable
from asperity.multiscale.surface_point import FinePoint, closed_area, fine_point
from asperity.trust.outside_model import top_areas
from surfaces.heightmap import HeightMap
from surfaces.peaks.segmentation import segment
from surfaces.peaks.summits import locate_summits

from .law_factory import SummitLaws
from .load_shares import Ranking
from .plan import Plan

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from surfaces.peaks.peaks import Peaks
    from surfaces.peaks.summits import Summits

__all__ = ["Asperities"]

Array = NDArray[np.float64]

LONGEST = 1.9
"""Share of the map in discs on the long axes of the contacts beyond which a point is refused. With
lay of 10:1 (shortest wave 8 pixels) the load is 24 to 32 % too high there, at 9 % of contact, with
20:1 half as much again at 5 %; 4:1 reaches 1.8 at 27 %, maps without lay 1 (seeds 1, 2, 11)."""


@dataclass(frozen=True, eq=False, repr=False)
class Asperities:
    """A surface taken apart into peaks, ready to be loaded.

    Attributes
    ----------
    hm, material, plan
        What it was made from.
    peaks, profiles
        Segmentation and summits; the rays of a summit are sampled when its law is made.
    laws
        Makes the laws of the summits.
    population
        The microcontacts with their laws and their interaction.
    seconds
        Time of each stage [s].
    """

    hm: HeightMap
    material: HalfSpace
    plan: Plan
    peaks: Peaks
    profiles: Summits
    laws: SummitLaws
    population: Population
    seconds: dict[str, float]

    @classmethod
    def of(cls, hm: HeightMap, material: HalfSpace, plan: Plan) -> Asperities:
        """Segment the map, fit the profiles and tabulate the contact laws."""
        clock, seconds = time.perf_counter, {"plan": plan.seconds}
        start = clock()
        mean = hm.roughness.mean
        solved = hm if plan.resampled is None else plan.resampled
        if plan.boundary == "free" and solved.periodic:
            solved = solved.replace(periodic=False)  # a finite punch is cut at its border
        above = None if plan.above is None else plan.above + mean
        if above is not None and plan.fine is not None:
            # the longer waves may stay far below the highest point of all
            above = min(above, solved.roughness.highest - 0.5 * solved.roughness.rms_height)
        peaks = segment(solved, above=above)
        seconds["segmentation"] = clock() - start
        start = clock()
        profiles = locate_summits(solved, peaks)
        seconds["profiles"] = clock() - start
        seconds["laws"] = 0.0
        ranking = None
        if plan.law == "auto":
            ranking = Ranking(profiles)
            if above is not None and not ranking.full:
                # laws may not depend on the loads that are asked for
                return cls.of(hm, material, replace(plan, above=None))
            ranking = ranking.joined(material)
            profiles = ranking.summits
        laws = SummitLaws(hm, profiles, ranking, material, plan.law, seconds)
        forms = profiles if ranking is None else ranking
        population = Population(
            x=profiles.x,
            y=profiles.y,
            height=profiles.height - mean,
            table=GrowingTable(len(profiles), laws.table),
            cell=hm.size,
            boundary=plan.boundary,
            material=material,
            interaction=plan.interaction,
            curvature=forms.curvature,
            angle=forms.angle,
        )
        return cls(hm, material, plan, peaks, profiles, laws, population, seconds)

    @property
    def solved(self) -> HeightMap:
        """The map whose summits are the contacts: on fewer points where the plan says so."""
        return self.hm if self.plan.resampled is None else self.plan.resampled

    @property
    def labels(self) -> NDArray[np.int32]:
        """Peak whose basin holds each pixel of the map, shape (ny, nx); -1 where not flooded.

        On a finer grid the middle of a pixel may lie between pixels: the highest of them counts.
        """
        labels, heights = self.peaks.labels, self.solved.heights
        if labels.shape == self.hm.shape:
            return labels
        sizes = list(zip(self.hm.shape, labels.shape, strict=True))
        rows, cols = ((2 * np.arange(n) + 1) * m // (2 * n) for n, m in sizes)
        found, top = labels[np.ix_(rows, cols)], heights[np.ix_(rows, cols)]
        above, left = (((2 * np.arange(n) + 1) * m - 1) // (2 * n) for n, m in sizes)
        for place in (np.ix_(above, cols), np.ix_(rows, left), np.ix_(above, left)):
            higher = heights[place] > top
            found, top = np.where(higher, labels[place], found), np.maximum(top, heights[place])
        return found

    @functools.cached_property
    def coupled(self) -> Population:
        """The same contacts with interaction, where the plan leaves it out."""
        found = copy.copy(self.population)
        found.interaction = found.boundary == "periodic" or len(found) > 1
        return found

    @functools.cached_property
    def aspect(self) -> NDArray[np.float64]:
        """Short over long axis of the contact on each summit, shape (n,)."""
        return aspect_ratio(self.profiles.curvature)

    @functools.cached_property
    def top_areas(self) -> Array:
        """Area [m^2] of the flat top of each summit, shape (n,); 0 where it has none."""
        return top_areas(self)

    def point(self, state: PopulationState) -> FinePoint:
        """Separation, area and stiffness of the whole surface at a state of its contacts."""
        if self.plan.fine is None:
            return FinePoint.plain(state)
        found = self.hm.roughness
        return fine_point(self.population, self.plan.fine, state, found.highest - found.mean)

    def refused(self, state: PopulationState, place: FinePoint) -> PopulationState:
        """The state of a point, refused where contacts are so long that they overlap end to end."""
        closed = np.flatnonzero(state.force > 0)
        if not (closed.size and self.plan.interaction):
            return state
        share = state.force[closed] / state.force.sum()
        longer = np.exp(-np.sum(share * np.log(self.aspect[closed])))
        if longer * place.contact_area <= LONGEST * self.population.nominal_area:
            return state
        reason = "the contacts on the ridges of the lay are so long that they overlap end to end"
        return replace(state, converged=False, reason=state.reason or reason)

    def closed_area(self, state: PopulationState) -> NDArray[np.float64]:
        """Area [m^2] that touches within each contact, shape (n,)."""
        if self.plan.fine is None:
            return state.area
        return closed_area(self.population, self.plan.fine, state)

    def warnings(self, separation: float) -> list[str]:
        """Reasons to doubt load points down to a separation [m], besides those of the plan."""
        height = self.population.height[sorted(self.laws.without)]
        silent = int(np.count_nonzero(height > separation))
        if not silent:
            return []
        return [
            f"summits above the flat that have no contact by the law {self.plan.law!r} and carry "
            f'nothing: {silent}; take law="auto" (--law auto)'
        ]

    def deep_enough(self, state: PopulationState) -> bool:
        """Whether no contact came near the height below which nothing was segmented."""
        return self.plan.above is None or state.lowest_candidate >= self.plan.above
