"""The curve of the model on a large map of random waves, checked on parts of it.

What the model leaves out is a matter of neighbors, and repeats itself over a random surface: some
parts tell it, at a fraction of the cost. The longest waves, which no part holds, are few.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.bem.curve import bem_curve
from asperity.curve import contact_curve
from asperity.halfspace.checks import model_warnings
from asperity.multiscale.wave_split import random_waves
from asperity.trust.verified import (
    answered,
    bounds_at,
    corrected,
    misfit_at,
    pixel_scatter,
    solved_points,
)
from surfaces.preparation.filtering import bandpass, make_periodic
from surfaces.preparation.resampling import resample

if TYPE_CHECKING:
    from collections.abc import Callable

    from asperity.bem.curve import SolvedLoad
    from asperity.contacts.run import ContactRun
    from asperity.halfspace.material import HalfSpace
    from asperity.model.plan import Plan
    from asperity.results.curve import ContactCurve
    from asperity.trust.verified import Accuracy, Judge
    from surfaces.heightmap import HeightMap

__all__ = ["can_sample", "parts_along", "sampled"]

Array = NDArray[np.float64]

SIDE = 4
"""Least parts along each side of a map; as many are solved at each load point."""

PART_POINTS, GRID_POINTS = 512, 75
"""Points along the shorter side of a part, and of the grid that the model solves on it, of maps
that have more than `SIDE` of such parts along a side."""

PART_SHARE = 0.05
"""Error of the area by boundary elements on a part over the accuracy asked for: less than that of
anchors, as it widens the bounds of all load points."""

LOADS = 4
"""Load points at which they are solved; between them the misfit is interpolated."""

LEAST_SHARE = 0.02
"""Load on a part over its share of the area from which on it is solved at a load point."""

HEAVIEST = 4.0
"""Load on a part, over that of as large a part of the map at the heaviest load point, up to which
it is solved: those that carry most of it are loaded above the mean. One where the long waves are
solved alone, too: they touch on more of the area, beyond what the model tells."""

LEAST_COVER = 0.4
"""Load on the parts solved at a load point, over what as many would carry if all carried alike,
below which they do not tell of the whole."""

LEAST_POINTS = 1536
"""Points of the shorter side of a map from which on parts of it are representative."""

FLOOR = 0.02, 0.04
"""Bound of load and area beside the scatter over `ALIKE` parts that carry alike; half of its square
is common to all parts (docs/development/verification.md)."""

ALIKE = 4
"""Parts that carry alike, over whose scatter `FLOOR` is the bound."""

FEW = 2.0
"""Power of `ALIKE` over the number of parts with which the squares of `FLOOR` grow where that is
less: the load follows the heights of few summits, the area their shapes."""

COARSE = 0.87
"""Rms height of the waves whose contacts are solved over that of all from which on the parts of a
map tell of it: white noise on the pixels has 0.6, Hurst exponents above 0 more than 0.9."""

LONGEST_LAY = 3.0
"""Slopes across over those along a lay from which on contacts reach over the borders of parts."""

SPARE = 1.5
"""Accuracies over these floors from which on parts are worth a try."""


def can_sample(hm: HeightMap, material: HalfSpace, plan: Plan, accuracy: Accuracy) -> bool:
    """Whether parts of a map can tell of the whole of it as accurately as asked.

    Not where the waves that act as a law hold much of the height: light contacts are then extremes
    of the whole map. Nor with a hardness: the load then follows single summits, and the part on
    which the highest one stands need not be the one on which the model sees it. Nor on a graded
    body, whose parts misjudge how far the whole sinks; nor where contacts are as long as parts.
    """
    law = plan.sub_contact_law
    if material.hardness < math.inf or material.m != 0.0:
        return False
    if law is not None and law.rms[0] < COARSE * law.rms[1]:
        return False
    enough = min(accuracy.load / FLOOR[0], accuracy.area / FLOOR[1]) >= SPARE
    large = min(hm.shape) >= LEAST_POINTS
    doubts = model_warnings(hm, LONGEST_LAY) if enough and large else []
    return enough and large and not doubts and random_waves(hm)


def sampled(
    hm: HeightMap,
    plan: Plan,
    run: ContactRun,
    kind: str,
    values: Array,
    judge: Judge | None,
    accuracy: Accuracy,
    progress: Callable[[SolvedLoad], object],
) -> ContactCurve | None:
    """Correct and bound a curve of the model by its misfit on parts of the map.

    None where they leave more open than asked at more than half of the load points.

    Parameters
    ----------
    hm
        The map, for which `can_sample` holds.
    plan, run
        Plan of the model and what it found, n load points.
    kind, values
        "pressure" or "separation", and the load points asked for, shape (n,).
    judge
        Boundary elements on the whole map, for load points where the parts leave more open than
        asked; None: these keep their bounds, NaN where no part tells anything.
    accuracy
        Errors allowed.
    progress
        Called with every load point that boundary elements have solved on the part that carries
        most of the lightest load.

    Notes
    -----
    The bounds are the scatter of the misfit over the parts and a floor, larger where few of them
    carry the load (docs/development/verification.md).
    """
    model = run.curve
    points = answered(model)
    nodes = np.unique(np.linspace(0, len(points) - 1, LOADS).astype(np.int64))
    at, grain = points[nodes], pixel_scatter(hm, model)[points]
    allowed = np.array([[accuracy.load], [accuracy.area]])
    error = PART_SHARE * accuracy.area
    judged = _Judged(run.decomposition.material, error, progress)
    shares = _load_shares(run, parts_along(hm, plan))[:, at]
    misfit, bounds = _misfit(
        judged, hm, plan, model, at, shares, np.inf if judge is None else allowed
    )
    bounds[1] += error
    solved: dict[int, ContactCurve] = {}
    if judge is not None:
        left = ~_within(bounds, grain[nodes], allowed)  # where no part tells anything it is NaN
        if 2 * np.count_nonzero(left) > len(nodes):
            return None
        solved = solved_points(judge, values, at[left])
        misfit[:, left] = misfit_at(model, kind, at[left], solved)
        # what parts leave open at best stays between loads that are solved on the whole map
        bounds[:, left] = np.maximum(bounds_at(at[left], solved), np.array(FLOOR)[:, None])
    position = np.log(model.mean_pressure[points])
    bend = _bend(position, position[nodes], misfit[:2].T)
    misfit, bounds = (
        np.array([np.interp(position, position[nodes], row) for row in each])
        for each in (misfit, bounds)
    )
    bounds += bend
    if judge is not None:
        met = points[_within(bounds, grain, allowed)]
        rest = np.setdiff1d(np.arange(len(model)), [*met, *solved])
        if len(rest) + len(solved) > len(model) // 2:
            return None
        solved |= solved_points(judge, values, rest)
    bounds[1] += grain
    return corrected(hm, model, kind, points, np.nan_to_num(misfit), bounds, solved)


def _within(bounds: Array, grain: Array, allowed: Array) -> NDArray[np.bool_]:
    """Load points at which bounds of load and area, shape (2, n), are within those allowed, (2, 1),
    the scatter of pixels counted in."""
    return np.asarray((bounds[0] <= allowed[0]) & (bounds[1] + grain <= allowed[1]))


@dataclass(frozen=True)
class _Judged:
    """Sets the model against boundary elements, of this error of the area."""

    material: HalfSpace
    error: float
    progress: Callable[[SolvedLoad], object]

    def __call__(self, hm: HeightMap, plan: Plan, pressures: Array, *, tell: bool = False) -> Array:
        """Model less boundary elements, shape (3, n): separation [m], and the logarithms of contact
        area and number of spots; NaN where the model has no answer."""
        scene = replace(plan, scene=(hm.without_rounding, self.material))
        model = contact_curve(hm, self.material, pressures=pressures, plan=scene)
        exact = bem_curve(
            hm,
            self.material,
            pressures=pressures,
            accuracy=self.error,
            coarsen=False,
            boundary=plan.boundary,
            progress=self.progress if tell else None,
        )
        area = np.log(model.contact_area / exact.contact_area)
        spots = np.log(np.maximum(model.contacts, 1.0) / np.maximum(exact.contacts, 1.0))
        return np.array([model.separation - exact.separation, area, spots])


def parts_along(hm: HeightMap, plan: Plan) -> int:
    """Parts along each side of a map."""
    grid = min((plan.resampled or hm).shape)
    return max(SIDE, min(min(hm.shape) // PART_POINTS, grid // GRID_POINTS))


def _load_shares(run: ContactRun, side: int) -> Array:
    """Share of the load that each part of the map carries, shape (parts, n)."""
    hm, summits = run.decomposition.hm, run.decomposition.summits
    row, column = (
        np.floor(place * (side / length)).astype(np.int64) % side
        for place, length in zip((summits.y, summits.x), hm.size, strict=True)
    )
    forces = [np.bincount(row * side + column, each.state.force, side**2) for each in run.points]
    return np.array([force / max(force.sum(), 1e-300) for force in forces]).T


def _misfit(
    judged: _Judged,
    hm: HeightMap,
    plan: Plan,
    model: ContactCurve,
    at: NDArray[np.int64],
    shares: Array,
    allowed: Array | float,
) -> tuple[Array, Array]:
    """Misfit of the model at some load points, from parts of the map that carry these shares of
    each.

    Returns the logarithms of load, area and number of spots of the model over boundary elements,
    shape (3, n), and bounds of the first two, shape (2, n): their standard deviation over the parts
    and the floor, larger where few parts carry the load; NaN where no part tells them, or the floor
    alone is more than is allowed.

    A part is loaded as the model loads it on the whole map, and solved by the plan of the whole
    map: those that carry most. Where the finest waves act as a law of the contacts of the others,
    and the others are a map so coarse that it costs no more than one part, the whole of that is
    solved too, and the parts add to it what the finest waves change in the separation: they do not
    hold the longest waves.
    """
    side, pressure = math.isqrt(len(shares)), model.mean_pressure[at]
    local = len(shares) * shares * pressure
    alone = replace(plan, above=None, resampled=None, sub_contact_law=None)
    grid = plan.resampled if plan.sub_contact_law is not None else None
    if grid is not None and math.prod(grid.shape) * len(shares) > math.prod(hm.shape):
        grid = None
    most = HEAVIEST if grid is None else 1.0
    usable = (len(shares) * shares > LEAST_SHARE) & (local <= most * pressure[-1])
    best = np.argsort(-np.where(usable, shares, 0.0).sum(axis=1), kind="stable")
    taken = np.empty_like(usable)
    taken[best] = usable[best] & (np.cumsum(usable[best], axis=0) <= side)
    taken &= (_floor(taken * shares) <= allowed).all(axis=0)
    found = np.full((*shares.shape, 3), np.nan)
    lightest = int(np.argmax(np.where(taken.any(axis=1), shares[:, 0], -1.0)))
    for place in np.flatnonzero(taken.any(axis=1)).tolist():
        here, part = taken[place], _part(hm, place, side)
        loads, cell = local[place, here], replace(alone, boundary="periodic")
        waves = _resampled(part, plan)
        own = replace(
            cell,
            sub_contact_law=plan.sub_contact_law,
            resampled=None if waves is part else waves,
        )
        found[place, here] = judged(part, own, loads, tell=place == lightest).T
        if grid is not None:
            found[place, here, 0] -= judged(waves, cell, loads)[0]
    weights = np.where(np.isnan(found).any(axis=-1), 0.0, shares)
    found, floor = np.nan_to_num(found), _floor(weights)
    share = (weights / _sum(weights))[..., None]
    misfit = (share * found).sum(axis=0).T
    scatter = np.sqrt((share * (found - misfit.T) ** 2).sum(axis=0)).T
    told = np.isfinite(floor[0])
    if grid is not None and told.any():
        misfit[0, told] += judged(grid, alone, pressure[told])[0]
    for each in (misfit, scatter):
        each[0] *= model.stiffness[at] / pressure
    return misfit, scatter[:2] + floor


def _sum(weights: Array) -> Array:
    """Sum over the parts, shape (n,); NaN where there is nothing."""
    total = weights.sum(axis=0)
    return np.where(total > 0.0, total, np.nan)


def _floor(weights: Array) -> Array:
    """Bounds of load and area beside the scatter over parts that carry these shares of the load at
    some points, shape (parts, n); NaN where they carry too little of it. Shape (2, n)."""
    total = _sum(weights)
    few = ALIKE * (weights**2).sum(axis=0) / total**2
    few[total < LEAST_COVER / math.sqrt(len(weights))] = np.nan
    return np.outer(FLOOR, np.sqrt(0.5 + 0.5 * np.maximum(few, few**FEW)))


def _bend(position: Array, nodes: Array, values: Array) -> Array:
    """Error of linear interpolation between nodes, shape (2, n): that of parabolas through three of
    them; zero where too few have values, shape (nodes, 2)."""
    if len(nodes) < 3:
        return np.zeros((2, len(position)))
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.diff(values, axis=0) / np.diff(nodes)[:, None]
        curvature = np.abs(np.diff(slope, axis=0)) / (nodes[2:] - nodes[:-2])[:, None]
    curvature = np.pad(np.where(np.isfinite(curvature), curvature, 0.0), ((1, 1), (0, 0)), "edge")
    after = np.clip(np.searchsorted(nodes, position, side="right"), 1, len(nodes) - 1)
    steps = (position - nodes[after - 1]) * (nodes[after] - position)
    return np.asarray((np.maximum(curvature[after - 1], curvature[after]) * steps[:, None]).T)


def _part(hm: HeightMap, place: int, side: int) -> HeightMap:
    """One part of a map about its mean height, made periodic."""
    rows, columns = (
        (n * k // side, n * (k + 1) // side)
        for n, k in zip(hm.shape, divmod(place, side), strict=True)
    )
    return make_periodic(hm.cut(rows, columns), "smooth").about_mean


def _resampled(part: HeightMap, plan: Plan) -> HeightMap:
    """The waves of a part that a plan solves, on pixels of the size of its grid."""
    law, grid = plan.sub_contact_law, plan.resampled
    kept = part if law is None else bandpass(part, law.shortest, None)
    return kept if grid is None else resample(kept, grid.spacing)
