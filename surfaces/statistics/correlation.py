"""Autocorrelation of a map, and what it says about its texture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from surfaces.errors import SurfaceError
from surfaces.heightmap import HeightMap, require_map

__all__ = ["THRESHOLD", "Autocorrelation", "Texture", "autocorrelation", "texture"]

THRESHOLD = 0.2
"""Correlation at which Sal and Str are read (ISO 25178-2)."""

_ANGLES = 180
"""Directions in which the correlation length is read."""


@dataclass(frozen=True, eq=False)
class Autocorrelation:
    """Correlation of the heights with themselves, shifted.

    Attributes
    ----------
    lag_y, lag_x
        Shifts [m], shape (my,), (mx,), zero in the middle.
    value
        Correlation, 1 without shift [-], shape (my, mx).

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> correlation = surfaces.autocorrelation(hm)
    >>> float(abs(correlation.lag_x).min())
    0.0
    """

    lag_y: NDArray[np.float64]
    lag_x: NDArray[np.float64]
    value: NDArray[np.float64]


@dataclass(frozen=True)
class Texture:
    """Spatial parameters of ISO 25178-2.

    Attributes
    ----------
    shortest
        Autocorrelation length Sal: the shortest shift that lowers the correlation to
        `THRESHOLD` [m].
    longest
        The longest such shift [m]; of a correlation that stays above within half the map, that
        half, and then `bounded` is True.
    aspect
        Texture aspect ratio Str, shortest over longest: near 1 isotropic, near 0 a lay [-].
    direction
        Direction of the longest shift, the lay [rad], ccw from +x to +y, in 0 to pi.
    bounded
        True if the map is too small to show where the correlation falls off along the lay.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> found = surfaces.texture(surfaces.autocorrelation(hm))
    >>> 0.0 < found.aspect <= 1.0
    True
    """

    shortest: float
    longest: float
    aspect: float
    direction: float
    bounded: bool


def autocorrelation(hm: HeightMap) -> Autocorrelation:
    """Autocorrelation for shifts up to half the map; missing points are left out of the means.

    Parameters
    ----------
    hm
        The map, levelled.

    Raises
    ------
    SurfaceError
        If the map is constant.

    Notes
    -----
    The mean product of all pairs of points present at each shift, over the variance: around the
    seam for a periodic map, without it (and unbiased) for one that is not.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> correlation = surfaces.autocorrelation(hm)
    >>> correlation.value.shape, f"{correlation.value.max():.2f}"
    ((33, 49), '1.00')
    """
    require_map(hm)
    present = np.isfinite(hm.heights)
    z = np.where(present, hm.heights - np.nanmean(hm.heights), 0.0)
    variance = float(np.sum(z * z)) / np.count_nonzero(present)
    if variance == 0.0:
        raise SurfaceError("the map is constant; it has no autocorrelation")
    shape = hm.shape if hm.periodic else tuple(fft.next_fast_len(2 * n, True) for n in hm.shape)
    products = _correlated(z, shape)
    half_y, half_x = hm.shape[0] // 2, hm.shape[1] // 2
    rows, columns = np.arange(-half_y, half_y + 1), np.arange(-half_x, half_x + 1)
    lag_y, lag_x = rows.astype(np.float64), columns.astype(np.float64)
    inside = np.ix_(rows % shape[0], columns % shape[1])
    if not present.all():
        pairs = np.maximum(_correlated(present.astype(np.float64), shape)[inside], 1.0)
    elif hm.periodic:
        pairs = np.array(float(present.size))
    else:
        pairs = np.outer(hm.shape[0] - np.abs(rows), hm.shape[1] - np.abs(columns))
    value = products[inside] / pairs / variance
    return Autocorrelation(lag_y * hm.spacing[0], lag_x * hm.spacing[1], value)


def texture(correlation: Autocorrelation) -> Texture:
    """Shortest and longest shift at which the correlation first falls to `THRESHOLD`.

    Examples
    --------
    >>> import surfaces
    >>> ground = surfaces.ground((32, 48), (32e-6, 48e-6), rms_slope=0.1, cutoff=8e-6)
    >>> found = surfaces.texture(surfaces.autocorrelation(ground))
    >>> found.shortest < found.longest
    True
    """
    from scipy.ndimage import map_coordinates

    lag_y, lag_x, value = correlation.lag_y, correlation.lag_x, correlation.value
    dy, dx = lag_y[1] - lag_y[0], lag_x[1] - lag_x[0]
    reach = min(lag_y[-1], lag_x[-1])
    steps = np.arange(0.0, reach, 0.5 * min(dy, dx))
    angles = np.arange(_ANGLES) * np.pi / _ANGLES
    rows = (np.outer(np.sin(angles), steps) - lag_y[0]) / dy
    columns = (np.outer(np.cos(angles), steps) - lag_x[0]) / dx
    along = map_coordinates(value, [rows, columns], order=1, mode="nearest")
    below = along <= THRESHOLD
    crossed = below.any(axis=1)
    first = np.maximum(below.argmax(axis=1), 1)
    ray = np.arange(_ANGLES)
    before, after = along[ray, first - 1], along[ray, first]
    part = (before - THRESHOLD) / np.where(before > after, before - after, 1.0)
    lengths = np.where(crossed, (first - 1 + part) * steps[1], reach)
    longest = max(range(_ANGLES), key=lambda index: (lengths[index], along[index].mean()))
    return Texture(
        shortest=float(lengths.min()),
        longest=float(lengths[longest]),
        aspect=float(lengths.min() / lengths[longest]),
        direction=float(angles[longest]),
        bounded=not bool(crossed.all()),
    )


def _correlated(z: NDArray[np.float64], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Sum of the products of `z` with itself at every shift, padded to `shape`."""
    modes = fft.rfft2(z, s=shape)
    power = np.square(modes.real) + np.square(modes.imag)
    return np.asarray(fft.irfft2(power, s=shape))
