"""Bounds from a certificate: errors of the load at equal separation and of the contact area."""

from __future__ import annotations

import math

import numpy as np

from surfaces.arrays import Array, Index

from .correction import GridSolution
from .problem import ContactProblem

__all__ = ["AREA_OVER_LOAD_ERROR", "area_error", "load_error"]

AREA_OVER_LOAD_ERROR = 3.0
"""Bound on the error of the contact area at equal load over that of the load at equal separation
(docs/development/verification.md)."""

_DECIDED_LENGTH = 3.0
"""A point counts as surely open or closed if its gap, or its displacement by its own pressure, is
this many times the error of the level: the certificate weights points by their pressure, so that
points of small pressure have a larger error."""

_NEAR_FULL = 0.1
"""Error of the level, over the separation, from which full contact is near."""

_LEVEL_PARTS = 8
"""Number of steps in the error of the level; points within one step open or close together, such as
equivalent points of a lattice."""


def load_error(problem: ContactProblem, solution: GridSolution) -> float:
    """Bound on the relative error of the load at equal separation [-], from the certificate.

    Notes
    -----
    A certificate e is relative to the rms height h, so that the level of the contact may be off by
    e h, and the load by the part e h k with k = -d ln F/ds. For k the larger of two values is
    taken: that of the stiffness of this contact, and F/U (`_past_error`). In full contact of a
    periodic cell no load changes the separation: the error is that of the prescribed load, and a
    prescribed separation leaves the load open.

    Near full contact k grows without limit. F(s) of an elastic cell is convex, since the contact
    grows, and ends at the load F0 of full contact: F(s - e h) <= F + (F0 - F) min(e h / s, 1).
    """
    if math.isinf(solution.stiffness):
        level = solution.goal.level is not None
        return math.inf if level else _past_error(problem, solution)
    error, mean = _level_error(solution), _mean(problem, solution)
    now = error * solution.stiffness / max(mean, 1e-300)
    beyond, full = 0.0, _full_contact(problem, solution)
    if math.isfinite(full):
        beyond = abs(full / mean - 1.0) * error / max(_separation(problem, solution), error)
    return max(_past_error(problem, solution), now, beyond)


def area_error(problem: ContactProblem, solution: GridSolution) -> tuple[float, float]:
    """Bound on the relative error of the contact area at equal load [-], and the part of one pixel.

    The bound is one pixel plus the larger of two errors: `AREA_OVER_LOAD_ERROR` times that of the
    load by F/U, and the area of points that may open or close together. One pixel is taken over the
    corrected area, which is smaller than that of the pixels.

    Notes
    -----
    On a lattice of equal hills, and on single waves, whole rings of points around all contacts are
    equally far from contact, so that the area changes by steps of many pixels: the largest step
    near the solution counts in full. On random maps points open and close one by one: what counts
    is how many more of the unsure points would open than close. At the distance d from the edge of
    a contact the gap is ~ d^((3-m)/2) and the pressure ~ d^((1+m)/2): with m < 0 hardly a point of
    the exact contact would open, so that only 1 + m of those that would close count against them.
    Under the load of full contact all open points close.
    """
    pixels = solution.contact[1] / (problem.hm.spacing[0] * problem.hm.spacing[1])
    if pixels == 0.0:
        return 0.0, 0.0
    reading, far = solution.reading, _DECIDED_LENGTH * _level_error(solution)
    _, pressure, gap = problem.finest.select(reading, reading.level + far)
    pressed = pressure > 0.0
    # a point under pressure lies as deep as this pressure alone displaces it
    opens = _by_length(pressure[pressed] * problem.own, far)
    closes = _by_length(gap[~pressed] - reading.level, far)
    excess = opens.sum() - min(1.0, 1.0 + problem.material.m) * closes.sum()
    opening, closing = max(opens.max(), excess), closes.max()
    leap = float(max(opening / max(pixels - opening, 1.0), closing / pixels))
    if _mean(problem, solution) >= _full_contact(problem, solution):
        leap = max(leap, problem.finest.heights.size / pixels - 1.0)
    one = 1.0 / pixels
    return max(AREA_OVER_LOAD_ERROR * _past_error(problem, solution), leap) + one, one


def _by_length(lengths: Array, far: float) -> Index:
    """Histogram of `lengths` [units] from 0 to `far`, in equal steps."""
    steps = round(_DECIDED_LENGTH * _LEVEL_PARTS)
    near = np.maximum(lengths[lengths < far], 0.0) / (far / steps)
    return np.bincount(np.minimum(near.astype(np.int64), steps - 1), minlength=steps)


def _past_error(problem: ContactProblem, solution: GridSolution) -> float:
    """Relative error of the load by k = F/U, with the work U = int_s F ds', elastic and plastic.

    F/U is an upper bound of k = -d ln F/ds wherever k falls with the load, as it does at light
    loads of rough surfaces and of every blunt body. In full contact of a periodic cell, where every
    point is pressed by more than the error of the level, it is the load error of the certificate.
    """
    reading = solution.reading
    total, work = reading.total, 0.5 * reading.moment + reading.plastic_work
    error = _level_error(solution)
    if problem.boundary == "periodic" and reading.weakest * problem.own > _DECIDED_LENGTH * error:
        return reading.certificate.load
    if total == 0.0:
        return 0.0
    return error * total / work if work > 0.0 else math.inf


def _full_contact(problem: ContactProblem, solution: GridSolution) -> float:
    """Mean of p~ in full contact of an elastic cell, infinite where that is far or unknown."""
    far = _level_error(solution) < _NEAR_FULL * _separation(problem, solution)
    return math.inf if far or not solution.stiffness else problem.full_contact


def _separation(problem: ContactProblem, solution: GridSolution) -> float:
    """Separation from the mean plane, in units."""
    return -(solution.reading.level + problem.finest.mean_height)


def _mean(problem: ContactProblem, solution: GridSolution) -> float:
    """Mean of p~ on the finest grid."""
    return solution.reading.total / problem.finest.heights.size


def _level_error(solution: GridSolution) -> float:
    """Bound on the error of the level of the contact, in units."""
    worst = max(solution.tolerance, solution.reading.certificate.worst)
    return worst * solution.reading.scale
