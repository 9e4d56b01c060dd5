"""Resolution: the uncertainty by the pixels of a map, however exactly its grid is solved."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from asperity.bem.answer import answer
from asperity.bem.curve import SolvedLoad
from asperity.bem.load_path import LoadPath
from asperity.bem.problem import ContactProblem
from asperity.halfspace.material import HalfSpace
from asperity.halfspace.scene import COARSE, Boundary, closed_share
from asperity.parameters import ENGINE
from surfaces.arrays import Array, Mask
from surfaces.checks import resolution_warning, seam_warning, straight_warning
from surfaces.heightmap import HeightMap
from surfaces.numerics import parallel
from surfaces.patches import label_patches
from surfaces.preparation.resampling import resample

__all__ = [
    "UNTOLD",
    "Resolution",
    "SolvedLoads",
    "between_grids",
    "narrow_share",
    "opened_share",
    "resolution",
]


PIXELS = ENGINE.pixel_uncertainty

ACCURACY = 0.05
"""Accuracy in load and area of the solution on the finer grid."""

FIRST_TOLERANCE = 1e-3
"""Tolerance that a load on the finer grid is solved to first: most are then within `ACCURACY`."""

NO_MAP = np.zeros((0, 0), np.bool_)

SAMPLE = 2**14
"""Points of a contact whose slope is looked at: its mean square is off by a percent."""

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
        if a finer grid would be needed, but does not converge.
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
    """Progress function of boundary elements that keeps what resolution needs of the load points,
    without their contact maps.

    Calls `progress` with every point; calls from several threads follow each other.

    Parameters
    ----------
    kind, values
        "pressure" or "separation", and the load points asked for, sorted.

    Attributes
    ----------
    best
        The load points kept, each with the rank that it is the least of: "lightest" (of those under
        load), "middle" (nearest to the middle one of those asked for), and "most opened" (of the
        largest `opened_share`, of equal ones the lightest).
    """

    def __init__(
        self,
        material: HalfSpace,
        boundary: Boundary,
        kind: str,
        values: Array,
        progress: Callable[[SolvedLoad], object] | None = None,
    ) -> None:
        self.material, self.periodic, self.progress = material, boundary == "periodic", progress
        self.best: dict[str, tuple[tuple[float, ...], SolvedLoad]] = {}
        self._column = "mean_pressure" if kind == "pressure" else "separation"
        self._middle = float(values[len(values) // 2])
        self._turn = threading.Lock()

    def __call__(self, point: SolvedLoad) -> None:
        with self._turn:
            if self.progress is not None:
                self.progress(point)
            load = point.mean_pressure
            if load <= 0.0:
                return
            ranks = {
                "lightest": (load,),
                "middle": (abs(point.columns[self._column] - self._middle),),
                "most opened": (-opened_share(point, self.material, periodic=self.periodic), load),
            }
            point = replace(point, contact=NO_MAP)  # which may be large
            for name, rank in ranks.items():
                if name not in self.best or rank < self.best[name][0]:
                    self.best[name] = rank, point

    @property
    def lightest(self) -> SolvedLoad | None:
        """The lightest load point under load; None before any."""
        return self.best["lightest"][1] if self.best else None

    @property
    def opened(self) -> float:
        """Largest `opened_share` of a load point; zero before any opens."""
        return -self.best["most opened"][0][0] if self.best else 0.0

    @property
    def kept(self) -> list[SolvedLoad]:
        """The load points kept whose part bears load, each once."""
        found = {id(point): point for _, point in self.best.values() if point.part.pressure.any()}
        return [*found.values()]


def narrow_share(contact: Mask) -> float:
    """Share of the contact area of a part of a map in narrow contacts (`PixelUncertainty`), whose
    pixels meet at edges; the border of the part is no edge of a contact that it cuts."""
    own = label_patches(contact, periodic=False, corners=False)[0][contact]
    around = np.pad(contact, 1, mode="edge")
    beside = around[:-2, 1:-1], around[2:, 1:-1], around[1:-1, :-2], around[1:-1, 2:]
    edges = 4.0 - np.sum(beside, axis=0)[contact]
    pixels, perimeter = np.bincount(own), np.bincount(own, edges)
    return float(pixels[4 * pixels < PIXELS.narrow * perimeter].sum() / max(len(own), 1))


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
    hm, pressed, resisted = point.hm, np.flatnonzero(point.contact), 0.0
    pressure = point.mean_pressure * point.contact.size / pressed.size
    place = np.unravel_index(pressed[:: -(-pressed.size // SAMPLE)], hm.shape)
    for axis, (length, spacing) in enumerate(zip(hm.shape, hm.spacing, strict=True)):
        # at the border of a free map the bend of the line beside it is taken
        middle = place[axis] if periodic else np.clip(place[axis], 1, max(length - 2, 0))
        three = (middle + np.array([[-1], [0], [1]])) % length
        beside = place[1 - axis]
        lower, at, upper = hm.heights[(three, beside) if axis == 0 else (beside, three)]
        slope = (lower - 2.0 * at + upper) / (2.0 * spacing)
        modulus = material.modulus * (spacing / math.pi) ** material.m
        resisted += modulus**2 * float(np.mean(slope**2))
    return 1.0 - closed_share(pressure / math.sqrt(resisted)) if resisted > 0.0 else 0.0


def resolution(hm: HeightMap, solved: SolvedLoads) -> Resolution:
    """Resolution of a curve from some of its `solved` loads.

    About the highest point, one to three of them are solved on a grid twice as fine, too. None is
    if the waves of the map end well above its pixels, where it touches, too, and few contacts there
    are narrow: the least uncertainty is stated.
    """
    point, opened = solved.lightest, solved.opened
    if point is None:
        return Resolution(0.0, 0.0, "nothing touches")
    share = narrow_share(point.part.pressure > 0.0)
    held = (
        f"contacts narrower than {PIXELS.narrow:g} pixels hold {share:.0%} of the lightest "
        f"contact, waves of less than two pixels would open {opened:.0%} of a contact"
    )
    broken = resolution_warning(hm, COARSE) + seam_warning(hm) + straight_warning(hm)
    if share < PIXELS.doubtful and opened <= PIXELS.floor[1] and not broken:
        return Resolution(*PIXELS.floor, held)
    apart = np.abs(between_grids(solved.kept, ACCURACY)).max(axis=1, initial=0.0)
    load, area = np.maximum(PIXELS.floor, PIXELS.safety * apart).tolist()
    if math.isnan(load + area):
        why = f"{held}, and a load on a grid twice as fine did not converge"
        return Resolution(np.nan, np.nan, why, (CURE.format("an unknown part"),))
    shares = (f"{x:.0%}" if x < 1 else "all" for x in (load, area))
    warning = CURE.format("{} of the load and {} of the contact area".format(*shares))
    ny, nx = point.part.hm.shape
    where = f"of {ny} x {nx} points about the highest one"
    told = f"{held}; {len(solved.kept)} loads solved on a grid twice as fine as that {where}"
    large = load > PIXELS.large[0] or area > PIXELS.large[1]
    return Resolution(load, area, told, (warning,) if large else ())


def between_grids(points: Sequence[SolvedLoad], accuracy: float) -> Array:
    """Logarithms of the load at equal separation and of the contact area at equal load about the
    highest point of a map, over those on a grid twice as fine, at n solved loads, shape (2, n); NaN
    where not converged.

    The part is pressed as on the map (`SolvedPart.alone`), and the finer grid is solved to an
    `accuracy` in load and area. In full contact, where the stiffness is infinite, the loads count
    as equal.
    """

    def finer(point: SolvedLoad) -> Array:
        """Both logarithms at one load."""
        part, stiffness = point.part, point.columns["stiffness"]
        own = part.alone()
        # by rounding it may exceed the hardness
        pressure = min(float(part.pressure.mean()), part.material.hardness)
        fine = resample(own, np.asarray(own.spacing) / 2)
        problem = ContactProblem(
            fine, part.material, tolerance=FIRST_TOLERANCE, boundary="periodic"
        )
        start = part.pressure.repeat(2, axis=0).repeat(2, axis=1)
        path = LoadPath(problem, (accuracy, accuracy), start)
        found = answer(problem, path.solve("pressure", pressure))
        rate = 0.0 if math.isinf(stiffness) else stiffness / point.mean_pressure
        load = rate * (point.separation - own.roughness.mean - found["separation"])
        area = math.log(part.contact_area / found["contact_area"])
        return np.array([load, area]) if found["converged"] else np.full(2, np.nan)

    return np.reshape(parallel.apart(finer, points), (-1, 2)).T
