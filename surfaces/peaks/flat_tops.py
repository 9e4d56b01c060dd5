"""Tops of one height: a spline through them only rings, and says nothing of their summits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from surfaces.heightmap import HeightMap

from .peaks import Peaks

__all__ = ["flat_share", "flat_tops"]

HIGHEST = 0.02
"""Share of the points that count as the highest."""


def flat_tops(hm: HeightMap, peaks: Peaks) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Peaks with a flat top and its middle.

    Parameters
    ----------
    hm
        Height map.
    peaks
        Its peaks.

    Returns
    -------
    rows
        Peaks of which a highest point has eight neighbors of its height, (k,).
    middle
        Row and column of such a point that is nearest to the mean of them, (k, 2).
    """
    heights, shape = hm.heights, np.array(hm.shape)
    tops = np.stack((peaks.row, peaks.col), axis=1)
    line, level = heights.shape[1], heights.ravel()
    at = peaks.row * line + peaks.col
    here, beside = level.take(at), (level.take(at + k, mode="wrap") for k in (1, -1, line, -line))
    rows = np.flatnonzero(np.logical_or.reduce([height == here for height in beside]))
    if not rows.size:
        return rows, tops[:0]
    top, slot = np.full(len(peaks) + 1, np.inf), np.zeros(len(peaks) + 1, np.int64)
    top[rows], slot[rows] = heights[tuple(tops[rows].T)], np.arange(rows.size)
    points = np.argwhere(heights == top[peaks.labels])
    points = points[_level_steps(hm, points).all(axis=1)]
    of = slot[peaks.labels[tuple(points.T)]]
    away = (points - tops[rows][of]).astype(float)
    if hm.periodic:
        away -= shape * np.round(away / shape)
    count, square = np.maximum(np.bincount(of), 1), np.zeros(of.size)
    for along in away.T:
        square += (along - (np.bincount(of, along) / count)[of]) ** 2
    order = np.lexsort((square, of))
    flat, first = np.unique(of[order], return_index=True)
    return rows[flat], points[order[first]]


def flat_share(hm: HeightMap) -> float:
    """Share of the highest points whose eight neighbors have their height."""
    heights = hm.heights
    if not hm.repeats:
        return 0.0
    top = np.argwhere(heights >= np.quantile(heights, 1.0 - HIGHEST))
    return float(np.mean(_level_steps(hm, top).all(axis=1)))


def _level_steps(hm: HeightMap, points: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which of the nine points about each of some, (k, 2), have its height, (k, 9)."""
    steps = np.stack(np.meshgrid((-1, 0, 1), (-1, 0, 1), indexing="ij"), axis=-1).reshape(9, 2)
    near, shape = points[:, None] + steps, np.array(hm.shape)
    inside = hm.periodic | ((near >= 0) & (near < shape)).all(axis=2)
    near %= shape
    here = hm.heights[tuple(points.T)][:, None]
    return np.asarray(inside & (hm.heights[near[:, :, 0], near[:, :, 1]] == here))
