"""Law "auto": for every contact the law that measured validity favors.

The expansion about the optimal ellipse is the most accurate wherever a polynomial describes the
summit inside the contact, at any ratio of curvatures and any filling of the basin. A sharp tip (a
cone, a pyramid) is no polynomial: there the harmonic-resolved law takes over, approach by
approach.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.errors import Flag
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.ellipse import batch as ellipse_batch

from . import circle, ritz
from .law_table import LawTable

if TYPE_CHECKING:
    from surfaces.peaks.profiles import Profiles

__all__ = ["tabulate"]

Array = NDArray[np.float64]

DOUBTFUL_END = 0.1
"""Root of the approach over the reach up to which an end of the expansion makes a summit
doubtful."""

COMPARED_SHARES = np.array([0.003, 0.01, 0.03, 0.1])
"""Shares of the reach at which the laws of a doubtful summit are compared."""

LEVEL_TIP = 2e-3, 0.3
"""f/r^2 at the first node of a ray over that at its end between which a tip is level: of r^4 it is
0.004, of r^3 0.06, of a plateau 0, and of a summit in noise about 1."""

GROSS_DIFFERENCE = 1.3
"""Ratio of two laws' forces beyond which the law that needs no polynomial is believed."""


def tabulate(
    profiles: Profiles,
    material: HalfSpace,
    *,
    law: str = "auto",
    nodes: int = ellipse_batch.TABLE_INTERVALS,
) -> LawTable:
    """Law table of a batch: the ellipse law, guarded by direct maximization where it ends early.

    Where no polynomial describes a summit beyond its tip (a noisy spike on a ridge), the
    continuation of the ellipse law can be off by factors. For such summits, about one in ten, the
    force of `ritz` is computed at a few approaches; where both disagree grossly, the summit is
    tabulated by `ritz` and the disagreement is its spread. So are summits whose smallest
    polynomial is no summit, of which the ellipse law has nothing to say: plateaus. A level tip such
    as that of r^4, which rises along every ray at once, is one by rounding alone; the harmonic law
    is exact there, and `ritz` at a third of the force.
    """
    table = replace(ellipse_batch.tabulate(profiles, material, nodes=nodes), law=law)
    left = table.flags[:, 1 : int(DOUBTFUL_END * nodes) + 1] & Flag.BEYOND_RADIUS
    ratio = np.where(profiles.valid & (table.reach == 0), np.inf, 1.0)
    doubtful = np.flatnonzero(left.any(axis=1) & (table.reach > 0))
    if doubtful.size:
        ratio[doubtful] = _worst_ratio(table, doubtful, profiles.rows(doubtful), material)
    tip, end = profiles.q[:, :, 1], profiles.q[:, :, -1]
    level = np.isinf(ratio) & ((tip > LEVEL_TIP[0] * end) & (tip < LEVEL_TIP[1] * end)).all(axis=1)
    for rows, second in (
        (np.flatnonzero(level), circle.tabulate),
        (np.flatnonzero(~level & (ratio > GROSS_DIFFERENCE)), ritz.tabulate),
    ):
        if rows.size:
            other = second(profiles.rows(rows), material, nodes=nodes)
            _without_pull(other)
            _replace(table, rows, other, ratio[rows])
    return table


def _without_pull(table: LawTable) -> None:
    """Mend laws by direct maximization that pull, in a table that nobody else holds.

    On a plateau that rays leave uphill they do so at first. Up to the node at which F / u^p is
    largest, u being the root of the approach over the reach, a paraboloid takes their place: of 12
    such plateaus pressed alone the force is then off by 0.15 to 0.2 (rms of its logarithm) from a
    twentieth of the reach on.
    """
    u = np.arange(1, table.nodes + 1) / table.nodes
    pulls = (table.force[:, 1:] <= 0).any(axis=1) & (table.force > 0).any(axis=1)
    for row in np.flatnonzero(pulls):
        last = 1 + int(np.argmax(table.force[row, 1:] / u**table.exponent))
        share = np.arange(last + 1) / last
        force, depth = table.force[row, last], table.reach[row] * u[last - 1] ** 2
        slope = 0.5 * table.exponent * force / depth
        table.force[row, : last + 1] = force * share**table.exponent
        table.stiffness[row, : last + 1] = slope * share ** (table.exponent - 2)
        table.area[row, : last + 1] = table.area[row, last] * share**2


def _worst_ratio(
    table: LawTable, rows: NDArray[np.int64], profiles: Profiles, material: HalfSpace
) -> Array:
    """Largest ratio of the forces of the table and of `ritz`, either way, over a few approaches."""
    first = table.evaluate(rows[:, None], COMPARED_SHARES * table.reach[rows, None])[0]
    other = ritz.forces(profiles, material, np.sqrt(COMPARED_SHARES))
    usable = (first > 0) & (other > 0)
    ratio = np.divide(first, other, out=np.ones(first.shape), where=usable)
    return np.asarray(np.maximum(ratio, 1 / ratio).max(axis=1))


def _replace(table: LawTable, rows: NDArray[np.int64], second: LawTable, ratio: Array) -> None:
    """Put `second` in the place of the `rows` of a table that nobody else holds."""
    for name in ("reach", "force", "stiffness", "area", "flags"):
        getattr(table, name)[rows] = getattr(second, name)
    table.spread[rows] = np.maximum(table.spread[rows], np.minimum(ratio - 1, 1.0)[:, None])
    if table.centre is not None:
        table.centre[rows] = 0.0
