"""A rough surface decomposed into summits, their contact laws and their interaction."""

from __future__ import annotations

import functools
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.errors import InputError
from asperity.halfspace.scene import as_pressed
from asperity.interaction.population import Population, PopulationState
from asperity.microcontact.hertz import axis_ratios
from surfaces.arrays import Array, Index
from surfaces.heightmap import HeightMap
from surfaces.numerics.memory import on_disk
from surfaces.numerics.stored_array import StoredArray, mapped
from surfaces.patches import points_at
from surfaces.peaks.segmentation import segment
from surfaces.peaks.summits import locate_summits

from .corrections.joined_pairs import join
from .law_factory import LawFactory
from .law_rows import LoadShares
from .overlap import Blocks
from .plan import Plan

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from surfaces.peaks.summits import Summits

__all__ = ["Decomposition"]


@dataclass(frozen=True, eq=False, repr=False)
class Decomposition:
    """The summits of a surface with their laws, ready to be loaded.

    Attributes
    ----------
    hm, material, plan
        The map as it is pressed, the body, and the plan that was followed: of the whole map where
        too few summits stand above `Plan.above`.
    summits
        Summits, with the segmentation as `summits.peaks`. Rays are sampled later, when
        `law_factory` makes a law.
    law_factory
        Makes the laws of the summits.
    curvature, angle
        Principal curvatures [1/m], shape (n, 2), and direction of the long axis [rad], (n,), that
        give the shape of each contact; those of joined summits differ from `summits.curvature`.
    seconds
        Time of each stage [s].
    """

    hm: HeightMap
    material: HalfSpace
    plan: Plan
    summits: Summits
    law_factory: LawFactory
    curvature: Array
    angle: Array
    seconds: dict[str, float]

    @classmethod
    def of(cls, hm: HeightMap, material: HalfSpace, plan: Plan) -> Decomposition:
        """Segment the map, locate the summits and prepare their laws."""
        seconds = {"plan": plan.seconds, "segmentation": 0.0, "profiles": 0.0, "laws": 0.0}
        hm = as_pressed(hm, plan.boundary)
        summits = _summits(hm, plan, seconds)
        shares = LoadShares.of(summits, plan.among) if plan.law == "auto" else None
        if shares is not None and plan.above is not None and not shares.full:
            plan = plan.of_whole_map()  # laws may not depend on the loads that are asked for
            summits = _summits(hm, plan, seconds)
            shares = LoadShares.of(summits, plan.among)
        parameters, curvature, angle = plan.parameters, summits.curvature, summits.angle
        if shares is not None and parameters.corrections.joined_pairs:
            summits, curvature, angle = join(summits, shares, material, parameters)
            shares = LoadShares.of(summits, plan.among)
        stored = isinstance(summits.hm.source, StoredArray)
        if stored:
            shares = shares and on_disk(shares)
            summits = on_disk(replace(summits, peaks=on_disk(summits.peaks)))
        made = cls(
            hm=hm,
            material=material,
            plan=plan,
            summits=summits,
            law_factory=LawFactory(summits, shares, material, plan.law, parameters, seconds),
            curvature=curvature,
            angle=angle,
            seconds=seconds,
        )
        return on_disk(made) if stored else made

    def of_whole_map(self) -> Decomposition:
        """The decomposition with all summits of the map, however low."""
        return Decomposition.of(self.hm, self.material, self.plan.of_whole_map())

    def of_hardness(self, material: HalfSpace) -> Decomposition:
        """A decomposition with the hardness of `material`, which shares the summits and the
        elastic laws of this one, which was made with a hardness if `material` has one."""
        if np.isinf(self.material.hardness) and np.isfinite(material.hardness):
            raise InputError("this decomposition was made without a hardness; make another one")
        seconds = dict.fromkeys(self.seconds, 0.0)
        return replace(
            self,
            material=material,
            law_factory=self.law_factory.of_hardness(material, seconds),
            seconds=seconds,
        )

    @functools.cached_property
    def population(self) -> Population:
        """The contacts with their laws, and with interaction if the plan has it."""
        return Population(
            x=self.places[1],
            y=self.places[0],
            height=self.summits.height - self.hm.roughness.mean,
            table=self.law_factory.all_laws(),
            cell=self.hm.size,
            boundary=self.plan.boundary,
            material=self.material,
            interaction=self.plan.interaction,
            curvature=self.curvature,
            angle=self.angle,
            parameters=self.plan.parameters,
        )

    @functools.cached_property
    def interacting(self) -> Population:
        """The contacts with interaction, whatever the plan says."""
        return self.population.coupled()

    @property
    def solved(self) -> HeightMap:
        """The map whose summits are the contacts: the plan may have changed its grid."""
        return self.plan.solved(self.hm)

    @functools.cached_property
    def places(self) -> tuple[Array, Array]:
        """Coordinates y and x [m] of the summits on `hm`, shape (n,) each."""
        down, right = self.corner
        return self.summits.y + down, self.summits.x + right

    @property
    def corner(self) -> tuple[float, float]:
        """Coordinates (y, x) [m] on `hm` of the corner of the map `solved`."""
        return (0.0, 0.0) if self.plan.resampled is None else self.plan.resampled.corner

    @functools.cached_property
    def blocks(self) -> Blocks:
        """The map `solved` by its blocks."""
        summits, mean = self.summits, self.hm.roughness.mean
        places = summits.y, summits.x
        return Blocks.of(self.solved, mean, *places, self.material, wraps=self.wraps)

    @property
    def wraps(self) -> bool:
        """Whether the surface continues across the border of the map."""
        return self.plan.boundary == "periodic"

    @property
    def labels(self) -> NDArray[np.int32]:
        """Peak whose basin holds each pixel of the map, shape (ny, nx); -1 where not flooded."""
        labels = self.summits.peaks.labels
        if labels.shape == self.hm.shape:
            return mapped(labels)
        rows, cols = (np.arange(n) for n in self.hm.shape)
        return self.labels_at(rows[:, None], cols)

    def labels_at(self, rows: Index, cols: Index) -> NDArray[np.int32]:
        """Peak whose basin holds each of the pixels `rows`, `cols` of `hm`; -1 where not flooded.

        The centre of a pixel of `hm` may lie on the border between pixels of `solved`: the highest
        of these pixels decides.
        """
        labels, heights = self.summits.peaks.labels, self.solved.source
        if labels.shape == self.hm.shape:
            return np.asarray(labels[rows, cols])
        (below, above), (right, left) = (
            # integers: both grids have their corners on a common grid, of which half steps count
            [
                ((2 * at + 1) * m - round(2 * n * corner / step) - shift) // (2 * n) % m
                for shift in (0, 1)
            ]
            for at, n, m, corner, step in zip(
                (rows, cols),
                self.hm.shape,
                labels.shape,
                self.corner,
                self.solved.spacing,
                strict=True,
            )
        )
        found, top = labels[below, right], heights[below, right]
        for pixels in ((above, right), (below, left), (above, left)):
            higher = heights[pixels] > top
            found, top = np.where(higher, labels[pixels], found), np.maximum(top, heights[pixels])
        return np.asarray(found)

    @functools.cached_property
    def aspect(self) -> Array:
        """Short over long axis of the contact on each summit, shape (n,)."""
        return axis_ratios(self.summits.curvature, self.material.m)

    @functools.cached_property
    def passes(self) -> tuple[NDArray[np.int32], Array]:
        """Pairs of summits whose basins adjoin, (n, 2), and the depth [m] of the pass between them
        below the mean of the two heights, (n,)."""
        summits = self.summits
        pairs = summits.single.astype(np.int32)[summits.peaks.neighbors]
        apart = pairs[:, 0] != pairs[:, 1]
        pairs = pairs[apart]
        bend = np.asarray(summits.hm.roughness.curvature) * np.square(summits.hm.spacing)
        sag = self.plan.parameters.spots.sag * np.sqrt(np.mean(bend**2))
        depth = summits.height[pairs].mean(axis=1) - summits.peaks.passes[apart]
        return pairs, np.asarray(depth + sag)

    def summit_pixels(self, rows: Index, hm: HeightMap) -> Index:
        """Flat index of the pixel of `hm`, which is `self.hm` or `self.solved`, that holds each of
        the summits `rows`."""
        places = (self.summits.y, self.summits.x) if hm is self.solved else self.places
        row, col = (
            np.floor(at[rows] / step).astype(np.int64)
            for at, step in zip(places, hm.spacing, strict=True)
        )
        row, col = (
            at % n if self.wraps else np.clip(at, 0, n - 1)
            for at, n in zip((row, col), hm.shape, strict=True)
        )
        return np.asarray(row * hm.shape[1] + col)

    @functools.cached_property
    def top_areas(self) -> Array:
        """Area [m^2] of the disc with the second moment of the flat top of each summit, shape (n,).

        The flat top are the points of the basin as high as the highest of the nine pixels about the
        summit. Their mean squared distance r^2 from the summit gives the area 2 pi r^2, since a
        disc of area A has A/(2 pi). The area is 0 if no neighbors have the same height, and if a
        law stands for the finest waves, which are random.
        """
        hm, count = self.hm, len(self.summits)
        if not hm.has_equal_neighbors or self.plan.sub_contact_law is not None:
            return np.zeros(count)
        row, col = np.divmod(self.summit_pixels(np.arange(count), hm), hm.shape[1])
        around = np.array([-1, 0, 1])
        rows, cols = (
            (at[:, None] + around) % n if self.wraps else np.clip(at[:, None] + around, 0, n - 1)
            for at, n in zip((row, col), hm.shape, strict=True)
        )
        top = hm.source[rows[:, :, None], cols[:, None, :]].max(axis=(1, 2))
        level = points_at(hm.source, np.unique(top))
        summit = np.append(self.summits.owner, count)[self.labels_at(*level)]
        held = hm.source[level] == np.append(top, np.inf)[summit]
        level, summit = (level[0][held], level[1][held]), summit[held]
        square = np.zeros(summit.size)
        for at, middle, step, n in zip(level, (row, col), hm.spacing, hm.shape, strict=True):
            away = at - middle[summit]
            square += (step * (away - n * np.round(away / n) if self.wraps else away)) ** 2
        total, points = np.bincount(summit, square, count), np.bincount(summit, None, count)
        return np.asarray(2.0 * np.pi * total / np.maximum(points, 1))

    def warnings(self, separation: float) -> list[str]:
        """Warnings that load points down to a separation [m] add to those of the plan."""
        height = self.population.height[sorted(self.law_factory.without)]
        silent = int(np.count_nonzero(height > separation))
        if not silent:
            return []
        cure = "boundary elements" if self.plan.law == "auto" else 'law="auto" (--law auto)'
        return [
            f"summits above the flat that have no contact by the law {self.plan.law!r} and carry "
            f"nothing: {silent}; take {cure}"
        ]

    def deep_enough(self, state: PopulationState) -> bool:
        """Whether no contact came near the height below which nothing was segmented."""
        return self.plan.above is None or state.lowest_candidate >= self.plan.above


def _summits(hm: HeightMap, plan: Plan, seconds: dict[str, float]) -> Summits:
    """Peaks and summits of the map that is solved; adds the times of both to `seconds`."""
    start = time.perf_counter()
    solved = plan.solved(hm)
    above = None if plan.above is None else plan.above + hm.roughness.mean
    if above is not None and plan.sub_contact_law is not None:
        # the longer waves may stay far below the highest point of all
        above = min(above, solved.roughness.highest - 0.5 * solved.roughness.rms_height)
    peaks = segment(solved, above=above)
    between = time.perf_counter()
    summits = locate_summits(solved, peaks)
    seconds["segmentation"] += between - start
    seconds["profiles"] += time.perf_counter() - between
    return summits
