"""Waves near the pixel: how much of the slope they hold, and a grid that shows their summits.

Summits are found on pixels, and the surface between them is interpolated. Where waves of two to
four pixels hold much of the slope, summits are missed or come out too low, and so does the load.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from surfaces.heightmap import HeightMap
from surfaces.preparation.filtering import resample

__all__ = [
    "TO_THE_PIXEL",
    "fineness",
    "random_waves",
    "refined_map",
    "resolution_warning",
]

Array = NDArray[np.float64]

KURTOSIS = 0.25
"""How far the kurtosis of second differences may be from 3, that of random waves."""

TO_THE_PIXEL = 0.13
"""`fineness` from which on any map is solved on smaller pixels: on cut-off 3 pixels and shorter
(also measured maps: four of seven). All summits, seed 11, 256 x 320, H 0.8
and 0.5: load to 15 % of contact -5 to -13 -> -0.5 to -4 %; four measured maps (0.1 to 25 %): -2 to
-10 -> 0 to -5 %, area no worse. Below, on cut-off 4 pixels, steps and lay with noise, load rises by
1 % and more whatever its error was."""

FINER = ((2.0, 2**22), (1.5, 10**7))
"""Points of the finer grid per point of the map, along each axis, and how many it may have: twice
takes 2.5 times as long (1024 x 1024), 1.5 times 1.7 times, and mends two thirds as much."""


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


def random_waves(hm: HeightMap) -> bool:
    """Whether the finest waves of a map are random: not with spikes, steps, worn plateaus, borders
    that fade, tops of one height.

    Notes
    -----
    Random waves are known by the kurtosis of their second differences.
    """
    return all(abs(value - 3.0) <= KURTOSIS for value in hm.roughness.kurtosis)


def resolution_warning(hm: HeightMap) -> list[str]:
    """What a map too coarse for its roughness leaves uncertain; empty where its pixels resolve it.

    Parameters
    ----------
    hm
        Height map without missing points.
    """
    share = fineness(hm)
    if share < TO_THE_PIXEL:
        return []
    return [
        "the map is too coarse for its roughness: between one pixel and two "
        f"{100 * share:.0f} % of the squared slope is lost, so that contact area and number of "
        "spots depend on the pixel size"
    ]


def refined_map(hm: HeightMap) -> HeightMap | str | None:
    """A map whose finest waves are near the pixel on more points, by its own spectrum.

    Parameters
    ----------
    hm
        Height map without missing points.

    Returns
    -------
    The map on the finer grid; why it was left where a finer one would take too long; None if its
    own grid holds it.
    """
    if fineness(hm) < TO_THE_PIXEL:
        return None
    for ratio, most in FINER:
        if ratio**2 * hm.heights.size <= most:
            return resample(hm, np.asarray(hm.spacing) / ratio)
    return "a finer one would hold the waves near its pixels better, but takes long"
