"""Laws by name, each with a function that makes the law table of many profiles; the law "auto"."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from asperity.errors import Flag
from asperity.halfspace.material import HalfSpace
from asperity.parameters import DEFAULTS, LawChoice
from surfaces.arrays import Array, Index
from surfaces.errors import as_choice

from . import hertz
from .capped_table import capped_table
from .ellipse import batch as ellipse
from .law_table import INTERVALS, LawTable
from .ray_laws import ritz_forces, tabulate_expansion, tabulate_ritz

if TYPE_CHECKING:
    from surfaces.peaks.profiles import Profiles

__all__ = ["LAWS", "elastic_table", "tabulate"]


COMPARED_SHARES = np.array([0.003, 0.01, 0.03, 0.1])
"""Approaches over the reach at which the laws of a doubtful summit are compared."""


def tabulate_auto(profiles: Profiles, material: HalfSpace, choice: LawChoice) -> LawTable:
    """Law table of many profiles: `ellipse`, checked against `ritz` where its expansion ends early.

    `ellipse`, the expansion about the optimal ellipse, is the most accurate law wherever a
    polynomial describes the summit inside the contact, at any ratio of curvatures. Where none does
    beyond the tip (a noisy spike on a ridge), its continuation can be off by factors. For such
    summits, about one in ten, the force of `ritz` is computed at a few approaches; if both disagree
    grossly, the summit gets the law `ritz`, and the disagreement as its spread. Plateaus, for which
    `ellipse` gives no law, get `ritz` too. `ellipse` also gives no law for a level tip such as r^4,
    which rises along every ray: the law `harmonic` is exact there, while `ritz` has a third of the
    force. Where `harmonic` has no contact either (the flat top of a post, whose rays look level),
    the summit gets `ritz`.
    """
    table = ellipse.tabulate(profiles, material)
    left = table.flags[:, 1 : int(choice.doubtful_end * table.nodes) + 1] & Flag.BEYOND_RADIUS
    ratio = np.where(profiles.valid & (table.reach == 0), np.inf, 1.0)
    doubtful = np.flatnonzero(left.any(axis=1) & (table.reach > 0))
    if doubtful.size:
        ratio[doubtful] = _worst_ratio(table, doubtful, profiles.rows(doubtful), material)
    tip, end = profiles.q[:, :, 1], profiles.q[:, :, -1]
    low, high = choice.level_tip
    level = np.isinf(ratio) & ((tip > low * end) & (tip < high * end)).all(axis=1)
    harmonic = partial(tabulate_expansion, law="harmonic", nodes=INTERVALS)
    for rows, second in (
        (np.flatnonzero(level), harmonic),
        (np.flatnonzero(ratio > choice.gross_difference), tabulate_ritz),
    ):
        carries = table.reach[rows] * table.force[rows, -1] > 0
        without = rows[~(level[rows] & carries)]
        if without.size:
            other = second(profiles.rows(without), material)
            _without_pull(other)
            _replace(table, without, other, ratio[without])
    return table


def _without_pull(table: LawTable) -> None:
    """Replace negative forces of `ritz` in a table, in place.

    The law `ritz` pulls at first on a plateau that rises along some rays. The law of a paraboloid,
    F ~ u^p with u = sqrt(d/reach), replaces it up to the node at which F / u^p is largest. On 12
    such plateaus the force is then 0.15 to 0.2 (rms of its logarithm) off that of boundary elements
    from a twentieth of the reach on.
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


def _worst_ratio(table: LawTable, rows: Index, profiles: Profiles, material: HalfSpace) -> Array:
    """Largest ratio, 1 or more, of the forces of the table and of `ritz` at `COMPARED_SHARES`."""
    first = table.evaluate(rows[:, None], COMPARED_SHARES * table.reach[rows, None])[0]
    other = ritz_forces(profiles, material, np.sqrt(COMPARED_SHARES))
    usable = (first > 0) & (other > 0)
    ratio = np.divide(first, other, out=np.ones(first.shape), where=usable)
    return np.asarray(np.maximum(ratio, 1 / ratio).max(axis=1))


def _replace(table: LawTable, rows: Index, second: LawTable, ratio: Array) -> None:
    """Replace the `rows` of a table by `second`, in place; `ratio` less one is their spread."""
    for name in ("reach", "force", "stiffness", "area", "flags"):
        getattr(table, name)[rows] = getattr(second, name)
    table.spread[rows] = np.maximum(table.spread[rows], np.minimum(ratio - 1, 1.0)[:, None])
    if table.centre is not None:
        table.centre[rows] = 0.0


TABULATORS: dict[str, Callable[..., LawTable]] = {
    "auto": tabulate_auto,
    "hertz": hertz.tabulate,
    "paper": partial(tabulate_expansion, law="paper"),
    "harmonic": partial(tabulate_expansion, law="harmonic"),
    "ellipse": ellipse.tabulate,
    "ritz": tabulate_ritz,
}
"""Law table of a batch by each law, the default first; "auto" takes a `LawChoice`, too."""

LAWS = tuple(TABULATORS)
"""Names of the laws."""


def elastic_table(
    profiles: Profiles, material: HalfSpace, *, law: str, choice: LawChoice
) -> LawTable:
    """`tabulate` without the hardness. If the half-space has one, the table holds the bearing areas
    from which `capped_table` makes the laws with the hardness. `choice` is that of the law "auto".
    """
    tabulated = TABULATORS[as_choice("law", law, TABULATORS)]
    table = tabulated(profiles, material, *([choice] if law == "auto" else []))
    if material.hardness < math.inf:
        table.bearing = profiles.bearing_areas(table.approach())
    return table


def tabulate(profiles: Profiles, material: HalfSpace, *, law: str = "harmonic") -> LawTable:
    """Table of force, stiffness and area over the approach of all profiles.

    Parameters
    ----------
    profiles
        Batch of profiles (`surfaces.fit_profiles`).
    material
        Half-space.
    law
        Name of the law, see `LAWS`.
    """
    choice = DEFAULTS.law_choice
    return capped_table(elastic_table(profiles, material, law=law, choice=choice), material)
