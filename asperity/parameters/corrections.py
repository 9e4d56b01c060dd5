"""Constants of the corrections of the model, and the switches of these."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "ContactShift",
    "Corrections",
    "ElongationBounds",
    "JoinedPairs",
    "PressedBasins",
    "SharpTips",
    "TiltedBasins",
]


@dataclass(frozen=True)
class ContactShift:
    """Contact shift under the slope of the neighbors' field.

    Attributes
    ----------
    largest
        Largest shift over the contact radius [-]. Farther off, the paraboloid of the summit does
        not describe the surface, and contacts that shift each other have several states. With 0.7
        the loads of 14 of 70 maps depended on the load path by more than a tenth of the stated
        error, up to 1.25 of it; with 0.55 those of 6 of 80, one up to 0.94, the others to 0.21. The
        load error is 1.1 % (74 judged maps). (25 %: load 0.8 %, area 0.7 %.)
    growth
        c [-] of the area A (1 + c (1 + m)^2 s^2/a^2) of a contact of radius a shifted by s, at
        equal force, if the contact has outgrown the paraboloid of its summit (boundary elements,
        contact by contact: 1.2 to 1.9 for cut-offs from 4 to 16 pixels). (25 %: load 0.0 %, area
        1.0 %.)
    """

    largest: float = 0.55
    growth: float = 1.5


@dataclass(frozen=True)
class ElongationBounds:
    """Bounds of elongated footprints.

    Attributes
    ----------
    aspect
        Largest ratio [-] of the axes of a footprint.
    radius
        Largest radius of curvature along a contact, over that of the round contact [-], in the
        contact shift: along a ridge the surface is no paraboloid. (25 %: load 0.5 %, area 0.8 %.)
    """

    aspect: float = 30.0
    radius: float = 1.5


@dataclass(frozen=True)
class PressedBasins:
    """Contacts that carry so much of the load that boundary elements press their basins alone.

    Attributes
    ----------
    ridge_share, plateau_share, round_share
        Least share [-] of the load, beyond its expansion, for which a contact is pressed alone: on
        a ridge or rough summit; on a peak without a summit between the pixels, for which no law
        holds; on a smooth, round summit, whose law is more accurate. (25 %: load 0.9 %, area 1.6
        %.)
    ridge
        Largest ratio of the curvatures [-] of a round summit.
    rough_node
        Last node of the law table at which the expansion of a rough summit ends. (25 %: load 0.7 %,
        area 1.2 %.)
    """

    ridge_share: float = 0.03
    plateau_share: float = 0.003
    round_share: float = 0.1
    ridge: float = 5.0
    rough_node: int = 5


@dataclass(frozen=True)
class JoinedPairs:
    """Pairs of contacts that boundary elements press as one.

    Attributes
    ----------
    share
        Least share [-] of the load that both carry as they join. (25 %: load 2.3 %, area 2.1 %.)
    slack
        Depth below the pass between them, over the mean approach [-], down to which both basins
        count as one. (25 %: load 0.4 %, area 0.8 %.)
    """

    share: float = 0.2
    slack: float = 0.1


@dataclass(frozen=True)
class TiltedBasins:
    """Contacts whose basins the field of the others tilts (`corrections.tilted_basins`).

    Fitted on seeds 1, 2 and 11 to 16.

    Attributes
    ----------
    shift
        Shift over the contact radius [-] at which a basin begins to count as tilted, and at which
        it counts fully.
    share
        Share [-] of the contact area on tilted basins at which the correction of areas begins, and
        at which it is complete.
    most
        Part [-] of the area on tilted basins that is corrected, in the largest contacts.
    passed
        Depth of a hollow, over the approach [-], at which a ray ends (0.1 to 0.4 are alike).
    pressed
        Least share [-] of the contact area of a yielded contact that is pressed. A quarter changes
        the area by 0.6 % with a hardness.
    confirmed
        Part [-] of the area of the pressed contacts at which its change counts fully; below it, in
        proportion. Nothing is pressed where the area is larger than load over hardness by less.
    """

    shift: tuple[float, float] = (0.25, 0.35)
    share: tuple[float, float] = (0.22, 0.3)
    most: float = 0.95
    passed: float = 0.2
    pressed: float = 0.003
    confirmed: float = 0.05


@dataclass(frozen=True)
class SharpTips:
    """Tips narrower than the first step of their rays.

    Attributes
    ----------
    ratio
        Least ratio [-] of f/r^2 at a tip to that at the first node of its rays for which the rays
        do not resolve it: 12 for r, 4 for r^1.5, at most 2.3 on nine maps. (25 %: load 0.2 %, area
        1.0 %.)
    error
        Expected error [-] of the force above which the expansion of a tip counts as exceeded.
    """

    ratio: float = 1.5
    error: float = 0.05


@dataclass(frozen=True)
class Corrections:
    """Switches of the corrections of the model (``benchmarks/ablation.py`` has a row for each).

    Attributes
    ----------
    contact_shift
        Contacts shift on the slope of their neighbors' field.
    elongation
        Footprints of contacts on elongated summits are elongated.
    pressed_basins
        Basins that carry much of the load are pressed alone.
    joined_pairs
        Two contacts that join while they carry much of the load are pressed as one.
    tilted_basins
        Contacts on basins that the field of the others tilts get the area of the tilted basin.
    sharp_tips
        Contacts on tips that their rays do not resolve state larger errors.
    wave_split
        The finest waves of a broad spectrum act as a law of the contacts.
    finer_grid
        Maps whose waves reach the pixel are solved on smaller pixels.
    coarser_grid
        Smooth maps are solved on larger pixels.
    """

    contact_shift: bool = True
    elongation: bool = True
    pressed_basins: bool = True
    joined_pairs: bool = True
    tilted_basins: bool = True
    sharp_tips: bool = True
    wave_split: bool = True
    finer_grid: bool = True
    coarser_grid: bool = True
