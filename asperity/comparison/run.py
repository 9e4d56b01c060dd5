"""The microcontact model against the full boundary-element solution, error against run time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.bem.curve import bem_curve
from asperity.bem.solve import bem_solve
from asperity.compilation import compile_ahead, curve_parts
from asperity.contacts.run import solve_contacts
from asperity.contacts.table import microcontacts
from asperity.curve import solve_loads
from asperity.errors import ConvergenceError, InputError, cautious, warn_once
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import checked_loads, default_pressures, map_facts
from asperity.model.plan import Plan, make_plan, require_plan
from asperity.progress import Progress, reported, require_function
from asperity.results.curve import ContactCurve, require_facts
from asperity.results.storage import provenance
from asperity.results.table import require_curve
from asperity.warmup import small_map
from surfaces.arrays import Array
from surfaces.heightmap import HeightMap

from .other_grids import (
    LOOSE_TOLERANCE,
    coarse_grids,
    coarse_run,
    error_table,
    load_at_separation,
    refined_run,
    rms_errors,
)
from .record import PARETO_TYPE
from .result import Comparison

if TYPE_CHECKING:
    from asperity.bem.solution import BemSolution
    from asperity.contacts.run import ContactRun

__all__ = ["compare"]

MAP_AREA_FRACTION = 0.03
"""Contact area fraction near which the contact maps are taken."""


@cautious
def compare(
    hm: HeightMap,
    material: HalfSpace,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    law: str = "auto",
    interaction: bool = True,
    boundary: str | None = None,
    scales: str = "auto",
    tolerance: float = 1e-6,
    plan: Plan | None = None,
    reference: Callable[[], ContactCurve] | None = None,
    progress: Progress = None,
) -> Comparison:
    """Run both models and boundary elements on coarser grids, and measure errors and run times.

    Parameters
    ----------
    hm, material, pressures, separations, law, interaction, boundary, scales, plan
        As in `contact_curve`.
    tolerance
        Tolerance of the reference solution.
    reference
        Gives the boundary-element curve of this map at these load points and this tolerance, such
        as one that goes on from an interrupted run; solved here if None.
    progress
        True for a progress bar, or a function called with a short label as each stage begins.

    Returns
    -------
    Comparison

    Raises
    ------
    SurfaceError, InputError
        As in `contact_curve` and `bem_curve`.

    Notes
    -----
    The baseline is honest: boundary elements on the full grid and on every coarser grid, with a
    loose tolerance, by the same solver.  Errors are measured against the full grid at `tolerance`.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> both = asperity.compare(hm, steel, pressures=[1e8, 1e9], tolerance=1e-4)
    >>> both.table["mean_pressure"].size, bool(abs(both.table["load_error"]).max() < 0.3)
    (2, True)
    """
    kind, values = checked_loads(hm, material, pressures, separations)
    if plan is not None:
        require_plan(plan)
    require_function("reference", reference)
    loads: dict[str, Any] = {f"{kind}s": values}
    chosen: dict[str, Any] = {
        "law": law,
        "interaction": interaction,
        "boundary": boundary,
        "scales": scales,
        **loads,
    }
    with reported(progress, None, "compare") as tell:
        say = tell or (lambda label: None)
        say("compilation")
        compile_ahead(*curve_parts(material.hardness), "bem")
        first = make_plan(hm, material, **chosen) if plan is None else plan
        warn_once(first.warnings)
        _compile(material, first)
        if plan is None:  # once more, on a map without stored means: its time belongs to the model
            plan = make_plan(hm.replace(), material, **chosen)
        say(f"boundary elements {hm.shape[0]} x {hm.shape[1]}, tolerance {tolerance}")
        if reference is None:
            reference_curve = bem_curve(
                hm, material, **loads, tolerance=tolerance, boundary=plan.boundary
            )
        else:
            reference_curve = reference()
            _require_reference(reference_curve, hm, material, plan.boundary, kind, values)
        say("microcontact model")
        pressures = _pressures(reference_curve, kind, values)
        run = solve_contacts(hm, material, plan, pressures=pressures)
        same, good = np.full(len(values), np.nan), reference_curve.converged
        if good.any():
            at = solve_contacts(hm, material, plan, separations=reference_curve.separation[good])
            same[good] = at.curve.mean_pressure
        table = error_table(run.curve, same, reference_curve, pressures, hm.rms_height)
        seconds = sum(run.curve.seconds.values())
        rows = [
            ("asperity", *run.curve.settings["grid"], np.nan, seconds, *rms_errors(table)),
            ("bem", *hm.shape, tolerance, sum(reference_curve.seconds.values()), 0.0, 0.0, 0.0),
        ]
        for grid in coarse_grids(hm.shape):
            say(f"boundary elements {grid[0]} x {grid[1]}, tolerance {LOOSE_TOLERANCE:.0e}")
            rows.append(coarse_run(hm, material, grid, plan.boundary, reference_curve, pressures))
        elastic = None
        if material.hardness < np.inf:
            say("microcontact model without hardness")
            made = run.decomposition.of_hardness(material.elastic)
            elastic = solve_loads(
                hm, material.elastic, made.plan, pressures=pressures, decomposition=made
            )[0]
        say("contact maps")
        point = _map_point(reference_curve, run.curve)
        solution = bem_solve(
            hm,
            material,
            pressure=float(pressures[point]),
            tolerance=tolerance,
            boundary=plan.boundary,
        )
        maps, overlap = _maps(hm, solution, run, point)
        if run.curve.converged[point]:
            contacts = run.microcontacts(point)
        else:
            contacts = microcontacts(run.decomposition, run.points[point])[:0]
        say("boundary elements on a refined grid")
        return Comparison(
            model=run.curve,
            reference=reference_curve,
            table=table,
            pareto=np.array(rows, dtype=PARETO_TYPE),
            overlap=overlap,
            maps=maps,
            map_point=point,
            microcontacts=contacts,
            plan=plan.reasons,
            about=_about(hm, material),
            elastic=elastic,
            resolution=refined_run(hm, material, plan.boundary, reference_curve),
        )


def _compile(material: HalfSpace, plan: Plan) -> None:
    """Run both models once on a small map, so that no run time holds compilation."""
    small = small_map()
    loads = default_pressures(small, material, count=2)
    solve_contacts(small, material, plan.whole, pressures=loads)
    bem_curve(small, material, pressures=loads, tolerance=LOOSE_TOLERANCE, boundary=plan.boundary)


def _maps(
    hm: HeightMap, solution: BemSolution, run: ContactRun, point: int
) -> tuple[dict[str, NDArray[Any]], float]:
    """Maps of heights [m], pressures [Pa] and contact of boundary elements and of the model at a
    load point, and the overlap of both contacts [-]; NaN if the model did not converge."""
    maps: dict[str, NDArray[Any]] = {
        "bem": solution.contact,
        "asperity": np.zeros_like(solution.contact),
        "heights": (hm.heights - hm.roughness.mean).astype(np.float32),
        "pressure_bem": solution.pressure.astype(np.float32),
    }
    if not run.curve.converged[point]:
        return maps, np.nan
    pressure = run.pressure_map(point)
    maps["asperity"] = pressure > 0
    maps["pressure_asperity"] = pressure.astype(np.float32)
    union = np.count_nonzero(maps["bem"] | maps["asperity"])
    both = np.count_nonzero(maps["bem"] & maps["asperity"])
    return maps, both / union if union else 1.0


def _map_point(reference: ContactCurve, model: ContactCurve) -> int:
    """The load point whose contact area fraction is nearest to `MAP_AREA_FRACTION`, of those that
    came out in both if there are such."""
    area = np.where(reference.converged, reference.area_fraction, model.area_fraction)
    away = np.abs(np.log(np.maximum(np.nan_to_num(area), 1e-12) / MAP_AREA_FRACTION))
    return int(np.argmin(np.where(reference.converged & model.converged, away, 1e3 + away)))


def _require_reference(
    reference_curve: ContactCurve,
    hm: HeightMap,
    material: HalfSpace,
    boundary: str,
    kind: str,
    values: Array,
) -> None:
    """Refuse what is no curve by boundary elements of this map and body at these load points."""
    require_curve(reference_curve)
    told = {"hardness": None, **material.facts}  # none is a fact, too
    facts = {"model": "bem", "input": hm.digest, "boundary": boundary, **told}
    require_facts(reference_curve, facts)
    asked = reference_curve.extra.get(f"asked_{kind}", np.empty(0))
    if asked.shape != values.shape or not np.allclose(asked, values, rtol=1e-9, atol=0.0):
        raise InputError(f"the reference has other load points than the {len(values)} asked for")


def _pressures(reference: ContactCurve, kind: str, values: Array) -> Array:
    """Mean pressures [Pa] of the load points, shape (n,): where the reference did not converge, as
    asked for, or read off its other points; a ConvergenceError if it has no two points to read a
    load off."""
    asked = values if kind == "pressure" else load_at_separation(reference, values)
    found = np.where(reference.converged, reference.mean_pressure, asked)
    if np.isnan(found).any():
        why = next(filter(None, reference.reasons))
        raise ConvergenceError(f"boundary elements have no curve to compare with: {why}")
    return found


def _about(hm: HeightMap, material: HalfSpace) -> dict[str, Any]:
    return {
        **map_facts(hm),
        "history": [dict(step) for step in hm.history],
        "input": hm.digest,
        "made": provenance(),
        **material.facts,
    }
