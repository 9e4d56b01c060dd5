"""Bearing curve (areal material ratio) and the functional parameters read from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surfaces.heightmap import HeightMap, require_map

__all__ = ["BearingCurve", "bearing_curve"]

_CORE = 0.4
"""Share of the curve to which the line of the core is fitted (ISO 25178-2)."""

_RATIOS = 2001
"""Points of the curve."""


@dataclass(frozen=True, eq=False)
class BearingCurve:
    """Material ratio against height.

    Attributes
    ----------
    ratio
        Fraction of the points present at or above the height [-], 0 to 1, evenly spaced.
    height
        Height above the mean [m], falling.

    Examples
    --------
    >>> import numpy as np
    >>> import surfaces
    >>> hm = surfaces.HeightMap(np.tile(np.arange(10.0), (5, 1)), 1.0)
    >>> curve = surfaces.bearing_curve(hm)
    >>> curve.ratio.shape == curve.height.shape
    True
    """

    ratio: NDArray[np.float64]
    height: NDArray[np.float64]

    def ratio_at(self, height: float) -> float:
        """Fraction of the surface above a height over the mean [m]."""
        return float(np.interp(-height, -self.height, self.ratio))

    def height_at(self, ratio: float) -> float:
        """Height over the mean [m] that a fraction of the surface exceeds."""
        return float(np.interp(ratio, self.ratio, self.height))

    def core(self) -> dict[str, float]:
        """Core height Sk, reduced peak and dale heights Spk, Svk [m] and their ratios Smr1, Smr2.

        Notes
        -----
        ISO 25178-2: the line is fitted to the 40 % of the curve where it is flattest; Spk and Svk
        are the heights of triangles of the area that the curve encloses above and below the core.
        """
        span = round(_CORE * (len(self.ratio) - 1))
        start = int(np.argmin(self.height[:-span] - self.height[span:]))
        part = slice(start, start + span + 1)
        slope, level = np.polyfit(self.ratio[part], self.height[part], 1)
        top, bottom = float(level), float(level + slope)
        smr1, smr2 = self.ratio_at(top), self.ratio_at(bottom)
        hills = self._mean(np.maximum(self.height - top, 0.0))
        dales = self._mean(np.maximum(bottom - self.height, 0.0))
        return {
            "Sk": top - bottom,
            "Spk": 2.0 * hills / smr1 if smr1 > 0.0 else 0.0,
            "Svk": 2.0 * dales / (1.0 - smr2) if smr2 < 1.0 else 0.0,
            "Smr1": smr1,
            "Smr2": smr2,
        }

    def volumes(self) -> dict[str, float]:
        """Material volumes Vmp, Vmc and void volumes Vvc, Vvv per area [m], at 10 % and 80 %."""
        z10, z80 = self.height_at(0.1), self.height_at(0.8)
        material = [self._mean(np.maximum(self.height - z, 0.0)) for z in (z10, z80)]
        void = [self._mean(np.maximum(z - self.height, 0.0)) for z in (z10, z80)]
        return {
            "Vmp": material[0],
            "Vmc": material[1] - material[0],
            "Vvc": void[0] - void[1],
            "Vvv": void[1],
        }

    def _mean(self, values: NDArray[np.float64]) -> float:
        from scipy.integrate import trapezoid

        return float(trapezoid(values, self.ratio))


def bearing_curve(hm: HeightMap) -> BearingCurve:
    """Bearing curve of the points present of a levelled map.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> curve = surfaces.bearing_curve(hm)
    >>> bool(curve.height[0] > curve.height[-1])
    True
    """
    require_map(hm)
    present = np.sort(hm.heights[np.isfinite(hm.heights)])
    ratio = np.linspace(0.0, 1.0, _RATIOS)
    place = (np.arange(present.size) + 0.5) / present.size
    height = np.interp(1.0 - ratio, place, present) - present.mean()
    height[0], height[-1] = present[-1] - present.mean(), present[0] - present.mean()
    return BearingCurve(ratio, height)
