"""The points a population has passed, and the forecast of the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["MEMORY", "Point", "forecast", "weights"]

MEMORY = 3
"""Points kept to extrapolate from."""

STEEPEST = 6.0
"""Largest weight of one point in an extrapolation over three: beyond it, noise is magnified."""


@dataclass(frozen=True, eq=False)
class Point:
    """One solved point.

    Attributes
    ----------
    separation, pressure
        Where it is [m], and its mean pressure [Pa].
    rows
        Summits that were listed, shape (m,).
    values
        Of each of these, shape (m, 4): approach [m], or minus the gap where it is open; gradients
        of the displacement [-]; approach gained per fall of the plane [-].
    """

    separation: float
    pressure: float
    rows: NDArray[np.int64]
    values: NDArray[np.float64]


def forecast(
    points: tuple[Point, ...], separation: float, count: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Summits of the last point, shape (m,), of `count` in all, and their `Point.values` at a
    separation, each from as many points as know it; along the response if there is one point."""
    last = points[-1]
    values = last.values.copy()
    if len(points) == 1:
        fall = last.separation - separation
        values[:, 0] += np.where(values[:, 0] > 0, values[:, 3] * fall, 0.0)
        return last.rows, values
    known, line = np.ones(len(last.rows), bool), [last.values]
    for back in range(2, len(points) + 1):
        place = np.zeros(count, np.int32)
        place[points[-back].rows] = np.arange(1, len(points[-back].rows) + 1)
        place = place[last.rows]
        known &= place > 0
        line.insert(0, points[-back].values[place - 1])
        share = weights(separation, [point.separation for point in points[-back:]])
        found = sum(w * part for w, part in zip(share, line, strict=True))
        values[known, :3] = found[known, :3]
    return last.rows, values


def weights(place: float, known: list[float]) -> NDArray[np.float64]:
    """Weights of points at `known` places in the value at `place`: the polynomial through up to
    three, the line through the last two if those lie badly, and never far beyond it."""
    count = len(known)
    if count == 1:
        return np.ones(1)
    if count > 2 and len(set(known)) == count:
        a, b, c = known
        share = np.array(
            [
                (place - b) * (place - c) / ((a - b) * (a - c)),
                (place - a) * (place - c) / ((b - a) * (b - c)),
                (place - a) * (place - b) / ((c - a) * (c - b)),
            ]
        )
        if np.abs(share).max() <= STEEPEST:
            return share
    before, last = known[-2:]
    ratio = 0.0 if before == last else (place - last) / (last - before)
    ratio = min(max(ratio, -1.5), 1.5)
    return np.array([0.0] * (count - 2) + [-ratio, 1.0 + ratio])
