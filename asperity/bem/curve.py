"""Contact curve by the boundary-element method: loads solved in turn, each started warm."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity.compilation import compile_ahead
from asperity.errors import InputError, cautious, warn_once
from asperity.halfspace.checks import scene_warnings
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import (
    checked_loads,
    chosen_boundary,
    expected_area_fraction,
    map_facts,
    pressure_scale,
)
from asperity.progress import Progress, reported
from asperity.results.curve import POINT_FIELDS, ContactCurve
from surfaces.heightmap import HeightMap
from surfaces.numerics.parallel import apart
from surfaces.numerics.parallel import threads as thread_count

from .accuracy import (
    LOOSEST,
    choose_grid,
    coarsened,
    interpolated,
    loads_to_solve,
    require_accuracy,
)
from .bounds import area_error, load_error
from .memory import fits
from .path import LoadPath, follow_chains, split_loads
from .problem import ContactProblem

__all__ = ["SolvedLoad", "bem_curve"]

_NO_MAP = np.zeros((0, 0), np.bool_)


@dataclass(frozen=True, eq=False)
class SolvedLoad:
    """One solved point of a curve, as `progress` sees it.

    Attributes
    ----------
    columns
        Every number of the point, by the names of `ContactCurve` and of its `extra`.
    contact
        Pixels under pressure, shape (ny, nx).
    reason
        Why the point did not converge, else "".
    """

    columns: Mapping[str, float]
    contact: NDArray[np.bool_]
    reason: str

    @property
    def mean_pressure(self) -> float:
        """Mean pressure [Pa]."""
        return self.columns["mean_pressure"]

    @property
    def separation(self) -> float:
        """Separation [m]."""
        return self.columns["separation"]

    @property
    def area_fraction(self) -> float:
        """Corrected contact area over nominal area [-]."""
        return self.columns["area_fraction"]

    @property
    def converged(self) -> bool:
        """Whether the certificate is within the tolerance."""
        return bool(self.columns["converged"])


@cautious
def bem_curve(
    hm: HeightMap,
    material: HalfSpace,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    tolerance: float = 1e-6,
    boundary: str | None = None,
    accuracy: float | None = None,
    coarsen: bool = True,
    check: bool = False,
    progress: Progress = None,
    checkpoint: Callable[[ContactCurve], object] | None = None,
) -> ContactCurve:
    """Load, separation and contact area of a rough map at several load points.

    Parameters
    ----------
    hm, material, tolerance, boundary
        As in `bem_solve`.
    pressures
        Mean pressures [Pa], in any order; or
    separations
        separations [m]. With neither: 10 geometric loads for about 0.1 % to 10 % of contact,
        from the rms slope and the modulus.
    accuracy
        Relative error allowed in load and corrected area [-], 1e-4 to 0.2, in place of a
        tolerance: each load is solved until its certificate bounds the error by that. The coarsest
        grid that holds it is chosen from the spectrum of the map and the lightest load
        (`accuracy.choose_grid`), and of more than ten pressures about ten are solved and the others
        interpolated (`accuracy.interpolated`): see `extra["interpolated"]` and the setting
        `solved_loads`.
    coarsen
        With `accuracy`: False solves every load on the grid of the map.
    check
        With `accuracy`: solve the middle load once more on a grid twice as fine (at most the full
        one); where the difference in separation over rms height or in area is larger than the bound
        of the certificate, it is the `error_estimate`.
    progress
        True for a progress bar, or a function called with every finished load point
        (`SolvedLoad`), with its contact map; one call at a time.
    checkpoint
        Called with the curve of the points finished so far, after each.

    Returns
    -------
    ContactCurve
        In the order asked for. `stiffness` is that of the contact found (`contact_stiffness`),
        infinite in full contact of a periodic cell. `residual` is the worst entry of the
        certificate, and `error_estimate` the bound on the error of the load on the grid that was
        solved (`bounds.load_error`), `extra["area_error_estimate"]` that of the area
        (`area_error`). `extra` holds the certificate by entry, raw area, elastic energy,
        iterations, transform pairs and seconds, with a hardness `plastic_share`; a point that
        missed the tolerance is marked and explained.

    Examples
    --------
    >>> import asperity, surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> steel = asperity.HalfSpace(210e9, 0.3)
    >>> curve = asperity.bem_curve(hm, steel, pressures=[1e8, 1e9])
    >>> bool(curve.converged.all()), bool(curve.area_fraction[1] > curve.area_fraction[0])
    (True, True)
    """
    if check and accuracy is None:
        raise InputError("check tells how well an accuracy is held; give accuracy as well")
    compile_ahead("bem")
    kind, values = checked_loads(hm, material, pressures, separations)
    sparse = accuracy is not None and coarsen and kind == "pressure"
    few = loads_to_solve(values) if sparse else None
    if few is not None:
        solved_curve = bem_curve(
            hm,
            material,
            pressures=few,
            boundary=boundary,
            accuracy=accuracy,
            check=check,
            progress=progress,
            checkpoint=checkpoint,
        )
        return interpolated(solved_curve, values)
    begun = time.perf_counter()
    boundary = chosen_boundary(hm, boundary)
    warnings = scene_warnings(hm, material)
    warn_once(warnings)
    asked: dict[str, Any] = {
        "input": hm.digest,
        "map": map_facts(hm),
        "pressure_scale": pressure_scale(hm, material),
        "warnings": warnings,
    }
    hm = hm.about_mean
    grid = hm
    if accuracy is not None:
        asked |= {"accuracy": require_accuracy(accuracy)}
        tolerance = LOOSEST
    if accuracy is not None and coarsen:
        lightest = _lightest_area(hm, material, kind, values)
        shape, why = choose_grid(hm, accuracy, lightest, boundary)
        grid = hm if shape == hm.shape else coarsened(hm, shape, boundary)
        asked |= {"accuracy_reason": why}
    order = np.argsort(values if kind == "pressure" else -values, kind="stable")
    chains = split_loads(_shares(kind, values[order]), grid.heights.size)
    together = len(chains) > 1 and thread_count() > 1 and fits(grid.shape, boundary, len(chains))

    def planned(_: range) -> ContactProblem:
        alone = kind == "pressure" and len(values) == 1
        return ContactProblem(
            grid,
            material,
            tolerance=tolerance,
            boundary=boundary,
            share=expected_area_fraction(hm, material, values[0]) if alone else None,
        )

    # those followed together have one thread each, from their plans on
    problems = apart(planned, chains if together else chains[:1])
    problem = problems[0]
    problem.prescribed(**{kind: float(values.max() if kind == "pressure" else values.min())})
    prepared = time.perf_counter()
    solved: dict[int, SolvedLoad] = {}
    turn = threading.Lock()

    def curve_of(indices: Sequence[int]) -> ContactCurve:
        seconds = {"setup": prepared - begun, "loads": time.perf_counter() - prepared}
        found = _curve(problem, [solved[i] for i in indices], seconds, asked)
        return replace(found, extra={f"asked_{kind}": values[indices], **found.extra})

    def follow(chain: range, stop: threading.Event) -> None:
        path = LoadPath(problems[-1] if chain.start else problem, accuracy or math.inf)
        for index in order[chain.start : chain.stop].tolist():
            if stop.is_set():
                return
            point = _solve_point(path, kind, float(values[index]), callable(progress))
            with turn:
                solved[index] = replace(point, contact=_NO_MAP)
                if tell is not None:
                    tell(point)
                if checkpoint is not None:
                    checkpoint(curve_of([*solved]))

    with reported(progress, len(values), "load points") as tell:
        follow_chains(chains, follow, together=together)
    curve = curve_of([*range(len(values))])
    return _checked(curve, hm, material, problem) if check and grid is not hm else curve


def _solve_point(path: LoadPath, kind: str, value: float, keep_map: bool) -> SolvedLoad:
    """Solve at one load and read the point off the state, with its contact map if that is kept."""
    problem = path.problem
    hm, exact = problem.hm, problem.level.exact
    begun, pairs = time.perf_counter(), exact.pairs
    outcome = path.solve(**{kind: value})
    certificate = outcome.reading.certificate
    contact = problem.level.pressure > 0.0 if keep_map else _NO_MAP
    raw, area, patches = outcome.contact
    mean = problem.mean_pressure(outcome)
    columns = {
        "separation": problem.separation(outcome),
        "mean_pressure": mean,
        "load": mean * hm.area,
        "area_fraction": area / hm.area,
        "contact_area": area,
        "contacts": patches,
        "stiffness": problem.stiffness(outcome),
        "converged": outcome.converged,
        "residual": certificate.worst,
        "error_estimate": load_error(problem, outcome),
        "area_error_estimate": area_error(problem, outcome)[0],
        "load_error": certificate.load,
        "complementarity": certificate.complementarity,
        "penetration": certificate.penetration,
        "contact_area_raw": raw,
        "elastic_energy": problem.elastic_energy(outcome),
        "iterations": outcome.iterations,
        "fft_pairs": exact.pairs - pairs,
        "seconds": time.perf_counter() - begun,
    }
    if math.isfinite(problem.level.cap):
        held = outcome.reading.held * (hm.area / hm.heights.size)
        columns |= {"lift": certificate.lift, "plastic_share": min(held / max(area, 1e-300), 1.0)}
        columns["plastic_work"] = problem.plastic_work(outcome)
        columns["unloading_stiffness"] = problem.unloading_stiffness(outcome)
    return SolvedLoad(columns, contact, outcome.reason)


def _curve(
    problem: ContactProblem,
    points: Sequence[SolvedLoad],
    seconds: dict[str, float],
    asked: dict[str, Any],
) -> ContactCurve:
    names = points[0].columns
    columns: dict[str, Any] = {name: np.array([p.columns[name] for p in points]) for name in names}
    return ContactCurve(
        **{name: columns.pop(name) for name in POINT_FIELDS},
        model="bem",
        seconds=seconds,
        settings={**problem.settings(), **asked},
        extra=columns,
        reasons=tuple(point.reason for point in points),
    )


def _shares(kind: str, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Loads over the largest, ascending; a guess if separations are prescribed."""
    if kind == "pressure":
        return np.asarray(values / max(values[-1], 1e-300))
    return np.linspace(0.0, 1.0, len(values)) ** 2


def _lightest_area(
    hm: HeightMap, material: HalfSpace, kind: str, values: NDArray[np.float64]
) -> float:
    """Area fraction expected at the lightest load point: from the load, or by the heights."""
    if kind == "pressure":
        loads = values[values > 0.0]
        return expected_area_fraction(hm, material, float(loads.min())) if loads.size else 1.0
    return 0.3 * float(np.mean(hm.heights - hm.heights.mean() > values.max()))


def _checked(
    curve: ContactCurve, hm: HeightMap, material: HalfSpace, problem: ContactProblem
) -> ContactCurve:
    """The curve with the error estimate from one solve on a grid twice as fine."""
    good = np.flatnonzero(curve.converged)
    if not good.size:
        return curve
    middle = int(good[np.argsort(curve.mean_pressure[good])[len(good) // 2]])
    rows, columns = (min(2 * n, full) for n, full in zip(problem.hm.shape, hm.shape, strict=True))
    whole = (rows, columns) == hm.shape
    finer = hm if whole else coarsened(hm, (rows, columns), problem.boundary)
    finest = bem_curve(
        finer,
        material,
        pressures=[curve.mean_pressure[middle]],
        tolerance=problem.tolerance,
        boundary=problem.boundary,
    )
    shift = abs(finest.separation[0] - curve.separation[middle]) / hm.rms_height
    area = abs(curve.contact_area[middle] / max(finest.contact_area[0], 1e-300) - 1.0)
    return replace(curve, error_estimate=np.maximum(curve.error_estimate, max(shift, area)))
