"""What the pixels of a map leave open, whatever is solved on them."""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asperity.bem.curve import SolvedLoad, bem_curve
from asperity.bem.memory import fits
from asperity.halfspace.load_points import Boundary
from asperity.halfspace.material import HalfSpace
from asperity.parameters import DEFAULTS
from surfaces.checks import resolution_warning, seam_warning, straight_warning
from surfaces.heightmap import HeightMap
from surfaces.numerics import parallel
from surfaces.patches import label_patches
from surfaces.preparation.borders import make_periodic
from surfaces.preparation.resampling import resample

__all__ = [
    "UNTOLD",
    "LightestLoad",
    "Resolution",
    "narrow_share",
    "representative_part",
    "resolution",
]

Array = NDArray[np.float64]

NARROW = 3.0
"""Width of a contact [pixels], four times its area over its perimeter, below which its area and its
load depend on the grid: discs of ten pixels, and ridges of one pixel, however long."""

DOUBTFUL = 0.5
"""Share of the contact area in narrow contacts from which on finer grids are solved."""

TILE = 512
"""Points along the sides of the part of a map, about its highest point, that stands for it."""

SAFETY = 1.5
"""Uncertainty stated over the largest difference that was found."""

FLOOR = 0.02, 0.05
"""Least uncertainty of load and area that is stated."""

LARGE = 0.05, 0.15
"""Uncertainty of load and area that is warned of."""

ACCURACY = 0.05
"""Accuracy in area of the solutions that are compared."""

CURE = (
    "the pixels of the map leave {} open: take out the waves below a length that matters "
    "(bandpass), or measure on a finer grid"
)


@dataclass(frozen=True)
class Resolution:
    """Uncertainty that stays however exactly the map is solved.

    Attributes
    ----------
    load, area
        Relative uncertainty of the load at equal separation and of the area at equal load [-]; NaN
        if a finer grid would be needed to tell, and does not fit into memory or is not solved.
    told_by
        One sentence.
    warnings
        What to do about it, where it is large.
    """

    load: float
    area: float
    told_by: str
    warnings: tuple[str, ...] = ()


UNTOLD = Resolution(float("nan"), float("nan"), "nothing was solved by boundary elements")
"""Of a curve that nothing verifies."""


class LightestLoad:
    """Keeps the lightest load point that boundary elements solve; calls `progress` with each, one
    at a time, from whatever thread."""

    def __init__(self, progress: Callable[[SolvedLoad], object] | None = None) -> None:
        self.progress = progress
        self.point: SolvedLoad | None = None
        self._turn = threading.Lock()

    def __call__(self, point: SolvedLoad) -> None:
        with self._turn:
            if self.progress is not None:
                self.progress(point)
            lightest = self.point is None or point.mean_pressure < self.point.mean_pressure
            if lightest and point.mean_pressure > 0.0:
                self.point = point


def narrow_share(contact: NDArray[np.bool_], *, periodic: bool) -> float:
    """Share of the contact area in narrow patches; pixels of a patch meet at their edges."""
    labels, _ = label_patches(contact, periodic=periodic, corners=False)
    pixels = np.bincount(labels[contact])
    perimeter = np.zeros_like(pixels)
    # the border of a free map is no edge of a contact that it cuts
    around = np.pad(contact, 1, mode="wrap" if periodic else "edge")
    beside = around[:-2, 1:-1], around[2:, 1:-1], around[1:-1, :-2], around[1:-1, 2:]
    for other in beside:
        perimeter += np.bincount(labels[contact & ~other], minlength=len(pixels))
    return float(pixels[4 * pixels < NARROW * perimeter].sum() / max(pixels.sum(), 1))


def resolution(
    hm: HeightMap, material: HalfSpace, boundary: Boundary, lightest: LightestLoad, heaviest: float
) -> Resolution:
    """What the pixels leave open of a curve from its lightest load point to its heaviest mean
    pressure [Pa], by some of its loads on a grid twice as fine.

    Where the waves of a map end well above its pixels, and contacts hold many of them, no finer
    grid is needed to know that it would tell the same.
    """
    point = lightest.point
    if point is None:
        return Resolution(0.0, 0.0, "nothing touches")
    share = narrow_share(point.contact, periodic=boundary == "periodic")
    held = f"contacts narrower than {NARROW:g} pixels hold {share:.0%} of the lightest contact"
    least = DEFAULTS.pixel_waves.to_the_pixel
    broken = resolution_warning(hm, least) + seam_warning(hm) + straight_warning(hm)
    if share < DOUBTFUL and not broken:
        return Resolution(*FLOOR, held)
    part = representative_part(hm)
    finer = resample(part, np.asarray(part.spacing) / 2)
    if not fits(finer.shape, boundary, 1):
        return _unknown(f"{held}, and a finer grid does not fit into memory")
    # the heaviest takes longest and differs least (docs/development/verification.md)
    middle = math.sqrt(point.mean_pressure * max(heaviest, point.mean_pressure))
    loads = np.unique([point.mean_pressure, middle])
    loads = np.minimum(loads, material.hardness)  # which those found may exceed by rounding
    load, area = np.maximum(FLOOR, _apart(part, finer, material, boundary, loads)).tolist()
    if math.isnan(load + area):
        return _unknown(f"{held}, and a load on a grid twice as fine did not converge")
    shares = (f"{x:.0%}" if x < 1 else "all" for x in (load, area))
    warning = CURE.format("{} of the load and {} of the contact area".format(*shares))
    where = "of the map" if part is hm else f"of {TILE} x {TILE} points about its highest"
    told = f"{held}; {len(loads)} loads solved on a grid twice as fine {where}"
    large = load > LARGE[0] or area > LARGE[1]
    return Resolution(load, area, told, (warning,) if large else ())


def _unknown(told_by: str) -> Resolution:
    """What a finer grid would tell that is not solved."""
    return Resolution(np.nan, np.nan, told_by, (CURE.format("an unknown part"),))


def _apart(
    hm: HeightMap, finer: HeightMap, material: HalfSpace, boundary: Boundary, pressures: Array
) -> tuple[float, float]:
    """Uncertainty of load and area by some loads of a map and of the same on a finer grid."""

    def solved(scene: tuple[HeightMap, float]) -> Array:
        """Separation, logarithm of the contact area, and stiffness over load: zero in full contact,
        where no load changes the separation; NaN if not converged."""
        grid, pressure = scene
        curve = bem_curve(grid, material, pressures=pressure, accuracy=ACCURACY, boundary=boundary)
        stiffness = np.where(np.isinf(curve.stiffness), 0.0, curve.stiffness)
        rate = stiffness / curve.mean_pressure
        found = np.concatenate([curve.separation, np.log(curve.contact_area), rate])
        return np.where(curve.converged, found, np.nan)

    scenes = list(itertools.product((hm, finer), pressures))
    rows = parallel.apart(solved, scenes)
    (own, own_area, rate), (fine, fine_area, _) = np.reshape(rows, (2, -1, 3)).transpose(0, 2, 1)
    load, area = np.abs(rate * (own - fine)), np.abs(own_area - fine_area)
    return SAFETY * float(load.max()), SAFETY * float(area.max())


def representative_part(hm: HeightMap) -> HeightMap:
    """The map, or of a large one the part about its highest point, faded to a period."""
    if max(hm.shape) <= TILE:
        return hm
    start = [
        int(np.clip(at - TILE // 2, 0, max(n - TILE, 0)))
        for at, n in zip(hm.roughness.summit, hm.shape, strict=True)
    ]
    rows, columns = ((at, min(at + TILE, n)) for at, n in zip(start, hm.shape, strict=True))
    part = hm.cut(rows, columns)
    return make_periodic(part, "taper") if hm.periodic else part
