"""Contact areas where contacts have joined their neighbors."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf, erfinv

from asperity.parameters import DEFAULTS, Spots
from surfaces.numerics import parallel

from . import _coalescence_kernels

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from surfaces.peaks.summits import Summits

__all__ = ["Coalescence"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

BINS = 32
"""Depths at which the pixels of a basin are counted, a power of 2 (16 to 200 do not differ)."""

DEEPEST = 1.5
"""The last of them over the approach."""

ASTRIDE = (0.15, 0.3)
"""Share of its outline that a contact has in common with others up to which it is pressed alone,
and from which on it is a part of a larger one."""

CROSSED = 0.45
"""Share of the passes about a contact that are closed beyond which it counts as joined."""

SOME = (0.12, 0.18)
"""Share of the contact area in such contacts up to which nothing is done, and from which on all."""


@dataclass(frozen=True, eq=False)
class Coalescence:
    """The basins of all summits, on the pixels of their map.

    Attributes
    ----------
    summits
        Summits of a map.
    material
        Its half-space.
    fitted
        Constants of what joins.

    Notes
    -----
    The law of a contact presses its basin alone. Where contacts have joined, each is a part of a
    larger one, and what bounds it no longer bears on the pressure. The mean pressure of the larger
    one is that of any contact on such slopes, 0.6 E* times their rms for a paraboloid; boundary
    elements find 0.56 to 0.65 on measured maps, of contacts that have up to half of their outline
    in common with others. With slopes themselves in place of their squares forces add up over the
    parts of a contact,

        F = c E a^m int |grad h| dA,     c = 6/(pi p^2 (p + 2)),     p = 1 + m,

    a the radius of a disc of the area of the contact: exact for a paraboloid (2/pi E* int |grad h|
    dA for m = 0). The contact is the highest part of its basin that carries its force so. As the
    basin fills, the pressure grows faster than the share f of it that is closed: by
    erfinv(f)/(sqrt(pi)/2 f), as on random heights (Persson 2001).

    Neighbors take over pressure at the border that they share, so that joining adds area: a sum
    below that of the laws is the error of the formula on smooth summits, whose laws are nearer, and
    changes nothing. Contacts that the border cuts keep the area of their law, which knows the edge.
    """

    summits: Summits
    material: HalfSpace
    fitted: Spots = DEFAULTS.spots

    @functools.cached_property
    def passes(self) -> tuple[Rows, Array]:
        """Pairs of summits whose basins adjoin, (n, 2), and the mean depth [m] of the pass between
        them under both, (n,)."""
        summits = self.summits
        pairs = summits.single[summits.peaks.neighbors]
        apart = pairs[:, 0] != pairs[:, 1]
        pairs = pairs[apart]
        bend = np.asarray(summits.hm.roughness.curvature) * np.square(summits.hm.spacing)
        depth = summits.height[pairs].mean(axis=1) - summits.peaks.passes[apart]
        return pairs, np.asarray(depth + self.fitted.sag * np.sqrt(np.mean(bend**2)))

    @functools.cached_property
    def _around(self) -> Rows:
        """Number of passes about each summit, shape (all,)."""
        return np.bincount(self.passes[0].ravel(), minlength=len(self.summits))

    def areas(self, index: Rows, approach: Array, force: Array, area: Array) -> Array:
        """Contact areas [m^2] of the summits `index`, shape (n,).

        Parameters
        ----------
        index
            Rows of the summits, shape (n,); all others are open.
        approach, force, area
            Approaches [m], forces [N] and areas alone [m^2], shape (n,); zero where open.
        """
        part = _rise(self._joined(index, approach, area), SOME)
        if part == 0.0:
            return area
        closed = np.flatnonzero(force > 0.0)
        rows, force, alone = index[closed], force[closed], area[closed]
        whole, fall = self._carrying(rows, approach[closed], force)
        weight = part * _rise(self._astride(rows, fall), ASTRIDE)
        inner = (whole > 0.0) & ~self.summits.border[rows]
        gain = np.where(inner, weight * (whole - alone), 0.0)
        if gain.sum() <= 0.0:
            return area
        area = area.copy()
        area[closed] += gain
        return area

    def _joined(self, index: Rows, approach: Array, area: Array) -> float:
        """Share of the area in contacts of which many passes are closed."""
        pairs, depth = self.passes
        deep = np.zeros(len(self.summits))
        deep[index] = approach
        one, two = deep[pairs].T
        closed = (one > 0.0) & (two > 0.0) & (one + two > 2.0 * self.fitted.joined * depth)
        crossed = np.bincount(pairs[closed].ravel(), minlength=len(deep)) > CROSSED * self._around
        return float(area @ crossed[index]) / max(float(area.sum()), np.finfo(float).tiny)

    def _carrying(self, rows: Rows, approach: Array, force: Array) -> tuple[Array, Array]:
        """Areas [m^2] of the highest parts of the basins that carry the forces, and how far [m]
        they reach down, both (n,)."""
        summits, m = self.summits, self.material.m
        depth, scene = DEEPEST * approach, self._map(rows)
        kernel: Any = _coalescence_kernels.tally

        def part(first: int, last: int) -> Array:
            sums = np.zeros((2, len(rows), BINS))
            kernel(*scene, first, last, summits.height[rows], depth, *sums)
            return sums

        count, slope = self._over_lines(part)
        count, slope = np.cumsum(count, axis=1), np.cumsum(slope, axis=1)
        pixel, most = math.prod(summits.hm.spacing), summits.pixels[rows]
        every = np.arange(len(rows))
        stiff = 6.0 / (math.pi * (1.0 + m) ** 2 * (3.0 + m)) * self.material.modulus

        def down_to(bins: Rows) -> tuple[Array, Array]:
            """What the highest bins carry, so many of each basin, and erfinv of their share."""
            last = np.maximum(bins - 1, 0)
            closed = np.clip(count[every, last], 1e-9, most)
            carried = stiff * (pixel * closed / math.pi) ** (0.5 * m) * pixel * slope[every, last]
            closed /= most + 1.0
            filled = erfinv(closed)
            carried *= filled / (0.5 * math.sqrt(math.pi) * closed)
            return np.where(bins > 0, carried, 0.0), np.where(bins > 0, filled, 0.0)

        place = np.zeros(len(rows), np.int64)
        for step in 2 ** np.arange(int(math.log2(BINS)))[::-1]:
            place += np.where(down_to(place + step)[0] <= force, step, 0)
        (low, start), (high, end) = down_to(place), down_to(place + 1)
        way = np.clip((force - low) / np.where(high > low, high - low, 1.0), 0.0, 1.0)
        whole = pixel * (most + 1.0) * erf(start + way * (end - start))
        return whole, depth * (place + way) / BINS

    def _astride(self, rows: Rows, fall: Array) -> Array:
        """Share of the outline of each contact in common with others, (n,), if they reach `fall`
        [m] under their summits."""
        level, scene = self.summits.height[rows] - fall, self._map(rows)
        kernel: Any = _coalescence_kernels.outlines

        def part(first: int, last: int) -> Array:
            lengths = np.zeros((2, len(level)))
            scratch = np.empty((2, self.summits.hm.shape[1]), np.int64)
            kernel(*scene, first, last, level, scratch, *lengths)
            return lengths

        common, free = self._over_lines(part)
        return np.asarray(common / np.maximum(common + free, np.finfo(float).tiny))

    def _over_lines(self, part: Callable[[int, int], Array]) -> Array:
        """Sum of what blocks of the rows of the map give, on all threads."""
        heights = self.summits.hm.heights
        return np.asarray(
            np.sum(parallel.run(part, parallel.lines(len(heights), heights.size)), axis=0)
        )

    def _map(self, rows: Rows) -> tuple[Any, ...]:
        """What loops over the pixels read first, of the closed contacts on the summits `rows`."""
        summits = self.summits
        hm, place = summits.hm, np.full(len(summits), -1)
        place[rows] = np.arange(len(rows))
        slot = np.append(place[summits.owner], -1)
        return hm.heights, summits.peaks.labels, slot, hm.periodic, hm.spacing


def _rise(value: float | Array, ends: tuple[float, float]) -> Array:
    """From 0 to 1 between two values."""
    return np.clip((value - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)
