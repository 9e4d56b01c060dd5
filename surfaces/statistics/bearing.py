"""Bearing curve (areal material ratio) and the functional parameters read from it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.arrays import Array, Index
from surfaces.errors import InputError, as_number
from surfaces.heightmap import HeightMap, require_map

from .heights import over_present, some_roughness

__all__ = ["BearingCurve", "bearing_curve"]

_CORE = 0.4
"""Share of the curve to which the line of the core is fitted (ISO 25178-2)."""

_TIED = 1e-9
"""Difference of falls of the curve, over its whole, that are equal but for rounding."""

_PEAKS, _DALES = 0.1, 0.8
"""Material ratios between peaks and core, and core and dales, of volumes (ISO 25178-3)."""

_RATIOS = 2001
"""Points of the curve."""

_LEVELS = 2**20
"""Levels in which the points of a map on disk are counted."""


@dataclass(frozen=True, eq=False)
class BearingCurve:
    """Material ratio against height.

    Attributes
    ----------
    ratio
        Fraction of the points present at or above the height [-], 0 to 1, evenly spaced.
    height
        Height above the mean [m], falling.
    points
        Heights of all points present above the mean [m], rising; of a map on disk, mean heights of
        those in each of 2^20 levels.
    counts
        Number of points that each of them stands for; None is one.

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> hm = surfaces.HeightMap(np.tile(np.arange(10.0), (5, 1)), 1.0)
    >>> curve = surfaces.bearing_curve(hm)
    >>> curve.ratio.shape == curve.height.shape
    True
    """

    ratio: Array
    height: Array
    points: Array = field(repr=False)
    counts: Index | None = field(default=None, repr=False)

    def ratio_at(self, height: float) -> float:
        """Fraction of the surface above a height over the mean [m]."""
        return float(np.interp(-as_number("height", height), -self.height, self.ratio))

    def height_at(self, ratio: float) -> float:
        """Height over the mean [m] that a fraction of the surface exceeds.

        Raises
        ------
        InputError
            If the fraction is not between 0 and 1.
        """
        if not 0.0 <= as_number("ratio", ratio) <= 1.0:
            raise InputError(f"ratio is {ratio}; it must be a fraction from 0 to 1")
        return float(np.interp(ratio, self.ratio, self.height))

    def core(self) -> dict[str, float]:
        """Core height Sk, reduced peak and dale heights Spk, Svk [m] and their ratios Smr1, Smr2.

        Notes
        -----
        ISO 25178-2:2021, 4.5 and annex B: the line is fitted to the 40 % of the curve where it is
        flattest; Spk and Svk are the heights of triangles of the area that the curve encloses above
        and below the core.
        """
        span = round(_CORE * (len(self.ratio) - 1))
        fall = self.height[:-span] - self.height[span:]
        # the first of equal ones, as rounding of another unit must not choose
        tied = fall.min() + _TIED * (self.height[0] - self.height[-1])
        start = int(np.argmax(fall <= tied))
        part = slice(start, start + span + 1)
        weight = np.ones(span + 1)
        weight[[0, -1]] = np.sqrt(0.5)  # as in an integral: ends count half
        middle = self.height[start + span // 2]  # a core of one height is fitted without rounding
        slope, level = np.polyfit(self.ratio[part], self.height[part] - middle, 1, w=weight)
        top, bottom = float(middle + level), float(middle + level + slope)
        smr1 = float(np.interp(top, self.height[::-1], self.ratio[::-1]))  # none of what is level
        smr2 = self.ratio_at(bottom)
        hills, dales = self._above(top), self._below(bottom)
        return {
            "Sk": top - bottom,
            "Spk": 2.0 * hills / smr1 if smr1 > 0.0 else 0.0,
            "Svk": 2.0 * dales / (1.0 - smr2) if smr2 < 1.0 else 0.0,
            "Smr1": smr1,
            "Smr2": smr2,
        }

    def heights(self) -> dict[str, float]:
        """Material ratio Smr at the mean plane, Smc of 10 % and Sxp, 2.5 % to 50 % [m].

        Notes
        -----
        ISO 25178-2:2021, 4.5; the ratios of Sxp are those of ISO 25178-3. `ratio_at` and
        `height_at` give Smr and Smc of other heights and ratios.
        """
        return {
            "Smr": self.ratio_at(0.0),
            "Smc": self.height_at(_PEAKS),
            "Sxp": self.height_at(0.025) - self.height_at(0.5),
        }

    def material_volume(self, ratio: float) -> float:
        """Volume of material Vm above the height of a material ratio, per area [m]."""
        return self._above(self.height_at(ratio))

    def void_volume(self, ratio: float) -> float:
        """Volume of void Vv below the height of a material ratio, per area [m]."""
        return self._below(self.height_at(ratio))

    def volumes(self) -> dict[str, float]:
        """Vm and Vv at 10 %, and the volumes of peaks, core and dales, at 10 % and 80 % [m].

        Notes
        -----
        ISO 25178-2:2021, 4.5: Vmp = Vm(10 %), Vmc = Vm(80 %) - Vm(10 %), Vvc = Vv(10 %) - Vv(80 %),
        Vvv = Vv(80 %).
        """
        material = [self.material_volume(ratio) for ratio in (_PEAKS, _DALES)]
        void = [self.void_volume(ratio) for ratio in (_PEAKS, _DALES)]
        return {
            "Vm": material[0],
            "Vv": void[0],
            "Vmp": material[0],
            "Vmc": material[1] - material[0],
            "Vvc": void[0] - void[1],
            "Vvv": void[1],
        }

    def _above(self, height: float) -> float:
        return float(np.average(np.maximum(self.points - height, 0.0), weights=self.counts))

    def _below(self, height: float) -> float:
        return float(np.average(np.maximum(height - self.points, 0.0), weights=self.counts))


def bearing_curve(hm: HeightMap) -> BearingCurve:
    """Bearing curve of the points present of a levelled map.

    Parameters
    ----------
    hm
        The map; one on disk is read three times by blocks. The curve is the same.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> curve = surfaces.bearing_curve(hm)
    >>> bool(curve.height[0] > curve.height[-1])
    True
    """
    require_map(hm)
    if not isinstance(hm.source, np.ndarray):
        return _counted(hm)
    points = np.sort(hm.heights[np.isfinite(hm.heights)])
    points -= points.mean()
    ratio = np.linspace(0.0, 1.0, _RATIOS)
    place = (np.arange(points.size) + 0.5) / points.size
    height = np.interp(1.0 - ratio, place, points)
    height[0], height[-1] = points[-1], points[0]
    return BearingCurve(ratio, height, points)


def _counted(hm: HeightMap) -> BearingCurve:
    """Bearing curve by counting: first how many points each level holds, then the points in order
    in those levels where the curve is read."""
    found, points = some_roughness(hm), hm.source.size - hm.missing
    per_height = _LEVELS / (found.highest - found.lowest)

    def level(z: Array) -> Index:
        return np.minimum(((z - found.lowest) * per_height).astype(np.int64), _LEVELS - 1)

    def counted(z: Array) -> tuple[NDArray[Any], NDArray[Any]]:
        levels = level(z)
        return (
            np.bincount(levels, minlength=_LEVELS),
            np.bincount(levels, z - found.mean, _LEVELS),
        )

    counts, sums = np.zeros(_LEVELS, np.int64), np.zeros(_LEVELS)
    for more, part in over_present(counted, hm):
        counts += more
        sums += part
    ratio = np.linspace(0.0, 1.0, _RATIOS)
    rank = np.clip((1.0 - ratio) * points - 0.5, 0.0, points - 1.0)
    lower = rank.astype(np.int64)
    ranks = np.stack([lower, np.minimum(lower + 1, points - 1)])
    of_rank = np.searchsorted(np.cumsum(counts), ranks, side="right")
    read = np.zeros(_LEVELS, np.bool_)
    read[of_rank] = True

    def held_in(z: Array) -> tuple[NDArray[Any], NDArray[Any]]:
        values, times = np.unique(z[read[level(z)]], return_counts=True)
        return values, times

    values, times = (np.concatenate(v) for v in zip(*over_present(held_in, hm), strict=True))
    held, back = np.unique(values, return_inverse=True)
    number = np.bincount(back, times).astype(np.int64)
    skipped = np.cumsum(np.where(read, 0, counts))
    low, high = held[np.searchsorted(np.cumsum(number), ranks - skipped[of_rank], side="right")]
    height = low - found.mean + (rank - lower) * (high - low)
    height[0], height[-1] = found.highest - found.mean, found.lowest - found.mean
    some = counts > 0
    return BearingCurve(ratio, height, sums[some] / counts[some], counts[some])
