"""The points a population has passed, and the prediction of the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["MEMORY", "Point", "predict", "weights"]

MEMORY = 3
"""Points kept to extrapolate from."""

STEEPEST = 6.0
"""Largest weight of one point in an extrapolation over three: beyond it, noise is magnified."""

Array = NDArray[np.float64]


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
        Of each of these, shape (5, m): z - s - u [m], the approach or minus the gap; force [N];
        two gradients of the displacement [-]; approach gained per fall of the plane [-].
    """

    separation: float
    pressure: float
    rows: NDArray[np.int64]
    values: Array


def predict(points: tuple[Point, ...], separation: float, count: int) -> Array:
    """`Point.values` of the summits of the last point, of `count` in all, at a separation, each
    from as many points as know it; along the response if there is one point."""
    last = points[-1]
    if len(points) == 1:
        values, fall = last.values.copy(), last.separation - separation
        values[0] += np.where(values[0] > 0, values[4] * fall, 0.0)
        return values
    share: list[float | Array] = [1.0]
    known, parts = None, [last.values]
    for back in range(2, len(points) + 1):
        other, found = points[-back], weights(separation, [p.separation for p in points[-back:]])
        values = other.values
        if other.rows is not last.rows:
            place = np.full(count, -1, np.int32)
            place[other.rows] = np.arange(len(other.rows), dtype=np.int32)
            place = place.take(last.rows)
            known = place >= 0 if known is None else known & (place >= 0)
            values = values.take(place, axis=1)
        parts.insert(0, values)
        share.insert(0, 0.0)
        for k, weight in enumerate(found):
            share[k] = weight if known is None else np.where(known, weight, share[k])
    values = share[0] * parts[0]
    for weight, part in zip(share[1:], parts[1:], strict=True):
        values += weight * part
    values[4] = last.values[4]
    return values


def weights(place: float, known: list[float]) -> Array:
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
