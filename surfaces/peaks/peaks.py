"""The peaks of a map: summits, basins, saddles, prominences and neighbors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Peaks"]


@dataclass(frozen=True, eq=False)
class Peaks:
    """Peaks of a height map in descending height, one row of every array per peak.

    Parameters
    ----------
    row, col
        Pixel of the summit, shape (n,). Of a plateau: the member nearest to its centroid.
    x, y
        Center of that pixel [m], shape (n,).
    height
        Height of the summit pixel [m], shape (n,).
    prominence
        Height of the summit above its saddle [m], shape (n,), positive.
    saddle
        Height [m] of the highest pass to a higher peak, shape (n,); of a peak without one, the
        lowest height flooded.
    parent
        Highest peak on the other side of that pass, shape (n,); -1 where there is none.
    basin_area
        Area [m^2] of the basin, shape (n,).
    border
        True where the basin touches the border of a map that is not periodic, shape (n,).
    labels
        Peak whose basin holds the pixel, shape (ny, nx); -1 where not flooded.
    neighbors
        Pairs of peaks whose basins touch, shape (k, 2), the higher peak first.
    passes
        Height [m] of the highest pass between each pair, shape (k,).
    min_prominence
        Limit of pruning [m] that was applied.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine(
    ...     (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6
    ... )
    >>> peaks = surfaces.segment(hm, min_prominence=0.1 * hm.rms_height)
    >>> len(peaks) == int(peaks.labels.max()) + 1
    True
    """

    row: NDArray[np.int64]
    col: NDArray[np.int64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    height: NDArray[np.float64]
    prominence: NDArray[np.float64]
    saddle: NDArray[np.float64]
    parent: NDArray[np.int64]
    basin_area: NDArray[np.float64]
    border: NDArray[np.bool_]
    labels: NDArray[np.int32]
    neighbors: NDArray[np.int64]
    passes: NDArray[np.float64]
    min_prominence: float = 0.0

    def __len__(self) -> int:
        return int(self.height.size)

    def __repr__(self) -> str:
        if not len(self):
            return "<Peaks: none>"
        return (
            f"<Peaks: {len(self)}, heights {self.height[-1]:.4g} .. {self.height[0]:.4g} m, "
            f"{int(self.border.sum())} at the border>"
        )
