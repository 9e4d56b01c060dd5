"""The finest waves of a broad spectrum as a law of the contacts between the longer ones.

Contacts confined to basins lose their meaning where basins are as small as the contacts: on a
spectrum that spans five octaves most do at a few per cent of contact. The waves that are too short
are then taken out, the rest is solved as contacts of its own summits, and within each of these
contacts the short waves leave part of the area open and lift the flat.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.interaction.footprint import Footprints
from surfaces.heightmap import HeightMap

from .pixel_waves import TO_THE_PIXEL, fineness, random_waves
from .spectrum_shells import Shells
from .sub_contact_law import FineScales

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace

__all__ = ["Split", "split_scales"]

Array = NDArray[np.float64]

BROADEST = 14.0
"""Breadth m0 m4 / m2^2 of the spectrum up to which basins are left as they are."""

WORTH_IT = 1.8
"""Breadth over `BROADEST` from which on the finest waves are taken out."""

UNRESOLVED = 3.0
"""Pixels below which the summits of a wave are uncertain."""

TOO_MANY = 0.2
"""Share of the squared slope in such waves from which on they are taken out of any spectrum."""

SURELY = 0.9
"""Share of that breadth up to which some lines of a map can tell that it is not reached."""

FEWEST_WAVES = 50
"""Of the shortest waves that are kept, so many fit the side of the map at least. Where few hills
carry the load, as on spectra without a roll-off, the law of the waves on each of them is rough."""

POINTS = 6.0
"""Points per shortest wave that is kept: with four the load is 1 to 2 % lower at 10 to 25 % of
contact, with eight no more than 0.4 % higher."""

WORTH_LOSING = 0.03
"""Share of the squared slope that the finest waves hold at least, if they are taken out."""

NARROW = "scales: all, the spectrum is narrow enough for a contact at each summit"

LAY = 0.2
"""Anisotropy (s1^2 - s2^2) / (s1^2 + s2^2) of the principal slopes s1, s2 of a map (0.52 at 2:1,
0.83 at 4:1) from which on there is no law."""

GRADED = 0.5
"""Largest |m| for which there is a law."""


@dataclass(frozen=True, eq=False, repr=False)
class Split:
    """A map without its finest waves, and the law of these.

    Attributes
    ----------
    coarse
        Map of the longer waves, on a grid that holds it well.
    fine
        Law of the finer ones.
    """

    coarse: HeightMap
    fine: FineScales


def split_scales(hm: HeightMap, material: HalfSpace) -> Split | str:
    """A map without its finest waves, on a grid that holds it well, and the law of those.

    Parameters
    ----------
    hm
        Height map without missing points.
    material
        Elastic half-space.

    Returns
    -------
    The split, or the reason to leave the map whole.

    Notes
    -----
    Waves are added from the longest on until the breadth m0 m4 / m2^2 of the spectrum (Nayak's
    parameter) reaches `BROADEST`, `FEWEST_WAVES` along the side of the map at least, and none
    shorter than `UNRESOLVED` pixels. The law holds for random waves without lay. A map that is not
    periodic is taken with its mirror images.
    """
    if abs(material.m) > GRADED:
        return f"scales: all, the law of fine waves is for |m| <= {GRADED:g}"
    if fineness(hm) < TO_THE_PIXEL and _breadth(hm) < SURELY * WORTH_IT * BROADEST:
        return NARROW
    if not random_waves(hm):
        return "scales: all, the finest waves are not random, so that no law holds for all of them"
    if _lay(hm) > LAY:
        return "scales: all, the waves have a lay, for which there is no law"
    shells = Shells.of(hm, material.m)
    m0, m2, m4 = shells.sums[:, :3].T
    breadth = np.divide(1.5 * m0 * m4, m2**2, out=np.zeros(m2.size), where=m2 > 0.0)
    last = int(np.argmax(breadth > BROADEST))  # 0 if it never is
    most = 2.0 * np.pi / (UNRESOLVED * max(hm.spacing))
    finest = min(int(most / shells.width + 1e-6), m2.size - 1)  # whole numbers but for rounding
    if m2[finest] > (1.0 - TOO_MANY) * m2[-1] and breadth[-1] < WORTH_IT * BROADEST:
        return NARROW
    last = min(max(last or finest, _shell(FEWEST_WAVES, hm)), finest)
    fine = _law(shells, last, material)
    if fine is None:
        return "scales: all, the map has too few waves to take the finest out"
    coarse = shells.map(last, POINTS)
    if coarse is None:
        return "scales: all, the map is too small to take its finest waves out"
    return Split(coarse, fine)


def _shell(waves: float, hm: HeightMap) -> int:
    """Shell of which so many waves fit the side of the map."""
    return round(waves * max(hm.size) / math.sqrt(hm.area))


def _law(shells: Shells, last: int, material: HalfSpace) -> FineScales | None:
    """Law of the waves beyond the shell `last`; None where these are hardly any."""
    sums = shells.sums
    if sums[last, 1] > (1.0 - WORTH_LOSING) * sums[-1, 1]:
        return None
    lost = sums[-1] - sums[last]
    stiffness = 1.0 / Footprints(material.modulus, material.m).symbol
    return FineScales(
        shortest=2.0 * np.pi / (shells.width * last),
        ratio=float(lost[4] / sums[last, 4]),
        variance=float(stiffness**2 * lost[4]),
        energy=float(0.5 * stiffness * lost[3]),
        number=float((lost[4] / lost[3]) ** (1.0 / (1.0 - material.m))),
        m=material.m,
    )


def _breadth(hm: HeightMap) -> float:
    """Breadth of the spectrum of a map whose waves have no direction, from some of its lines."""
    turns = np.zeros((2, 2))  # mean squares of slope and curvature along y and x
    for mean, power, length in zip(turns, hm.line_power, hm.size, strict=True):
        number = np.arange(power.size) * (2.0 if hm.periodic else 1.0) * np.pi / length
        mean[:] = power @ number**2, power @ number**4
    slope, bend = turns.mean(axis=0)
    return float(hm.roughness.rms_height**2 * bend / slope**2)


def _lay(hm: HeightMap) -> float:
    """(s1^2 - s2^2) / (s1^2 + s2^2) of the principal slopes of a map, from some of its rows."""
    rows = np.arange(0, hm.shape[0] - 1, max(1, hm.shape[0] // 256))
    low, high = hm.heights[rows], hm.heights[rows + 1]
    along = np.diff(low, axis=1) + np.diff(high, axis=1)
    across = (high - low)[:, 1:] + (high - low)[:, :-1]
    y, x = across / hm.spacing[0], along / hm.spacing[1]
    yy, xx, xy = np.mean(y * y), np.mean(x * x), np.mean(y * x)
    return float(np.hypot(xx - yy, 2.0 * xy) / (xx + yy))
