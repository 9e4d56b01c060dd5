"""The contact curve of a rough surface: the sweep over its load points."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from asperity.compilation import compile_ahead, curve_parts
from asperity.errors import cautious
from asperity.halfspace.material import HalfSpace, require_half_space
from asperity.halfspace.scene import checked_loads, map_facts, pressure_scale
from asperity.interaction.population import handed_on
from asperity.model.decomposition import Decomposition
from asperity.model.load_point import (
    LoadPoint,
    load_difference,
    load_point,
    plastic_share,
    point_at_separation,
    spot_count,
)
from asperity.model.plan import Plan, make_plan, require_plan
from asperity.progress import Progress, reported, require_function
from asperity.results.curve import ContactCurve
from asperity.results.interpolation import curve_stiffness
from asperity.trust.error_estimate import CALIBRATED, estimate, nonrandomness, terms
from asperity.trust.verified import anchored
from surfaces.arrays import Array
from surfaces.heightmap import HeightMap

__all__ = ["contact_curve", "solve_loads"]

RESIDUAL_UNDER_LOAD = 2e-2
"""Bound on the residual under a load before the last Newton step. That step changes load and area
by a tenth of the residual or less (docs/development/interaction.md)."""

RESIDUAL_AT_SEPARATION = 4e-3
"""Bound on the residual at a separation, where no last Newton step follows."""

UNRESOLVED_WARNED = 0.2
"""Smallest term `unresolved` (contacts smaller than a pixel) at which a load point is warned of."""

OF_CONTACTS = "mean_pressure", "residual", "active", "filled_share"
OF_SURFACE = "separation", "contact_area", "stiffness", "unloading"
"""Columns of a curve that come from `LoadPoint.state`, and from `LoadPoint.surface`."""


@cautious
def contact_curve(
    hm: HeightMap,
    material: HalfSpace,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    law: str = "auto",
    interaction: bool = True,
    plan: Plan | None = None,
    boundary: str | None = None,
    scales: str = "auto",
    progress: Progress = None,
    checkpoint: Callable[[ContactCurve], object] | None = None,
    verify: Callable[..., ContactCurve] | None = None,
) -> ContactCurve:
    """Load, separation and real contact area from the sum of interacting microcontacts.

    Parameters
    ----------
    hm
        Height map without missing points.
    material
        Elastic half-space in contact with a rigid flat (composite modulus for two bodies).
    pressures
        Mean pressures [Pa], scalar or (n,), non-negative; about 0.1 % to 10 % of contact if
        neither these nor `separations` are given.
    separations
        Separations [m], scalar or (n,), in place of the pressures.
    law
        Contact law of one summit: "hertz", "paper", "harmonic", "ellipse", "ritz" or "auto". Errors
        are estimated with "auto" and "ellipse" only, and NaN with the others, as with a lay of
        10:1 and more.
    interaction
        False gives the classical sum of independent contacts. `extra["interaction_difference"]`
        then holds how much its load at equal separation differs from the load of the same contacts
        with interaction; the error estimate includes this difference.
    plan
        A plan made before by `make_plan`; overrides `law`, `interaction`, `boundary`, `scales`.
    boundary
        "periodic" or "free"; as the map says if None.
    scales
        "auto": the finest waves of a broad random spectrum act as a law of the contacts of the
        longer waves (`asperity.multiscale`); other maps whose waves reach the pixel are solved on
        a finer grid (`asperity.multiscale.wave_split`). "all": every summit is a contact.
    progress
        True for a progress bar, or a function called with the state of every finished point.
    checkpoint
        Called with the curve of the points finished so far, after each.
    verify
        `bem_curve`, or a function with its arguments: solves anchors, as in `solve`, that correct
        and bound the curve to 5 % in load (all points if fewer than five); the a-priori estimate
        is the prior. None: no check.

    Returns
    -------
    ContactCurve
        One row per load point, in the order asked.

    Raises
    ------
    SurfaceError
        If the map has missing points or is constant.
    InputError
        If an argument is not usable.
    ModelRangeError
        If m is near -1, or the law has no contact for the highest summit.

    Notes
    -----
    Each local peak is confined to its basin and carries the load of its contact law at the approach
    d_i = z_i - s - sum_j G_ij F_j (docs/development/laws.md, docs/development/interaction.md);
    contacts that touch remain separate and interact.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> curve = asperity.contact_curve(hm, steel, pressures=[1e8, 1e9])
    >>> bool(curve.converged.all()), bool(curve.separation[0] > curve.separation[1])
    (True, True)
    >>> loads = [1e8, 2e8, 4e8, 6e8, 1e9]
    >>> checked = asperity.contact_curve(hm, steel, pressures=loads, verify=asperity.bem_curve)
    >>> bool(checked.error_estimate.max() < 0.05)
    True
    """
    require_function("verify", verify)
    require_half_space(material)
    compile_ahead(*curve_parts(material.hardness), *(["bem"] if verify else []))
    asked: dict[str, Any] = {"pressures": pressures, "separations": separations}
    if plan is None:
        law_of: dict[str, Any] = {"law": law, "interaction": interaction, "scales": scales}
        plan = make_plan(hm, material, boundary=boundary, **asked, **law_of)
    told: dict[str, Any] = {"progress": progress, "checkpoint": checkpoint}
    curve = solve_loads(hm, material, plan, keep=False, **asked, **told)[0]
    return curve if verify is None else anchored(hm, material, plan, curve, verify)


def solve_loads(
    hm: HeightMap,
    material: HalfSpace,
    plan: Plan | None = None,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    progress: Progress = None,
    checkpoint: Callable[[ContactCurve], object] | None = None,
    decomposition: Decomposition | None = None,
    keep: bool = True,
) -> tuple[ContactCurve, Decomposition, tuple[LoadPoint, ...]]:
    """The curve of a plan with the decomposed surface and the load points behind it.

    Arguments are those of `contact_curve`; if there is no plan, `make_plan` makes one. A given
    `decomposition` must be that of the plan. Load points take most memory: `keep` returns them.

    The points are solved from light to heavy, and each starts from the one before. Where a contact
    comes near the height below which nothing was segmented, all are solved again on the whole map.
    """
    kind, given = checked_loads(hm, material, pressures, separations)
    values, place = np.unique(given, return_inverse=True)  # equal loads are solved once
    require_function("checkpoint", checkpoint)
    compile_ahead(*curve_parts(material.hardness))
    if plan is None:
        plan = make_plan(hm, material, pressures=pressures, separations=separations)
    require_plan(plan)
    start = time.perf_counter() - plan.seconds
    if decomposition is None:
        plan.require_scene_of(hm.without_rounding, material)
        decomposition = Decomposition.of(hm.without_rounding, material, plan)
    else:
        start = time.perf_counter() - sum(decomposition.seconds.values())
    rows: dict[int, _Row] = {}
    points: dict[int, LoadPoint] = {}

    def curve_of(solved: Decomposition, points: list[int]) -> ContactCurve:
        asked, seconds = {f"asked_{kind}": values[points]}, time.perf_counter() - start
        return _curve(hm, solved, [rows[i] for i in points], asked, seconds)

    with reported(progress, len(values), "load points") as tell:
        while True:
            for i, point, row in _sweep(decomposition, kind, values):
                rows[i] = row
                if keep:
                    points[i] = point
                if tell is not None:
                    tell(point.state)
                if checkpoint is not None:
                    checkpoint(curve_of(decomposition, [*rows]))
                del point
            if len(rows) == len(values):
                break
            decomposition, rows = decomposition.of_whole_map(), {}
    curve = curve_of(decomposition, sorted(rows)).select(place)
    return curve, decomposition, tuple(points[i] for i in place.tolist() if keep)


class _Row(NamedTuple):
    """One row of a curve: the numbers of one load point.

    `numbers` holds the columns `OF_CONTACTS`, `OF_SURFACE` and ``contacts`` by name, and for
    independent contacts ``interaction_difference`` (`load_difference`). `terms` holds the terms of
    the error estimate. `reason` says why the load point cannot be used; it is empty if it can.
    """

    numbers: dict[str, float]
    terms: dict[str, float]
    reason: str


def _sweep(
    decomposition: Decomposition, kind: str, values: Array
) -> Iterator[tuple[int, LoadPoint, _Row]]:
    """Solve the load points from light to heavy: the index of each in `values`, its point, its row.

    The sweep ends early where a contact comes near the height below which nothing was segmented.
    """
    by_load = kind == "pressure"
    bound = RESIDUAL_UNDER_LOAD if by_load else RESIDUAL_AT_SEPARATION
    heaviest = float(values.max()) if by_load else None
    nonrandom = nonrandomness(decomposition.hm)
    population = decomposition.population
    last: LoadPoint | None = None
    interacting = None
    for i in np.argsort(values if by_load else -values, kind="stable").tolist():
        value = float(values[i])
        if last is not None and last.end_to_end:
            point = last
        elif decomposition.plan.sub_contact_law is not None and not by_load:
            point = point_at_separation(decomposition, value, last, RESIDUAL_UNDER_LOAD)
        else:
            asked: Any = {"pressure" if by_load else "separation": value, "tolerance": bound}
            state = None if last is None else handed_on(last.state, **asked)
            del last  # frees its list of candidates before the next list is made
            state = population.solve(state=state, heaviest=heaviest, **asked)
            point = load_point(decomposition, state)
            del state
        if not decomposition.deep_enough(point.state):
            return
        if not decomposition.plan.interaction:
            at: Any = {"separation": point.state.separation, "tolerance": RESIDUAL_AT_SEPARATION}
            if interacting is not None:
                interacting = handed_on(interacting, **at)
            interacting = decomposition.interacting.solve(state=interacting, **at)
        found = terms(decomposition, point, nonrandom)
        numbers = {name: getattr(point.state, name) for name in OF_CONTACTS}
        numbers |= {name: getattr(point.surface, name) for name in OF_SURFACE}
        numbers["contacts"] = spot_count(decomposition, point)
        if interacting is not None:
            numbers["interaction_difference"] = load_difference(point, interacting)
        yield i, point, _Row(numbers, found, point.reason)
        last = point
        del point


def _curve(
    hm: HeightMap,
    decomposition: Decomposition,
    rows: Sequence[_Row],
    asked: dict[str, Array],
    seconds: float,
) -> ContactCurve:
    """The curve of the load points `rows`; `asked` holds the loads or separations asked for, and
    `seconds` the time since the run began."""
    plan = decomposition.plan
    columns = {name: np.array([row.numbers[name] for row in rows]) for name in rows[0].numbers}
    pressure, tangent = columns["mean_pressure"], columns["stiffness"]
    converged = np.array([not row.reason for row in rows])
    area, separation = columns["contact_area"], columns["separation"]
    found = decomposition.hm.roughness
    # `surface_point` lifts the flat no higher than the highest point: no slope of a curve there
    held = separation == found.highest - found.mean
    stiffness = curve_stiffness(pressure, separation, tangent, converged & ~held)
    weights = plan.parameters.error_estimate
    known = 0.0 if plan.law in CALIBRATED and plan.estimated else np.nan
    found_terms = {name: np.array([row.terms[name] for row in rows]) for name in rows[0].terms}
    load_error = known + estimate(found_terms, weights.load_weights, weights)
    warnings = [*plan.warnings, *decomposition.warnings(separation.min())]
    small = sum(row.terms["unresolved"] > UNRESOLVED_WARNED for row in rows)
    if small:
        warnings.append(
            f"at {small} of {len(rows)} load points contacts are as small as a pixel of the map, "
            "which does not tell their loads: take smaller pixels or more load"
        )
    body, more = decomposition.material, {}
    plastic = plastic_share(pressure * hm.area, area, body.hardness)
    if body.hardness < np.inf:
        more["unloading_stiffness"] = np.maximum(columns["unloading"], stiffness)
        more["plastic_share"] = plastic
    area_error = known + estimate(found_terms, weights.area_weights, weights, plastic)
    if "interaction_difference" in columns:
        more["interaction_difference"] = columns["interaction_difference"]
        load_error = load_error + np.abs(columns["interaction_difference"])
    return ContactCurve(
        separation=separation,
        mean_pressure=pressure,
        load=pressure * hm.area,
        area_fraction=area / hm.area,
        contact_area=area,
        contacts=columns["contacts"],
        stiffness=stiffness,
        converged=converged,
        residual=columns["residual"],
        error_estimate=load_error,
        model="asperity",
        seconds={**decomposition.seconds, "contact": seconds - sum(decomposition.seconds.values())},
        settings={
            "law": plan.law,
            "interaction": plan.interaction,
            "boundary": plan.boundary,
            "above": plan.above,
            "shortest_wave": plan.sub_contact_law and plan.sub_contact_law.shortest,
            "grid": list(decomposition.summits.peaks.labels.shape),
            **body.facts,
            "input": hm.digest,
            "map": map_facts(hm),
            "pressure_scale": pressure_scale(hm, body),
            "peaks": len(decomposition.summits),
            "warnings": warnings,
        },
        extra={
            **asked,
            "microcontacts": columns["active"],
            "filled_share": columns["filled_share"],
            "tangent_stiffness": tangent,
            "area_error_estimate": area_error,
            **more,
            **found_terms,
        },
        reasons=tuple(row.reason for row in rows),
    )
