"""Waves near the pixel: how much of the slope they hold, and a grid that shows their summits.

Summits are found on pixels, and the surface between them is interpolated. Where waves of two to
four pixels hold much of the slope, summits are missed or come out too low, and so does the load.
"""

from __future__ import annotations

import numpy as np

from asperity.parameters import DEFAULTS
from asperity.parameters.constants import PixelWaves
from surfaces.heightmap import HeightMap
from surfaces.preparation.filtering import resample

__all__ = [
    "fineness",
    "random_waves",
    "refined_map",
    "resolution_warning",
]


def fineness(hm: HeightMap) -> float:
    """Share of the squared slope that is lost when heights are taken two pixels apart, not one.

    0 for a smooth map, 0.03 for a spectrum that ends at 8 pixels, 0.09 at 4, 0.14 at 3 and 0.2 to
    0.4 at the pixel, 0.75 for noise.

    Notes
    -----
    For differences d, d' of neighboring pairs, <(d - d')^2> = 4 <d^2> - <(d + d')^2>.
    """
    found = hm.roughness
    bend = np.asarray(found.curvature) * hm.spacing
    return float(bend @ bend) / (4.0 * found.rms_slope**2)


def random_waves(hm: HeightMap, waves: PixelWaves = DEFAULTS.pixel_waves) -> bool:
    """Whether the finest waves of a map are random: not with spikes, steps, worn plateaus, borders
    that fade, tops of one height.

    Notes
    -----
    Random waves are known by the kurtosis of their second differences.
    """
    return all(abs(value - 3.0) <= waves.kurtosis for value in hm.roughness.kurtosis)


def resolution_warning(hm: HeightMap, waves: PixelWaves = DEFAULTS.pixel_waves) -> list[str]:
    """What a map too coarse for its roughness leaves uncertain; empty where its pixels resolve it.

    Parameters
    ----------
    hm
        Height map without missing points.
    waves
        Which waves are near the pixel.
    """
    share = fineness(hm)
    if share < waves.to_the_pixel:
        return []
    return [
        "the map is too coarse for its roughness: between one pixel and two "
        f"{100 * share:.0f} % of the squared slope is lost, so that contact area and number of "
        "spots depend on the pixel size"
    ]


def refined_map(hm: HeightMap, waves: PixelWaves = DEFAULTS.pixel_waves) -> HeightMap | str | None:
    """A map whose finest waves are near the pixel on more points, by its own spectrum.

    Parameters
    ----------
    hm
        Height map without missing points.
    waves
        Which waves are near the pixel.

    Returns
    -------
    The map on the finer grid; why it was left where a finer one would take too long; None if its
    own grid holds it.
    """
    if fineness(hm) < waves.to_the_pixel:
        return None
    for ratio, most in waves.finer:
        if ratio**2 * hm.heights.size <= most:
            return resample(hm, np.asarray(hm.spacing) / ratio)
    return "a finer one would hold the waves near its pixels better, but takes long"
