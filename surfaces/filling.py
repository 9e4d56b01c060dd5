"""Missing points: mark outliers as missing, and fill missing points harmonically."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import LinearOperator, cg, splu

from .errors import SurfaceError
from .heightmap import HeightMap

__all__ = ["fill_missing", "mark_outliers"]

_DIRECT = 400_000
_NINE_TENTHS = 1.6449  # nine tenths of a normal variable lie within this many deviations


def mark_outliers(hm: HeightMap, threshold: float = 6.0) -> HeightMap:
    """Turn spikes into missing points.

    Parameters
    ----------
    hm
        The map; missing points are left out of the judgement.
    threshold
        A point is a spike if its roughness (what a 5 x 5 median filter, applied twice, leaves)
        exceeds this many robust standard deviations (0.61 times the ninth decile of the roughness
        of the map); at least 3.

    Returns
    -------
    HeightMap
        History step ``outliers`` with the threshold [m] and the count.

    Notes
    -----
    Repeated until nothing more is found, at most five times, with spikes replaced by the medians:
    a spike wider than two points is taken from its rim inwards.
    """
    if not threshold >= 3.0:
        raise SurfaceError(f"outliers is {threshold}; use 3 or more robust standard deviations")
    present = np.isfinite(hm.heights)
    middle = float(np.median(hm.heights[present]))
    scale = float(np.max(np.abs(hm.heights[present] - middle))) or 1.0
    z = np.where(present, (hm.heights - middle) / scale, 0.0)
    if not present.all():
        z = _local_fill(z, present)
    spikes = np.zeros(hm.shape, dtype=bool)
    limit = 0.0
    for _ in range(5):
        median = _median(z, hm.periodic)
        rough = z - median
        rough -= _median(rough, hm.periodic)
        if limit == 0.0:
            sigma = float(np.quantile(np.abs(rough[present]), 0.9)) / _NINE_TENTHS
            limit = threshold * sigma + 1e-7
        found = present & ~spikes & (np.abs(rough) > limit)
        if not found.any():
            break
        spikes |= found
        z[found] = median[found]
    heights = np.where(spikes, np.nan, hm.heights)
    step = {
        "step": "outliers",
        "threshold": threshold,
        "limit": limit * scale,
        "count": int(np.count_nonzero(spikes)),
    }
    return hm.replace(heights=heights, step=step)


def fill_missing(hm: HeightMap, *, limit: float = 0.1) -> HeightMap:
    """Fill missing points with the harmonic surface through the points about them.

    Parameters
    ----------
    hm
        The map.
    limit
        Largest fraction of the points that may be filled.

    Returns
    -------
    HeightMap
        History step ``fill`` with the count, the fraction and the largest gap [pixels].

    Raises
    ------
    SurfaceError
        If more points are missing than the limit allows.

    Notes
    -----
    Solves Laplace's equation on the missing points (five-point stencil with the true pixel sizes;
    no flux across the border of a map that is not periodic). The filled heights lie between those
    around them: no summit is invented.
    """
    missing = np.isnan(hm.heights)
    count = int(np.count_nonzero(missing))
    fraction = count / missing.size
    if fraction > limit:
        raise SurfaceError(
            f"{count} of {missing.size} points are missing ({100 * fraction:.3g} %), more than the "
            f"fill limit of {100 * limit:.3g} %; crop the map or raise fill_limit (--fill-limit)"
        )
    step: dict[str, Any] = {
        "step": "fill",
        "method": "harmonic",
        "count": count,
        "fraction": fraction,
    }
    if count == 0:
        return hm.replace(step=step)
    gaps = cv2.connectedComponentsWithStats(missing.astype(np.uint8), connectivity=4)[2]
    step["largest_gap"] = int(gaps[1:, cv2.CC_STAT_AREA].max())
    heights = hm.heights.copy()
    direct = step["largest_gap"] <= _DIRECT
    heights[missing] = _harmonic(heights, missing, hm.spacing, hm.periodic, direct)
    return hm.replace(heights=heights, step=step)


def _median(z: NDArray[np.float64], periodic: bool) -> NDArray[np.float64]:
    """Median of the 5 x 5 points about each point; the map goes on evenly beyond its border."""
    padded = np.pad(z, 2, mode="wrap") if periodic else _extended(_extended(z).T).T
    blurred = cv2.medianBlur(padded.astype(np.float32), 5)
    return np.asarray(blurred[2:-2, 2:-2], dtype=np.float64)


def _extended(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Two rows more on either side, mirrored through the medians along the border rows."""
    first, last = (median_filter(row, 5, mode="nearest") for row in (z[0], z[-1]))
    return np.vstack([2.0 * first - z[2:0:-1], z, 2.0 * last - z[-2:-4:-1]])


def _harmonic(
    heights: NDArray[np.float64],
    missing: NDArray[np.bool_],
    spacing: tuple[float, float],
    periodic: bool,
    direct: bool,
) -> NDArray[np.float64]:
    """Solution of the discrete Laplace equation on the missing points, in scan order."""
    ny, nx = heights.shape
    rows, columns = np.nonzero(missing)
    count = len(rows)
    number = np.full(heights.shape, -1, dtype=np.int64)
    number[missing] = np.arange(count)
    middle = float(np.nanmedian(heights))
    total, right = np.zeros(count), np.zeros(count)
    pairs: list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]] = []
    ratio = spacing[1] / spacing[0]
    for dr, dc, weight in ((1, 0, ratio), (-1, 0, ratio), (0, 1, 1 / ratio), (0, -1, 1 / ratio)):
        r, c = rows + dr, columns + dc
        inside = (
            np.ones(count, dtype=bool) if periodic else (r >= 0) & (r < ny) & (c >= 0) & (c < nx)
        )
        r, c = r % ny, c % nx
        total[inside] += weight
        unknown = inside & missing[r, c]
        known = inside & ~missing[r, c]
        right[known] += weight * (heights[r[known], c[known]] - middle)
        pairs.append(
            (
                np.flatnonzero(unknown),
                number[r[unknown], c[unknown]],
                np.full(unknown.sum(), -weight),
            )
        )
    i, j, w = (np.concatenate(part) for part in zip(*pairs, strict=True))
    matrix = (coo_matrix((w, (i, j)), shape=(count, count)) + diags(total)).tocsc()
    if direct:
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0)
        return np.asarray(factors.solve(right) + middle)
    start = _local_fill(np.where(missing, 0.0, heights - middle), ~missing)[missing]
    jacobi = LinearOperator((count, count), matvec=lambda x: x / total)
    filled, status = cg(matrix.tocsr(), right, x0=start, rtol=1e-8, maxiter=4000, M=jacobi)
    if status != 0:
        raise SurfaceError(
            f"filling {count} missing points did not converge; crop the map to the measured part"
        )
    return np.asarray(filled + middle)


def _local_fill(z: NDArray[np.float64], present: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Quick fill by averages over ever coarser blocks: a start, and a stand-in for medians."""
    if present.all():
        return z
    ny, nx = z.shape
    even = ((0, ny % 2), (0, nx % 2))
    weight = np.pad(present.astype(np.float64), even)
    weighted = np.pad(np.where(present, z, 0.0), even)
    blocks = (weight.shape[0] // 2, 2, weight.shape[1] // 2, 2)
    count = weight.reshape(blocks).sum(axis=(1, 3))
    mean = weighted.reshape(blocks).sum(axis=(1, 3)) / np.maximum(count, 1.0)
    coarse = _local_fill(mean, count > 0)
    return np.where(present, z, np.kron(coarse, np.ones((2, 2)))[:ny, :nx])
