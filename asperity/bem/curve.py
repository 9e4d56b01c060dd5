"""Contact curve by the boundary-element method: loads solved in turn, each started warm."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surfaces.heightmap import HeightMap

from ..loadpoints import checked_loads
from ..results import ContactCurve
from .kernel import ElasticHalfSpace
from .operator import Boundary
from .solution import BemSolution
from .solve import ContactProblem

__all__ = ["bem_curve"]


def bem_curve(
    hm: HeightMap,
    mat: ElasticHalfSpace,
    *,
    pressures: ArrayLike | None = None,
    separations: ArrayLike | None = None,
    tolerance: float = 1e-6,
    boundary: Boundary | None = None,
    progress: Callable[[BemSolution], object] | None = None,
    checkpoint: Callable[[ContactCurve], object] | None = None,
) -> ContactCurve:
    """Load, separation and contact area of a rough map at several load points.

    Parameters
    ----------
    hm, mat, tolerance, boundary
        As in `bem_solve`.
    pressures
        Mean pressures [Pa], in any order; or
    separations
        separations [m]. With neither: 10 geometric loads for about 0.1 % to 10 % of contact,
        from the rms slope and the modulus.
    progress
        Called with the solution of every finished load point.
    checkpoint
        Called with the curve of the points finished so far, after each.

    Returns
    -------
    ContactCurve
        In the order asked for. `residual` is the worst entry of the certificate; `extra` holds
        the certificate by entry, raw area, elastic energy, mean gap, iterations and transform
        pairs; a point that missed the tolerance is marked and explained.
    """
    kind, values = checked_loads(hm, mat, pressures, separations)
    start = time.perf_counter()
    problem = ContactProblem(hm, mat, tolerance=tolerance, boundary=boundary)
    order = np.argsort(values if kind == "pressure" else -values, kind="stable")
    solved: dict[int, tuple[dict[str, float], str]] = {}
    guess: BemSolution | None = None

    def curve_of(points: Iterable[int]) -> ContactCurve:
        seconds = {"setup": problem.setup_seconds}
        seconds["loads"] = time.perf_counter() - start - problem.setup_seconds
        return _curve(problem, [solved[i] for i in points], seconds)

    for index in order.tolist():
        value = float(values[index])
        solution = problem.solve(
            pressure=value if kind == "pressure" else None,
            separation=value if kind == "separation" else None,
            guess=guess,
        )
        solved[index] = (_row(solution), solution.reason)
        guess = solution if solution.mean_pressure > 0.0 else None
        if progress is not None:
            progress(solution)
        if checkpoint is not None:
            checkpoint(curve_of(solved))
    return curve_of(range(len(values)))


def _row(solution: BemSolution) -> dict[str, float]:
    return {
        "separation": solution.separation,
        "mean_pressure": solution.mean_pressure,
        "load": solution.load,
        "area_fraction": solution.area_fraction,
        "contact_area": solution.contact_area,
        "contacts": solution.contacts,
        "converged": solution.converged,
        "residual": solution.certificate.worst,
        "load_error": solution.certificate.load,
        "complementarity": solution.certificate.complementarity,
        "penetration": solution.certificate.penetration,
        "contact_area_raw": solution.contact_area_raw,
        "mean_gap": solution.mean_gap,
        "elastic_energy": solution.elastic_energy,
        "iterations": solution.iterations,
        "fft_pairs": solution.fft_pairs,
        "seconds": sum(t for stage, t in solution.seconds.items() if stage != "setup"),
    }


def curve_stiffness(
    separation: NDArray[np.float64], mean_pressure: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Minus the slope of mean pressure over separation [Pa/m] by differences, shape (n,).

    Repeated points (closer than 1e-5 of the range) share one value; NaN if there is one point.
    """
    order = np.argsort(separation, kind="stable")
    steps = np.diff(separation[order])
    first = np.append(True, steps > 1e-5 * np.ptp(separation))
    chosen = order[first]
    if chosen.size < 2:
        return np.full(separation.shape, np.nan)
    slope = -np.gradient(mean_pressure[chosen], separation[chosen])
    stiffness = np.empty(separation.shape)
    stiffness[order] = slope[np.cumsum(first) - 1]
    return stiffness


def _curve(
    problem: ContactProblem,
    points: Sequence[tuple[dict[str, float], str]],
    seconds: dict[str, float],
) -> ContactCurve:
    rows, reasons = zip(*points, strict=True)
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    names = ("separation", "mean_pressure", "load", "area_fraction", "contact_area")
    main = {name: columns.pop(name) for name in names}
    return ContactCurve(
        **main,
        contacts=columns.pop("contacts").astype(np.int64),
        stiffness=curve_stiffness(main["separation"], main["mean_pressure"]),
        converged=columns.pop("converged").astype(bool),
        residual=columns.pop("residual"),
        error_estimate=np.full(len(rows), np.nan),
        model="bem",
        seconds=seconds,
        settings={**problem.settings(), "input": problem.hm.digest},
        extra=columns,
        reasons=tuple(reasons),
    )
