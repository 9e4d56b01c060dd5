"""What some lines of a map tell of all of it: power of its waves, repeated heights."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics import parallel

__all__ = ["has_repeated_heights", "line_power"]

LINES = 64
"""Rows, and columns, that suffice."""


def line_power(
    heights: NDArray[np.float64], periodic: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean square of the waves along y and x in some lines of a map.

    Parameters
    ----------
    heights
        Heights without missing points [m], shape (ny, nx).
    periodic
        Whether the map continues across its border as if repeated.

    Returns
    -------
    y, x
        Mean squares [m^2] along each axis. The k-th wave has k periods over the length of the map;
        k / 2 in a map that is not periodic, which is continued by its mirror images.
    """
    from scipy import fft

    def along(axis: int) -> NDArray[np.float64]:
        count = heights.shape[axis]
        stride = max(1, heights.shape[1 - axis] // LINES)
        lines = heights[::stride] if axis else np.ascontiguousarray(heights[:, ::stride].T)
        if periodic:
            waves = fft.rfft(lines, axis=1)
            squares = np.square(waves.real) + np.square(waves.imag)
        else:
            squares = np.square(0.5 * fft.dct(lines, axis=1))
        power: NDArray[np.float64] = squares.mean(axis=0) * (2.0 / count**2)
        power[0] *= 0.5
        if periodic and count % 2 == 0:
            power[-1] *= 0.5
        return power

    y, x = parallel.each(along, (0, 1))
    return y, x


def has_repeated_heights(heights: NDArray[np.float64]) -> bool:
    """Whether neighbors have the same height, as far as some lines tell."""
    step = max(1, len(heights) // LINES)
    lines, below = heights[:-1:step], heights[1::step]
    return bool((lines[:, 1:] == lines[:, :-1]).any() or (lines == below).any())
