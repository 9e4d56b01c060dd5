"""Engine "sampled": the curve of the model on a large map of random waves, checked on its parts.

The errors of the model come from neighboring contacts, and are statistically alike all over a
random surface: some parts show them at a fraction of the cost of the whole map. The longest waves,
which no part holds, are solved on a coarse grid of the whole map if they matter.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from asperity.halfspace.scene import model_warnings
from asperity.parameters import ENGINE
from asperity.trust.verified import (
    answered,
    bounds_at,
    corrected,
    misfit_at,
    pixel_scatter,
    solved_points,
)
from surfaces.arrays import Array, Mask
from surfaces.checks import random_map
from surfaces.numerics.stored_array import sampled_lines

from .part_misfit import PartMisfit, corner, long_waves, misfit_on_parts

if TYPE_CHECKING:
    from collections.abc import Callable

    from asperity.bem.curve import SolvedLoad
    from asperity.contacts.run import ContactRun
    from asperity.halfspace.material import HalfSpace
    from asperity.model.plan import Plan
    from asperity.results.curve import ContactCurve
    from asperity.trust.verified import Accuracy, ReferenceSolver, Solved
    from surfaces.heightmap import HeightMap

__all__ = ["can_sample", "copied", "parts_along", "sampled", "statistically_homogeneous"]


PARTS = ENGINE.parts

COPY = 0.999
"""Least correlation of a map of copies with itself, moved or mirrored: 0.92 at most on 120 random
maps, some of them of waves of half their length alone."""


def statistically_homogeneous(hm: HeightMap, plan: Plan) -> bool:
    """Whether a map consists of random waves without a long lay: its contacts are statistically
    alike, so that the misfit is that of a few places and changes slowly with the load."""
    warned = model_warnings(hm, PARTS.longest_lay)
    return not warned and random_map(hm, plan.parameters.pixel_waves.kurtosis)


def copied(hm: HeightMap) -> bool:
    """Whether a map consists of copies of one part, beside each other or mirrored: parts of it are
    no independent samples then.

    No point may be missing.

    Notes
    -----
    The correlations are sums over x of h(x) h(x + s), for shifts s from a quarter of the length to
    three quarters, and of h(x) h(s - x), over some lines along each axis.
    """
    for axis in (0, 1):
        waves = np.fft.rfft(sampled_lines(hm.source, axis), axis=1)
        waves[:, 0] = 0.0
        moved, mirrored = (
            np.fft.irfft(power.sum(axis=0), hm.shape[axis])
            for power in (waves * waves.conj(), waves * waves)
        )
        quarter = -(-moved.size // 4)
        largest = max(moved[quarter : moved.size - quarter + 1].max(initial=0.0), mirrored.max())
        if largest > COPY * moved[0] > 0.0:
            return True
    return False


def can_sample(hm: HeightMap, material: HalfSpace, plan: Plan, accuracy: Accuracy) -> bool:
    """Whether the misfit on parts of a map bounds that of the whole map as closely as asked.

    It does not

    - with a hardness: the load then depends on single summits, and the model may find the highest
      one on another part than boundary elements;
    - on a graded body: parts misjudge the mean displacement of the whole;
    - if the waves of a sub-contact law hold much of the height: light contacts are then extremes of
      the whole map;
    - if the accuracy asked for is near the floor of the bounds, the map is small, its waves are not
      random, or it consists of copies, which are no sample;
    - if long waves have to be solved on the whole map, and that costs more than the parts.
    """
    law = plan.sub_contact_law
    if material.hardness < math.inf or material.m != 0.0:
        return False
    if law is not None and law.rms[0] < PARTS.coarse * law.rms[1]:
        return False
    enough = min(accuracy.load / PARTS.floor[0], accuracy.area / PARTS.floor[1]) >= PARTS.spare
    if not enough or min(hm.shape) < PARTS.least_points:
        return False
    if not statistically_homogeneous(hm, plan) or copied(hm):
        return False
    side = parts_along(hm, plan.solved(hm))
    waves = long_waves(hm, plan, side)
    return waves is None or side * math.prod(waves.shape) <= math.prod(hm.shape)


def sampled(
    hm: HeightMap,
    run: ContactRun,
    judge: ReferenceSolver | None,
    accuracy: Accuracy,
    progress: Callable[[SolvedLoad], object],
) -> ContactCurve:
    """Correct and bound a curve of the model, of n load points, by its misfit on parts of the map.

    Parameters
    ----------
    hm
        The map, for which `can_sample` holds.
    judge
        Boundary elements on the whole map. They solve the load points whose bounds from the parts
        exceed those asked for, or all if these are more than half. None: all load points keep the
        bounds from the parts, NaN where no part was solved.
    progress
        Called with every load point that boundary elements have solved on the part that carries
        most of the lightest load.

    Notes
    -----
    The bounds are twice the standard error of the misfit and a floor, larger where few parts
    carry the load (docs/development/verification.md).
    """
    model = run.curve
    (values,) = model.asked.values()
    points = answered(model)
    nodes = np.unique(np.linspace(0, len(points) - 1, PARTS.loads).astype(np.int64))
    at, scatter = points[nodes], pixel_scatter(hm, model)[points]
    allowed = np.array([[accuracy.load], [accuracy.area]])
    error = PARTS.judge_share * accuracy.area
    judged = PartMisfit(run.decomposition.material, error, progress)
    among, solved_map = run.decomposition.law_factory.shares, run.decomposition.solved
    # load shares of contacts are those of the whole map, on which the parts get their laws
    lower = solved_map.roughness.mean - hm.roughness.mean
    plan = replace(run.decomposition.plan, among=among and among.lowered(lower))
    shares = _load_shares(run, parts_along(hm, plan.solved(hm)))[:, at]
    solved: Solved = {}

    def on_whole(which: Mask) -> None:
        if judge is not None:
            solved.update(solved_points(judge, values, at[which], ENGINE.anchors.judge_share))

    misfit, bounds, floor = misfit_on_parts(
        judged, hm, plan, model, at, shares, allowed, None if judge is None else on_whole
    )
    bounds[1] += error
    if judge is not None:
        left = ~_within(bounds, scatter[nodes], allowed)  # also where no part was solved: NaN
        if 2 * np.count_nonzero(left) > len(nodes):  # the parts are no sample of this map
            bounds[:] = np.nan
        else:
            on_whole(left & ~np.isin(at, list(solved)))
            misfit[:, left] = misfit_at(model, at[left], solved)
            # the floor stays, for the loads between those that are solved on the whole map
            bounds[:, left] = np.maximum(bounds_at(at[left], solved), floor[:, left])
    position = np.log(model.mean_pressure[points])
    bend = _bend(position, position[nodes], misfit[:2].T)
    misfit, bounds = (
        np.array([np.interp(position, position[nodes], row) for row in each])
        for each in (misfit, bounds)
    )
    bounds += bend
    if judge is not None:
        met = points[_within(bounds, scatter, allowed)]
        rest = np.setdiff1d(np.arange(len(model)), [*met, *solved])
        solved |= solved_points(judge, values, rest, 1.0)
    bounds[1] += scatter
    return corrected(hm, model, points, np.nan_to_num(misfit), bounds, solved)


def _within(bounds: Array, scatter: Array, allowed: Array) -> Mask:
    """Whether the bounds of load and area, shape (2, n), are within those allowed, (2, 1), with the
    `pixel_scatter` of the area added."""
    return np.asarray((bounds[0] <= allowed[0]) & (bounds[1] + scatter <= allowed[1]))


def parts_along(hm: HeightMap, solved: HeightMap) -> int:
    """Number of parts along each side of a map; `solved` is the map on the grid of the plan."""
    most = min(hm.shape) // PARTS.points, min(solved.shape) // PARTS.grid_points
    return max(PARTS.side, min(most))


def _load_shares(run: ContactRun, side: int) -> Array:
    """Share of the load that each part of the map carries, shape (parts, n)."""
    hm, places = run.decomposition.hm, run.decomposition.places
    row, column = (
        np.floor((place / step - first) * (side / n)).astype(np.int64) % side
        for place, step, first, n in zip(
            places, hm.spacing, corner(hm, side), hm.shape, strict=True
        )
    )
    forces = [np.bincount(row * side + column, each.state.force, side**2) for each in run.points]
    return np.array([force / max(force.sum(), 1e-300) for force in forces]).T


def _bend(position: Array, nodes: Array, values: Array) -> Array:
    """Error of linear interpolation at `position` between `nodes`, shape (2, n), estimated by the
    parabola through three nodes: |f''|/2 (x - a)(b - x). Zero where fewer than three nodes have
    `values`, shape (nodes, 2)."""
    if len(nodes) < 3:
        return np.zeros((2, len(position)))
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.diff(values, axis=0) / np.diff(nodes)[:, None]
        curvature = np.abs(np.diff(slope, axis=0)) / (nodes[2:] - nodes[:-2])[:, None]
    curvature = np.pad(np.where(np.isfinite(curvature), curvature, 0.0), ((1, 1), (0, 0)), "edge")
    after = np.clip(np.searchsorted(nodes, position, side="right"), 1, len(nodes) - 1)
    steps = (position - nodes[after - 1]) * (nodes[after] - position)
    return np.asarray((np.maximum(curvature[after - 1], curvature[after]) * steps[:, None]).T)
