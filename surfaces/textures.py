"""Machined and layered surfaces built from self-affine parts."""

from __future__ import annotations

import numpy as np

from surfaces.arrays import Array

from .errors import LARGEST_NUMBER, LONGEST_LENGTH, InputError
from .heightmap import HeightMap
from .synthesis import self_affine, synthesis

__all__ = ["ground", "plateau_honed", "turned", "two_scale"]


_SCRATCH = 12.0
"""Length over width of the scratches of a honed surface."""


@synthesis
def plateau_honed(
    shape: tuple[int, int],
    size: tuple[float, float],
    *,
    rms_slope: float,
    cutoff: float,
    rolloff: float | None = None,
    hurst: float = 0.8,
    crossing: float = np.pi / 3,
    plateau: float = 0.35,
    fine: float = 0.15,
    seed: int = 0,
) -> HeightMap:
    """Plateau-honed surface: two crossed families of scratches, worn tops, a fine roughness.

    Parameters
    ----------
    shape, size
        Points (ny, nx) and lengths (Ly, Lx) [m] of the periodic cell.
    rms_slope
        Root-mean-square gradient of the whole [-], from its spectrum.
    cutoff
        Shortest wavelength [m].
    rolloff
        Longest wavelength across a scratch [m]; None: an eighth of the shorter side.
    hurst
        Hurst exponent of all parts [-].
    crossing
        Angle between both families [rad], symmetric about +x.
    plateau
        Heights above the mean are compressed to this fraction, smoothly [-].
    fine
        Rms height of the isotropic roughness relative to that of the worn scratches [-].
    seed
        Seeds are `seed` (roughness), `seed + 1` and `seed + 2` (scratches).

    Returns
    -------
    HeightMap
        Periodic map with negative skewness.

    Raises
    ------
    InputError
        If `plateau` is not in (0, 1], `rms_slope` not positive, or no wave fits the map.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.plateau_honed((32, 48), (32e-6, 48e-6), rms_slope=0.1, cutoff=8e-6)
    >>> bool(surfaces.describe(hm).heights["Ssk"] < 0)
    True
    """
    if not 0.0 < plateau <= 1.0:
        raise InputError(f"plateau is {plateau}; it must be a fraction above 0, at most 1")
    _check_share(fine)
    long = min(size) / 8.0 if rolloff is None else rolloff
    stretch = np.sqrt(_SCRATCH)  # the short wavelengths keep the roll-off asked for
    scratches = sum(
        self_affine(
            shape, size, hurst=hurst, rms_height=1.0, rolloff=long * stretch,
            cutoff=1.5 * cutoff * stretch, anisotropy=_SCRATCH, angle=angle, seed=seed + k,
        ).heights
        for k, angle in ((1, 0.5 * crossing), (2, -0.5 * crossing))
    ) / np.sqrt(2.0)  # fmt: skip
    half = 0.5 * (1.0 - plateau)
    worn = 0.5 * (1.0 + plateau) * scratches - np.hypot(half * scratches, 0.1)
    worn /= worn.std()
    rough = self_affine(
        shape, size, hurst=hurst, rms_height=1.0, rolloff=long, cutoff=2.0 * cutoff, seed=seed
    )
    return _finished(worn + fine * rough.heights, size, cutoff, rms_slope, "plateau_honed")


@synthesis
def ground(
    shape: tuple[int, int],
    size: tuple[float, float],
    *,
    rms_slope: float,
    cutoff: float,
    rolloff: float | None = None,
    hurst: float = 0.8,
    length: float = 25.0,
    angle: float = 0.0,
    fine: float = 0.1,
    seed: int = 0,
) -> HeightMap:
    """Ground surface: parallel scratches `length` times as long as wide, and a fine roughness.

    Parameters
    ----------
    shape, size, rms_slope, cutoff, rolloff, hurst
        As in `plateau_honed`.
    length
        Length over width of the scratches [-], at least 1.
    angle
        Direction of the scratches [rad], counter-clockwise from +x towards +y.
    fine
        Rms height of the isotropic roughness relative to that of the scratches [-].
    seed
        Seeds are `seed` (roughness) and `seed + 1` (scratches).

    Returns
    -------
    HeightMap
        Periodic map.

    Raises
    ------
    InputError
        If `length` is below 1, `fine` negative, `rms_slope` not positive, or no wave fits the map.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.ground((32, 48), (32e-6, 48e-6), rms_slope=0.1, cutoff=8e-6)
    >>> f"{hm.roughness.rms_slope:.2f}"
    '0.10'
    """
    long = min(size) / 8.0 if rolloff is None else rolloff
    if not 1.0 <= length < np.inf:
        raise InputError(f"length is {length}; it must be a ratio of at least 1, and finite")
    _check_share(fine)
    stretch = np.sqrt(length)
    scratches = self_affine(
        shape, size, hurst=hurst, rms_height=1.0, rolloff=long * stretch, cutoff=cutoff * stretch,
        anisotropy=length, angle=angle, seed=seed + 1,
    )  # fmt: skip
    rough = self_affine(
        shape, size, hurst=hurst, rms_height=1.0, rolloff=long, cutoff=cutoff, seed=seed
    )
    heights = scratches.heights + fine * rough.heights
    return _finished(heights, size, cutoff, rms_slope, "ground")


@synthesis
def turned(
    shape: tuple[int, int],
    size: tuple[float, float],
    *,
    feed: float,
    nose_radius: float,
    roughness: float = 0.0,
    cutoff: float | None = None,
    hurst: float = 0.8,
    seed: int = 0,
) -> HeightMap:
    """Turned surface: the grooves of a round tool, with self-affine roughness on top.

    Parameters
    ----------
    shape, size
        Points (ny, nx) and lengths (Ly, Lx) [m] of the periodic cell.
    feed
        Distance of the grooves along y [m]; rounded so that a whole number fits the cell.
    nose_radius
        Radius of the tool's nose [m], at least half the feed.
    roughness
        Rms height of the roughness [m]; it is rolled off above the feed.
    cutoff, hurst, seed
        Shortest wavelength [m], Hurst exponent and seed of the roughness.

    Returns
    -------
    HeightMap
        Periodic map of ridges along x, each about ``feed**2 / (8 nose_radius)`` high.

    Raises
    ------
    InputError
        If the feed is not positive or below two points, the nose too sharp for it, or the roughness
        negative.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.turned((32, 48), (32e-6, 48e-6), feed=16e-6, nose_radius=1e-4)
    >>> len(surfaces.segment(hm)) > 0
    True
    """
    if not 0.0 < feed <= 2.0 * nose_radius <= LONGEST_LENGTH:
        raise InputError(
            f"feed is {feed} and nose_radius is {nose_radius}; give a positive feed of at most "
            f"twice the nose radius, and that of up to {LONGEST_LENGTH:g} m"
        )
    if not roughness >= 0.0:
        raise InputError(f"roughness is {roughness}; it must be a height of at least 0 m")
    count = max(1, round(size[0] / feed))
    width = size[0] / count
    if width > 2.0 * nose_radius:
        raise InputError(
            f"grooves that fit the cell are {width:g} m wide, more than twice the nose radius of "
            f"{nose_radius:g} m; take another feed or size"
        )
    if 2 * count > shape[0]:
        raise InputError(
            f"feed is {feed:g} m, less than two of the {shape[0]} points over {size[0]:g} m: take "
            "a larger feed or more points"
        )
    y = (np.arange(shape[0]) + 0.5) * size[0] / shape[0]
    across = np.mod(y, width) - 0.5 * width
    # R - sqrt(R^2 - y^2), without cancellation
    groove = across**2 / (nose_radius + np.sqrt(nose_radius**2 - across**2))
    heights = np.repeat((groove - groove.mean())[:, None], shape[1], axis=1)
    if roughness > 0.0:
        heights = heights + self_affine(
            shape, size, hurst=hurst, rms_height=roughness, rolloff=min(width, *size),
            cutoff=cutoff, seed=seed,
        ).heights  # fmt: skip
    return _map(heights, size, "turned")


@synthesis
def two_scale(
    shape: tuple[int, int],
    size: tuple[float, float],
    *,
    coarse: float,
    fine: float,
    coarse_height: float,
    fine_height: float,
    width: float = 2.0,
    hurst: float = 0.8,
    seed: int = 0,
) -> HeightMap:
    """Sum of two narrow bands of waves: hills of one size carrying bumps of another.

    Parameters
    ----------
    shape, size
        Points (ny, nx) and lengths (Ly, Lx) [m] of the periodic cell.
    coarse, fine
        Shortest wavelength of each band [m].
    coarse_height, fine_height
        Rms height of each band [m].
    width
        Ratio of the longest to the shortest wavelength of a band, above 1.
    hurst
        Hurst exponent inside the bands.
    seed
        Seeds are `seed` (coarse) and `seed + 1` (fine).

    Returns
    -------
    HeightMap
        Periodic map.

    Raises
    ------
    InputError
        If the coarse waves are not the longer ones, a height is negative, or no wave fits into a
        band.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.two_scale(
    ...     (64, 96),
    ...     (64e-6, 96e-6),
    ...     coarse=32e-6,
    ...     fine=8e-6,
    ...     coarse_height=1e-7,
    ...     fine_height=1e-8,
    ... )
    >>> f"{hm.rms_height:.1e}"
    '1.0e-07'
    """
    if not (coarse > fine > 0.0 and width > 1.0):
        raise InputError(
            f"coarse is {coarse}, fine is {fine} and width is {width}; give coarse > fine > 0 "
            "and width > 1"
        )
    if not (0.0 <= coarse_height < np.inf and 0.0 <= fine_height < np.inf):
        raise InputError(
            f"coarse_height is {coarse_height} and fine_height {fine_height}; both are rms heights "
            "of at least 0 m"
        )
    heights = np.zeros(shape)
    for k, (short, rms) in enumerate(((coarse, coarse_height), (fine, fine_height))):
        whole = self_affine(shape, size, hurst=hurst, rms_height=1.0, cutoff=short, seed=seed + k)
        band = _filtered(whole.heights, size, short, width * short)
        if not band.any():
            raise InputError(f"no wave fits between {width * short:g} and {short:g} m")
        heights += band * (rms / band.std())
    return _map(heights, size, "two_scale")


def _check_share(fine: float) -> None:
    """Refuse a relative rms height of the fine roughness that is none."""
    if not 0.0 <= fine <= LARGEST_NUMBER:
        raise InputError(f"fine is {fine}; it must be a share from 0 to {LARGEST_NUMBER:g}")


def _filtered(heights: Array, size: tuple[float, float], shortest: float, longest: float) -> Array:
    """Waves of the map from a shortest length [m] up to, but without, a longest one."""
    ny, nx = heights.shape
    f = np.hypot(np.fft.fftfreq(ny, size[0] / ny)[:, None], np.fft.rfftfreq(nx, size[1] / nx))
    spectrum = np.fft.rfft2(heights)
    spectrum[(f <= 1.0 / longest) | (f > (1.0 + 1e-9) / shortest)] = 0.0
    return np.fft.irfft2(spectrum, s=heights.shape)


def _finished(
    heights: Array,
    size: tuple[float, float],
    cutoff: float,
    rms_slope: float,
    name: str,
) -> HeightMap:
    """Band-limited map of zero mean, scaled to the rms slope of its spectrum."""
    if not rms_slope > 0.0:
        raise InputError(f"rms_slope is {rms_slope}; it must be positive")
    ny, nx = heights.shape
    smooth = _filtered(heights, size, cutoff, np.inf)
    fy = np.fft.fftfreq(ny, size[0] / ny)[:, None]
    fx = np.fft.fftfreq(nx, size[1] / nx)[None, :]
    power = np.abs(np.fft.fft2(smooth) / smooth.size) ** 2
    slope = 2.0 * np.pi * np.sqrt(np.sum(power * (fy**2 + fx**2)))
    return _map(smooth * (rms_slope / slope), size, name)


def _map(heights: Array, size: tuple[float, float], name: str) -> HeightMap:
    spacing = (size[0] / heights.shape[0], size[1] / heights.shape[1])
    return HeightMap(heights, spacing, periodic=True, name=name)
