"""Two rough surfaces in contact, as one map against a flat."""

from __future__ import annotations

import numpy as np

from .errors import SLIMMEST_PIXEL, SurfaceError
from .heightmap import HeightMap, require_full
from .preparation.filtering import crop
from .preparation.resampling import resample

__all__ = ["composite"]

_SAME = 1e-6
"""Relative difference below which two lengths of a map are one."""


def composite(a: HeightMap, b: HeightMap) -> HeightMap:
    """Heights of two rough surfaces that face each other, as one map against a flat.

    Parameters
    ----------
    a
        The lower surface, without missing points.
    b
        The upper surface as it was measured, heights out of its own solid, without missing points.
        It is turned over about the y axis: its columns run backwards, its heights point towards a.

    Returns
    -------
    HeightMap
        Heights a + mirrored b on the finer pixels of both (axis by axis), with the history of both.
        Two periodic maps of one size give a periodic map. Others are laid corner to corner, a's
        first pixel below b's last of the first row, and cropped to the overlap: not periodic.

    Raises
    ------
    SurfaceError
        If points are missing, the pixel sizes cannot be of one unit, or too little overlaps.

    Notes
    -----
    The gap between two surfaces is the separation of their mean planes less the sum of the heights
    that face each other, so both press as this sum and a flat do, with the composite modulus of
    `asperity.HalfSpace.pair`. The coarser map is moved to the finer pixels by its spectrum
    (`resample`); where these do not divide its length, its points lie off by up to half a pixel.

    Examples
    --------
    >>> import surfaces
    >>> a, b = (
    ...     surfaces.self_affine((32, 48), (32e-6, 48e-6), rms_slope=0.1, hurst=0.8, seed=seed)
    ...     for seed in (1, 2)
    ... )
    >>> both = surfaces.composite(a, b)
    >>> bool((both.heights == a.heights + b.heights[:, ::-1]).all()), both.periodic
    (True, True)
    """
    for hm in (a, b):
        require_full(hm, "a composite")
    ratio = np.divide(a.spacing, b.spacing)
    if max(ratio.max(), 1.0 / ratio.min()) > SLIMMEST_PIXEL:
        raise SurfaceError(
            f"pixels of {a.spacing[0]:g} m and {b.spacing[0]:g} m are not of one unit: "
            "give the sizes of both maps in m"
        )
    turned = b.replace(heights=b.heights[:, ::-1])
    spacing = tuple(min(pair) for pair in zip(a.spacing, b.spacing, strict=True))
    periodic = a.periodic and b.periodic and np.allclose(a.size, b.size, rtol=_SAME, atol=0.0)
    lower, upper = (
        hm if np.allclose(hm.spacing, spacing, rtol=_SAME, atol=0.0) else resample(hm, spacing)
        for hm in (a, turned)
    )
    if lower.shape != upper.shape or not periodic:
        ny, nx = (min(pair) for pair in zip(lower.shape, upper.shape, strict=True))
        lower, upper = (
            hm.replace(periodic=False) if hm.shape == (ny, nx) else crop(hm, (0, ny), (0, nx))
            for hm in (lower, upper)
        )
    step = {
        "step": "composite",
        "with": b.name,
        "turned": "about y",
        "shape": list(lower.shape),
        "history": [dict(done) for done in upper.history],
    }
    name = " on ".join(filter(None, (b.name, a.name)))
    heights = lower.heights + upper.heights
    return lower.replace(heights=heights, spacing=spacing, name=name, step=step)
