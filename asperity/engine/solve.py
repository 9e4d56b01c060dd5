"""One question, one answer: the contact curve by the engine that gives it soonest, verified."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.bem.curve import SolvedLoad, bem_curve
from asperity.bem.problem import AREA_OVER_LOAD_ERROR
from asperity.compilation import CURVE, compile_ahead
from asperity.contacts.run import solve_contacts
from asperity.errors import InputError, ModelRangeError
from asperity.halfspace.scene import Boundary, checked_loads, chosen_boundary
from asperity.model.map_checks import map_warnings
from asperity.model.plan import make_plan
from surfaces.errors import as_number

from .cost import forecast
from .resolution import LightestLoad, resolution
from .verified import LEAST_LOADS, Accuracy, verified

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.model.plan import Plan
    from asperity.results.curve import ContactCurve
    from surfaces.heightmap import HeightMap

__all__ = ["ENGINES", "solve"]

Array = NDArray[np.float64]

ENGINES = ("auto", "bem", "anchored")
"""What `solve` can be told to use, the default first."""

ACCURACIES = 0.004, 0.1
"""Least and largest accuracy in load that can be asked for."""

KINDS = "pressure", "separation"
"""Kinds of load points."""

JUDGE_SHARE = 0.15
"""Error of boundary elements at anchors over the accuracy asked for."""


def solve(
    hm: HeightMap,
    material: HalfSpace,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    accuracy: float = 0.05,
    area_accuracy: float | None = None,
    engine: str = "auto",
    boundary: str | None = None,
    progress: Callable[[SolvedLoad], object] | None = None,
    judge: Callable[..., ContactCurve] = bem_curve,
) -> ContactCurve:
    """Load, separation and real contact area, as accurate as asked for, by the cheaper engine.

    Either boundary elements solve every load point, or the microcontact model gives the curve and
    boundary elements anchor it at a few of its loads. Which one is decided from the map, the loads
    and a measured model of run times.

    Parameters
    ----------
    hm
        Height map without missing points.
    material
        Elastic half-space in contact with a rigid flat (composite modulus for two bodies).
    pressures, separations
        As in `contact_curve`.
    accuracy
        Relative error allowed in the load at equal separation [-], 0.004 to 0.1.
    area_accuracy
        Relative error allowed in the contact area at equal load [-]; twice `accuracy` if None.
    engine
        "auto" chooses; "bem" or "anchored" settles it.
    boundary
        "periodic" or "free"; as the map says if None.
    progress
        Called with every load point that boundary elements have solved.
    judge
        Solves load points by boundary elements: a function with the arguments of `bem_curve`, such
        as one that keeps in a file what it has solved.

    Returns
    -------
    ContactCurve
        One row per load point, in the order asked. `error_estimate` and
        `extra["area_error_estimate"]` are bounds on the distance from the exact solution on the
        grid of the map; `verification` tells engine, reasons, anchors and what the pixels of the
        map leave open beside that (`resolution_uncertainty`).

    Raises
    ------
    SurfaceError
        If the map has missing points or is constant.
    InputError
        If an argument is not usable, or boundary elements do not fit into memory.

    Notes
    -----
    The bound is an empirical one where the model answers (docs/development/verification.md), and
    follows from the certificate where boundary elements do (`bem_curve`).

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine(
    ...     (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
    ... )
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> answer = asperity.solve(hm, steel, pressures=[1e8, 3e8, 1e9], accuracy=0.05)
    >>> answer.verification["engine"], bool(answer.error_estimate.max() < 0.05)
    ('bem', True)
    """
    begun = time.perf_counter()
    compile_ahead(*CURVE, "bem")
    asked = _accuracy(accuracy, area_accuracy)
    if engine not in ENGINES:
        raise InputError(f"engine is {engine!r}; give one of {', '.join(ENGINES)}")
    kind, values = checked_loads(hm, material, pressures, separations)
    edge = chosen_boundary(hm, boundary)
    plan, chosen, reason = _choice(hm, material, kind, values, edge, engine)
    lightest = LightestLoad(progress)

    def exact(points: Array, error: float) -> ContactCurve:
        """Boundary elements on the grid of the map, within an error of the area."""
        pressures, separations = (points if kind == one else None for one in KINDS)
        return judge(
            hm,
            material,
            pressures=pressures,
            separations=separations,
            accuracy=error,
            coarsen=False,
            boundary=edge,
            progress=lightest,
        )

    spent = {"choice": time.perf_counter() - begun}
    if plan is not None:
        pressures, separations = (values if kind == one else None for one in KINDS)
        run = solve_contacts(hm, material, plan, pressures=pressures, separations=separations)
        spent["model"] = time.perf_counter() - begun - sum(spent.values())
        error = JUDGE_SHARE * asked.area
        curve = verified(hm, run.curve, kind, values, lambda at: exact(at, error), asked)
    else:
        curve = exact(values, min(asked.area, AREA_OVER_LOAD_ERROR * asked.load))
    anchors = np.flatnonzero(curve.extra.get("anchor", np.ones(len(values))))
    if plan is not None and len(anchors) == len(values):
        chosen, reason = "bem", f"{reason}; but it did not hold between anchors"
    spent["boundary elements"] = time.perf_counter() - begun - sum(spent.values())
    if lightest.point is None and (curve.mean_pressure > 0.0).any():  # all were solved before
        exact(
            values[[np.argmin(np.where(curve.mean_pressure > 0.0, curve.mean_pressure, np.inf))]],
            asked.area,
        )
    left = resolution(hm, material, edge, lightest, float(curve.mean_pressure.max()))
    spent["resolution"] = time.perf_counter() - begun - sum(spent.values())
    told = {
        "engine": chosen,
        "reason": reason,
        "accuracy": [asked.load, asked.area],
        "met": bool(np.all(asked.met(curve) & curve.converged)),
        "anchors": anchors.tolist(),
        "reference": f"grid of the map, {hm.shape[0]} x {hm.shape[1]}, {edge}",
        "resolution_uncertainty": [left.load, left.area],
        "resolution": left.told_by,
    }
    warnings = [*map_warnings(hm), *curve.settings["warnings"], *left.warnings]
    settings = {
        **curve.settings,
        "warnings": list(dict.fromkeys(warnings)),
        "verification": told,
    }
    return replace(curve, seconds=spent, settings=settings)


def _accuracy(load: float, area: float | None) -> Accuracy:
    """The accuracy asked for, checked."""
    low, high = ACCURACIES
    if not low <= as_number("accuracy", load) <= high:
        raise InputError(f"accuracy is {load!r}; give a relative error from {low} to {high}")
    if area is not None and not low <= as_number("area_accuracy", area) <= 2 * high:
        raise InputError(f"area_accuracy is {area!r}; give one from {low} to {2 * high}")
    return Accuracy(load, 2.0 * load if area is None else area)


def _choice(
    hm: HeightMap, material: HalfSpace, kind: str, values: Array, edge: Boundary, engine: str
) -> tuple[Plan | None, str, str]:
    """Plan of the model, None for boundary elements alone; name of the engine; and the reason."""
    if engine == "bem":
        return None, "bem", "as asked"
    if engine == "auto" and len(values) < LEAST_LOADS:
        return None, "bem", f"fewer than {LEAST_LOADS} load points"
    pressures, separations = (values if kind == one else None for one in KINDS)
    try:
        plan = make_plan(hm, material, pressures=pressures, separations=separations, boundary=edge)
    except ModelRangeError as error:
        return None, "bem", f"the microcontact model has no answer: {error}"
    if engine == "anchored":
        return plan, "anchored", "as asked"
    alone, anchored = forecast(hm, plan, len(values))
    times = f"{alone:.2g} s forecast of boundary elements alone, {anchored:.2g} s of the model"
    if alone <= anchored:
        return None, "bem", f"{times} with anchors"
    return plan, "anchored", f"{times} with anchors"
