"""What is known of the summits of all peaks of a map before any ray is sampled."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from surfaces.heightmap import HeightMap

from .peaks import Peaks

__all__ = ["PLATEAU", "RIM", "SUMMIT", "SummitArrays"]

SUMMIT, PLATEAU, RIM = 0, -1, -2
"""Kinds of summits: a maximum of the surface, none within reach, none at the border of the map."""

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SummitArrays:
    """Summits of n peaks, one row of every array per peak.

    Attributes
    ----------
    x, y, height, curvature, angle, pixels, border, valid, owner
        As in `Profiles`.
    peaks
        The peaks.
    hm
        The map that was segmented.
    spline
        Coefficients of the spline through the map.
    places
        Row and column of the summits [pixels], shape (n, 2).
    kinds
        How each was found: `SUMMIT`, `RIM` or `PLATEAU`, or one more than the peak into whose basin
        the surface rises, shape (n,).
    floor
        Height [m] above which the basin of summits that were joined hangs together, shape (n,).
    tilt
        By how much the surface about each is taken to fall along y and x [m per pixel], (n, 2).
    dip
        How far f may fall along a ray before the ray ends [m], shape (n,).
    single
        Owners before any were joined, shape (n,).
    """

    x: Array
    y: Array
    height: Array
    curvature: Array
    angle: Array
    pixels: NDArray[np.int64]
    border: NDArray[np.bool_]
    valid: NDArray[np.bool_]
    owner: NDArray[np.int64]
    peaks: Peaks = field(repr=False)
    hm: HeightMap = field(repr=False)
    spline: Array = field(repr=False)
    places: Array = field(repr=False)
    kinds: NDArray[np.int64] = field(repr=False)
    floor: Array = field(repr=False)
    tilt: Array = field(repr=False)
    dip: Array = field(repr=False)
    single: NDArray[np.int64] = field(repr=False)

    def __len__(self) -> int:
        return int(self.x.size)
