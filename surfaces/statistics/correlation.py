"""Autocorrelation of a map, and what it says about its texture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from surfaces.arrays import Array, Index
from surfaces.errors import require_kind
from surfaces.heightmap import HeightMap, require_map
from surfaces.numerics import parallel
from surfaces.numerics.memory import Transform, along_both
from surfaces.numerics.stored_array import Blocks, Source, array_of, blocks_of, windows

from .heights import some_roughness

__all__ = ["THRESHOLD", "Autocorrelation", "Texture", "autocorrelation", "texture"]


THRESHOLD = 0.2
"""Correlation at which Sal and Str are read (ISO 25178-2)."""

_ANGLES = 180
"""Directions in which the correlation length is read."""

_TIED = 1e-9
"""Relative difference of directions that are equal but for rounding: the first is the lay."""


@dataclass(frozen=True, eq=False)
class Autocorrelation:
    """Correlation of the heights with themselves, shifted.

    Attributes
    ----------
    lag_y, lag_x
        Shifts [m], shape (my,), (mx,), zero in the middle.
    value
        Correlation, 1 without shift [-], shape (my, mx); NaN at shifts for which no pair of points
        is present; stays on disk if the map does.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> correlation = surfaces.autocorrelation(hm)
    >>> float(abs(correlation.lag_x).min())
    0.0
    """

    lag_y: Array
    lag_x: Array
    value: Source

    @property
    def size(self) -> tuple[float, float]:
        """Lengths (Ly, Lx) [m] of the shifts, each of which is shown as a pixel."""
        (my, mx), lag_y, lag_x = self.value.shape, self.lag_y, self.lag_x
        return float(my * (lag_y[1] - lag_y[0])), float(mx * (lag_x[1] - lag_x[0]))


@dataclass(frozen=True)
class Texture:
    """Spatial parameters of ISO 25178-2.

    Attributes
    ----------
    shortest
        Autocorrelation length Sal: the shortest shift that lowers the correlation to
        `THRESHOLD` [m].
    longest
        The longest such shift [m]; where the correlation stays above within half the map, the
        longest shift there, and then `bounded` is True.
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
    found = some_roughness(hm)
    mean, variance = found.mean, found.rms_height**2
    shape = hm.shape if hm.periodic else tuple(fft.next_fast_len(2 * n, True) for n in hm.shape)
    lags = tuple(np.arange(-(n // 2), n // 2 + 1) for n in hm.shape)
    products = _correlated(hm, lambda z: np.where(np.isfinite(z), z - mean, 0.0), shape, lags)
    pairs: Source | None = None
    if hm.missing:
        pairs = _correlated(hm, lambda z: np.isfinite(z).astype(np.float64), shape, lags)
    pairs_y, pairs_x = (
        np.full(lag.size, float(n)) if hm.periodic else n - np.abs(lag)
        for n, lag in zip(hm.shape, lags, strict=True)
    )

    def values() -> Blocks:
        for begin, end, rows in windows(products):
            if pairs is None:
                number = np.outer(pairs_y[begin:end], pairs_x)
            else:
                counted = pairs[begin:end]  # whole numbers, but for rounding
                number = np.where(counted > 0.5, counted, np.nan)
            yield begin, rows / (number * variance)

    dy, dx = hm.spacing
    value = array_of(values(), products.shape, products)
    return Autocorrelation(lags[0].astype(np.float64) * dy, lags[1].astype(np.float64) * dx, value)


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
    require_kind(correlation, Autocorrelation, "surfaces.autocorrelation(hm)")
    lag_y, lag_x, value = correlation.lag_y, correlation.lag_x, correlation.value
    dy, dx = lag_y[1] - lag_y[0], lag_x[1] - lag_x[0]
    angles = np.arange(_ANGLES) * np.pi / _ANGLES
    with np.errstate(divide="ignore"):  # each direction reaches to the border of half the map
        reach = np.minimum(lag_y[-1] / np.sin(angles), lag_x[-1] / np.abs(np.cos(angles)))
    end_y, end_x = np.sin(angles) * reach, np.cos(angles) * reach
    pixels = float(np.hypot(end_y / dy, end_x / dx).max())
    steps = np.linspace(0.0, 1.0, 1 + round(2.0 * pixels))
    rows = (np.outer(end_y, steps) - lag_y[0]) / dy
    columns = (np.outer(end_x, steps) - lag_x[0]) / dx
    along = _read_at(value, rows.ravel(), columns.ravel()).reshape(rows.shape)
    for ray in along:  # across shifts without pairs; the correlation without shift is known
        known = np.isfinite(ray)
        ray[:] = np.interp(steps, steps[known], ray[known])
    below = along <= THRESHOLD
    crossed = below.any(axis=1)
    first = np.maximum(below.argmax(axis=1), 1)
    every = np.arange(_ANGLES)
    before, after = along[every, first - 1], along[every, first]
    part = (before - THRESHOLD) / np.where(before > after, before - after, 1.0)
    lengths = np.where(crossed, (first - 1 + part) * steps[1], 1.0) * reach
    bounded = not bool(crossed.all())
    # of directions that are not seen to end, the lay is that of the highest correlation
    far = np.where(crossed, -1.0, along.mean(axis=1)) if bounded else lengths
    direction = int(np.argmax(far >= far.max() - _TIED * abs(far.max())))
    shortest = lengths[crossed].min() if crossed.any() else lengths.max()
    return Texture(
        shortest=float(shortest),
        longest=float(lengths.max()),
        aspect=float(shortest / lengths.max()),
        direction=float(angles[direction]),
        bounded=bounded,
    )


def _read_at(value: Source, rows: Array, columns: Array) -> Array:
    """Linear interpolation at points of an array, in units of its elements, between those that are
    known; NaN where none is."""
    from scipy.ndimage import map_coordinates

    order = np.argsort(rows, kind="stable")
    found = np.empty(rows.size)
    for begin, end, window in windows(value, below=1):
        here = order[slice(*np.searchsorted(rows, (begin, end), sorter=order))]
        places = [rows[here] - begin, columns[here]]
        known = np.isfinite(window)
        found[here] = map_coordinates(np.where(known, window, 0.0), places, order=1, mode="nearest")
        if not known.all():
            weight = map_coordinates(known.astype(float), places, order=1, mode="nearest")
            found[here] /= np.where(weight > 1e-9, weight, np.nan)
    return found


def _correlated(
    hm: HeightMap, change: Callable[[Array], Array], shape: tuple[int, ...], lags: tuple[Index, ...]
) -> Source:
    """Sum of the products of the heights, changed and padded to `shape`, with themselves at these
    lags, an array like the heights."""
    workers = parallel.threads()

    def products(_: slice, modes: NDArray[Any]) -> NDArray[Any]:
        modes = fft.fft(modes, shape[0], axis=0, workers=workers)
        power = np.square(modes.real) + np.square(modes.imag)
        return np.asarray(fft.ifft(power, axis=0, workers=workers)[lags[0] % shape[0]])

    correlation = Transform(
        shape[1] // 2 + 1,
        lambda rows: fft.rfft(change(rows), shape[1], workers=workers),
        products,
        lambda modes: fft.irfft(modes, shape[1], workers=workers)[:, lags[1] % shape[1]],
        tallest=shape[0],
    )
    return along_both(blocks_of(hm.source), hm.source, (lags[0].size, lags[1].size), correlation)
