"""All constants that decide answers of the microcontact model and of the engines.

Each entry gives quantity and unit, effect, what it was fitted on, and its sensitivity: "25 %" is
the largest change of load and area on ten judged maps if the constant is a quarter larger or
smaller, where that is a tenth of a per cent or more (``benchmarks/sensitivity.py``,
docs/development/sensitivity.csv). Numerical tolerances are in the modules that use them.

Those of the model are a `Parameters`, which a plan holds (`make_plan`). Those by which `solve`
chooses an engine, verifies its answer and bounds it are in this module, and no plan changes them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from .corrections import (
    ContactShift,
    Corrections,
    ElongationBounds,
    JoinedPairs,
    PressedBasins,
    SharpTips,
    TiltedBasins,
)
from .model import (
    ErrorEstimate,
    LawChoice,
    Limits,
    PixelWaves,
    Segmentation,
    Spots,
    SubContact,
    WaveSplit,
)

__all__ = [
    "DEFAULTS",
    "ENGINE",
    "Anchors",
    "ContactShift",
    "Corrections",
    "ElongationBounds",
    "EngineConstants",
    "ErrorEstimate",
    "JoinedPairs",
    "LawChoice",
    "Limits",
    "Parameters",
    "Parts",
    "PixelUncertainty",
    "PixelWaves",
    "PressedBasins",
    "RunTimes",
    "Segmentation",
    "SharpTips",
    "Spots",
    "SubContact",
    "TiltedBasins",
    "WaveSplit",
]


@dataclass(frozen=True)
class Anchors:
    """Load points at which boundary elements correct and bound a curve of the model
    (docs/development/verification.md).

    Attributes
    ----------
    least_loads
        Least number of load points for which the model is used.
    first
        Number of anchors to begin with: on random waves; on other maps, whose misfit varies less
        evenly.
    loads_each
        Number of successive load points that boundary elements solve in the time of one anchor,
        which is solved more accurately, and without a neighbor to start from.
    judge_share
        Error [-] of boundary elements at anchors, over the accuracy asked for.
    prior_share
        Shares [-] of the a-priori estimates of load and area that bound the misfit between anchors,
        if the estimates held at all anchors.
    yielded_share
        Increase of these shares [-], times the plastic share: the load on contacts at the hardness
        depends on the heights of single summits, so that the misfit does not vary slowly.
    unknown
        A-priori estimates of load and area [-] used where the model states none.
    """

    least_loads: int = 5
    first: tuple[int, int] = (3, 5)
    loads_each: int = 4
    judge_share: float = 0.15
    prior_share: tuple[float, float] = (0.5, 1.0 / 3.0)
    yielded_share: tuple[float, float] = (1.0, 0.0)
    unknown: tuple[float, float] = (0.05, 0.15)


@dataclass(frozen=True)
class Parts:
    """Parts of a large map on which boundary elements check the model
    (docs/development/verification.md).

    Attributes
    ----------
    least_points
        Least points along the shorter side of a map that is checked on parts.
    longest_lay
        Largest slope across over that along a lay [-], so that contacts stay within parts.
    coarse
        Least rms height of the waves that have contacts, over that of all [-] (white noise 0.6,
        Hurst exponents above 0 more than 0.9).
    side, points, grid_points
        Least number of parts along each side; a larger map has more, with at least `points` of the
        map and `grid_points` of the grid of the plan along the shorter side of a part.
    first
        Number of parts solved at each load before the bounds are looked at: two tell little of
        their scatter.
    loads, judge_share
        Number of load points at which parts are solved; error of the area there, over the accuracy
        [-].
    least_load, heaviest
        Range of the mean pressure on a part that is solved [-]: the least over that of the map at
        this load point, the largest over that of the map at its heaviest load point.
    cover
        Least load on the solved parts, over the load that one row of parts would carry if all
        carried alike [-]: with less the parts do not bound the misfit.
    long_waves, part
        Share [-] of the mean square height in waves longer than half a part above which these waves
        are solved on the whole map. Part of the correction, and of the change of the load by the
        other waves, that may be wrong [-] (root of the squares with the floor).
    floor, alike, few
        Bounds of load and area [-], added to the standard error of the mean, over `alike` parts of
        equal load. For r times fewer parts their squares are (1 + r^`few`)/2 times as large [-].
    spare, enough
        Least accuracy over the floor for which parts are tried; bounds over the accuracy at which
        no more parts are solved [-].
    """

    least_points: int = 1536
    longest_lay: float = 3.0
    coarse: float = 0.87
    side: int = 4
    points: int = 512
    grid_points: int = 75
    first: int = 3
    loads: int = 4
    judge_share: float = 0.05
    least_load: float = 0.02
    heaviest: float = 4.0
    cover: float = 0.4
    long_waves: float = 1.0 / 3.0
    part: float = 0.1
    floor: tuple[float, float] = (0.02, 0.04)
    alike: int = 4
    few: float = 2.0
    spare: float = 1.5
    enough: float = 0.75


@dataclass(frozen=True)
class PixelUncertainty:
    """What the pixels of a map leave open, by some loads on a grid twice as fine
    (docs/development/verification.md).

    Attributes
    ----------
    narrow
        Width of a contact [pixels], four times its area over its perimeter, below which it is
        narrow: its area and load depend on the grid. Discs of ten pixels are narrow, and ridges of
        one pixel.
    doubtful
        Least share [-] of the contact area in narrow contacts for which a finer grid is solved.
    safety
        Stated uncertainty over the largest difference between both grids [-].
    floor
        Least stated uncertainty of load and area [-].
    large
        Uncertainty of load and area above which a warning is given [-].
    """

    narrow: float = 3.0
    doubtful: float = 0.5
    safety: float = 2.0
    floor: tuple[float, float] = (0.02, 0.05)
    large: tuple[float, float] = (0.05, 0.15)


@dataclass(frozen=True)
class RunTimes:
    """Forecast of run times, from which the engine is chosen; only their ratios decide (measured on
    two cores, docs/development/verification.md).

    Attributes
    ----------
    model
        Seconds of a curve of the model: constant part, and part per peak that may touch.
    bem
        Seconds of boundary elements: constant part; per point of a map of 512 x 512, that of a
        curve over the square root of its number of loads; that of one load without a neighbor to
        start from.
    growth
        The seconds per point grow with this power [-] of the number of points over 512 x 512.
    fine
        Peaks per point of the map [-] at which these seconds are twice those of a smooth map: many
        small contacts take more steps. Found on random waves of 512 x 512 to 2048 x 2048 points,
        H 0.3 to 0.95, with and without roll-off and cut-off (seeds 61 and 71; within a quarter).
    free, yielded
        Factors [-] on these seconds: without periodicity, where transforms have four times the
        points; and with a hardness, where loads take more steps and the unloading stiffness is
        solved too.
    anchors
        Expected number of anchors.
    parts, beside
        For the engine "sampled": number of parts expected to be solved by boundary elements, over
        the number of parts along a side [-]; seconds besides these and the curve of the model
        (models of the parts, one load on the whole map).
    worth
        An engine that uses the model is chosen if its forecast is less than this share [-] of that
        of boundary elements: on surfaces that the model describes badly the time of both is spent.
    """

    model: tuple[float, float] = (0.06, 3e-5)
    bem: tuple[float, float, float] = (0.03, 2.0e-7, 1.3e-7)
    growth: float = 0.2
    fine: float = 0.055
    free: float = 2.0
    yielded: float = 1.5
    anchors: int = 4
    parts: float = 1.5
    beside: float = 1.2
    worth: float = 0.75


@dataclass(frozen=True)
class EngineConstants:
    """All constants of the engines, in groups."""

    anchors: Anchors = field(default_factory=Anchors)
    parts: Parts = field(default_factory=Parts)
    run_times: RunTimes = field(default_factory=RunTimes)
    pixel_uncertainty: PixelUncertainty = field(default_factory=PixelUncertainty)


@dataclass(frozen=True)
class Parameters:
    """All constants of the model, in groups."""

    segmentation: Segmentation = field(default_factory=Segmentation)
    pixel_waves: PixelWaves = field(default_factory=PixelWaves)
    wave_split: WaveSplit = field(default_factory=WaveSplit)
    sub_contact: SubContact = field(default_factory=SubContact)
    contact_shift: ContactShift = field(default_factory=ContactShift)
    elongation: ElongationBounds = field(default_factory=ElongationBounds)
    pressed_basins: PressedBasins = field(default_factory=PressedBasins)
    joined_pairs: JoinedPairs = field(default_factory=JoinedPairs)
    tilted_basins: TiltedBasins = field(default_factory=TiltedBasins)
    sharp_tips: SharpTips = field(default_factory=SharpTips)
    spots: Spots = field(default_factory=Spots)
    law_choice: LawChoice = field(default_factory=LawChoice)
    limits: Limits = field(default_factory=Limits)
    error_estimate: ErrorEstimate = field(default_factory=ErrorEstimate)
    corrections: Corrections = field(default_factory=Corrections)


DEFAULTS = Parameters()
"""The constants of the model that results are judged with."""

ENGINE = EngineConstants()
"""The constants of the engines."""
