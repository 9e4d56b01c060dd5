"""Law "auto": for every contact the law that measured validity favours.

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

from asperity.indentation import Indentation
from asperity.material import HalfSpace
from surfaces.polar import PolarProfile, PowerSumProfile

from . import ellipse, expansion, ritz
from .flags import Flag
from .table import LawTable

if TYPE_CHECKING:
    from surfaces import Profiles

__all__ = ["indent", "tabulate"]

Array = NDArray[np.float64]

LATEST_END = 3
"""Node of the table up to which an early end of the expansion makes a summit doubtful."""

GROSS = 1.3
"""Ratio of two laws' forces beyond which the law that needs no polynomial is believed."""


def indent(
    profile: PowerSumProfile | PolarProfile,
    material: HalfSpace,
    approach: Array,
    *,
    law: str = "auto",
) -> Indentation:
    """Solution by the law with the smaller expected error; see `asperity.indent`."""
    first = ellipse.indent(profile, material, approach)
    second = expansion.indent(profile, material, approach, law="harmonic")
    own = np.where(np.isfinite(first.force), first.error_estimate, np.inf)
    other = np.where(np.isfinite(second.force), second.error_estimate, np.inf)
    take = np.nan_to_num(own, nan=np.inf) <= np.nan_to_num(other, nan=np.inf)
    rows = take.reshape(-1, 1)
    names = ("force", "contact_area", "radius", "stiffness", "flags", "error_estimate")
    columns = {name: np.where(take, getattr(first, name), getattr(second, name)) for name in names}
    return replace(
        first,
        law=law,
        **columns,
        contour_function=lambda phi: np.where(
            rows, first.contour_function(phi), second.contour_function(phi)
        ),
        pressure_function=lambda r, phi: np.where(
            rows, first.pressure_function(r, phi), second.pressure_function(r, phi)
        ),
        history_function=None,
    )


def tabulate(
    profiles: Profiles, material: HalfSpace, *, law: str = "auto", nodes: int = 32
) -> LawTable:
    """Law table of a batch: the ellipse law, guarded by direct maximisation where it ends early.

    Where no polynomial describes a summit beyond its tip (a noisy spike on a ridge), the
    continuation of the ellipse law can be off by factors. Such summits, a few in a hundred, are
    tabulated by `ritz` as well; where both disagree grossly, `ritz` is taken and the disagreement
    is their spread. So are summits whose smallest polynomial is no summit: the ellipse law has
    nothing to say of them.
    """
    table = replace(ellipse.tabulate(profiles, material, nodes=nodes), law=law)
    left = (table.flags[:, 1 : LATEST_END + 1] & Flag.BEYOND_RADIUS).any(axis=1)
    lost = profiles.valid & (table.reach == 0)
    doubtful = np.flatnonzero((left & (table.reach > 0)) | lost)
    if not doubtful.size:
        return table
    second = ritz.tabulate(profiles.rows(doubtful), material, nodes=nodes)
    ratio = _worst_ratio(table, doubtful, second)
    ratio[lost[doubtful]] = np.inf
    wrong = ratio > GROSS
    return _merged(table, doubtful[wrong], second, np.flatnonzero(wrong), ratio[wrong])


def _worst_ratio(table: LawTable, rows: NDArray[np.int64], second: LawTable) -> Array:
    """Largest ratio of the two forces, either way, over a few shares of the reach."""
    own = np.arange(rows.size)
    worst = np.ones(rows.size)
    for share in (0.003, 0.01, 0.03, 0.1):
        approach = share * table.reach[rows]
        first, other = table.evaluate(rows, approach)[0], second.evaluate(own, approach)[0]
        usable = (first > 0) & (other > 0) & (second.reach > 0)
        ratio = np.divide(first, other, out=np.ones(rows.size), where=usable)
        worst = np.maximum(worst, np.maximum(ratio, 1 / ratio))
    return worst


def _merged(
    table: LawTable,
    rows: NDArray[np.int64],
    second: LawTable,
    chosen: NDArray[np.int64],
    ratio: Array,
) -> LawTable:
    """`table` with its `rows` replaced by the `chosen` rows of `second`."""
    columns = {}
    for name in ("reach", "force", "stiffness", "area", "flags"):
        columns[name] = getattr(table, name).copy()
        columns[name][rows] = getattr(second, name)[chosen]
    spread = table.spread.copy()
    spread[rows] = np.maximum(spread[rows], np.minimum(ratio - 1, 1.0)[:, None])
    if table.centre is not None:
        columns["centre"] = table.centre.copy()
        columns["centre"][rows] = 0.0 if second.centre is None else second.centre[chosen]
    return replace(table, spread=spread, **columns)
