"""Engine "sampled": misfit of the model on parts of a map, and the bounds that follow from it."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from asperity.bem.curve import bem_curve
from asperity.curve import contact_curve
from asperity.parameters import ENGINE
from asperity.results.interpolation import log_ratio
from surfaces.arrays import Array, Index, Mask
from surfaces.numerics import parallel
from surfaces.preparation.borders import make_periodic
from surfaces.preparation.filtering import bandpass
from surfaces.preparation.resampling import Resampled, resample

if TYPE_CHECKING:
    from collections.abc import Callable

    from asperity.bem.curve import SolvedLoad
    from asperity.halfspace.material import HalfSpace
    from asperity.model.plan import Plan
    from asperity.results.curve import ContactCurve
    from surfaces.heightmap import HeightMap

__all__ = ["PartMisfit", "corner", "long_waves", "misfit_on_parts"]


PARTS = ENGINE.parts

SAMPLED_ROWS = 4
"""Every fourth row of a map is taken for the means of its long waves."""

PARTS_TOGETHER = 2
"""Parts solved between two checks of the bounds, after the first ones. The number does not depend
on that of the threads, so that results do not either."""


@dataclass(frozen=True)
class PartMisfit:
    """Compares the model with boundary elements, whose error of the area is `error`."""

    material: HalfSpace
    error: float
    progress: Callable[[SolvedLoad], object]

    def __call__(self, hm: HeightMap, plan: Plan, pressures: Array, *, tell: bool = False) -> Array:
        """Differences of the model from boundary elements at n mean pressures [Pa], shape (5, n):
        separation [m]; logarithms of contact area, number of spots and stiffness; last the
        separation of the model [m]. NaN where the model has no answer. `tell` reports progress."""
        own_plan = replace(plan, scene=(hm.without_rounding, self.material))
        model = contact_curve(hm, self.material, pressures=pressures, plan=own_plan)
        true = bem_curve(
            hm,
            self.material,
            pressures=pressures,
            accuracy=self.error,
            boundary=plan.boundary,
            progress=self.progress if tell else None,
        )
        area = np.log(model.contact_area / true.contact_area)
        spots = np.log(np.maximum(model.contacts, 1.0) / np.maximum(true.contacts, 1.0))
        stiffness = log_ratio(model.extra["tangent_stiffness"], true.stiffness)
        apart = model.separation - true.separation
        return np.array([apart, area, spots, stiffness, model.separation])


def misfit_on_parts(
    judged: PartMisfit,
    hm: HeightMap,
    plan: Plan,
    model: ContactCurve,
    at: Index,
    shares: Array,
    allowed: Array,
    otherwise: Callable[[Mask], object] | None,
) -> tuple[Array, Array, Array]:
    """Misfit of the model at the n load points `at`, from parts of the map.

    Parameters
    ----------
    shares
        Share of the load that the model puts on each part, shape (parts, n).
    allowed
        Bounds of load and area to reach, shape (2, 1): parts are solved, those of the largest
        shares first, until the bounds are well within these.
    otherwise
        Solves load points on the whole map, or None. It gets a mask of the load points whose floor
        alone exceeds the bounds allowed, and runs beside the parts. If these are more than half of
        the load points, no part is solved.

    Returns
    -------
    misfit, bounds, floor
        Logarithms of load, area, number of spots and stiffness of the model over boundary elements,
        shape (4, n). Bounds of load and area, (2, n): twice the standard error of the mean over the
        parts, plus the floor, larger where few parts carry the load; NaN where no part was solved.
        The floor, (2, n).

    Notes
    -----
    A part gets the load that the model puts on it on the whole map, and the plan of the whole map.
    If the `long_waves` are solved on the whole map, the parts give only the change of the
    separation by the finer waves, which is added.
    """
    side, pressure = math.isqrt(len(shares)), model.mean_pressure[at]
    rate = model.stiffness[at] / pressure
    grid, whole = long_waves(hm, plan, side), np.zeros((5, len(at)))
    floor = np.tile(np.array(PARTS.floor)[:, None], len(at))
    if grid is not None:
        whole = judged(grid, plan.whole, pressure)
        fine = rate * (model.separation[at] - whole[-1])
        floor[0] = np.hypot(floor[0], PARTS.part * np.nan_to_num(fine))
    over_mean = len(shares) * shares
    # a part of large share has a mean pressure above that of the map, and long waves solved alone
    # have more contact than the map under the same load
    local, heaviest = over_mean * pressure, PARTS.heaviest if grid is None else 1.0
    usable = (over_mean > PARTS.least_load) & (local <= heaviest * pressure[-1])
    usable &= np.isfinite(whole[0])
    best = np.argsort(-np.where(usable, shares, 0.0).sum(axis=1), kind="stable")
    taken = _first(usable, best, side)
    beside = None
    if otherwise is not None:
        sure = floor * _on_floor(_fewer(taken * shares)) <= PARTS.enough * allowed
        taken &= sure.all(axis=0)
        unsure = np.logical_not(taken.any(axis=0))
        if 2 * np.count_nonzero(unsure) > len(at):
            taken[:] = False
        elif unsure.any():
            beside = functools.partial(otherwise, unsure)
    lightest = int(np.argmax(np.where(taken.any(axis=1), shares[:, 0], -1.0)))
    order = np.array([lightest, *best[best != lightest]])
    found, here = np.full((*shares.shape, 4), np.nan), _first(taken, order, PARTS.first)

    def solve(place: int) -> None:
        loads, options = here[place], {"long_alone": grid is not None, "tell": place == lightest}
        part = _part(hm, place, side)
        found[place, loads] = _on_part(judged, part, plan, local[place, loads], **options).T
        found[place, loads, 0] += whole[0, loads]

    some = order[here[order].any(axis=1)]
    while len(some):
        parallel.apart(solve, some, beside)
        _, bounds, number = _pooled(found, shares, rate, floor)
        enough = (number >= PARTS.first) & (bounds <= PARTS.enough * allowed).all(axis=0)
        taken[some] &= ~here[some]  # a part is solved once, even if it gave nothing
        here = taken & ~enough
        some, beside = order[here[order].any(axis=1)][:PARTS_TOGETHER], None
    return *_pooled(found, shares, rate, floor)[:2], floor


def _on_part(
    judged: PartMisfit, part: HeightMap, plan: Plan, loads: Array, *, long_alone: bool, tell: bool
) -> Array:
    """First four rows of `PartMisfit` on a part at mean pressures [Pa], by the plan of the whole
    map, shape (4, n). With `long_alone` the first row is the misfit of the change of the separation
    by the finer waves."""
    level, part = part.roughness.mean, part.about_mean
    among = plan.among and plan.among.lowered(level - part.roughness.mean)
    waves = _resampled(part, plan)
    cell = replace(plan.whole, boundary="periodic", among=among)
    own = replace(
        cell,
        sub_contact_law=plan.sub_contact_law,
        resampled=None if waves is part else Resampled(waves, (0.0, 0.0)),
    )
    misfit = judged(part, own, loads, tell=tell)[:4]
    if long_alone:
        misfit[0] -= judged(waves, cell, loads)[0]
    return misfit


def _first(parts: Mask, order: Index, count: int) -> Mask:
    """The first `count` of the marked parts in the order `order`, at each load point, shape
    (parts, n)."""
    first = np.zeros_like(parts)
    first[order] = parts[order] & (np.cumsum(parts[order], axis=0) <= count)
    return first


def long_waves(hm: HeightMap, plan: Plan, side: int) -> HeightMap | None:
    """The map that the plan solves, if waves longer than about half a part hold much of its height
    variance; else None. There are `side` parts along each side."""
    (row, column), (ny, nx) = corner(hm, side), hm.shape
    edges = [np.arange(4 * side + 1) * n // (4 * side) for n in (ny, nx)]
    rows = ((row + np.arange(*pair, SAMPLED_ROWS)) % ny for pair in itertools.pairwise(edges[0]))
    lines = np.roll([hm.source[each].mean(axis=0) for each in rows], -column, axis=1)
    means = np.add.reduceat(lines, edges[1][:-1], axis=1) / np.diff(edges[1])
    share = float(means.var()) / hm.roughness.rms_height**2
    return plan.solved(hm) if share > PARTS.long_waves else None


def _pooled(found: Array, shares: Array, rate: Array, floor: Array) -> tuple[Array, Array, Index]:
    """Weighted mean over the parts of the misfit `found`, shape (parts, n, 4), as (4, n); bounds of
    load and area, (2, n); and the number of parts that were solved, (n,).

    `rate` turns separations into logarithms of the load.

    Notes
    -----
    The mean of a sample of a finite population, with weights w that sum to W over the sample:
    standard error s (sum w^2 (1 - W))^(1/2) / W, unbiased variance s^2 = (sum w d^2 / W) /
    (1 - sum w^2 / W^2) (Cochran 1977, Sampling techniques, ch. 2). The bounds hold `alike`^(1/2)
    = 2 standard errors. A part that is cut out is not the part on the map: 1 - W counts as no less
    than one of `alike` parts.
    """
    known = np.isfinite(found).all(axis=-1)
    weights = np.where(known, shares, 0.0)
    share, found = (weights / _sum(weights))[..., None], np.nan_to_num(found)
    mean = (share * found).sum(axis=0).T
    scatter = np.sqrt((share * (found - mean.T) ** 2).sum(axis=0)).T
    for each in (mean, scatter):
        each[0] *= rate
    fewer, left = _fewer(weights), np.maximum(1.0 - weights.sum(axis=0), 1.0 / PARTS.alike)
    spread = scatter[:2] / np.sqrt(np.maximum(1.0 - fewer / PARTS.alike, np.finfo(float).tiny))
    floor = np.hypot(floor, PARTS.part * mean[:2]) * _on_floor(fewer)
    return mean, spread * np.sqrt(fewer * left) + floor, known.sum(axis=0)


def _sum(weights: Array) -> Array:
    """Sum over the parts, shape (n,); NaN where it is zero."""
    total = weights.sum(axis=0)
    return np.where(total > 0.0, total, np.nan)


def _fewer(weights: Array) -> Array:
    """How many times fewer than `PARTS.alike` parts of equal share carry the load, from their
    shares, shape (parts, n); NaN where the parts carry too little of it (`PARTS.cover`)."""
    total = _sum(weights)
    fewer = PARTS.alike * (weights**2).sum(axis=0) / total**2
    fewer[total < PARTS.cover / math.sqrt(len(weights))] = np.nan
    return np.asarray(fewer)


def _on_floor(fewer: Array) -> Array:
    """Factor on the floor of the bounds where `_fewer` parts carry the load."""
    return np.asarray(np.sqrt(0.5 + 0.5 * np.maximum(fewer, fewer**PARTS.few)))


def corner(hm: HeightMap, side: int) -> tuple[int, int]:
    """Row and column at which the first of `side` parts along each side begins.

    On a periodic map the edge between the highest point and its higher neighbor is in the middle of
    this part, so that the parts do not change if the map is moved or mirrored.
    """
    if not hm.periodic:
        return 0, 0
    (row, column), (ny, nx), beside = hm.roughness.summit, hm.shape, np.array([-1, 1])
    lower, upper = hm.source[(row + beside) % ny, column]
    left, right = hm.source[row, (column + beside) % nx]
    first, last = row - ny // (2 * side), column - nx // (2 * side)
    return (first + int(upper > lower)) % ny, (last + int(right > left)) % nx


def _part(hm: HeightMap, place: int, side: int) -> HeightMap:
    """Part number `place` of a map, made periodic."""
    rows, columns = (
        (first + np.arange(n * k // side, n * (k + 1) // side)) % n
        for first, n, k in zip(corner(hm, side), hm.shape, divmod(place, side), strict=True)
    )
    heights = [(0, hm.source[rows][:, columns])]
    shape = len(rows), len(columns)
    part = hm.with_rows(heights, shape, periodic=False, step={"step": "part", "place": place})
    return make_periodic(part, "smooth")


def _resampled(part: HeightMap, plan: Plan) -> HeightMap:
    """The part with the waves and the pixel size of the grid that the plan solves."""
    law, grid = plan.sub_contact_law, plan.resampled
    # the grid of the plan holds all waves that are kept: filtering there is faster
    moved = part if grid is None else resample(part, grid.hm.spacing)
    return moved if law is None else bandpass(moved, law.shortest, None)
