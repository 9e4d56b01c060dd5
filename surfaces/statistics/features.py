"""Feature parameters of ISO 25178-2: peaks and pits, areas and volumes of hills and dales."""

from __future__ import annotations

import numpy as np

from surfaces.heightmap import HeightMap
from surfaces.numerics.stored_array import each_block, windows
from surfaces.peaks.peaks import Peaks
from surfaces.peaks.segmentation import segment

__all__ = ["FEATURES", "features"]

FEATURES = ("Spd", "Svd", "Spc", "Svc", "S5p", "S5v", "S10z", "Sha", "Sda", "Shv", "Sdv")

_TOP = 5
"""Peaks of S5p and pits of S5v."""


def features(hm: HeightMap, wolf: float) -> dict[str, float]:
    """Feature parameters of a map after Wolf pruning at `wolf` percent of Sz, see `describe`; NaN
    where there is no such feature.

    Notes
    -----
    ISO 25178-2:2021, clause 5; the dales are the hills of the negated map.

    - Spd, Svd: number of all peaks, pits per area.
    - Spc, Svc: mean of -(z_xx + z_yy) / 2 at all peaks, pits, by second differences; those of
      points on the border, which have none, are left out.
    - S5p, S5v: mean height above the mean plane of the five highest peaks, mean depth of the five
      deepest pits, of fewer if there are no more; S10z is their sum.
    - Sha, Sda: mean area of the closed hills, dales, which do not reach the border of the map.
    - Shv, Sdv: mean volume of their material above, their void below the pass that leads to a
      neighbor first: the volume of a lake in a dale when it begins to overflow.
    """
    density, curvature, height, area, volume = _motifs(hm, wolf)
    upside_down = hm.replace(heights=each_block(hm.source, np.negative))
    pits, bend, depth, space, void = _motifs(upside_down, wolf)
    values = (density, pits, curvature, -bend, height, depth, height + depth)
    return dict(zip(FEATURES, (*values, area, space, volume, void), strict=True))


def _motifs(hm: HeightMap, wolf: float) -> tuple[float, float, float, float, float]:
    """Density, mean curvature, mean of the highest five, and mean area and volume of the hills."""
    peaks, heights = segment(hm, wolf=wolf), hm.roughness
    closed = ~peaks.border
    saddle = np.full(len(peaks), -np.inf)
    np.maximum.at(saddle, peaks.neighbors, peaks.passes[:, None])
    saddle[np.isinf(saddle)] = heights.lowest
    volume = np.zeros(len(peaks))
    for begin, end, rows in windows(hm.source):
        labels = peaks.labels[begin:end]
        above = np.maximum(rows - saddle[labels], 0.0)
        volume += np.bincount(labels.ravel(), above.ravel(), len(peaks))
    volume *= hm.area / hm.source.size
    some = bool(closed.any())
    return (
        len(peaks) / hm.area,
        _curvature(hm, peaks),
        float(peaks.height[:_TOP].mean() - heights.mean),
        float(peaks.basin_area[closed].mean()) if some else np.nan,
        float(volume[closed].mean()) if some else np.nan,
    )


def _curvature(hm: HeightMap, peaks: Peaks) -> float:
    """Mean of the mean curvatures at the peaks [1/m], positive."""
    (ny, nx), (dy, dx), row, col = hm.shape, hm.spacing, peaks.row, peaks.col
    if not hm.periodic:
        inside = (row > 0) & (row < ny - 1) & (col > 0) & (col < nx - 1)
        row, col = row[inside], col[inside]
    if not row.size:
        return np.nan
    z = hm.source
    bend_y = 2.0 * z[row, col] - z[row - 1, col] - z[(row + 1) % ny, col]
    bend_x = 2.0 * z[row, col] - z[row, col - 1] - z[row, (col + 1) % nx]
    return float(0.5 * np.mean(bend_y / dy**2 + bend_x / dx**2))
