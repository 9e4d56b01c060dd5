"""Outliers: points that stand out from the roughness about them become missing."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from surfaces.errors import SurfaceError, as_number
from surfaces.heightmap import HeightMap, require_map

from .filling import quick_fill

__all__ = ["mark_outliers"]

_NINE_TENTHS = 1.6449  # nine tenths of a normal variable lie within this many deviations
_MEAN = 0.7979  # mean absolute value of a normal variable, in deviations
_AROUND = 11  # side [pixels] of the surroundings of a point
_ROUNDS = 5  # searches for spikes, at most


def mark_outliers(hm: HeightMap, threshold: float = 6.0) -> HeightMap:
    """Turn spikes into missing points.

    Parameters
    ----------
    hm
        The map; missing points are left out of the judgement.
    threshold
        A point is a spike if its roughness (what a 5 x 5 median filter, applied twice, leaves)
        exceeds this many standard deviations, of the map and of the 11 x 11 points about it; at
        least 3.

    Returns
    -------
    HeightMap
        History step ``outliers`` with the smallest limit [m] and the count.

    Raises
    ------
    SurfaceError
        If the threshold is below 3.

    Notes
    -----
    The deviation of the map is its ninth decile over 1.6449, that of the surroundings 1.25 times
    the mean, spikes cut off in both: steep or rough places are not taken for spikes. Repeated
    until nothing more is found, at most five times, with spikes replaced by the medians: a spike
    wider than two points is taken from its rim inwards.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> heights = hm.heights.copy()
    >>> heights[10, 20] += 1e-3
    >>> surfaces.mark_outliers(hm.replace(heights=heights)).missing
    1
    """
    require_map(hm)
    if not as_number("outliers", threshold) >= 3.0:
        raise SurfaceError(f"outliers is {threshold}; use 3 or more robust standard deviations")
    present = np.isfinite(hm.heights)
    middle = float(np.median(hm.heights[present]))
    scale = float(np.max(np.abs(hm.heights[present] - middle))) or 1.0
    z = quick_fill(np.where(present, (hm.heights - middle) / scale, 0.0), present)
    spikes = np.zeros(hm.shape, dtype=bool)
    limit = 0.0
    for _ in range(_ROUNDS):
        median = _median(z, hm.periodic)
        rough = z - median
        rough = np.abs(rough - _median(rough, hm.periodic))
        if limit == 0.0:
            limit = threshold * float(np.quantile(rough[present], 0.9)) / _NINE_TENTHS + 1e-7
        around = cv2.blur(np.minimum(rough, limit), (_AROUND, _AROUND)) / _MEAN
        found = present & ~spikes & (rough > np.maximum(limit, threshold * around))
        if not found.any():
            break
        spikes |= found
        z[found] = median[found]
    step = {
        "step": "outliers",
        "threshold": threshold,
        "limit": limit * scale,
        "count": int(np.count_nonzero(spikes)),
    }
    return hm.replace(heights=np.where(spikes, np.nan, hm.heights), step=step)


def _median(z: NDArray[np.float64], periodic: bool) -> NDArray[np.float64]:
    """Median of the 5 x 5 points about each point; the map goes on evenly beyond its border."""
    padded = np.pad(z, 2, mode="wrap") if periodic else _extended(_extended(z).T).T
    blurred = cv2.medianBlur(padded.astype(np.float32), 5)
    return np.asarray(blurred[2:-2, 2:-2], dtype=np.float64)


def _extended(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Two rows more on either side, mirrored through the medians along the border rows."""
    first, last = (median_filter(row, 5, mode="nearest") for row in (z[0], z[-1]))
    return np.vstack([2.0 * first - z[2:0:-1], z, 2.0 * last - z[-2:-4:-1]])
