"""Contact curve by the boundary-element method: loads solved in turn, each started warm."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from asperity.compilation import compile_ahead
from asperity.errors import InputError, cautious, warn_once
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import (
    as_pressed,
    checked_loads,
    chosen_boundary,
    expected_area_fraction,
    map_facts,
    pressure_scale,
    scene_warnings,
)
from asperity.progress import Progress, reported, require_function
from asperity.results.curve import ContactCurve
from asperity.results.interpolation import POINT_FIELDS
from surfaces.arrays import Array, Mask
from surfaces.errors import as_numbers
from surfaces.heightmap import HeightMap
from surfaces.numerics.parallel import apart
from surfaces.numerics.parallel import threads as thread_count

from .answer import answer, answer_of_hardness
from .load_path import NO_LIMIT, LoadPath, follow_chains, split_loads, stopping
from .memory import fits
from .part import SolvedPart, solved_part
from .problem import ContactProblem

__all__ = ["SolvedLoad", "bem_curve"]

_LOOSEST = 1e-2
"""Tolerance that each load of an accuracy is solved to first; looser saves little."""


@dataclass(frozen=True, eq=False)
class SolvedLoad:
    """One solved point of a curve, as `progress` sees it.

    Attributes
    ----------
    columns
        Every number of the point, by the names of `ContactCurve` and of its `extra`.
    contact
        Pixels under pressure, shape (ny, nx).
    part
        State about the highest point of the map.
    reason
        Why the point did not converge, else "".
    hm
        The map that was solved, about its mean.
    """

    columns: Mapping[str, float]
    contact: Mask
    part: SolvedPart
    reason: str
    hm: HeightMap

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
    accuracy: float | tuple[float, float] | None = None,
    progress: Progress = None,
    checkpoint: Callable[[ContactCurve], object] | None = None,
    paths: dict[str, Array] | None = None,
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
        Relative error allowed in load and corrected area [-], 1e-4 to 0.2, or one for each, in
        place of a tolerance: each load is solved until its certificate bounds the error by that.
    progress
        True for a progress bar, or a function called with every finished load point
        (`SolvedLoad`), with its contact map; one call at a time.
    checkpoint
        Called with the curve of the points finished so far, after each.
    paths
        Filled, before each checkpoint, with how far the run has come. Given to a call for the
        loads that are left of a run, it makes their points those of a run without interruption.

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
    compile_ahead("bem")
    kind, given = checked_loads(hm, material, pressures, separations)
    values, place = np.unique(given, return_inverse=True)  # equal loads are solved once
    if kind == "separation":  # from light to heavy
        values, place = values[::-1], len(values) - 1 - place
    require_function("checkpoint", checkpoint)
    begun = time.perf_counter()
    boundary = chosen_boundary(hm, boundary)
    warnings = scene_warnings(as_pressed(hm, boundary), material)
    warn_once(warnings)
    asked: dict[str, Any] = {
        "input": hm.digest,
        "map": map_facts(hm),
        "pressure_scale": pressure_scale(hm, material),
        "warnings": warnings,
    }
    hm = hm.about_mean
    allowed = NO_LIMIT
    if accuracy is not None:
        allowed = _require_accuracy(accuracy)
        asked |= {"accuracy": allowed[0] if allowed[0] == allowed[1] else [*allowed]}
        tolerance = _LOOSEST
    paths = {} if paths is None else paths
    values, left = _run(kind, values, hm.heights.size, paths)
    chains = [*left]
    together = len(chains) > 1 and thread_count() > 1 and fits(hm.shape, boundary, len(chains))

    def planned(_: range) -> ContactProblem:
        alone = kind == "pressure" and len(values) == 1
        return ContactProblem(
            hm,
            material,
            tolerance=tolerance,
            boundary=boundary,
            share=expected_area_fraction(hm, material, values[0]) if alone else None,
        )

    # those followed together have one thread each, from their plans on
    problems = apart(planned, chains if together else chains[:1])
    problem = problems[0]
    problem.prescribed(kind, float(values[-1]))
    prepared = time.perf_counter()
    solved: dict[int, tuple[Mapping[str, float], str]] = {}
    turn = threading.Lock()

    def curve_of(indices: Sequence[int]) -> ContactCurve:
        points, reasons = zip(*(solved[i] for i in indices), strict=True)
        columns: dict[str, Any] = {
            name: np.array([point[name] for point in points]) for name in points[0]
        }
        return ContactCurve(
            **{name: columns.pop(name) for name in POINT_FIELDS},
            model="bem",
            seconds={"setup": prepared - begun, "loads": time.perf_counter() - prepared},
            settings={**problem.settings(), **asked},
            extra={f"asked_{kind}": values[indices], **columns},
            reasons=reasons,
        )

    def follow(chain: range, stop: threading.Event) -> None:
        path = LoadPath(problems[-1] if chain.start else problem, allowed)
        if left[chain].start > chain.start:
            path.go_on(paths[f"state {chain.start}"])
        for index in left[chain]:
            if stop.is_set():
                return
            columns, reason = _solve_point(path, kind, float(values[index]))
            seen = None if tell is None else _seen(path.problem, columns, reason)
            state = None if checkpoint is None else path.state()
            with turn, stopping(stop):
                if stop.is_set():  # meanwhile: nobody waits for the rest
                    return
                solved[index] = columns, reason
                if tell and seen:
                    tell(seen)
                if checkpoint is not None and state is not None:
                    reached = {f"next {chain.start}": np.array([index + 1])}
                    paths.update(reached | {f"state {chain.start}": state})
                    checkpoint(curve_of([*solved]))

    with reported(progress, sum(map(len, left.values())), "load points") as tell:
        follow_chains(chains, follow, together=together)
    given_ones = [index for some in left.values() for index in some]
    return curve_of([given_ones[i] for i in place])


def _require_accuracy(accuracy: float | tuple[float, float]) -> tuple[float, float]:
    """Relative errors allowed in load and area; refused if they are not from 1e-4 to 0.2."""
    found = as_numbers("accuracy", accuracy).ravel().tolist()
    if len(found) not in (1, 2) or not all(1e-4 <= each <= 0.2 for each in found):
        raise InputError(
            f"accuracy is {accuracy!r}; give a relative error from 1e-4 to 0.2, or two: of load "
            "and of area"
        )
    return found[0], found[-1]


def _solve_point(path: LoadPath, kind: str, value: float) -> tuple[dict[str, float], str]:
    """Solve at one load and read the point off the state: `SolvedLoad.columns` and `reason`."""
    problem = path.problem
    exact = problem.finest.exact
    begun, pairs = time.perf_counter(), exact.pairs
    solution = path.solve(kind, value)
    certificate = solution.reading.certificate
    columns = answer(problem, solution) | {
        "residual": certificate.worst,
        "load_error": certificate.load,
        "complementarity": certificate.complementarity,
        "penetration": certificate.penetration,
        "fft_pairs": exact.pairs - pairs,
        "seconds": time.perf_counter() - begun,
    }
    if math.isfinite(problem.finest.cap):
        columns |= answer_of_hardness(problem, solution)
    return columns, solution.reason


def _seen(problem: ContactProblem, columns: Mapping[str, float], reason: str) -> SolvedLoad:
    """The load solved last as `progress` sees it."""
    contact = problem.finest.pressure > 0.0
    return SolvedLoad(columns, contact, solved_part(problem), reason, problem.hm)


def _run(
    kind: str, loads: Array, points: int, paths: dict[str, Array]
) -> tuple[Array, dict[range, range]]:
    """All loads of a run, and which of them each of its chains has left: of the run that `paths`
    tells of, if just these loads are left of it; else of a new run."""
    for run in (paths.get("loads", loads), loads):
        chains = split_loads(_shares(kind, run), points)
        left = {c: range(int(paths.get(f"next {c.start}", [c.start])[0]), c.stop) for c in chains}
        if np.array_equal(np.concatenate([run[some] for some in left.values()]), loads):
            break
        paths.clear()
    paths["loads"] = run
    return run, left


def _shares(kind: str, values: Array) -> Array:
    """Loads over the largest, ascending; a guess if separations are prescribed."""
    if kind == "pressure":
        return np.asarray(values / max(values[-1], 1e-300))
    return np.linspace(0.0, 1.0, len(values)) ** 2
