"""The certificate: how far a pressure is from solving the contact problem, in float64.

It is recomputed from the returned pressure alone with the exact operator; no quantity of the
iteration enters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Certificate", "certify", "height_scale"]


@dataclass(frozen=True)
class Certificate:
    """Relative errors of a contact solution; zero for the exact one.

    Attributes
    ----------
    load
        |mean pressure / prescribed - 1|, or with prescribed separation the error of the
        separation over the rms height [-].
    complementarity
        ``sum p (g - min g) / (sum p rms h)``: pressure times gap, which must vanish [-].
    penetration
        (mean gap over the contact - smallest gap) / rms h [-].
    """

    load: float
    complementarity: float
    penetration: float

    @property
    def worst(self) -> float:
        """Largest of the three; NaN counts as infinite."""
        values = (self.load, self.complementarity, self.penetration)
        return float("inf") if any(v != v for v in values) else max(values)


def height_scale(rms_height: float, largest_displacement: float) -> float:
    """Length that the certificate is relative to [m].

    The rms height; for a map flat to within rounding of the displacement, a millionth of the
    largest displacement, below which float64 cannot resolve the gap.
    """
    return max(rms_height, 1e-6 * largest_displacement, np.finfo(float).tiny)


def certify(
    pressure: NDArray[np.float64],
    displacement: NDArray[np.float64],
    heights: NDArray[np.float64],
    rms_height: float,
    *,
    mean_pressure: float | None = None,
    offset: float | None = None,
) -> tuple[Certificate, float, float]:
    """Certificate of a pressure, mean of u - h over its contact [m], and the length of scale [m].

    Parameters
    ----------
    pressure
        Pressure in any unit, shape (ny, nx), non-negative.
    displacement
        Displacement of that pressure by the exact operator [m], shape (ny, nx).
    heights
        Heights out of the solid [m], shape (ny, nx).
    rms_height
        Root-mean-square height [m].
    mean_pressure
        Prescribed mean pressure, in the unit of `pressure`; or
    offset
        prescribed value of u - h in the contact [m].
    """
    gap = displacement - heights
    contact = pressure > 0.0
    lowest = float(gap.min())
    scale = height_scale(rms_height, float(np.abs(displacement).max()))
    if not contact.any():
        missing = 0.0 if not mean_pressure else 1.0
        below = 0.0 if offset is None else max(0.0, offset - lowest) / scale
        return Certificate(missing, 0.0, below), lowest if offset is None else offset, scale
    total = float(pressure.sum())
    level = float(gap[contact].mean())
    work = float(np.vdot(pressure, gap)) / total - lowest
    if offset is not None:
        load = abs(level - offset) / scale
    else:
        load = abs(float(pressure.mean()) / mean_pressure - 1.0) if mean_pressure else np.inf
    return Certificate(load, max(work, 0.0) / scale, (level - lowest) / scale), level, scale
