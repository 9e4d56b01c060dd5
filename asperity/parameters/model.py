"""Constants of the microcontact model without its corrections, and of its error estimate."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "ErrorEstimate",
    "LawChoice",
    "Limits",
    "PixelWaves",
    "Segmentation",
    "Spots",
    "SubContact",
    "WaveSplit",
]


@dataclass(frozen=True)
class Segmentation:
    """Part of a map that is segmented.

    Attributes
    ----------
    spare_share, depth
        The share [-] of the heights that is segmented, from the highest down, is `spare_share` +
        `depth` times the expected area fraction. The lowest candidate needs 5 (self-affine) to 7
        (plateau-honed maps) times the area fraction; the rest keeps rays from ending where the
        segmented part ends.
    whole_share
        Share [-] of the heights above which the whole map is segmented, since that costs no more.
    whole_points
        Number of points up to which the whole map is segmented: basins that are cut off change the
        laws of their summits a little.
    flat_share
        Share [-] of the highest points on flat tops above which a map is not resampled: a Fourier
        series through heights that are cut off rings, and has summits where the map has none.
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
        Share [-] of the squared slope lost between one pixel and two (`checks.fineness`) above
        which a map is solved on smaller pixels. Maps with a cut-off of 3 pixels or less exceed it,
        and four of seven measured maps. (25 %: load 0.2 %, area 0.5 %.)
    finer
        Points of the finer grid per point of the map along each axis [-], with the largest number
        of points of that grid; the first that fits is taken. 2 takes 2.5 times as long as the map;
        1.5 takes 1.7 times as long and corrects two thirds of the error.
    kurtosis
        Largest difference [-] of the kurtosis of second differences from 3, that of random waves.
    """

    to_the_pixel: float = 0.13
    finer: tuple[tuple[float, int], ...] = ((2.0, 2**22), (1.5, 10**7))
    kurtosis: float = 0.25


@dataclass(frozen=True)
class WaveSplit:
    """Split of the waves of a map: the fine ones get a law, the longer ones ("kept") contacts.

    Attributes
    ----------
    breadth
        Nayak parameter m0 m4 / m2^2 [-] of the kept waves: with a larger one basins would be as
        small as contacts. (25 %: load 2.6 %, area 2.0 %.)
    worth
        Least Nayak parameter of the whole map, over `breadth` [-], for which the waves are split.
    sure_breadth
        Part [-] of that parameter below which some lines of a map suffice to tell that its waves
        are not split.
    unresolved_pixels
        Length of a wave [pixels] below which its summits are uncertain. (25 %: load 4.1 %, area 5.8
        %.)
    unresolved_slope
        Share [-] of the squared slope in such waves above which the waves are always split.
    fewest_waves
        Least number of the shortest kept waves along the side of the map. Where few hills carry the
        load, as without a roll-off, the law of the fine waves on each is inaccurate.
    kept_slope
        Least share [-] of the squared slope in the kept waves. With less their contacts cover the
        map: at 0.04 (0.1, 0.2) the load was 12 (6, 3) % low at a tenth of contact. A quarter
        changes the load by 2 % there.
    points
        Grid points per shortest kept wave [-]: four lower the load by 1 to 2 %, eight raise it by
        up to 0.4 %. (25 %: load 2.2 %, area 1.4 %.)
    least_slope
        Least share [-] of the squared slope in the fine waves for which the waves are split.
    lay
        Largest anisotropy [-] (s1^2 - s2^2) / (s1^2 + s2^2) of the principal slopes of a map for
        which the law holds (lay of 2:1 has 0.52, 4:1 has 0.83).
    grading
        Largest |m| [-] for which the law was fitted.
    """

    breadth: float = 14.0
    worth: float = 1.8
    sure_breadth: float = 0.9
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
        g0 [-]: part of the pressure variance of the fine waves in full contact that spreads the
        pressure of a contact about to open, in the limit of few fine waves (0.50 to 0.63 found;
        Wang and Mueser 2017: 5/9). (25 %: load 0.7 %, area 5.7 %.)
    more_spread
        Increase of g0 [-] in the limit where the slope of the fine waves is far above that of the
        longer ones. (25 %: load 0.1 %, area 0.6 %.)
    graded_spread
        c1, c2 [-]: factor 1 - c1 m - c2 m^2 on g0 of a graded body, |m| <= 0.5. (25 %: load 0.1 %,
        area 1.1 %.)
    lift
        c [-]: the lift of the flat at no contact is 1 + c times its first-order value. (25 %: load
        0.8 %, area 0.0 %.)
    lift_power
        n [-]: at the area fraction P, c is multiplied by (1 - P)^n.
    graded_lift
        c1 [-]: factor 1 - c1 m on `lift` of a graded body. (25 %: load 0.2 %, area 0.0 %.)
    tops
        c' [-]: further lift c' max(z - `tops_from`, 0) times the increase of the rms height by the
        fine waves; a normal variable exceeds z with the probability P. Fitted with `lift` on 13
        spectra, seeds 1 and 2, Hurst exponents -1 to 0.8, roll-offs at 5 to 64 pixels, 0.1 to 9 %
        of contact: the error of the load fell from 42 to 3 % rms. (25 %: load 1.5 %, area 0.0 %.)
    tops_from
        z above which there is a further lift [-] (P = 14 %). (25 %: load 0.9 %, area 0.0 %.)
    graded_tops
        c1 [-]: factor 1 - c1 m on `tops` of a graded body (m = -0.5, -0.3, 0.3, 0.5).
    seen
        x0 [-] in the factor x^2/(x^2 + x0^2) on the pressure variance of the fine waves in a
        contact, x being their wave number times its radius: a wave longer than the contact only
        makes the summit higher or sharper. On seeds 1, 2 and 11 to 14 values from 0.9 to 1.5 hardly
        differ. (25 %: load 0.0 %, area 2.1 %.)
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
    """Number of contact spots.

    Attributes
    ----------
    joined
        Mean approach of two contacts over the mean depth of the pass below their summits [-], at
        which they have joined (boundary elements on double wells: 1.7 for two equal summits). (25
        %: load 2.2 %, area 2.1 %.)
    sag
        Depth of a pass below its pixels, over the rms second difference of the heights [-].
    parted, crowding
        c, n [-]: the fine waves add c P^-n (1 - f)/f spots per wave under the contacts
        (`load_point.spot_count`). Fitted on boundary elements on the pixels of the map, 256 x 320,
        cut-off 2 and 4 pixels, H = 0.5 and 0.8, seeds 1, 2 and 11.
    """

    joined: float = 1.6
    sag: float = 0.7
    parted: float = 0.349
    crowding: float = 0.233


@dataclass(frozen=True)
class LawChoice:
    """Summits to which the law "auto" gives another law than "ellipse".

    Attributes
    ----------
    doubtful_end
        Square root of approach over reach [-]: a summit whose expansion ends below it is compared
        with the law "ritz". (25 %: load 0.3 %, area 0.8 %.)
    gross_difference
        Ratio of the forces of both laws [-] beyond which such a summit gets "ritz", which needs no
        polynomial. (25 %: load 4.2 %, area 15.2 %.)
    level_tip
        Range of f/r^2 at the first node of a ray, over that at its end [-], in which a tip counts
        as level: it is 0.004 for r^4, 0.06 for r^3, 0 for a plateau, and about 1 for a summit in
        noise.
    """

    doubtful_end: float = 0.1
    gross_difference: float = 1.3
    level_tip: tuple[float, float] = (2e-3, 0.3)


@dataclass(frozen=True)
class Limits:
    """Limits of the model, beyond which load points are refused.

    Attributes
    ----------
    long_area
        Largest area of discs on the long axes of the contacts, over the area of the map [-]. With
        lay of 10:1 (shortest wave 8 pixels) it is reached at 9 % of contact, where the load is 24
        to 32 % too high; with 20:1 at 5 %, where the load is half as much again too high. Lay of
        4:1 has 1.8 at 27 %, maps without lay 1 (seeds 1, 2, 11).
    area
        Largest contact area over that of the map [-].
    overlap
        Largest overlap of flat and surface beside the contacts [-] (`Blocks.overlap`): the mean gap
        is zero, or they overlap on twice the area that touches.
    unsettled_area
        Largest contact area over that of the map [-] at which contacts that do not settle are tried
        once more from a lighter load; beyond it they are too crowded to be separate.
    power
        Least 1 + m of the half-space [-]. Below it a footprint, which has all but 2 % of the
        compliance of its contact, would be a thousand times as wide as the contact: 1.02^(1/(1+m)).
    """

    long_area: float = 1.9
    area: float = 0.5
    overlap: float = 1.0
    unsettled_area: float = 0.3
    power: float = 3e-3


@dataclass(frozen=True)
class ErrorEstimate:
    """Weights of the terms of the error estimate, by quantile regression on synthetic surfaces so
    that nine in ten errors are below it (``benchmarks/calibrate_estimate.py``).

    Attributes
    ----------
    load_weights, area_weights
        Weights [-] of `error_estimate.TERMS`, for the load at equal separation and the contact area
        at equal load.
    flat_tops, at_border, unsure, unresolved
        Weights [-] of terms of `error_estimate.OUTSIDE_MODEL`, for load and area alike: the largest
        errors found if the whole load is on such contacts. Heights cut off at one rms height and a
        single wave: 0.7 to 0.99; tilted maps and cups: 0.15; single tips r and r^4: 0.8 to 1.6.
    overlap
        Weight [-] of the overlap of flat and surface beside the contacts
        (docs/development/errors.md).
    overshoot, usual_overshoot
        Weight [-] of the height of summits above their highest pixels, over the approach; and the
        value [-] that random maps have, which is subtracted (docs/development/fits.md).
    pressed
        Part [-] by which the term of flat tops falls if these are pressed alone. The errors of load
        are then 0.2, those of area 0.5 at the lightest loads (heights cut off at one and two rms
        heights, cut cones, coarse steps; seeds 1, 2 and 11).
    wide_top
        Area of a flat top over that of the map [-] above which pressing it alone does not help: on
        heights cut off at 0.3 rms heights, whose tops are connected, the load is up to 80 % low.
    resolved_pixels
        Pixels [-] of a contact above which the points of the map determine the height of its
        summit. At one pixel per contact the loads of boundary elements on the map and on the map
        refined twice are off by 1.4 and 0.5 of the load (uniform heights, 128 x 128, seed 1).
    fewest_pixels, unsure_error
        Number of pixels [-] that smaller contacts are counted with; and expected error of the force
        [-] from which on the law of a contact counts as unsure.
    longest_lay
        Slopes across over those along a lay [-] from which on no errors are estimated. On lays of
        7:1 to 10:1 (seeds 1 to 6, 11 and 12) loads were up to 23 % too high, up to 2 times the
        estimate from 7 on, 1.3 times it from 6 to 7 (docs/development/fits.md).
    yielded
        Slope and least value [-] of the factor on the estimate of the area, over the share of the
        area that is not plastic; the plastic part is load over hardness. 98 % of the errors over
        the estimate are below it (hardness 0.02 to 1 E* h', seeds 31 and 32,
        docs/development/hardness.md).
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
    overlap: float = 1.0
    overshoot: float = 2.5
    usual_overshoot: float = 0.05
    pressed: float = 0.5
    wide_top: float = 0.2
    resolved_pixels: float = 2.0
    fewest_pixels: float = 0.1
    unsure_error: float = 0.5
    longest_lay: float = 7.0
    yielded: tuple[float, float] = (8.0, 0.05)
