"""Random rough surfaces with a prescribed power spectrum or distribution of heights."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import ParamSpec

import numpy as np

from surfaces.arrays import Array

from .errors import InputError, as_count, as_number, as_numbers, shown
from .heightmap import HeightMap, require_map
from .random_waves import RandomWaves, checked_shape, checked_size

__all__ = ["redistribute", "self_affine", "synthesis"]


Arguments = ParamSpec("Arguments")


def synthesis(make: Callable[Arguments, HeightMap]) -> Callable[Arguments, HeightMap]:
    """A function that makes a periodic map of a shape, a size and numbers: all are checked, and its
    name and its other arguments are what the history of the map begins with."""
    signature = inspect.signature(make)

    @functools.wraps(make)
    def checked(*args: Arguments.args, **kwargs: Arguments.kwargs) -> HeightMap:
        given = signature.bind(*args, **kwargs)
        given.apply_defaults()
        settings = dict(given.arguments)
        given.arguments["shape"] = checked_shape(settings.pop("shape"))
        given.arguments["size"] = checked_size(settings.pop("size"))
        for name, value in settings.items():
            if value is not None or signature.parameters[name].default is not None:
                # plain numbers: seeds are added to, and the history is kept in files
                number = int(value) if isinstance(value, np.integer) else as_number(name, value)
                settings[name] = given.arguments[name] = value if type(value) is int else number
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
    >>> f"{hm.roughness.rms_slope:.2f}"
    '0.10'
    """
    waves = RandomWaves(
        shape,
        size,
        hurst=hurst,
        rms_slope=rms_slope,
        rms_height=rms_height,
        rolloff=rolloff,
        cutoff=cutoff,
        anisotropy=anisotropy,
        angle=angle,
        seed=seed,
    )
    return HeightMap(waves.heights(), waves.spacing, periodic=True)


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
        If the map is not periodic, or constant, there is no iteration, or the quantiles are not
        finite and increasing.

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
    require_map(hm)
    if not callable(quantile):
        raise InputError(f"quantile is {shown(quantile)}; give a function of the share of points")
    if not hm.periodic or hm.missing or hm.rms_height == 0.0:
        raise InputError(
            "redistribute needs a periodic map without missing points, and not a constant one"
        )
    iterations = as_count("iterations", iterations, 1)
    n = hm.heights.size
    levels = as_numbers("what quantile gives", quantile((np.arange(n) + 0.5) / n))
    if levels.shape != (n,) or not (np.diff(levels) >= 0.0).all():
        raise InputError(f"quantile must give {n} increasing heights for {n} probabilities")
    amplitude = np.abs(np.fft.rfft2(hm.heights))
    amplitude *= levels.std() / hm.rms_height
    amplitude[0, 0] = abs(levels.sum())
    heights = hm.heights
    for turn in range(iterations):
        if turn:
            phase = np.angle(np.fft.rfft2(heights))
            heights = np.fft.irfft2(amplitude * np.exp(1j * phase), s=hm.shape)
        ranked = np.empty(n)
        ranked[np.argsort(heights, axis=None, kind="stable")] = levels
        heights = ranked.reshape(hm.shape)
    return hm.replace(heights=heights, step={"step": "redistribute", "iterations": iterations})
