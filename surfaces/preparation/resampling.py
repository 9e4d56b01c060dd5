"""Maps on other grids: Fourier interpolation, and the coarsest grid that holds a smooth map."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from surfaces.arrays import Array, Index
from surfaces.errors import SurfaceError, checked_spacing
from surfaces.heightmap import HeightMap, require_full
from surfaces.numerics import parallel, splines
from surfaces.numerics.memory import Transform, along_both, require_memory
from surfaces.numerics.stored_array import Source, blocks_of
from surfaces.roughness import ROW_BANDS

__all__ = [
    "Resampled",
    "block_means",
    "coarse_map",
    "corner_of",
    "resample",
    "resample_waves",
    "shortest_wave",
]

_POINTS_PER_WAVE = 8.0
"""Points per shortest wave of a coarser grid: it changes the contact curve no more than a shift of
the full grid by half a pixel."""

_SLOPE_LOST = 2e-3
"""Share of the slope variance that waves shorter than the shortest one may carry."""

_SMOOTH = 2.0
"""Least length over which the slope turns [pixels] of a map that a coarser grid can hold."""

_WORTH_IT = 0.75
"""Largest ratio of the points per axis of a coarser grid that is worth its use."""

_LEAST_SIDE_POINTS = 64
"""Least number of points along the shorter side of a coarser grid."""

_ROWS = 32
"""Rows transformed at a time."""

_RMS_MISSED, _MOST_MISSED = 5e-4, 5e-3
"""Largest rms and largest single deviation of a coarser grid at the highest points of the blocks of
a map, over the rms height."""


def resample(hm: HeightMap, spacing: ArrayLike) -> HeightMap:
    """Move the map to other pixel sizes by its spectrum.

    Parameters
    ----------
    hm
        The map, without missing points.
    spacing
        Wanted pixel size (dy, dx) [m], or one number; the nearest that divides the map's size into
        whole pixels is used.

    Returns
    -------
    HeightMap
        History step ``resample`` with the shapes; wavelengths that the new pixels cannot hold are
        left out, not folded back. So are waves of two pixels of a periodic map, whose phase its
        points do not tell.

    Raises
    ------
    SurfaceError
        If points are missing, the pixel sizes are not positive, or too few pixels are left.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> surfaces.resample(hm, 2e-6)
    <HeightMap 16 x 24, pixel 2e-06 x 2e-06 m, periodic>
    """
    require_full(hm, "resampling")
    wanted = checked_spacing(spacing)
    ny, nx = (max(1, round(length / d)) for length, d in zip(hm.size, wanted, strict=True))
    if min(ny, nx) < 3:
        raise SurfaceError(f"pixels of {wanted[0]:g} x {wanted[1]:g} m leave {ny} x {nx} points")
    if isinstance(hm.source, np.ndarray):
        needed = 24 * ny * nx + 8 * hm.shape[0] * (nx + hm.shape[1])
        require_memory(needed, f"a map of {ny} x {nx} points", "take larger pixels")
    moved = (_waves if hm.periodic else _cosines)(hm.shape, (ny, nx))
    heights = along_both(blocks_of(hm.source), hm.source, (ny, nx), moved)
    step = {"step": "resample", "from": list(hm.shape), "to": [ny, nx]}
    return hm.replace(heights=heights, spacing=(hm.size[0] / ny, hm.size[1] / nx), step=step)


class Resampled(NamedTuple):
    """A map interpolated to other pixels by its waves.

    Attributes
    ----------
    hm
        The interpolated map.
    corner
        Position (y, x) [m] of its corner on the original map: see `corner_of`.
    """

    hm: HeightMap
    corner: tuple[float, float]


def corner_of(hm: HeightMap, spacing: tuple[float, float]) -> tuple[float, float]:
    """Corner (y, x) [m] of a grid of other pixels that has one on the highest point of the map.

    Results on this grid then do not change if the map is moved or mirrored. A map that is not
    periodic keeps its own corner.
    """
    if not hm.periodic:
        return 0.0, 0.0
    y, x = (
        math.fmod((place + 0.5) * step + 0.5 * new, new)
        for place, step, new in zip(hm.roughness.summit, hm.spacing, spacing, strict=True)
    )
    return y, x


def resample_waves(
    heights: Source,
    ny: int,
    nx: int,
    fewer: tuple[int, int] = (1, 1),
    corner: tuple[float, float] = (0.0, 0.0),
) -> Array:
    """Trigonometric interpolation of a periodic array to the cell centres of (ny, nx) pixels.

    Rows are transformed first, then the columns of the waves that are kept. If every `fewer`-th
    element along y and x holds all waves of the array, only these are used; `fewer` divides the
    shape. The pixels begin at `corner`, in units of the lengths of the array.
    """
    moved = _waves(heights.shape, (ny, nx), fewer, corner)
    (first_y, first_x), (step_y, step_x) = ((part - 1) // 2 for part in fewer), fewer
    count, width = (n // step for n, step in zip(heights.shape, fewer, strict=True))
    rows = np.empty((count, moved.width), np.complex128)

    def part(begin: int, end: int) -> None:
        for start in range(begin, end, _ROWS):
            stop = min(start + _ROWS, end)
            lines = slice(first_y + start * step_y, first_y + (stop - 1) * step_y + 1, step_y)
            rows[start:stop] = moved.rows(heights[lines, first_x::step_x])

    parallel.run(part, parallel.lines(count, count * width))
    return np.asarray(moved.back(moved.columns(slice(None), rows)))


def _waves(
    old: tuple[int, ...],
    new: tuple[int, int],
    fewer: tuple[int, int] = (1, 1),
    corner: tuple[float, float] = (0.0, 0.0),
) -> Transform:
    """Interpolation by the waves of a periodic array of shape `old`, of which every `fewer`-th
    element along y and x is given, to pixels from `corner` on."""
    down, across = (_factors(*each) for each in zip(old, new, fewer, corner, strict=True))
    workers = len(parallel.lines(old[0], math.prod(old)))

    def rows(heights: NDArray[Any]) -> NDArray[Any]:
        return np.asarray(fft.rfft(heights, axis=1)[:, : across.size] * across)

    def columns(_: slice, waves: NDArray[Any]) -> NDArray[Any]:
        waves = fft.fft(waves, axis=0, workers=workers, overwrite_x=True)
        kept = np.zeros((new[0], waves.shape[1]), np.complex128)
        kept[: down.size] = waves[: down.size] * down[:, None]
        kept[1 - down.size :] = waves[1 - down.size :] * down[:0:-1, None].conj()
        return np.asarray(fft.ifft(kept, axis=0, workers=workers, overwrite_x=True))

    def back(waves: NDArray[Any]) -> NDArray[Any]:
        return np.asarray(fft.irfft(waves, n=new[1], axis=1, workers=workers))

    return Transform(across.size, rows, columns, back)


def _cosines(old: tuple[int, ...], new: tuple[int, int]) -> Transform:
    """Interpolation by the cosines of an array that does not repeat, to cells of its length."""
    kept = [min(pair) for pair in zip(old, new, strict=True)]

    def there(values: NDArray[Any], axis: int) -> NDArray[Any]:
        if old[axis] == new[axis]:
            return values
        waves = fft.dct(values, axis=axis, workers=parallel.threads())
        return np.asarray(waves[: kept[0]] if axis == 0 else waves[:, : kept[1]])

    def back(waves: NDArray[Any], axis: int) -> NDArray[Any]:
        if old[axis] == new[axis]:
            return waves
        waves = waves * (new[axis] / old[axis])
        return np.asarray(fft.idct(waves, n=new[axis], axis=axis, workers=parallel.threads()))

    return Transform(
        kept[1],
        lambda heights: there(heights, 1),
        lambda _, waves: back(there(waves, 0), 0),
        lambda waves: back(waves, 1),
    )


def coarse_map(hm: HeightMap) -> Resampled | None:
    """A smooth periodic map on the coarsest grid that holds it; None if that is its own grid.

    Notes
    -----
    Fourier truncation to eight points per shortest wave (`shortest_wave`), both axes by the same
    ratio. The highest point of every block of the map must lie on the surface through the coarse
    points: features too few to show in the spectrum, such as single spikes, keep the full grid.
    """
    if not hm.periodic or min(hm.shape) <= _LEAST_SIDE_POINTS:
        return None
    turns = [
        slope / (bend * step) if bend > 0.0 else math.inf
        for slope, bend, step in zip(
            hm.roughness.slope, hm.roughness.curvature, hm.spacing, strict=True
        )
    ]
    if min(turns) < _SMOOTH:
        return None
    wave = min(shortest_wave(hm, axis) for axis in (0, 1))
    ratio = max(_POINTS_PER_WAVE / wave, _LEAST_SIDE_POINTS / min(hm.shape))
    if ratio > _WORTH_IT:
        return None
    ny, nx = (min(n, fft.next_fast_len(math.ceil(ratio * n), real=True)) for n in hm.shape)
    # of all points there are more than enough to find waves that the coarse grid holds
    fewer = [_divisor(n, n // m) for n, m in zip(hm.shape, (ny, nx), strict=True)]
    require_memory(
        8 * nx * (hm.shape[0] // fewer[0] + 4 * ny),
        f"the grid of {ny} x {nx} points that holds a map of {hm.shape[0]} x {hm.shape[1]}",
        "raise the limit of memory, or crop the map",
    )
    spacing = hm.size[0] / ny, hm.size[1] / nx
    y, x = corner_of(hm, spacing)
    shares = y / hm.size[0], x / hm.size[1]
    coarse = hm.replace(
        heights=resample_waves(hm.source, ny, nx, (fewer[0], fewer[1]), shares),
        spacing=spacing,
        step={"step": "resample", "from": list(hm.shape), "to": [ny, nx]},
    )
    return Resampled(coarse, (y, x)) if _holds(coarse, hm, (y, x)) else None


def _divisor(count: int, most: int) -> int:
    """Largest divisor of `count` that is no larger than `most`."""
    return next(part for part in range(most, 0, -1) if count % part == 0)


def block_means(source: Source, blocks: tuple[int, int]) -> Array:
    """Mean heights of equal blocks of an array, to a row and a column, of the shape `blocks`.

    Examples
    --------
    >>> block_means(np.arange(12.0).reshape(3, 4), (1, 2)).tolist()
    [[4.5, 6.5]]
    """
    first = [np.arange(k) * n // k for n, k in zip(source.shape, blocks, strict=True)]
    count = [np.diff(at, append=n).astype(float) for at, n in zip(first, source.shape, strict=True)]

    def by_column(_: slice, rows: NDArray[Any]) -> Array:
        return np.add.reduceat(rows, first[1], axis=1, dtype=float)

    sums = np.concatenate(list(parallel.over_rows(by_column, source)))
    return np.asarray(np.add.reduceat(sums, first[0], axis=0) / np.multiply.outer(*count))


def shortest_wave(hm: HeightMap, axis: int) -> float:
    """Length [pixels] of the shortest wave along an axis of a periodic map that carries slope."""
    power, count = hm.line_power[axis], hm.shape[axis]
    inside = np.cumsum(power * np.arange(power.size) ** 2)
    if inside[-1] == 0.0:
        return float(count)
    return count / max(1, int(np.searchsorted(inside, (1.0 - _SLOPE_LOST) * inside[-1])))


def _holds(coarse: HeightMap, hm: HeightMap, corner: tuple[float, float]) -> bool:
    """Whether the highest point of every block of a map lies on the surface of a coarser one."""
    rows, cols = _highest(hm)
    spline = splines.coefficients(coarse.heights, coarse.periodic)
    y, x = (
        ((at + 0.5) * step - begin) / new - 0.5
        for at, step, begin, new in zip(
            (rows, cols), hm.spacing, corner, coarse.spacing, strict=True
        )
    )
    places = zip(np.mod(y, coarse.shape[0]), np.mod(x, coarse.shape[1]), strict=True)
    flat, width = spline.ravel(), spline.shape[1]
    off = np.array([splines.expand(flat, width, *place)[0] for place in places])
    off -= hm.source[rows, cols]
    rms = hm.roughness.rms_height
    return bool(
        np.sqrt(np.mean(off**2)) <= _RMS_MISSED * rms and np.abs(off).max() <= _MOST_MISSED * rms
    )


def _highest(hm: HeightMap) -> tuple[Index, Index]:
    """Row and column of the highest point of each of `ROW_BANDS` times `ROW_BANDS` blocks."""
    nx, found, band = hm.shape[1], hm.roughness, np.arange(ROW_BANDS)
    bounds = nx * np.arange(ROW_BANDS + 1) // ROW_BANDS
    columns = np.minimum(bounds[:-1, None] + np.arange(-(-nx // ROW_BANDS)), bounds[1:, None] - 1)
    cols = columns[band, found.tops[:, columns].argmax(axis=2)]
    return found.rows[band[:, None], cols].ravel(), cols.ravel()


def _factors(all_points: int, count: int, fewer: int, corner: float) -> NDArray[np.complex128]:
    """Factors of the waves kept when every `fewer`-th of the cell centres becomes `count`, the
    first of which begins at the share `corner` of the length."""
    old = all_points // fewer
    kept = min(old, count)
    waves = np.arange(kept // 2 + 1)
    first = ((fewer - 1) // 2 + 0.5) / all_points
    shift: NDArray[np.complex128] = np.exp(2j * np.pi * waves * (corner + 0.5 / count - first))
    shift *= count / old
    if kept % 2 == 0 and (count != all_points or corner != 0.0):
        shift[-1] = 0.0
    return shift
