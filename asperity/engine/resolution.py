"""What the pixels of a map leave open, whatever is solved on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asperity.bem.curve import SolvedLoad, bem_curve
from asperity.bem.memory import fits
from asperity.halfspace.boundary import Boundary
from asperity.halfspace.material import HalfSpace
from surfaces.heightmap import HeightMap
from surfaces.patches import label_patches
from surfaces.preparation.filtering import resample

__all__ = ["LightestLoad", "Resolution", "resolution", "small_share"]

FEW_PIXELS = 10
"""Pixels of a contact below which its area and its load depend on the grid."""

DOUBTFUL = 0.5
"""Share of the contact area in such contacts from which on a refined grid is solved."""

FLOOR = 0.02, 0.05
"""Least uncertainty of load and area that is stated."""

LARGE = 0.05, 0.15
"""Uncertainty of load and area that is warned of."""

CURE = (
    "the waves of the map reach its pixels, which leaves open {}: take out the waves below a "
    "length that matters (bandpass), or measure on a finer grid"
)

SAFETY = 1.5
"""Uncertainty stated over the difference that was found at one load."""


@dataclass(frozen=True)
class Resolution:
    """Uncertainty that stays however exactly the map is solved.

    Attributes
    ----------
    load, area
        Relative uncertainty of the load at equal separation and of the area at equal load [-]; NaN
        if a finer grid would be needed to tell and does not fit into memory.
    told_by
        One sentence.
    warnings
        What to do about it, where it is large.
    """

    load: float
    area: float
    told_by: str
    warnings: tuple[str, ...] = ()


class LightestLoad:
    """Keeps the lightest load point that boundary elements solve, and calls `progress` of each."""

    def __init__(self, progress: Callable[[SolvedLoad], object] | None = None) -> None:
        self.progress = progress
        self.point: SolvedLoad | None = None

    def __call__(self, point: SolvedLoad) -> None:
        if self.progress is not None:
            self.progress(point)
        lightest = self.point is None or point.mean_pressure < self.point.mean_pressure
        if lightest and point.mean_pressure > 0.0:
            self.point = point


def small_share(contact: NDArray[np.bool_], *, periodic: bool) -> float:
    """Share of the contact area in contacts of fewer than ten pixels."""
    labels, _ = label_patches(contact, periodic=periodic)
    pixels = np.bincount(labels[contact])
    return float(pixels[pixels < FEW_PIXELS].sum() / max(pixels.sum(), 1))


def resolution(
    hm: HeightMap, material: HalfSpace, boundary: Boundary, lightest: LightestLoad
) -> Resolution:
    """What the pixels leave open of a curve, by its lightest load on a grid twice as fine."""
    point = lightest.point
    if point is None:
        return Resolution(0.0, 0.0, "nothing touches")
    share = small_share(point.contact, periodic=boundary == "periodic")
    held = f"contacts of fewer than {FEW_PIXELS} pixels hold {share:.0%} of the lightest contact"
    if share < DOUBTFUL:
        return Resolution(*FLOOR, held)
    ny, nx = hm.shape
    if not fits((2 * ny, 2 * nx), boundary, 1):
        why = f"{held}, and a finer grid does not fit into memory"
        return Resolution(np.nan, np.nan, why, (CURE.format("an unknown part"),))
    finer = resample(hm, np.asarray(hm.spacing) / 2)
    found = bem_curve(
        finer, material, pressures=[point.mean_pressure], accuracy=FLOOR[0], boundary=boundary
    )
    columns = point.columns
    rate = columns["load"] / columns["elastic_energy"]
    load = abs(rate * (columns["separation"] - float(found.separation[0])))
    area = abs(np.log(columns["contact_area"] / float(found.contact_area[0])))
    load, area = (max(SAFETY * x, least) for x, least in zip((load, area), FLOOR, strict=True))
    warnings = (CURE.format(f"{load:.0%} of the load and {area:.0%} of the area"),)
    return Resolution(
        load,
        area,
        f"{held}: solved on a grid twice as fine",
        warnings if load > LARGE[0] or area > LARGE[1] else (),
    )
