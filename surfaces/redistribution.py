"""Other heights on a map whose spectrum stays."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .heightmap import HeightMap

__all__ = ["redistribute"]

Array = NDArray[np.float64]


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
