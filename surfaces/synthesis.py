"""Random rough surfaces with a prescribed power spectrum or distribution of heights."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import ParamSpec

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics.memory import require_memory

from .errors import LONGEST, SHORTEST, InputError, as_number
from .heightmap import HeightMap

__all__ = ["redistribute", "self_affine", "synthesis"]


Arguments = ParamSpec("Arguments")

Array = NDArray[np.float64]

_EDGE = 1e-9  # relative tolerance of the band edges, below the spacing of wave numbers


def synthesis(make: Callable[Arguments, HeightMap]) -> Callable[Arguments, HeightMap]:
    """A function that makes a periodic map of a shape and a size: both are checked, and its name
    and its other arguments are what the history of the map begins with."""

    @functools.wraps(make)
    def checked(*args: Arguments.args, **kwargs: Arguments.kwargs) -> HeightMap:
        given = inspect.signature(make).bind(*args, **kwargs)
        given.apply_defaults()
        settings = dict(given.arguments)
        given.arguments["shape"] = _checked_shape(settings.pop("shape"))
        given.arguments["size"] = _checked_size(settings.pop("size"))
        hm = make(*given.args, **given.kwargs)
        return hm.replace(history=({"step": make.__name__, **settings},))

    return checked


@synthesis
def self_affine(
    shape: tuple[int, int],
    size: tuple[float, float],
    *,
    hurst: float,
    rms_slope: float | None = None,
    rms_height: float | None = None,
    rolloff: float | None = None,
    cutoff: float | None = None,
    anisotropy: float = 1.0,
    angle: float = 0.0,
    seed: int = 0,
) -> HeightMap:
    """Periodic self-affine surface: deterministic amplitudes, random phases, zero mean.

    Parameters
    ----------
    shape
        Number of points (ny, nx), each at least 3.
    size
        Lengths (Ly, Lx) [m] of the periodic cell.
    hurst
        Hurst exponent H [-], between 0 and 1.
    rms_slope
        Root-mean-square gradient of the band-limited surface [-], from its spectrum.
    rms_height
        Root-mean-square height [m]; give this or `rms_slope`, not both.
    rolloff
        Wavelength [m] above which the spectrum is flat; None: self-affine to the cell's size.
    cutoff
        Shortest wavelength [m]; None: the pixel.
    anisotropy
        Ratio (at least 1) of equivalent wavelengths along and across the lay. Both are stretched
        by the square root of the ratio, so that areas of features are kept.
    angle
        Direction of the lay (of the long wavelengths), counter-clockwise from +x [rad].
    seed
        Seed of `numpy.random.default_rng`. One uniform phase is drawn for each point of the half
        spectrum (ny, nx//2 + 1), so a seed names one surface of one `shape`: other sizes, spectra
        and pixel sizes at the same shape keep the phases, other shapes are other realisations.

    Returns
    -------
    HeightMap
        Periodic map of the surface.

    Raises
    ------
    InputError
        If a parameter is out of its range or no wave lies in the band.

    Notes
    -----
    The amplitude of wave vector k (cycles per metre) is proportional to
    ``max(|k|, 1/rolloff) ** -(1 + H)`` for ``|k| <= 1/cutoff`` and zero beyond, so that the power
    spectral density falls as ``|k| ** (-2 - 2 H)``. The mean and the Nyquist lines are zero.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> hm
    <HeightMap 32 x 48, pixel 1e-06 x 1e-06 m, periodic>
    >>> f"{hm.roughness.rms_slope:.3f}"
    '0.100'
    """
    (ny, nx), (ly, lx) = shape, size
    lengths = {"rolloff": rolloff, "cutoff": cutoff}
    scales = {"rms_slope": rms_slope, "rms_height": rms_height}
    for name, value in {**lengths, **scales, "hurst": hurst, "angle": angle}.items():
        if value is not None:
            as_number(name, value)
    as_number("anisotropy", anisotropy)
    _check(0.0 <= hurst <= 1.0, f"hurst is {hurst}; it must lie between 0 and 1")
    _check(
        1.0 <= anisotropy < np.inf, f"anisotropy is {anisotropy}; it must be at least 1, and finite"
    )
    _check(np.isfinite(angle), f"angle is {angle}; it must be a number of radians")
    _check(
        isinstance(seed, int | np.integer) and seed >= 0,
        f"seed is {seed}; it must be a whole number, not negative",
    )
    for name, wavelength in (("rolloff", rolloff), ("cutoff", cutoff)):
        _check(
            wavelength is None or wavelength > 0.0,
            f"{name} is {wavelength}; it must be a positive wavelength in m",
        )
    _check(
        (rms_slope is None) != (rms_height is None),
        "give either rms_slope or rms_height, and not both",
    )
    target = rms_slope if rms_height is None else rms_height
    _check(
        target is not None and 0.0 < target < np.inf,
        f"the rms value is {target}; it must be positive and finite",
    )
    require_memory(80 * ny * nx, f"a map of {ny} x {nx} points", "make it smaller")

    fy = np.asarray(np.fft.fftfreq(ny, 1.0 / ny)[:, None] / ly, np.float64)
    fx = np.asarray(np.arange(nx // 2 + 1)[None, :] / lx, np.float64)
    amplitude = _amplitude(fy, fx, hurst, rolloff, cutoff, anisotropy, angle)
    if ny % 2 == 0:
        amplitude[ny // 2, :] = 0.0
    if nx % 2 == 0:
        amplitude[:, nx // 2] = 0.0
    twice = np.full(nx // 2 + 1, 2.0)  # columns that stand for two conjugate waves
    twice[0] = 1.0
    with np.errstate(over="ignore", invalid="ignore"):
        power = twice * amplitude**2
        if rms_height is None:
            power = power * (2.0 * np.pi) ** 2 * (fy**2 + fx**2)
        total = float(power.sum())
    _check(total > 0.0, "no wave lies between the cut-off and the size of the cell")
    _check(total < np.inf, f"anisotropy is {anisotropy}; no calculation holds such waves")

    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, size=amplitude.shape)
    half = np.arange(1, (ny + 1) // 2)
    phase[ny - half, 0] = -phase[half, 0]
    amplitude *= float(target or 0.0) / np.sqrt(total) * (ny * nx)
    heights = np.fft.irfft2(amplitude * np.exp(1j * phase), s=(ny, nx))
    heights -= heights.mean()
    return HeightMap(heights, (ly / ny, lx / nx), periodic=True)


def redistribute(
    hm: HeightMap, quantile: Callable[[Array], Array], *, iterations: int = 20
) -> HeightMap:
    """Give a periodic map another height distribution and keep its spectrum.

    Parameters
    ----------
    hm
        Periodic map without missing points.
    quantile
        Inverse of the cumulative height distribution: heights [m] of probabilities in (0, 1);
        for instance the method ``ppf`` of a distribution of `scipy.stats`.
    iterations
        Rounds of imposing the spectrum, then the heights.

    Returns
    -------
    HeightMap
        Map with exactly these heights and nearly the old spectrum.

    Raises
    ------
    InputError
        If the map is not periodic or the quantiles are not finite and increasing.

    References
    ----------
    Schreiber and Schmitz, Phys. Rev. Lett. 77 (1996) 635 (iterated amplitude adjustment).

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> import numpy as np
    >>> uniform = surfaces.redistribute(hm, lambda share: 1e-6 * share)
    >>> f"{np.ptp(uniform.heights):.1e}"
    '1.0e-06'
    """
    if not hm.periodic or hm.missing:
        raise InputError("redistribute needs a periodic map without missing points")
    n = hm.heights.size
    levels = np.asarray(quantile((np.arange(n) + 0.5) / n), float)
    if not (np.isfinite(levels).all() and (np.diff(levels) >= 0.0).all()):
        raise InputError("the quantile function must give finite, increasing heights")
    amplitude = np.abs(np.fft.rfft2(hm.heights))
    amplitude *= levels.std() / hm.rms_height
    amplitude[0, 0] = abs(levels.sum())
    heights = hm.heights
    for turn in range(max(1, iterations)):
        if turn:
            phase = np.angle(np.fft.rfft2(heights))
            heights = np.fft.irfft2(amplitude * np.exp(1j * phase), s=hm.shape)
        ranked = np.empty(n)
        ranked[np.argsort(heights, axis=None, kind="stable")] = levels
        heights = ranked.reshape(hm.shape)
    return hm.replace(heights=heights, step={"step": "redistribute", "iterations": iterations})


def _amplitude(
    fy: Array,
    fx: Array,
    hurst: float,
    rolloff: float | None,
    cutoff: float | None,
    anisotropy: float,
    angle: float,
) -> Array:
    """Unscaled amplitudes over the half spectrum; `fy`, `fx` are frequencies [1/m]."""
    if anisotropy == 1.0:
        k = np.hypot(fy, fx)
    else:
        stretch = np.sqrt(anisotropy)
        along = (fx * np.cos(angle) + fy * np.sin(angle)) * stretch
        across = (fy * np.cos(angle) - fx * np.sin(angle)) / stretch
        k = np.hypot(along, across)
    lowest = np.min(k[k > 0.0])
    k_rolloff = lowest if rolloff is None else 1.0 / rolloff
    inside = k < k_rolloff * (1.0 - _EDGE)
    amplitude: Array = np.where(inside, k_rolloff, np.maximum(k, lowest)) ** (-(1.0 + hurst))
    amplitude[0, 0] = 0.0
    if cutoff is not None:
        amplitude[k > (1.0 + _EDGE) / cutoff] = 0.0
    return amplitude


def _checked_shape(shape: tuple[int, int]) -> tuple[int, int]:
    _check(np.shape(shape) == (2,), f"shape is {shape}; give the numbers of points (ny, nx)")
    ny, nx = (int(n) for n in shape)
    whole = (ny, nx) == tuple(shape)
    _check(whole and min(ny, nx) >= 3, f"shape is {tuple(shape)}; give whole numbers from 3")
    return ny, nx


def _checked_size(size: tuple[float, float]) -> tuple[float, float]:
    _check(np.shape(size) == (2,), f"size is {size}; give the lengths (Ly, Lx) in m")
    ly, lx = (float(length) for length in size)
    _check(
        SHORTEST <= min(ly, lx) and max(ly, lx) <= LONGEST,
        f"size is {tuple(size)}; both (Ly, Lx) must be positive lengths in m",
    )
    return ly, lx


def _check(holds: bool, message: str) -> None:
    if not holds:
        raise InputError(message)
