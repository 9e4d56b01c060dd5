"""Fill missing points with the harmonic surface through the points about them."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import LinearOperator, cg, splu

from surfaces.errors import SurfaceError, as_number
from surfaces.heightmap import HeightMap, require_map

__all__ = ["fill_missing", "quick_fill"]

_DIRECT = 400_000
"""Largest gap [pixels] that is solved directly, not by conjugate gradients."""


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

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> y, x = np.mgrid[:32, :48]
    >>> heights = 1e-9 * (x + y)
    >>> heights[10, 10] = np.nan
    >>> surfaces.fill_missing(surfaces.HeightMap(heights, 1e-6)).missing
    0
    """
    require_map(hm)
    missing = np.isnan(hm.heights)
    count = int(np.count_nonzero(missing))
    fraction = count / missing.size
    if fraction > as_number("limit", limit):
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
    start = quick_fill(np.where(missing, 0.0, heights - middle), ~missing)[missing]
    jacobi = LinearOperator((count, count), matvec=lambda x: x / total)
    filled, status = cg(matrix.tocsr(), right, x0=start, rtol=1e-8, maxiter=4000, M=jacobi)
    if status != 0:
        raise SurfaceError(
            f"filling {count} missing points did not converge; crop the map to the measured part"
        )
    return np.asarray(filled + middle)


def quick_fill(z: NDArray[np.float64], present: NDArray[np.bool_]) -> NDArray[np.float64]:
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
    coarse = quick_fill(mean, count > 0)
    return np.where(present, z, np.kron(coarse, np.ones((2, 2)))[:ny, :nx])
