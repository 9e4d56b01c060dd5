"""Resolution: the uncertainty by the pixels of a map, however exactly its grid is solved."""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from asperity.bem.curve import SolvedLoad, bem_curve
from asperity.bem.memory import fits
from asperity.halfspace.load_points import Boundary, closed_share
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
    "Resolution",
    "SolvedLoads",
    "between_grids",
    "narrow_share",
    "opened_share",
    "resolution",
    "two_grids",
]

Array = NDArray[np.float64]

FITTED = DEFAULTS.pixel_uncertainty

ACCURACY = 0.05
"""Accuracy in area of the solutions on both grids."""

CURE = (
    "the pixels of the map leave {} open: take out the waves below a length that matters "
    "(bandpass), or measure on a finer grid"
)


@dataclass(frozen=True)
class Resolution:
    """Uncertainty by the pixels of a map, however exactly its grid is solved.

    Attributes
    ----------
    load, area
        Relative uncertainty of the load at equal separation and of the area at equal load [-]; NaN
        if a finer grid would be needed, but does not fit into memory or does not converge.
    told_by
        How it was found, in one sentence.
    warnings
        What to do, if it is large.
    """

    load: float
    area: float
    told_by: str
    warnings: tuple[str, ...] = ()


UNTOLD = Resolution(float("nan"), float("nan"), "nothing was solved by boundary elements")
"""Resolution of a curve without boundary elements."""


class SolvedLoads:
    """Progress function of boundary elements that keeps what resolution needs of the load points.

    Calls `progress` with every point; calls from several threads follow each other.

    Attributes
    ----------
    lightest
        The lightest load point under load; None before any.
    most_opened
        The load point of the largest `opened_share`, of equal ones the lightest; None before any
        opens.
    """

    def __init__(
        self,
        material: HalfSpace,
        boundary: Boundary,
        progress: Callable[[SolvedLoad], object] | None = None,
    ) -> None:
        self.material, self.periodic, self.progress = material, boundary == "periodic", progress
        self.lightest: SolvedLoad | None = None
        self.most_opened: SolvedLoad | None = None
        self._rank = 0.0, 0.0
        self._turn = threading.Lock()

    def __call__(self, point: SolvedLoad) -> None:
        with self._turn:
            if self.progress is not None:
                self.progress(point)
            if point.mean_pressure <= 0.0:
                return
            share = opened_share(point, self.material, periodic=self.periodic)
            rank = share, -point.mean_pressure
            if rank > self._rank:
                self._rank, self.most_opened = rank, point
            if self.lightest is None or point.mean_pressure < self.lightest.mean_pressure:
                self.lightest = point

    @property
    def opened(self) -> float:
        """Largest `opened_share` of a load point; zero before any opens."""
        return self._rank[0]


def narrow_share(contact: NDArray[np.bool_], *, periodic: bool) -> float:
    """Share of the contact area in narrow contacts (`PixelUncertainty`); their pixels meet at
    edges."""
    labels, count = label_patches(contact, periodic=periodic, corners=False)
    row, column = np.nonzero(contact)
    own = labels[row, column]
    pixels, perimeter = np.bincount(own, minlength=count + 1), np.zeros(count + 1, np.int64)
    # the border of a free map is no edge of a contact that it cuts
    over_border: Literal["wrap", "clip"] = "wrap" if periodic else "clip"
    for down, across in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        beside = np.ravel_multi_index((row + down, column + across), contact.shape, over_border)
        perimeter += np.bincount(own[~contact.take(beside)], minlength=count + 1)
    return float(pixels[4 * pixels < FITTED.narrow * perimeter].sum() / max(pixels.sum(), 1))


def opened_share(point: SolvedLoad, material: HalfSpace, *, periodic: bool) -> float:
    """Share of the contact at a load point that waves too short for the pixels are expected to
    open.

    Notes
    -----
    Taking heights two pixels apart in place of one loses the squared slope (second difference over
    2 dx)^2 along each axis (`checks.fineness`), here its mean over the contact: what touches may be
    rougher than the map. The contact pressure closes waves of this slope like random roughness
    (`closed_share`). A graded body resists waves of two pixels with E_m* (dx/pi)^m.
    """
    hm, place, resisted = point.hm, np.nonzero(point.contact), 0.0
    for axis, (length, spacing) in enumerate(zip(hm.shape, hm.spacing, strict=True)):
        # at the border of a free map the bend of the line beside it is taken
        middle = place[axis] if periodic else np.clip(place[axis], 1, max(length - 2, 0))
        three = (middle + np.array([[-1], [0], [1]])) % length
        beside = place[1 - axis]
        lower, at, upper = hm.heights[(three, beside) if axis == 0 else (beside, three)]
        slope = (lower - 2.0 * at + upper) / (2.0 * spacing)
        modulus = material.modulus * (spacing / math.pi) ** material.m
        resisted += modulus**2 * float(np.mean(slope**2))
    pressure = point.mean_pressure / float(point.contact.mean())
    return 1.0 - closed_share(pressure / math.sqrt(resisted)) if resisted > 0.0 else 0.0


def resolution(
    hm: HeightMap, material: HalfSpace, boundary: Boundary, solved: SolvedLoads, heaviest: float
) -> Resolution:
    """Resolution of a curve from the lightest of the `solved` loads to its `heaviest` mean pressure
    [Pa].

    One to three of its loads are solved on a grid twice as fine. No finer grid is solved if the
    waves of the map end well above its pixels, where it touches, too, and few contacts are narrow:
    the least uncertainty is stated.
    """
    point, opened = solved.lightest, solved.opened
    if point is None:
        return Resolution(0.0, 0.0, "nothing touches")
    share = narrow_share(point.contact, periodic=solved.periodic)
    held = (
        f"contacts narrower than {FITTED.narrow:g} pixels hold {share:.0%} of the lightest "
        f"contact, waves of less than two pixels would open {opened:.0%} of a contact"
    )
    least = DEFAULTS.pixel_waves.to_the_pixel
    broken = resolution_warning(hm, least) + seam_warning(hm) + straight_warning(hm)
    if share < FITTED.doubtful and opened <= FITTED.floor[1] and not broken:
        return Resolution(*FITTED.floor, held)
    grids = two_grids(point.hm, boundary)
    if grids is None:
        return _unknown(f"{held}, and a finer grid does not fit into memory")
    # the heaviest load is left out: it takes longest and differs least
    # (docs/development/verification.md)
    light, odd = (_on_part(each) for each in (point, solved.most_opened or point))
    heaviest = max(heaviest, point.mean_pressure)
    loads = np.unique([light, odd, math.sqrt(min(light, heaviest) * heaviest)])
    apart = np.abs(between_grids(*grids, material, boundary, loads, ACCURACY)).max(axis=1)
    load, area = np.maximum(FITTED.floor, FITTED.safety * apart).tolist()
    if math.isnan(load + area):
        return _unknown(f"{held}, and a load on a grid twice as fine did not converge")
    shares = (f"{x:.0%}" if x < 1 else "all" for x in (load, area))
    warning = CURE.format("{} of the load and {} of the contact area".format(*shares))
    ny, nx = grids[0].shape
    where = "the map" if (ny, nx) == hm.shape else f"a part of {ny} x {nx} points"
    told = f"{held}; {len(loads)} loads solved on a grid twice as fine as that of {where}"
    large = load > FITTED.large[0] or area > FITTED.large[1]
    return Resolution(load, area, told, (warning,) if large else ())


def _unknown(told_by: str) -> Resolution:
    """Resolution where a finer grid was needed and not solved."""
    return Resolution(np.nan, np.nan, told_by, (CURE.format("an unknown part"),))


def between_grids(
    hm: HeightMap,
    finer: HeightMap,
    material: HalfSpace,
    boundary: Boundary,
    pressures: Array,
    accuracy: float,
) -> Array:
    """Logarithms of the load at equal separation and of the contact area at equal load on a map,
    over those on a finer grid, at n mean pressures [Pa], shape (2, n); NaN where not converged.

    Both are solved to an `accuracy` in load and area. In full contact, where the stiffness is
    infinite, the loads count as equal.
    """

    def solved(scene: tuple[HeightMap, float]) -> Array:
        """Separation, logarithm of the contact area, and stiffness over mean pressure."""
        grid, pressure = scene
        curve = bem_curve(grid, material, pressures=pressure, accuracy=accuracy, boundary=boundary)
        stiffness = np.where(np.isinf(curve.stiffness), 0.0, curve.stiffness)
        rate = stiffness / curve.mean_pressure
        found = np.concatenate([curve.separation, np.log(curve.contact_area), rate])
        return np.where(curve.converged, found, np.nan)

    pressures = np.minimum(pressures, material.hardness)  # by rounding solved ones may exceed it
    scenes = list(itertools.product((hm, finer), pressures))
    rows = parallel.apart(solved, scenes)
    (own, own_area, rate), (fine, fine_area, _) = np.reshape(rows, (2, -1, 3)).transpose(0, 2, 1)
    return np.array([rate * (own - fine), own_area - fine_area])


def _on_part(point: SolvedLoad) -> float:
    """Mean pressure [Pa] on the part of `two_grids` at a load point of the map: by its contact
    area, since contacts are under equal pressure, and no less than that on the map."""
    window = _window(point.hm)
    if window is None:
        return point.mean_pressure
    share = point.contact[window].mean() / point.contact.mean()
    return point.mean_pressure * max(float(share), 1.0)


def _window(hm: HeightMap) -> tuple[slice, slice] | None:
    """Rows and columns of the part of a large map about its highest point; None if the whole map is
    to be refined."""
    tile = FITTED.tile
    if max(hm.shape) <= FITTED.whole:
        return None
    start = [
        int(np.clip(at - tile // 2, 0, max(n - tile, 0)))
        for at, n in zip(hm.roughness.summit, hm.shape, strict=True)
    ]
    rows, columns = (slice(at, min(at + tile, n)) for at, n in zip(start, hm.shape, strict=True))
    return rows, columns


def two_grids(hm: HeightMap, boundary: Boundary) -> tuple[HeightMap, HeightMap] | None:
    """The map, or the part of a large map about its highest point, tapered if periodic; and the
    same on a grid twice as fine. None if boundary elements on that do not fit into memory."""
    part, window = hm, _window(hm)
    if window is not None:
        part = hm.cut(*((side.start, side.stop) for side in window))
        part = make_periodic(part, "taper") if hm.periodic else part
    finer = resample(part, np.asarray(part.spacing) / 2)
    return (part, finer) if fits(finer.shape, boundary, 1) else None
