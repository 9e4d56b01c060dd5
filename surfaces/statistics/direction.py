"""Texture direction of a map, from its spectral density."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .density import Density, over_rows, wave_numbers

__all__ = ["texture_direction"]

Array = NDArray[np.float64]


def texture_direction(waves: Density) -> float:
    """Texture direction Std [rad], 0 to pi: where the angular amplitude spectrum is largest.

    Notes
    -----
    ISO 25178-2:2021, 4.3: amplitudes of all waves up to the largest full ring, summed over sectors
    of one degree; the mean direction in the largest. It is that of the wave vectors, ccw from +x
    to +y, across the lay; NaN of a plane.
    """

    def sectors(part: slice, density: Array) -> Array:
        qy, qx = wave_numbers(waves, part)
        q, angle = np.hypot(qy[:, None], qx), np.arctan2(qy[:, None], qx) % np.pi
        amplitude = np.sqrt(density) * (q <= np.pi / max(waves.source.spacing))
        amplitude *= np.where(qx == 0.0, 0.5, 1.0)  # holds both of two opposite waves
        amplitude[q == 0.0] = 0.0
        sector = np.round(np.degrees(angle)).astype(np.int64)
        angle -= np.radians(sector)
        values = amplitude, amplitude * angle
        return np.stack([np.bincount(sector.ravel() % 180, v.ravel(), 180) for v in values])

    total, moment = sum(over_rows(sectors, waves), np.zeros((2, 180)))
    most = int(np.argmax(total))
    if total[most] == 0.0:
        return np.nan
    return float((np.radians(most) + moment[most] / total[most]) % np.pi)
