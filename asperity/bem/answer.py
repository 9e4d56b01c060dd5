"""What a solution says, in SI units."""

from __future__ import annotations

import math
from typing import Any

from .bounds import area_error, load_error
from .correction import GridSolution
from .problem import ContactProblem
from .stiffness import contact_stiffness

__all__ = ["answer", "answer_of_hardness"]


def answer(problem: ContactProblem, solution: GridSolution) -> dict[str, Any]:
    """Numbers of a solution, by the names of `BemSolution` and of the columns of a curve.

    In full contact of a periodic cell the separation is zero, and where all has yielded the mean
    pressure is at most the hardness, without rounding: above it no load can be asked for.
    """
    hm, finest, reading = problem.hm, problem.finest, solution.reading
    mean = min(reading.total / hm.heights.size / problem.compliance, problem.material.hardness)
    full = math.isinf(solution.stiffness)
    raw, area, patches = solution.contact
    return {
        "separation": 0.0 if full else -(reading.level + finest.mean_height) * problem.unit,
        "mean_pressure": mean,
        "load": mean * hm.area,
        "area_fraction": min(area / hm.area, 1.0),
        "contact_area": area,
        "contact_area_raw": raw,
        "contacts": patches,
        "stiffness": _slope(problem, solution, solution.stiffness),
        "converged": solution.converged,
        "error_estimate": load_error(problem, solution),
        "area_error_estimate": area_error(problem, solution)[0],
        "elastic_energy": 0.5 * reading.moment * _energy(problem),
        "iterations": solution.iterations,
    }


def answer_of_hardness(problem: ContactProblem, solution: GridSolution) -> dict[str, float]:
    """Further numbers of a solution under a hardness."""
    reading, area = solution.reading, solution.contact[1]
    held = reading.held * (problem.hm.area / problem.hm.heights.size)
    slope = (
        contact_stiffness(problem.finest, reading, unloading=True) if solution.converged else 0.0
    )
    return {
        "lift": reading.certificate.lift,
        "plastic_share": min(held / max(area, 1e-300), 1.0),
        "plastic_work": reading.plastic_work * _energy(problem),
        "unloading_stiffness": _slope(problem, solution, slope),
    }


def _slope(problem: ContactProblem, solution: GridSolution, stiffness: float) -> float:
    """Minus the slope of mean pressure over separation [Pa/m], NaN if not converged."""
    return (stiffness if solution.converged else math.nan) / problem.finest.exact.compliance


def _energy(problem: ContactProblem) -> float:
    """Work [J] of a p~ and a displacement of one unit each on a pixel."""
    dy, dx = problem.hm.spacing
    return problem.unit / problem.compliance * dy * dx
