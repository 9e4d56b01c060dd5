"""Constants of the microcontact model, but for its corrections, each with what it was fitted on.

"25 %" says by how much a quarter more or less changes load and area at most, where that is a tenth
of a percent and more on ten judged maps (``benchmarks/sensitivity.py``,
docs/development/sensitivity.csv). Numerical tolerances stand where they act.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "Anchors",
    "ErrorEstimate",
    "Parts",
    "PixelWaves",
    "Segmentation",
    "Spots",
    "SubContact",
    "WaveSplit",
]


@dataclass(frozen=True)
class Segmentation:
    """How much of a map is segmented.

    Attributes
    ----------
    spare_share, depth
        Share [-] of the heights to segment: the first, and the second times the contact area
        fraction. The lowest candidate needs 5 (self-affine) to 7 times (plateau-honed maps) that
        fraction; the rest keeps the rays of the contacts off the height that is cut.
    whole_share
        Share [-] of the heights from which on the whole map is segmented, which costs no more.
    whole_points
        Points up to which all is segmented: laws of summits whose basins are cut differ a little.
    flat_share
        Share [-] of the highest points on flat tops from which on a map stays on its own grid:
        waves through heights cut off ring, and have summits where the map has none.
    """

    spare_share: float = 0.1
    depth: float = 8.0
    whole_share: float = 0.6
    whole_points: int = 2**20
    flat_share: float = 0.4


@dataclass(frozen=True)
class PixelWaves:
    """Waves near the pixel.

    Attributes
    ----------
    to_the_pixel
        Share [-] of the squared slope lost between one pixel and two (`wave_split.fineness`) from
        which on a map is solved on smaller pixels: cut-off 3 pixels and shorter, and four of seven
        measured maps. (25 %: load 0.2 %, area 0.6 %.)
    finer
        Points of the finer grid per point of the map, along each axis, and how many it may have: 2
        takes 2.5 times as long, 1.5 takes 1.7 times and mends two thirds as much.
    kurtosis
        How far the kurtosis [-] of second differences may be from 3, that of random waves.
    """

    to_the_pixel: float = 0.13
    finer: tuple[tuple[float, int], ...] = ((2.0, 2**22), (1.5, 10**7))
    kurtosis: float = 0.25


@dataclass(frozen=True)
class WaveSplit:
    """Which waves are too fine for contacts of their own.

    Attributes
    ----------
    breadth
        Nayak's parameter m0 m4 / m2^2 [-] up to which waves are kept for contacts: beyond it basins
        are as small as contacts. (25 %: load 2.5 %, area 0.7 %.)
    worth
        Breadth of the whole map over `breadth` [-] from which on the finest waves are taken out.
    unresolved_pixels
        Pixels [-] below which the summits of a wave are uncertain. (25 %: load 5.8 %, area 6.0 %.)
    unresolved_slope
        Share [-] of the squared slope in such waves from which on they are always taken out.
    fewest_waves
        Of the shortest waves that are kept, so many fit the side of the map at least. Where few
        hills carry the load, as without a roll-off, the law of the waves on each is rough.
    kept_slope
        Share [-] of the squared slope that they hold at least, else their contacts cover the map:
        at 0.04 (0.1, 0.2) the load was 12 (6, 3) % low at a tenth of contact. (25 %: 2 % there.)
    points
        Grid points per shortest wave: four lower the load by 1 to 2 %, eight raise it by up to
        0.4 %. (25 %: load 6.0 %, area 1.7 %.)
    least_slope
        Share [-] of the squared slope that the finest waves hold at least, if they are taken out.
    lay
        Anisotropy [-] (s1^2 - s2^2) / (s1^2 + s2^2) of the principal slopes of a map (0.52 at 2:1,
        0.83 at 4:1) from which on there is no law.
    grading
        Largest |m| [-] for which the law was measured.
    """

    breadth: float = 14.0
    worth: float = 1.8
    unresolved_pixels: float = 3.0
    unresolved_slope: float = 0.2
    fewest_waves: float = 50.0
    kept_slope: float = 0.07
    points: float = 6.0
    least_slope: float = 0.03
    lay: float = 0.2
    grading: float = 0.5


@dataclass(frozen=True)
class SubContact:
    """Law of the fine waves within contacts (`SubContactLaw`), fitted on boundary elements without
    microcontacts: pressures of solutions of the longer waves, Hurst exponents 0.5 to 0.9, one to
    four octaves.

    Attributes
    ----------
    spread
        Share [-] of the pressure variance of the fine waves in full contact that spreads the
        pressure of a contact about to open, for few fine waves (0.50 to 0.63 found; Wang and Mueser
        2017 have 5/9). (25 %: load 0.9 %, area 5.7 %.)
    more_spread
        What is added to it [-] where the slope of the fine waves is far above the others'. (25 %:
        load 0.1 %, area 0.6 %.)
    graded_spread
        c1, c2 [-]: graded, times 1 - c1 m - c2 m^2, |m| <= 0.5. (25 %: load 0.1 %, area 1.1 %.)
    lift
        How far the flat is lifted at no contact, over the first-order value less one [-].
    lift_power
        It falls with this power [-] of the share of the area that is not in contact.
    graded_lift
        `lift` on a graded body times 1 - c m [-].
    tops
        Further lift over what the fine waves add to the rms height, per standard deviation of
        height at which the share of area in contact is that above it [-]. Fitted with `lift` on 13
        spectra, seeds 1 and 2, Hurst exponents -1 to 0.8, roll-offs at 5 to 64 pixels, 0.1 to 9 %
        of contact: load 42 -> 3 % rms.
    tops_from
        Standard deviations of height [-] from which on it counts (14 % of the area).
    graded_tops
        `tops` on a graded body times 1 - c m [-] (m = -0.5, -0.3, 0.3, 0.5).
    seen
        Wave number times contact radius [-] at which half the pressure of the fine waves parts a
        contact: a longer wave only makes the summit higher or sharper. On seeds 1, 2 and 11 to 14
        0.9 to 1.5 hardly differ. (25 %: load 0.0 %, area 2.1 %.)
    """

    spread: float = 0.50
    more_spread: float = 0.13
    graded_spread: tuple[float, float] = (0.70, 0.55)
    lift: float = 0.12
    lift_power: float = 5.0
    graded_lift: float = 2.3
    tops: float = 0.69
    tops_from: float = 1.1
    graded_tops: float = 0.3
    seen: float = 1.0


@dataclass(frozen=True)
class Spots:
    """Number of separate spots.

    Attributes
    ----------
    joined
        Mean approach over the mean depth [-] of the pass at which two contacts have joined
        (boundary elements on double wells: 1.7 for two equal summits). (25 %: load 2.2 %, area 6.2
        %.)
    sag
        How much deeper a pass lies than its pixels, over the rms second difference of heights [-].
    parted, crowding
        Spots that fine waves add per wave under the contacts: the factor [-] and the exponent [-]
        of the area fraction (boundary elements on the pixels of the map, 256 x 320, cut-off 2 and 4
        pixels, H = 0.5 and 0.8, seeds 1, 2 and 11).
    """

    joined: float = 1.6
    sag: float = 0.7
    parted: float = 0.349
    crowding: float = 0.233


@dataclass(frozen=True)
class ErrorEstimate:
    """Weights of the terms of the error estimate: the bound that nine errors in ten keep, by
    quantile regression on synthetic surfaces (``benchmarks/calibrate_estimate.py``).

    Attributes
    ----------
    load_weights, area_weights
        Weights [-] of `error_estimate.TERMS`, for the load at equal separation and the contact area
        at equal load.
    flat_tops, at_border, unsure, unresolved
        Weights [-] of the terms outside the model, for load and area alike: the largest errors
        where all contacts are such, of heights cut off at one rms height and of a single wave (0.7
        to 0.99), of tilted maps and of cups (0.15), of single tips r and r^4 (0.8 to 1.6).
    overshoot, usual_overshoot
        Weight [-] of how far summits stand above their highest pixels over the approach, and what
        of it is usual (docs/development/fits.md).
    pressed
        Part [-] of the errors on flat tops that is gone where these are pressed alone: of heights
        cut off at one and two rms heights, cut cones and coarse steps those of load are 0.2 then,
        those of area 0.5 at the lightest loads (seeds 1, 2 and 11).
    wide_top
        Part [-] of the map over which a flat top reaches from which on it is no contact among
        others: of heights cut off at 0.3 rms heights, whose tops hang together, the load is up to
        80 % low.
    resolved_pixels
        Pixels [-] of a contact from which on the points of the map tell how high its summit is.
        Boundary elements on the map and refined twice are 1.4 and 0.5 of the load off at a pixel
        for each contact (uniform heights, 128 x 128, seed 1).
    fewest_pixels, unsure_error
        Pixels [-] of the smallest contact that counts as smaller, and the error [-] of its force
        that a law expects from which on it tells nothing of a contact.
    longest_lay
        Slopes across over those along a lay [-] from which on no errors are estimated: of lays of
        7:1 to 10:1 (seeds 1 to 6, 11 and 12) loads came out up to 23 % too high, up to twice what
        was stated from 7 on, 1.3 times it from 6 to 7 (docs/development/fits.md).
    yielded
        Slope and least value [-] of the factor of the area's estimate over the share of the area
        that is not plastic: the rest is load over hardness. 98 of 100 errors over estimates are
        below it, hardnesses of 0.02 to 1 E* h' (seeds 31 and 32, docs/development/hardness.md).
    """

    load_weights: tuple[float, ...] = (
        0.0391, 0.0292, 1.1872, 0.1278, 0.5705, 0.0111, 0.0, 0.2729, 0.3301,
    )  # fmt: skip
    area_weights: tuple[float, ...] = (
        0.3272, 0.0846, 1.2033, 0.6293, 0.0, 0.0292, 0.0528, 0.0123, 0.5485,
    )  # fmt: skip
    flat_tops: float = 1.0
    at_border: float = 0.15
    unsure: float = 1.0
    unresolved: float = 1.0
    overshoot: float = 2.5
    usual_overshoot: float = 0.05
    pressed: float = 0.5
    wide_top: float = 0.2
    resolved_pixels: float = 2.0
    fewest_pixels: float = 0.1
    unsure_error: float = 0.5
    longest_lay: float = 7.0
    yielded: tuple[float, float] = (8.0, 0.05)


@dataclass(frozen=True)
class Anchors:
    """Load points at which boundary elements correct and bound a curve of the model
    (docs/development/verification.md).

    Attributes
    ----------
    least_loads
        Load points from which on some can be left to the model.
    first
        Anchors in any case: on random waves, and on other maps, whose misfit varies less evenly.
    judge_share
        Error [-] of boundary elements at anchors over the accuracy asked for.
    prior_share
        Shares [-] of the a-priori estimates of load and area that are left between anchors at all
        of which they held.
    yielded_share
        What is added to them [-] where the contacts bear the hardness: there the load follows the
        heights of single summits, and the misfit does not vary slowly.
    unknown
        Estimates of load and area [-] where the model states none.
    """

    least_loads: int = 5
    first: tuple[int, int] = (3, 5)
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
    least_points, longest_lay, coarse
        Maps on which they may: points of the shorter side from which on parts are representative,
        slopes across over those along a lay up to which contacts stay within them, and rms height
        of the waves whose contacts are solved over that of all (white noise 0.6, Hurst exponents
        above 0 more than 0.9) [-].
    side, points, grid_points
        Least parts along each side; points along the shorter side of a part, and of the grid that
        the model solves on it, of maps that have more of such parts.
    loads, judge_share
        Load points at which they are solved, and error of the area there over the accuracy [-].
    least_load, heaviest, cover
        Load on a part over its share of the area from which on it is solved [-]; over that of as
        large a part at the heaviest load point up to which it is [-]; load on all parts solved over
        what as many would carry if all carried alike below which they do not tell of the whole [-].
    long_waves, fine
        Share [-] of the mean square height in waves longer than half a part from which on these are
        solved on the whole map, and the part left open then of what the others change [-].
    floor, alike, few
        Bounds of load and area [-] beside the scatter over parts that carry alike, the number of
        these, and the power with which the squares of both grow where parts are fewer.
    spare, enough
        Accuracies over the floors from which on parts are tried, and bounds over the accuracies at
        which no more are solved [-].
    """

    least_points: int = 1536
    longest_lay: float = 3.0
    coarse: float = 0.87
    side: int = 4
    points: int = 512
    grid_points: int = 75
    loads: int = 4
    judge_share: float = 0.05
    least_load: float = 0.02
    heaviest: float = 4.0
    cover: float = 0.4
    long_waves: float = 1.0 / 3.0
    fine: float = 0.1
    floor: tuple[float, float] = (0.02, 0.04)
    alike: int = 4
    few: float = 2.0
    spare: float = 1.5
    enough: float = 0.75
