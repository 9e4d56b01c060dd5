"""Band-pass by physical wavelength (S and L filters): sharp, Gaussian, spline; crop."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import LinearOperator, cg

from surfaces.arrays import Array, Mask
from surfaces.errors import SurfaceError, as_choice, as_number, checked_part
from surfaces.heightmap import HeightMap, require_full, require_map
from surfaces.numerics import parallel
from surfaces.numerics.memory import Transform, along_both
from surfaces.numerics.stored_array import Blocks, Source, blocks_of, windows

from .levelling import level

__all__ = ["FILTERS", "bandpass", "crop", "passed"]


FILTERS = ("sharp", "gaussian", "spline")

_LONGEST = 40.0
"""Longest cut-off of a spline filter over the longer side of a map that is not periodic: the
condition of its equations grows by the fourth power, to an error of 1e-4 rms heights there."""


def bandpass(
    hm: HeightMap,
    shortest: float | None = None,
    longest: float | None = None,
    *,
    filter: str = "sharp",
) -> HeightMap:
    """Keep the wavelengths between two lengths: S filter, then L filter.

    Parameters
    ----------
    hm
        The map, without missing points.
    shortest, longest
        Limits of the wavelength [m]; None leaves that side open. The mean is always kept. They are
        the nesting indices (cut-offs) of the S filter and of the L filter.
    filter
        ``sharp``; ``gaussian`` (ISO 16610-61); ``spline`` (ISO 16610-62). Half of a wave as long
        as a limit passes the last two.

    Returns
    -------
    HeightMap
        History step ``bandpass`` with the filter, the limits, and the rms height [m] before and
        after.

    Raises
    ------
    InputError
        If points are missing, the filter is unknown, the limits are crossed, or no wave of the map
        lies between those of a sharp filter.

    Notes
    -----
    A sharp cut of the Fourier spectrum for a periodic map. A map that is not periodic is cut in
    its cosine spectrum, which is the spectrum of the map mirrored at its border: there is no cliff
    at the seam. So is that of the Gaussian filter, of which a wave passes with
    2^-(limit / wavelength)^2. The spline filter is free at the border and keeps planes. An L
    filter takes off what passes the filter of the longest wave.

    References
    ----------
    ISO 16610-61 (areal Gaussian filters); ISO 16610-62 (areal spline filters); ISO 25178-2:2021,
    3.1 (S filter, L filter, nesting index).

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> smooth = surfaces.bandpass(hm, shortest=16e-6)
    >>> bool(smooth.roughness.rms_slope < hm.roughness.rms_slope)
    True
    """
    require_full(hm, "a band-pass")
    as_choice("filter", filter, FILTERS)
    lower = 0.0 if shortest is None else as_number("shortest", shortest)
    upper = np.inf if longest is None else as_number("longest", longest)
    if not 0.0 <= lower < upper:
        raise SurfaceError(
            f"bandpass keeps wavelengths {lower:g} to {upper:g} m; the first must be the shorter"
        )
    if filter == "sharp":
        made = hm.replace(heights=_cut(hm, lower, upper))
    else:
        made = hm.replace(heights=_smooth(hm, lower, filter)) if lower > 0.0 else hm
        if upper < np.inf:
            long, mean = _smooth(made, upper, filter), hm.roughness.mean
            made = hm.with_rows(
                (begin, rows - long[begin:end] + mean) for begin, end, rows in windows(made.source)
            )
    step = {
        "step": "bandpass",
        "filter": filter,
        "shortest": lower or None,
        "longest": upper if np.isfinite(upper) else None,
        "rms_before": hm.rms_height,
        "rms_after": made.rms_height,
    }
    return made.replace(step=step)


def crop(hm: HeightMap, rows: tuple[int, int], columns: tuple[int, int]) -> HeightMap:
    """Cut out a rectangle of pixels, first and one past last; the result is not periodic.

    Raises
    ------
    SurfaceError
        If the rectangle is not inside the map.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> surfaces.crop(hm, (0, 16), (8, 40))
    <HeightMap 16 x 32, pixel 1e-06 x 1e-06 m, not periodic>
    """
    require_map(hm)
    ny, nx = hm.shape
    return hm.cut(checked_part("rows", rows, ny), checked_part("columns", columns, nx))


def _cut(hm: HeightMap, lower: float, upper: float) -> Source:
    """Heights of the waves of lengths from `lower` to `upper` [m], with the mean."""
    fy, fx = _frequencies(hm)
    kept = 0

    def share(columns: slice) -> Mask:
        nonlocal kept
        frequency = np.hypot(fy[:, None], fx[None, columns])
        keep = frequency >= (1.0 - 1e-12) / upper
        if lower > 0.0:
            keep &= frequency <= (1.0 + 1e-12) / lower
        if columns.start == 0:
            keep[0, 0] = True
        kept += int(np.count_nonzero(keep))
        return keep

    found = passed(blocks_of(hm.source), hm.source, hm.periodic, share)
    if kept < 2:
        raise SurfaceError(
            f"no wavelength of the map lies between {lower:g} and {upper:g} m; the map has "
            f"{2 * max(hm.spacing):.4g} to {max(hm.size) * (1 if hm.periodic else 2):.4g} m"
        )
    return found


def _smooth(hm: HeightMap, cutoff: float, filter: str) -> Source:
    """Heights of the waves that a Gaussian or spline low-pass filter keeps."""
    if filter == "spline":
        share = _spline_share(hm, cutoff)
        if not hm.periodic:
            return _free_spline(hm, cutoff, share(slice(None)))
    else:
        across, along = (np.exp2(-np.square(cutoff * f)) for f in _frequencies(hm))

        def share(columns: slice) -> Array:
            return np.asarray(across[:, None] * along[columns])

    return passed(blocks_of(hm.source), hm.source, hm.periodic, share)


def _spline_share(hm: HeightMap, cutoff: float) -> Callable[[slice], Array]:
    """Share of each wave that passes the filter of a map without a border, of those in the columns
    of its spectrum asked for; half of the wavelength `cutoff` [m].

    They are those of its Fourier spectrum, or of its cosine spectrum if it is not periodic.

    Raises
    ------
    SurfaceError
        If the cut-off is below two pixels.

    Notes
    -----
    The filtered map w minimizes sum (z - w)^2 + sum (a_y^2 w_yy)^2 + 2 (a_y a_x w_yx)^2 +
    (a_x^2 w_xx)^2 over second differences w_yy, w_yx, w_xx of the grid, with a = 1 / (2 sin(pi d /
    cutoff)) for the pixel size d of each axis. A wave along an axis passes with 1 / (1 + (sin(pi d
    / wavelength) / sin(pi d / cutoff))^4), as through the profile filter; one in another direction
    to the order of the grid.

    References
    ----------
    ISO 16610-62 (areal spline filters), ISO 16610-22, 4.2 (alpha of the profile filter).
    Krystek 2005, Spline filters for surface texture analysis, Key Eng. Mater. 295-296, 441-446.
    """
    if cutoff < 2.0 * max(hm.spacing):
        raise SurfaceError(
            f"a spline filter of {cutoff:g} m is shorter than two pixels; take "
            f"{2.0 * max(hm.spacing):g} m or more, or None"
        )
    (bend_y, bend_x) = (
        np.square(np.sin(math.pi * d * frequency) / math.sin(math.pi * d / cutoff))
        for d, frequency in zip(hm.spacing, _frequencies(hm), strict=True)
    )

    def share(columns: slice) -> Array:
        return np.asarray(1.0 / (1.0 + np.square(bend_y[:, None] + bend_x[columns])))

    return share


def _free_spline(hm: HeightMap, cutoff: float, shares: Array) -> Array:
    """Long waves of a map that is not periodic and has no missing points, heights [m] (ny, nx).

    Its ends are free (natural conditions), which keep planes: conjugate gradients about the plane,
    preconditioned by the filter of the map mirrored at its border, of which the `shares` are those
    of `_spline_share` for this `cutoff` [m]. Beyond `_LONGEST` sides the equations lose the digits.
    """
    if cutoff > _LONGEST * max(hm.size):
        raise SurfaceError(
            f"a spline filter of {cutoff:g} m is more than {_LONGEST:g} times as long as the map; "
            'level the map (level="plane", --level plane) in its place'
        )
    y, x = (0.25 / math.sin(math.pi * d / cutoff) ** 2 for d in hm.spacing)
    (slope_y, bend_y), (slope_x, bend_x) = (_squares_of_differences(count) for count in hm.shape)

    def normal(flat: Array) -> Array:
        w = flat.reshape(hm.shape)
        bends = y * y * (bend_y @ w) + 2.0 * x * y * (slope_y @ w @ slope_x) + x * x * (w @ bend_x)
        return np.asarray(w + bends).ravel()

    def mirrored(flat: Array) -> Array:
        return np.asarray(fft.idctn(fft.dctn(flat.reshape(hm.shape)) * shares)).ravel()

    operator, guess = (
        LinearOperator((hm.heights.size,) * 2, matvec=f, dtype=np.float64)
        for f in (normal, mirrored)
    )
    z = level(hm).heights.ravel()
    w, status = cg(operator, z, x0=guess @ z, rtol=1e-9, maxiter=3000, M=guess)
    if status != 0:
        raise SurfaceError(
            f"the spline filter of {cutoff:g} m did not converge; take a shorter cut-off or "
            'filter="gaussian" (--filter gaussian)'
        )
    return np.asarray(hm.heights + (w - z).reshape(hm.shape))


def _squares_of_differences(count: int) -> tuple[csr_array, csr_array]:
    """Matrices D'D of the first and of the second differences D of a line of points."""
    first = diags_array([-1.0, 1.0], offsets=[0, 1], shape=(count - 1, count))
    second = diags_array([1.0, -2.0, 1.0], offsets=[0, 1, 2], shape=(count - 2, count))
    return csr_array(first.T @ first), csr_array(second.T @ second)


def passed(
    blocks: Blocks, like: Source, periodic: bool, share: Callable[[slice], NDArray[Any]]
) -> Source:
    """Heights of which a share passes of every wave of the Fourier or cosine spectrum: that of the
    waves in these columns of it."""
    (ny, nx), workers = like.shape, parallel.threads()
    width = nx // 2 + 1 if periodic else nx
    there, here = (fft.fft, fft.ifft) if periodic else (fft.dct, fft.idct)
    first, last = (fft.rfft, fft.irfft) if periodic else (fft.dct, fft.idct)

    def rows(heights: NDArray[Any]) -> NDArray[Any]:
        return np.asarray(first(heights, axis=1, workers=workers))

    def columns(place: slice, waves: NDArray[Any]) -> NDArray[Any]:
        modes = there(waves, axis=0, workers=workers, overwrite_x=True) * share(place)
        return np.asarray(here(modes, axis=0, workers=workers, overwrite_x=True))

    def back(waves: NDArray[Any]) -> NDArray[Any]:
        return np.asarray(last(waves, n=nx, axis=1, workers=workers))

    return along_both(blocks, like, (ny, nx), Transform(width, rows, columns, back))


def _frequencies(hm: HeightMap) -> tuple[Array, Array]:
    """Frequencies [1/m] of the two axes of the Fourier or cosine spectrum."""
    (ny, nx), (dy, dx) = hm.shape, hm.spacing
    if hm.periodic:
        return np.abs(fft.fftfreq(ny, dy)), fft.rfftfreq(nx, dx)
    return np.arange(ny) / (2 * ny * dy), np.arange(nx) / (2 * nx * dx)
