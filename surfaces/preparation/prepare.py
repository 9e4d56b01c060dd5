"""Preparation of a measured map; every step is recorded in its history."""

from __future__ import annotations

import numpy as np

from surfaces.errors import SurfaceError, as_choice, as_number, shown
from surfaces.heightmap import HeightMap, require_map

from . import borders, filling, filtering, levelling
from .outliers import mark_outliers

__all__ = ["prepare"]


def prepare(
    hm: HeightMap,
    *,
    level: str | None = "plane",
    fill: str | None = "harmonic",
    outliers: float | None = None,
    bandpass: tuple[float | None, float | None] | None = None,
    filter: str = "sharp",
    periodic: str | None = None,
    fill_limit: float = 0.1,
) -> HeightMap:
    """Level, remove outliers, fill, filter and make periodic, in this order.

    Parameters
    ----------
    hm
        The map as measured.
    level
        F operator: None or ``none``, ``mean``, ``plane``, ``quadratic``, ``cubic``, ``quartic``,
        ``quintic`` or ``cylinder``; see `surfaces.level`.
    fill
        ``harmonic`` fills missing points; None or ``none`` leaves them missing.
    outliers
        Robust standard deviations beyond which a point is a spike, or None to keep all points.
        Spikes become missing, and are filled with the rest.
    bandpass
        (shortest, longest) wavelength to keep [m], the nesting indices of S and L filter; None
        leaves a side open.
    filter
        ``sharp``, ``gaussian`` or ``spline`` limits of the band: see `surfaces.bandpass`.
    periodic
        ``mirror``, ``taper``, ``smooth`` or ``wrap``: see `surfaces.make_periodic`; None leaves it.
    fill_limit
        Largest fraction of the points that may be filled.

    Returns
    -------
    HeightMap
        The prepared map. Its history has one step per thing done, with counts and parameters.

    Raises
    ------
    InputError
        If an option is unknown or belongs to one that is not given, or too many points are missing.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> part = surfaces.crop(hm, (0, 16), (8, 40))
    >>> ready = surfaces.prepare(part, periodic="taper")
    >>> ready.periodic, [step["step"] for step in ready.history]
    (True, ['self_affine', 'crop', 'level', 'periodic'])
    """
    require_map(hm)
    level = as_choice("level", "none" if level is None else level, ("none", *levelling.FORMS))
    fill = as_choice("fill", "none" if fill is None else fill, ("none", "harmonic"))
    if not 0.0 <= as_number("fill_limit", fill_limit) < 1.0:
        raise SurfaceError(f"fill_limit is {fill_limit}; it is a fraction from 0 to below 1")
    if bandpass is not None and np.shape(np.asarray(bandpass, dtype=object)) != (2,):
        raise SurfaceError(
            f"bandpass is {shown(bandpass)}; give (shortest, longest) wavelength in m"
        )
    if fill == "none" and fill_limit != 0.1:
        raise SurfaceError(
            f"fill_limit is {fill_limit} and nothing is filled: leave it out, or pass "
            'fill="harmonic" (--fill harmonic)'
        )
    if bandpass is None and as_choice("filter", filter, filtering.FILTERS) != "sharp":
        raise SurfaceError(
            f"filter is {filter!r} and nothing is filtered: leave it out, or pass bandpass="
            "(shortest, longest) (--bandpass SHORT LONG)"
        )
    if level != "none":
        hm = levelling.level(hm, level)
    if outliers is not None:
        hm = mark_outliers(hm, outliers)
    if fill != "none" and (hm.missing or outliers is not None):
        hm = filling.fill_missing(hm, limit=fill_limit)
    if bandpass is not None:
        hm = filtering.bandpass(hm, *bandpass, filter=filter)
    if periodic is not None:
        hm = borders.make_periodic(hm, periodic)
    return hm
