"""`asperity.solve`: the contact curve by the engine that is expected to be fastest, verified."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from asperity.bem.curve import bem_curve
from asperity.bem.memory import fits
from asperity.compilation import compile_ahead, curve_parts
from asperity.contacts.run import ContactRun, solve_contacts
from asperity.errors import InputError, ModelRangeError, cautious, warn_once
from asperity.halfspace.material import HalfSpace, require_half_space
from asperity.halfspace.scene import (
    Boundary,
    as_pressed,
    checked_loads,
    chosen_boundary,
    scene_warnings,
)
from asperity.model.plan import make_plan
from asperity.parameters import ENGINE
from asperity.progress import Progress, reported, require_function
from asperity.results.curve import verified_facts
from asperity.trust.verified import Accuracy, anchors_suffice, verified
from surfaces.arrays import Array
from surfaces.errors import as_choice, as_number

from .cost import can_anchor, cheapest, forecast
from .parts import can_sample, sampled
from .resolution import UNTOLD, Resolution, SolvedLoads, resolution

if TYPE_CHECKING:
    from asperity.model.plan import Plan
    from asperity.results.curve import ContactCurve
    from surfaces.heightmap import HeightMap

__all__ = ["ENGINES", "solve"]


ENGINES = ("auto", "bem", "anchored", "sampled")
"""Values of the argument `engine`, the default first."""

WAYS = {
    "bem": "of boundary elements",
    "anchored": "of the model anchored at a few loads",
    "sampled": "of the model checked on parts of the map",
}
"""Descriptions of the engines in the reason of a choice."""

ACCURACIES = 0.004, 0.1
"""Least and largest accuracy in load that can be asked for."""


@cautious
def solve(
    hm: HeightMap,
    material: HalfSpace,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    accuracy: float = Accuracy.load,
    area_accuracy: float | None = None,
    verify: str | bool = "auto",
    engine: str = "auto",
    boundary: str | None = None,
    progress: Progress = None,
    judge: Callable[..., ContactCurve] | None = None,
) -> ContactCurve:
    """Load, separation and real contact area, as accurate as asked for, by the cheaper engine.

    There are three engines: boundary elements solve every load point ("bem"); the microcontact
    model gives the curve, and boundary elements anchor it at a few loads ("anchored") or, on large
    maps of random waves, check it on parts of the map ("sampled"). A forecast of run times from the
    map and the loads decides between them.

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
    verify
        "auto" anchors the model as far as the accuracy asks for. False leaves boundary elements
        out: the model answers with its a-priori estimate, which is no bound.
    engine
        "auto" chooses by the forecast; "bem"; "anchored" or "sampled", or "bem" where these fail.
    boundary
        "periodic" or "free"; as the map says if None.
    progress
        True for a progress bar, or a function called with every load point that boundary elements
        have solved.
    judge
        Solves load points by boundary elements: `bem_curve` if None, or a function with its
        arguments, such as one that keeps in a file what it has solved.

    Returns
    -------
    ContactCurve
        One row per load point, in the order asked. `error_estimate` and
        `extra["area_error_estimate"]` are bounds on the distance from the exact solution on the
        grid of the map. `settings["engine"]` names the engine, "model" if nothing is verified;
        `verification` holds the reason for it, the anchors, and the uncertainty by the pixels of
        the map (`resolution_uncertainty`), which comes on top of the bounds.

    Raises
    ------
    SurfaceError
        If the map has missing points, or is constant and the model is to answer.
    InputError, ModelRangeError
        If an argument is not usable; if the model has no answer, and is not to be verified.

    Notes
    -----
    The bound is empirical where the model answers (docs/development/verification.md); where
    boundary elements answer it follows from their certificate (`bem_curve`). If these do not fit
    into memory, the model answers as with `verify=False`, and the reason says so.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine(
    ...     (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
    ... )
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> answer = asperity.solve(hm, steel, pressures=[1e8, 3e8, 1e9], accuracy=0.05)
    >>> answer.settings["engine"], bool(answer.error_estimate.max() < 0.05)
    ('bem', True)
    """
    require_half_space(material)
    compile_ahead(*curve_parts(material.hardness), "bem")
    begun = time.perf_counter()
    asked = _accuracy(accuracy, area_accuracy)
    as_choice("engine", engine, ENGINES)
    if not (isinstance(verify, bool) or (isinstance(verify, str) and verify == "auto")):
        raise InputError(f"verify is {verify!r}; give 'auto' or False")
    if engine in ("anchored", "sampled") and not verify:
        raise InputError(f"engine is {engine!r}, which verifies; leave out verify=False")
    require_function("judge", judge)
    kind, given = checked_loads(hm, material, pressures, separations)
    values, place = np.unique(given, return_inverse=True)  # equal loads are solved once
    with reported(progress, None, "boundary elements") as tell:
        border = chosen_boundary(hm, boundary)
        solved = SolvedLoads(material, border, kind, values, tell)
        scene = _Scene(hm, material, kind, border, judge or bem_curve, solved)
        clock = _Clock(begun)
        choice = scene.choice(values, engine, bool(verify), asked)
        pressed = as_pressed(hm, border)
        known = scene_warnings(pressed, material) if choice.plan is None else choice.plan.warnings
        warn_once(known)
        clock.stage("choice")
        if choice.plan is not None and choice.engine != "bem":
            try:
                run = solve_contacts(hm, material, choice.plan, **scene.loads(values))
            except ModelRangeError as error:
                if not verify:
                    raise
                why = f"the microcontact model has no answer: {error}"
                choice = choice._replace(engine="bem", reason=why)
            clock.stage("model")
        curve = None
        if choice.engine == "model":
            curve = _marked(run.curve, False)
        elif choice.engine != "bem":
            curve = scene.checked(choice, run, asked)
        if curve is None:
            curve = scene.exact(values, asked.times(1.0))
        if choice.engine in ("anchored", "sampled") and curve.extra["anchor"].all():
            why = f"the model did not hold so well; {choice.engine} was tried, {choice.reason}"
            choice = choice._replace(engine="bem", reason=why)
            kept = {name: told for name, told in curve.settings.items() if name != "law"}
            curve = replace(curve, model="bem", settings=kept)
        clock.stage("boundary elements")
        left = UNTOLD if choice.engine == "model" else scene.resolution(curve, values)
        clock.stage("resolution")
    curve = curve.select(place)
    told = {
        "reason": choice.reason,
        "accuracy": [asked.load, asked.area],
        **verified_facts(curve, asked.load, asked.area),
        "reference": f"grid of the map, {hm.shape[0]} x {hm.shape[1]}, {scene.boundary}",
        "resolution_uncertainty": [left.load, left.area],
        "resolution": left.told_by,
    }
    warnings = dict.fromkeys([*known, *curve.settings["warnings"], *left.warnings])
    settings = {**curve.settings, "engine": choice.engine, "warnings": [*warnings]}
    settings["verification"] = told
    return replace(curve, seconds=clock.seconds, settings=settings)


class _Choice(NamedTuple):
    """Engine ("bem", "anchored", "sampled", or "model" without verification), the reason for it,
    and the plan of the model if one was made."""

    engine: str
    reason: str
    plan: Plan | None


class _Clock:
    """Seconds of each stage."""

    def __init__(self, begun: float) -> None:
        self.last, self.seconds = begun, dict[str, float]()

    def stage(self, name: str) -> None:
        """Record the time since the last stage under this name."""
        now = time.perf_counter()
        self.seconds[name] = now - self.last
        self.last = now


@dataclass(frozen=True)
class _Scene:
    """Map, material, kind of load points and boundary; `judge` solves them by boundary elements,
    and `solved` keeps what `resolution` needs of them."""

    hm: HeightMap
    material: HalfSpace
    kind: str
    boundary: Boundary
    judge: Callable[..., ContactCurve]
    solved: SolvedLoads

    def loads(self, values: Array) -> dict[str, Any]:
        """Load points as a keyword argument."""
        return {f"{self.kind}s": values}

    def choice(self, values: Array, engine: str, verify: bool, asked: Accuracy) -> _Choice:
        """The engine for these load points, and why."""
        if engine == "bem":
            return _Choice("bem", "as asked", None)
        least = ENGINE.anchors.least_loads
        if engine == "auto" and verify and len(values) < least:
            return _Choice("bem", f"fewer than {least} load points", None)
        loads = self.loads(values)
        if engine == "auto" and verify and self.fits:
            seconds = forecast(self.hm, self.material, self.boundary, len(values))
            if cheapest(seconds) == "bem":
                return _Choice("bem", _told(seconds, "at least "), None)
        try:
            plan = make_plan(self.hm, self.material, boundary=self.boundary, **loads)
        except ModelRangeError as error:
            if not verify:
                raise
            return _Choice("bem", f"the microcontact model has no answer: {error}", None)
        if not verify:
            return _Choice("model", "not to be verified", plan)
        sampling = can_sample(self.hm, self.material, plan, asked)
        if engine == "sampled" and not sampling:
            raise InputError(
                "engine is 'sampled', but parts of the map do not tell of the whole: it is too "
                "small, its waves are not random, or too fine, the body yields or is graded, or "
                "the accuracy is too high; give 'auto'"
            )
        if not self.fits:
            if engine == "anchored":
                raise InputError(
                    "engine is 'anchored', which does not fit into memory; give 'auto'"
                )
            why = "boundary elements do not fit into memory"
            return _Choice("sampled" if sampling else "model", why, plan)
        if engine != "auto":
            return _Choice(engine, "as asked", plan)
        seconds = forecast(self.hm, self.material, self.boundary, len(values), plan)
        if not sampling:
            del seconds["sampled"]
        if not can_anchor(self.hm, plan):
            del seconds["anchored"]
        return _Choice(cheapest(seconds), _told(seconds), plan)

    @property
    def fits(self) -> bool:
        """Whether boundary elements of the whole map fit into memory."""
        return fits(self.hm.shape, self.boundary, 1)

    def checked(self, choice: _Choice, run: ContactRun, asked: Accuracy) -> ContactCurve | None:
        """The curve of the model, corrected and bounded by the chosen engine; None if a few anchors
        cannot suffice."""

        def judge(at: Array, share: float) -> ContactCurve:
            return self.exact(at, asked.times(share))

        if choice.engine == "anchored":
            if not anchors_suffice(run.curve, asked):
                return None
            return verified(self.hm, run.decomposition.plan, run.curve, judge, asked)
        return sampled(self.hm, run, judge if self.fits else None, asked, self.solved)

    def exact(self, values: Array, accuracy: tuple[float, float]) -> ContactCurve:
        """Boundary elements on the grid of the map, within errors of load and area."""
        found = self.judge(
            self.hm,
            self.material,
            **self.loads(values),
            accuracy=accuracy,
            boundary=self.boundary,
            progress=self.solved,
        )
        return _marked(found, True)

    def resolution(self, curve: ContactCurve, values: Array) -> Resolution:
        """Resolution of a curve (`engine.resolution`)."""
        pressure, told = curve.mean_pressure, self.solved.lightest
        known = (pressure > 0.0) & (curve.extra["anchor"] | (told is None))
        first = int(np.argmin(np.where(known, pressure, np.inf)))
        if known.any() and (told is None or told.mean_pressure > (1.0 + 1e-6) * pressure[first]):
            # it was solved before, by a judge that keeps what it solves, and so was the middle one
            if not self.fits:
                return UNTOLD
            again = np.unique([first, len(values) // 2])
            direct = replace(self, judge=bem_curve)
            direct.exact(values[again], (ACCURACIES[1], 2.0 * ACCURACIES[1]))
        return resolution(as_pressed(self.hm, self.boundary), self.solved)


def _told(seconds: dict[str, float], least: str = "") -> str:
    """The forecast in words; `least` is said of all engines but boundary elements."""
    each = (
        f"{'' if name == 'bem' else least}{value:.2g} s {WAYS[name]}"
        for name, value in seconds.items()
    )
    return f"forecast {', '.join(each)}"


def _marked(curve: ContactCurve, anchor: bool) -> ContactCurve:
    """The curve with the column `anchor`: whether boundary elements solved its load points."""
    return replace(curve, extra={**curve.extra, "anchor": np.full(len(curve), anchor)})


def _accuracy(load: float, area: float | None) -> Accuracy:
    """The accuracy asked for, checked."""
    low, high = ACCURACIES
    if not low <= as_number("accuracy", load) <= high:
        raise InputError(f"accuracy is {load!r}; give a relative error from {low} to {high}")
    if area is not None and not low <= as_number("area_accuracy", area) <= 2 * high:
        raise InputError(f"area_accuracy is {area!r}; give one from {low} to {2 * high}")
    return Accuracy(load, 2.0 * load if area is None else area)
