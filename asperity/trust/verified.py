"""The curve of the model, corrected and bounded by boundary elements at a few loads."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from asperity.halfspace.material import HalfSpace
from asperity.model.plan import Plan
from asperity.parameters import ENGINE
from asperity.results.curve import ContactCurve
from asperity.results.interpolation import halved_intervals, interpolated_misfit, log_ratio
from surfaces.arrays import Array, Index
from surfaces.checks import random_map
from surfaces.heightmap import HeightMap

__all__ = [
    "Accuracy",
    "ReferenceSolver",
    "Solved",
    "anchored",
    "anchors_suffice",
    "answered",
    "bounds_at",
    "corrected",
    "misfit_at",
    "pixel_scatter",
    "solved_points",
    "verified",
]


Solved = dict[int, ContactCurve]
"""Curves of one load point each, by its number."""

ReferenceSolver = Callable[[Array, float], ContactCurve]
"""Function of load points and of a share of the accuracy asked for: solves these points by boundary
elements within that share."""

ANCHORS = ENGINE.anchors

PRIOR_SHARE = np.array([ANCHORS.prior_share]).T
YIELDED_SHARE = np.array([ANCHORS.yielded_share]).T

YIELDED_COLUMNS = "plastic_share", "unloading_stiffness"
"""Columns of a curve with a hardness that are corrected too."""

CORRECTED = "mean_pressure", "separation", "contact_area", "contacts", "stiffness", "residual"
"""Columns of the model that are corrected by the misfit at the anchors."""

KEPT = "law", "boundary", "modulus", "m", "hardness", "input", "map", "pressure_scale", "warnings"
"""Settings of the model that a verified curve keeps."""


@dataclass(frozen=True)
class Accuracy:
    """Relative errors allowed.

    Attributes
    ----------
    load
        Of the load at equal separation [-].
    area
        Of the contact area at equal load [-].
    """

    load: float = 0.05
    area: float = 0.1

    def times(self, share: float) -> tuple[float, float]:
        """The errors of load and area times `share`."""
        return share * self.load, share * self.area


def anchored(
    hm: HeightMap,
    material: HalfSpace,
    plan: Plan,
    model: ContactCurve,
    solver: Callable[..., ContactCurve],
) -> ContactCurve:
    """`verified` with the default accuracy, by boundary elements such as `bem_curve`."""
    ((name, given),) = model.asked.items()
    kind = name.removeprefix("asked_")
    _, first, place = np.unique(given, return_index=True, return_inverse=True)
    begun, asked = time.perf_counter(), Accuracy()

    def judge(at: Array, share: float) -> ContactCurve:
        loads: dict[str, Any] = {f"{kind}s": at}
        return solver(hm, material, **loads, accuracy=asked.times(share), boundary=plan.boundary)

    curve = verified(hm, plan, model.select(first), judge, asked).select(place)
    seconds = {**model.seconds, "verification": time.perf_counter() - begun}
    return replace(curve, seconds=seconds)


def verified(
    hm: HeightMap, plan: Plan, model: ContactCurve, judge: ReferenceSolver, accuracy: Accuracy
) -> ContactCurve:
    """Anchor the curve of a plan, of n load points, until its bounds are within the accuracy.

    `judge` solves load points by boundary elements on the grid of the map. In the curve returned,
    `error_estimate` and `extra["area_error_estimate"]` are bounds, and `extra["anchor"]` marks the
    points that the judge solved.

    Notes
    -----
    At an anchor the model is off by d in the logarithm of the load at equal separation, and by a in
    the logarithm of the area at equal load. Both vary slowly with the load, and are interpolated
    over its logarithm to correct the points between the anchors: s = s_model - d/k with
    k = -d ln F/ds, and A = A_model exp(-a) (docs/development/verification.md). What a correction
    exceeds the a-priori estimate of its point by is added to the bound. Where the bounds exceed the
    accuracy, anchors are added. Boundary elements also solve the points where the model has no
    answer. If they solve all points, they do so to the accuracy asked for, not to a part of it.
    """
    (values,) = model.asked.values()
    points = answered(model)
    others = np.setdiff1d(np.arange(len(model)), points)
    if (count := len(points)) < ANCHORS.least_loads:
        return judge(values, 1.0)
    position = np.log(model.mean_pressure[points])
    prior, plastic = _prior_estimates(model, points)
    first = ANCHORS.first[not random_map(hm, plan.parameters.pixel_waves.kurtosis)]
    scatter = pixel_scatter(hm, model)[points]
    anchors = np.unique(np.linspace(0, count - 1, first).astype(np.int64))
    solved = solved_points(judge, values, others, 1.0)
    while True:
        new = [i for i in points[anchors] if i not in solved]
        share = ANCHORS.judge_share if len(anchors) < count else 1.0
        solved |= solved_points(judge, values, np.array(new), share)
        bare = [i for i in points[anchors] if not solved[i].contact_area[0] > 0.0]
        if bare:  # where the model touches alone, the judge has the answer
            kept = ~np.isin(points, bare)
            points, position, scatter = points[kept], position[kept], scatter[kept]
            prior, plastic = prior[:, kept], plastic[:, kept]
            if (count := len(points)) < ANCHORS.least_loads:
                return judge(values, 1.0)
            held = np.flatnonzero(np.isin(points, list(solved)))
            anchors = np.union1d(held, [0, count - 1])
            continue
        known = misfit_at(model, points[anchors], solved)
        broken = float(np.max(np.abs(known[:2]) / prior[:, anchors]))
        floors = prior * np.maximum(PRIOR_SHARE + plastic, broken if broken > 1.0 else 0.0)
        load, load_bound = interpolated_misfit(position, anchors, known[0], floors[0])
        area, area_bound = interpolated_misfit(position, anchors, known[1], floors[1])
        known_bounds = bounds_at(points[anchors], solved)
        rest = np.array([np.interp(position, position[anchors], row) for row in known_bounds])
        beyond = np.abs([load, area]) - prior * max(broken, 1.0)
        bounds = np.array([load_bound, area_bound + scatter]) + np.maximum(beyond, 0.0) + rest
        over = np.maximum(bounds[0] / accuracy.load, bounds[1] / accuracy.area)
        over[anchors], bounds[1, anchors] = 0.0, rest[1, anchors]
        if len(anchors) == count or over.max() <= 1.0:
            break
        few = ANCHORS.loads_each * len(anchors) <= count
        anchors = halved_intervals(anchors, over) if few else np.arange(count)
    beside = [np.interp(position, position[anchors], row) for row in known[2:]]
    misfit = np.array([load, area, *beside])
    return corrected(hm, model, points, misfit, bounds, solved)


def answered(model: ContactCurve) -> Index:
    """Indices of the load points at which the model has an answer, in the order of the load."""
    points = np.flatnonzero(
        model.converged
        & (model.mean_pressure > 0)
        & (model.contact_area > 0)
        & (model.stiffness > 0)
    )
    return points[np.argsort(model.mean_pressure[points], kind="stable")]


def pixel_scatter(hm: HeightMap, model: ContactCurve) -> Array:
    """Relative scatter of the area of boundary elements, which count it in pixels, shape (n,).

    The number of pixels in a disc of radius R pixels scatters by about sqrt(R) about its area: over
    n spots that hold N = n pi R^2 pixels, by sqrt(n R).
    """
    pixels = model.contact_area / (hm.spacing[0] * hm.spacing[1])
    scatter = (np.maximum(model.contacts, 1) * pixels / np.pi) ** 0.25
    return np.asarray(scatter / np.maximum(pixels, 1e-300))


def solved_points(judge: ReferenceSolver, values: Array, new: Index, share: float) -> Solved:
    """The load points `new`, solved by boundary elements within a share of the accuracy."""
    if not new.size:
        return {}
    curve = judge(values[new], share)
    return {int(i): curve.select([at]) for at, i in enumerate(new)}


def anchors_suffice(model: ContactCurve, accuracy: Accuracy) -> bool:
    """Whether a-priori estimates let anchors bound at least half of the load points within the
    accuracy, without solving these."""
    prior, plastic = _prior_estimates(model, answered(model))
    left = prior * (PRIOR_SHARE + plastic) > np.array([[accuracy.load], [accuracy.area]])
    return bool(np.count_nonzero(left.any(axis=0)) <= len(model) // 2)


def _prior_estimates(model: ContactCurve, points: Index) -> tuple[Array, Array]:
    """A-priori estimates of load and area, shape (2, n), and the share of them that yielding adds
    to `PRIOR_SHARE`, (2, n)."""
    stated = model.error_estimate, model.extra["area_error_estimate"]
    prior = np.array(
        [
            np.where(np.isfinite(error), error, unknown)[points]
            for error, unknown in zip(stated, ANCHORS.unknown, strict=True)
        ]
    )
    plastic = np.asarray(model.extra.get("plastic_share", np.zeros(len(model))))[points]
    return prior, YIELDED_SHARE * plastic


def bounds_at(points: Index, solved: Solved) -> Array:
    """Bounds of load and area of boundary elements at the `points`, shape (2, k)."""
    return np.array([_column(solved, points, f"{of}error_estimate") for of in ("", "area_")])


def _column(solved: Solved, points: Index, name: str) -> Array:
    """Column `name` of boundary elements at the `points`, shape (k,)."""
    curves = [solved[i] for i in points.tolist()]
    return np.array([float({**vars(one), **one.extra}[name][0]) for one in curves])


def misfit_at(model: ContactCurve, points: Index, solved: Solved) -> Array:
    """Logarithms of model over boundary elements, shape (4 or 6, k): load at equal separation;
    area, number of spots and stiffness at equal load; with a hardness also `YIELDED_COLUMNS`."""

    def ratio(name: str) -> Array:
        return log_ratio(getattr(model, name)[points], _column(solved, points, name))

    spots = model.contacts[points], _column(solved, points, "contacts")
    told = {name: model.extra[name] for name in YIELDED_COLUMNS if name in model.extra}
    told = {"stiffness": model.extra["tangent_stiffness"], **told}
    beside = [
        np.subtract(*(np.log(np.maximum(count, 1)) for count in spots)),
        *(log_ratio(each[points], _column(solved, points, name)) for name, each in told.items()),
    ]
    if "asked_pressure" in model.asked:
        apart = model.separation[points] - _column(solved, points, "separation")
        return np.array([_rate(model, points) * apart, ratio("contact_area"), *beside])
    load = ratio("mean_pressure")
    return np.array([load, ratio("contact_area") - _growth(model, points) * load, *beside])


def _rate(model: ContactCurve, points: Index) -> Array:
    """k = -d ln F/ds [1/m] of the model, shape (k,)."""
    return np.asarray(model.stiffness[points] / model.mean_pressure[points])


def _growth(model: ContactCurve, points: Index) -> Array:
    """d ln A/d ln F of the model at the `points`, shape (k,)."""
    usable = answered(model)
    x, y = np.log(model.mean_pressure[usable]), np.log(model.contact_area[usable])
    rising = np.diff(x, prepend=-np.inf) > 1e-9
    x, y = x[rising], y[rising]
    if len(x) < 2:
        return np.ones(len(points))
    return np.asarray(np.interp(np.log(model.mean_pressure[points]), x, np.gradient(y, x)))


def corrected(
    hm: HeightMap,
    model: ContactCurve,
    points: Index,
    misfit: Array,
    bounds: Array,
    solved: Solved,
) -> ContactCurve:
    """The curve of the model corrected by the `misfit` at the `points`, with the `bounds`; the
    values of boundary elements at the points that these `solved`."""
    load, area, spots, stiffness, *beside = misfit
    settings = {name: model.settings[name] for name in KEPT if name in model.settings}
    yielded = YIELDED_COLUMNS if "hardness" in settings else ()
    columns: dict[str, Any] = {name: np.array(getattr(model, name), float) for name in CORRECTED}
    columns["stiffness"][points] = model.extra["tangent_stiffness"][points] * np.exp(-stiffness)
    columns["error_estimate"] = np.zeros(len(model))
    extra = {name: model.extra[name].copy() for name in yielded}
    for values, off in zip(extra.values(), beside, strict=True):
        values[points] *= np.exp(-off)
    told = extra["area_error_estimate"] = np.zeros(len(model))
    if "asked_pressure" in model.asked:
        columns["separation"][points] -= load / _rate(model, points)
        columns["contact_area"][points] *= np.exp(-area)
    else:
        columns["mean_pressure"][points] *= np.exp(-load)
        columns["contact_area"][points] *= np.exp(-area - _growth(model, points) * load)
    columns["contacts"][points] *= np.exp(-spots)
    columns["error_estimate"][points], told[points] = bounds
    converged, reasons = model.converged.copy(), list(model.reasons)
    for i, one in solved.items():
        for name, values in columns.items():
            values[i] = getattr(one, name)[0]
        for name, values in extra.items():
            values[i] = one.extra[name][0]
        converged[i], reasons[i] = one.converged[0], one.reasons[0]
    columns["contacts"] = np.rint(columns["contacts"])
    pressure = columns["mean_pressure"]
    if yielded:
        least = pressure * hm.area / settings["hardness"]
        columns["contact_area"] = np.maximum(columns["contact_area"], least)
        loading, falling = columns["stiffness"], extra["unloading_stiffness"]
        extra["unloading_stiffness"] = np.maximum(falling, loading)
        extra["plastic_share"] = np.minimum(extra["plastic_share"], 1.0)
    return replace(
        model,
        **columns,
        load=pressure * hm.area,
        area_fraction=columns["contact_area"] / hm.area,
        converged=converged,
        model="anchored",
        settings=settings,
        extra={
            **model.asked,
            "area_error_estimate": told,
            "anchor": np.isin(np.arange(len(model)), list(solved)),
            **extra,
            "prior_error_estimate": model.error_estimate,
            "prior_area_error_estimate": model.extra["area_error_estimate"],
        },
        reasons=tuple(reasons),
    )
