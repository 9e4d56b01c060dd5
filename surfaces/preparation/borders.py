"""Maps made periodic: mirrored, tapered, smoothed, or wrapped as they are."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy import fft

from surfaces.arrays import Array
from surfaces.errors import InputError, SurfaceError, as_choice, as_number
from surfaces.heightmap import HeightMap, require_full
from surfaces.numerics.stored_array import Source, windows

from .filtering import passed

__all__ = ["make_periodic"]

PERIODIC = ("mirror", "taper", "smooth", "wrap")

STEEPNESS = 1.0 / 3.0
"""Slope of the taper: rms height over the width of the faded strip, over the rms slope of the map.
"""

WIDEST_FADE = 0.1
"""Largest width of the faded strip, over the shorter side of the map."""

NARROWEST_FADE = 2.0
"""Least width of the faded strip [pixels]: along one pixel heights fade by half only."""


def make_periodic(hm: HeightMap, how: str, *, width: float | None = None) -> HeightMap:
    """Turn a measured map into one period of an endless surface, and state what that costs.

    Parameters
    ----------
    hm
        The map, levelled and without missing points.
    how
        ``mirror``: the map and its mirror images, twice as long on each side; no height is
        changed. ``taper``: heights fade to their mean within `width` of the border. ``smooth``: a
        smooth surface that carries the steps across the seam is taken off (Moisan 2011): no strip
        is lost, and slopes inside hardly change. ``wrap``: the map as it is, with a cliff where its
        sides do not meet.
    width
        Width of the faded strip [m] of ``taper``. By default the fade is a third as steep as the
        map, by rms height and slope, over a tenth of the shorter side at most, but two pixels: what
        fades lies too low, and touches otherwise than the surface does.

    Returns
    -------
    HeightMap
        History step ``periodic`` with the rms step across the seam and inside the map [m]
        (``seam_step``, ``inner_step``), the rms heights before and after, and the fraction of the
        area that was changed.

    Raises
    ------
    InputError
        If points are missing, `how` is unknown, the strip is narrower than two pixels or wider than
        half the map, or a width is given for what does not fade.

    Examples
    --------
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> part = surfaces.crop(hm, (0, 16), (8, 40))
    >>> surfaces.make_periodic(part, "mirror")
    <HeightMap 32 x 64, pixel 1e-06 x 1e-06 m, periodic>
    """
    as_choice("periodic", how, PERIODIC)
    if width is not None and how != "taper":
        raise InputError(f"width is {width}, and only taper fades a strip; leave it out")
    require_full(hm, "a periodic map")
    made, changed = hm, 0.0
    step: dict[str, object] = {"step": "periodic", "how": how, "rms_before": hm.rms_height}
    if how == "mirror":
        made = hm.with_rows(_mirrored(hm.source), (2 * hm.shape[0], 2 * hm.shape[1]))
    elif how == "taper":
        strip = _gentle(hm) if width is None else as_number("width", width)
        least = NARROWEST_FADE * max(hm.spacing)
        if width is not None and not least <= strip <= 0.5 * min(hm.size):
            raise SurfaceError(
                f"the tapered strip is {strip:g} m wide; it must be at least {NARROWEST_FADE:g} "
                f"pixels, {least:g} m, and at most half of {min(hm.size):g} m"
            )
        strips = [
            max(strip, min(NARROWEST_FADE * step, 0.5 * length))
            for step, length in zip(hm.spacing, hm.size, strict=True)
        ]
        across = _window(hm.y, hm.size[0], strips[0])
        along = _window(hm.x, hm.size[1], strips[1])
        mean = hm.roughness.mean
        made = hm.with_rows(
            (begin, mean + (rows - mean) * (across[begin:end, None] * along))
            for begin, end, rows in windows(hm.source)
        )
        kept = np.count_nonzero(across == 1.0) * np.count_nonzero(along == 1.0)
        changed = float(hm.source.size - kept) / hm.source.size
        step["width"] = max(strips)
    elif how == "smooth":
        carrier = _seam_carrier(hm.source)
        made = hm.with_rows(
            (begin, rows - carrier[begin:end]) for begin, end, rows in windows(hm.source)
        )
        changed = 1.0
    seam, inner = _steps(made)
    step |= {
        "rms_after": made.rms_height,
        "seam_step": seam,
        "inner_step": inner,
        "area_changed": changed,
    }
    return made.replace(periodic=True, step=step)


def _mirrored(source: Source) -> Iterator[tuple[int, Array]]:
    """Blocks of rows of an array and its mirror images."""
    for begin, end, rows in windows(source):
        rows = np.hstack([rows, rows[:, ::-1]])
        yield begin, rows
        yield 2 * source.shape[0] - end, rows[::-1]


def _steps(hm: HeightMap) -> tuple[float, float]:
    """Rms steps [m] across the seam of a map, and between the neighbors inside it."""
    (ny, nx), source = hm.shape, hm.source
    ends = np.concatenate([source[0] - source[-1], source[:, 0] - source[:, -1]])
    inside = np.square(np.multiply(hm.roughness.slope, hm.spacing))
    count = (ny - 1) * nx, ny * (nx - 1)
    return math.sqrt(np.mean(np.square(ends))), math.sqrt(np.average(inside, weights=count))


def _seam_carrier(source: Source) -> Source:
    """The smoothest surface whose steps across the seam are those of the map.

    Notes
    -----
    Its discrete Laplacian is that of the steps alone, of a period, and its mean is zero (Moisan
    2011, Periodic plus smooth image decomposition, eqs. 10 and 11).
    """
    (ny, nx), down, across = source.shape, source[-1] - source[0], source[:, -1] - source[:, 0]

    def steps() -> Iterator[tuple[int, Array]]:
        for begin, end, _ in windows(source):
            rows = np.zeros((end - begin, nx))
            if begin == 0:
                rows[0] += down
            if end == ny:
                rows[-1] -= down
            rows[:, 0] += across[begin:end]
            rows[:, -1] -= across[begin:end]
            yield begin, rows

    along_y, along_x = np.cos(2 * np.pi * fft.fftfreq(ny)), np.cos(2 * np.pi * fft.rfftfreq(nx))

    def share(columns: slice) -> Array:
        laplacian = 2.0 * (along_y[:, None] + along_x[columns]) - 4.0
        if columns.start == 0:
            laplacian[0, 0] = np.inf
        return np.asarray(1.0 / laplacian)

    return passed(steps(), source, True, share)


def _gentle(hm: HeightMap) -> float:
    """Width [m] of a strip in which heights fade, see `make_periodic`."""
    steepest = STEEPNESS * hm.roughness.rms_slope
    width = hm.rms_height / max(steepest, np.finfo(float).tiny)
    return min(width, WIDEST_FADE * min(hm.size))


def _window(places: Array, length: float, strip: float) -> Array:
    """Raised cosine: 0 at the border, 1 from `strip` inwards."""
    inward = np.minimum(places, length - places)
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.minimum(inward / strip, 1.0)))
