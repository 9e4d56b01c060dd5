"""The certificate: how far a pressure is from solving the contact problem, in float64.

It is recomputed from the pressure alone with the exact operator; no quantity of the iteration
enters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surfaces.arrays import Array
from surfaces.numerics.parallel import by_rows

from ._grid_kernels import BLOCK, contact_sums

__all__ = ["Certificate", "Prescribed", "Reading", "certify"]


@dataclass(frozen=True)
class Prescribed:
    """What a solution is asked for: a level where one is given, else a mean pressure.

    Attributes
    ----------
    mean
        Mean of p~ [m].
    level
        Level of the contact, u - h in it [m]; what was found is `Reading.level`.
    """

    mean: float = 0.0
    level: float | None = None


@dataclass(frozen=True)
class Certificate:
    """Relative errors of a contact solution; zero for the exact one. A length h that they are
    relative to is the rms height, or what `certify` takes in its place.

    Attributes
    ----------
    load
        |mean pressure / prescribed - 1|, or with prescribed separation the error of the
        separation over h; or, if larger, the share of load above the hardness [-].
    complementarity
        ``(sum_{p<H} p (g - l) + sum_{p=H} H max(g - l, 0)) / (sum p h)`` with the smallest gap
        l where p < H: pressure times gap, which must vanish [-].
    penetration
        (mean gap of the contact below the hardness - smallest gap there) / h [-].
    lift
        (largest gap at the hardness - mean gap of the contact below it) / h, or zero [-].
    """

    load: float
    complementarity: float
    penetration: float
    lift: float = 0.0

    @property
    def worst(self) -> float:
        """Largest of the four; NaN counts as infinite."""
        values = (self.load, self.complementarity, self.penetration, self.lift)
        return float("inf") if any(v != v for v in values) else max(values)


@dataclass(frozen=True)
class Reading:
    """A certificate and what was read with it.

    Attributes
    ----------
    certificate
        The relative errors.
    points, held
        Number of points under pressure, and of those at the cap.
    level
        Mean of u - h over the contact below the cap [m]; its smallest value if there is no contact.
    scale
        Length that the errors are relative to [m].
    total
        Sum of the pressure.
    moment
        Sum of pressure times displacement [m^2].
    plastic_work
        Sum of pressure times plastic depth [m^2].
    block_low
        Lowest gap of each run of 64 points, -inf where there is pressure [m].
    weakest
        Smallest pressure if all points are under pressure, and all or none at the cap; or zero [m].
    """

    certificate: Certificate
    points: int
    held: int
    level: float
    scale: float
    total: float
    moment: float
    plastic_work: float
    block_low: Array
    weakest: float = 0.0


def certify(
    pressure: Array,
    displacement: Array,
    heights: Array,
    rms_height: float,
    *,
    cap: float,
    goal: Prescribed,
    highest_point: float = math.inf,
) -> Reading:
    """Certificate of a pressure p~ from 0 to a cap [m] and its displacement by the exact operator
    [m], both at least as large as the map, heights [m] of shape (ny, nx).

    With a prescribed level the highest point [m] bounds the length of scale.

    Notes
    -----
    With G the operator, J(p) = <p, Gp>/2 - <p, h> is smallest for the exact pressure of this load.
    The complementarity bounds how far it is above that, over sum p times the length of scale: it is
    the duality gap of the bounds 0 <= p <= cap with the smallest gap below the cap as multiplier.

    The length of scale is the rms height; for a map flat to within rounding, what float64 resolves
    of the gap: a millionth of the largest displacement or of the mean pressure, a length too (a
    flat map in a periodic cell is not displaced), and 1e-8 of the level of the contact. With a
    prescribed level it is the approach of the highest point if that is less: errors of as much let
    nothing touch.
    """
    ny, nx = heights.shape
    block_low = np.empty((ny, -(-nx // BLOCK)))
    found = np.array(
        by_rows(contact_sums, (ny, nx), pressure, displacement, heights, cap, block_low)
    )
    count, gap_sum, work, total, moment, held, held_sum, excess = found[:, :-3].sum(axis=0).tolist()
    lowest, highest, largest = map(
        float, (found[:, -3].min(), found[:, -2].max(), found[:, -1].max())
    )
    most, lowest = lowest, highest if lowest == np.inf else lowest
    level = gap_sum / count if count else lowest
    if held:
        at_cap = pressure[:, :nx] >= cap
        gap = displacement[:, :nx][at_cap] - heights[at_cap]
        work += cap * float(np.maximum(gap, lowest).sum())
        if count == 0:  # any level between the two bounds
            level = 0.5 * (lowest + highest)
            if goal.level is not None:
                level = max(min(goal.level, most), highest)
    resolved = max(1e-6 * largest, 1e-6 * total / heights.size, 1e-8 * abs(level))
    approach = math.inf if goal.level is None else goal.level + highest_point
    scale = max(min(max(rms_height, resolved), approach), float(np.finfo(float).tiny))
    if count + held == 0:
        missing = 1.0 if goal.level is None and goal.mean else 0.0
        level = lowest if goal.level is None else goal.level
        penetration = max(0.0, level - lowest) / scale
        certificate = Certificate(missing, 0.0, penetration)
        return Reading(certificate, 0, 0, level, scale, 0.0, 0.0, 0.0, block_low)
    if goal.level is not None:
        load = abs(level - goal.level) / scale
    else:
        load = abs(total / heights.size / goal.mean - 1.0)
    certificate = Certificate(
        load=max(load, excess / total),
        complementarity=max(work / total - lowest, 0.0) / scale,
        penetration=max(level - most, 0.0) / scale,
        lift=max(highest - level, 0.0) / scale,
    )
    plastic_work = cap * (held * level - held_sum) if held else 0.0
    points = int(count + held), int(held)
    weakest = float(pressure[:, :nx].min()) if heights.size in (count, held) else 0.0
    sums = total, moment, plastic_work
    return Reading(certificate, *points, level, scale, *sums, block_low, weakest)
