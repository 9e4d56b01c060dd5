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
    values
        Of each summit, shape (n, 3): approach [m], or minus the gap where it is open; gradients of
        the displacement [-]. NaN where unknown.
    """

    separation: float
    pressure: float
    values: NDArray[np.float64]


def forecast(points: tuple[Point, ...], separation: float) -> NDArray[np.float64]:
    """`Point.values` at a separation, each from as many points as know it; zero where none does."""
    values = points[-1].values.copy()
    for count in range(2, len(points) + 1):
        last = points[-count:]
        share = weights(separation, [point.separation for point in last])
        found = sum(w * point.values for w, point in zip(share, last, strict=True))
        known = np.isfinite(found[:, 0])
        values[known] = found[known]
    values[np.isnan(values[:, 0])] = 0.0
    return values


def weights(place: float, known: list[float]) -> NDArray[np.float64]:
    """Weights of points at `known` places in the value at `place`: the polynomial through up to
    three, the line through the last two if those lie badly, and never far beyond it."""
    count = len(known)
    if count == 1:
        return np.ones(1)
    if count > 2 and len(set(known)) == count:
        x = np.array(known)
        share = [np.prod((place - np.delete(x, i)) / (x[i] - np.delete(x, i))) for i in range(3)]
        if np.abs(share).max() <= STEEPEST:
            return np.array(share)
    before, last = known[-2:]
    ratio = 0.0 if before == last else (place - last) / (last - before)
    ratio = min(max(ratio, -1.5), 1.5)
    return np.array([0.0] * (count - 2) + [-ratio, 1.0 + ratio])
