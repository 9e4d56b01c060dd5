"""Laws of single summits by boundary elements on their own basins.

The law of a summit that has outgrown its expansion is off by several per cent. Where few contacts
carry the load these errors do not average out. A basin cut out of the map and pressed alone is a
problem of some two hundred unknowns.
"""

from __future__ import annotations

import itertools
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asperity.errors import Flag
from asperity.halfspace.influence import compliance, near_influence
from asperity.halfspace.material import HalfSpace
from asperity.microcontact.law_kernels import BLUNT_TIP
from asperity.microcontact.law_table import LawTable
from surfaces.arrays import Array, Index
from surfaces.numerics import parallel
from surfaces.numerics.stored_array import mapped
from surfaces.peaks.peaks import RIM

if TYPE_CHECKING:
    from surfaces.peaks.summits import Summits

__all__ = ["areas_under", "press", "put"]


PRESSED_NODES = np.array([0, 1, 2, 4, 6, 9, 13, 23])
"""Nodes of the table at which a basin is pressed, counted from the last node that the expansion
describes; nodes beyond the table count as its last one."""

PRESSED_NODES_JOINED = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 19, 23])
"""`PRESSED_NODES` of joined summits, whose contact grows by jumps."""

ELEMENTS = 300.0
"""Number of elements in the box about the part of a basin above the flat at a given approach. The
contact takes a third of them."""

ELEMENTS_LOADED = 150.0
"""Number of elements in this box under a given force."""

GAP_WORK = 1e-3
"""Tolerance: work of the pressures on the residual overlaps, over their work on all overlaps."""

EXPECTED_ERROR = 0.005
"""Expected relative error of the force (`LawTable.spread`) of laws made here."""

NODES_BEFORE = 4
"""Number of nodes of the expansion, before the first pressed one, that the spline runs through."""

LEVELS_PER_THREAD = 8
"""Levels of a basin that a thread takes at a time: some basins take ten times as long as others."""

BASINS_PER_THREAD = 3
"""Basins under a force that a thread takes at a time."""

FEWEST_PRESSED = 3
"""Least number of nodes at which a basin was pressed; with fewer its law is not changed."""


def press(summits: Summits, rows: Index, depths: Array, material: HalfSpace) -> Array:
    """Press the basins of the summits `rows` alone at the approaches `depths` [m], (n, levels).

    Approaches ascend along each row. Returns for each, shape (n, levels, 8): force [N], area [m^2],
    centre y, x [m] of the pressure relative to the summit, second moments yy, xx, yx [m^2] of the
    pressure about this centre, and area of the basin above the flat [m^2]. All are zero where too
    few elements overlap, and from the level on at which a basin reaches too far.

    Notes
    -----
    The surface is the spline of the map within the basin; the rest of the map is left out. The grid
    of rectangular elements lies along the long axis of the part of the basin above the flat. The
    edge of contact lies between elements, where pressure and gap of a smooth contact become zero
    (`_closing_kernels.contact_size`).
    """
    from ._element_kernels import press_levels

    surface, tops = _scene(summits, summits.peaks.row, summits.peaks.col)
    out = np.zeros((*depths.shape, 8))
    unit = compliance((1.0, 1.0), material)
    rules = unit, material.m, _kernels(material.m), ELEMENTS, GAP_WORK
    spare: list[Any] = []

    def part(some: tuple[int, int]) -> None:
        slot, first = some
        space = spare.pop() if spare else _space()
        last = min(first + LEVELS_PER_THREAD, depths.shape[1])
        press_levels(slot, first, last, rows[slot], surface, tops, depths, *rules, out, space)
        spare.append(space)

    parts = itertools.product(range(len(rows)), range(0, depths.shape[1], LEVELS_PER_THREAD))
    parallel.each(part, [(k, a) for k, a in parts if a == 0 or depths[k, a] > 0.0])
    out[np.logical_or.accumulate(out[:, :, 0] < 0.0, axis=1)] = 0.0
    return out


def areas_under(
    summits: Summits, rows: Index, force: Array, depth: Array, body: HalfSpace
) -> Array:
    """Areas [m^2] of basins pressed alone by forces [N] under the hardness of a half-space, (n,).

    `depth` estimates the approaches [m]. An area is zero where a basin reaches too far, or does not
    bear the force.
    """
    from ._element_kernels import areas_under_load

    row, col = (np.rint(place).astype(np.int64) for place in summits.places.T)
    surface, tops = _scene(summits, row, col)
    out = np.zeros(len(rows))
    unit, kernels = compliance((1.0, 1.0), body), _kernels(body.m)
    rules = unit, body.m, body.hardness, kernels, ELEMENTS_LOADED, GAP_WORK

    def part(first: int, last: int) -> None:
        areas_under_load(first, last, rows, force, depth, surface, tops, *rules, out, _space())

    parallel.run(part, parallel.blocks(len(rows), BASINS_PER_THREAD))
    return out


def _scene(summits: Summits, row: Index, col: Index) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Arguments `surface` and `summits` of `press_levels`; `row`, `col` are pixels of summits."""
    hm, peaks = summits.hm, summits.peaks
    surface = (
        hm.mapped, mapped(peaks.labels), summits.owner, hm.periodic, summits.spline.ravel(),
        summits.spline.shape[1], hm.spacing,
    )  # fmt: skip
    tops = (
        row, col, summits.places, summits.height, summits.angle, summits.curvature, summits.floor,
        summits.tilt,
    )  # fmt: skip
    return surface, tops


def _space() -> tuple[tuple[NDArray[Any], ...], ...]:
    """Working arrays of `press_levels`: for the window on the map, the grid and its elements."""
    from ._closing_kernels import MOST_ELEMENTS, MOST_SIDE_ELEMENTS
    from ._element_kernels import HALF_WINDOW

    mark, grid = np.empty((2 * HALF_WINDOW + 1,) * 2, np.int32), MOST_SIDE_ELEMENTS**2
    return (
        (mark, *np.empty((2, mark.size), np.int64)),
        (np.empty(grid), np.empty(grid, np.int8), *np.empty((2, grid), np.int64), np.empty(4)),
        (
            (
                np.empty((MOST_ELEMENTS, MOST_ELEMENTS), np.float32),
                np.empty(MOST_ELEMENTS, bool),
            ),
            *np.empty((2, MOST_ELEMENTS), np.float32), np.empty((4, MOST_ELEMENTS), np.float32),
            *np.empty((2, MOST_ELEMENTS), np.int64),
        ),
    )  # fmt: skip


@lru_cache(maxsize=4)
def _kernels(m: float) -> NDArray[np.float32]:
    """Influences of an element of unit area at offsets (row, column), for each of `ASPECTS`."""
    from ._closing_kernels import MOST_SIDE_ELEMENTS
    from ._element_kernels import ASPECTS

    out = np.zeros((len(ASPECTS), MOST_SIDE_ELEMENTS, 2 * MOST_SIDE_ELEMENTS), np.float32)
    for kernel, aspect in zip(out, ASPECTS, strict=True):
        right = near_influence(
            (MOST_SIDE_ELEMENTS, MOST_SIDE_ELEMENTS), (aspect**-0.5, aspect**0.5), m
        )
        kernel[:, MOST_SIDE_ELEMENTS : 2 * MOST_SIDE_ELEMENTS] = right
        kernel[:, 1:MOST_SIDE_ELEMENTS] = right[:, :0:-1]
    return out


def put(table: LawTable, slots: Index, summits: Summits, rows: Index, material: HalfSpace) -> None:
    """Replace laws beyond their expansions by basins pressed alone, in place.

    `table` holds laws by expansion; its rows `slots` belong to the summits `rows`. A row keeps the
    nodes that its expansion describes, its reach and its flags.

    Notes
    -----
    With u = sqrt(d/reach), F / u^p and area / u^2 change slowly. Between the approaches at which a
    basin is pressed F / u^p is a cubic spline, whose slope gives the stiffness; area / u^2 and the
    centre are monotonic cubics.
    """
    if not slots.size:
        return
    beyond = (table.flags[slots] & Flag.BEYOND_RADIUS) > 0
    first = np.where(beyond.any(axis=1), beyond.argmax(axis=1) - 1, table.nodes)
    first[summits.kinds[rows] == RIM] = 1  # no expansion describes a tip that the border cuts
    joined = np.isfinite(summits.floor[rows])
    for k in np.flatnonzero(joined):
        first[k] = min(first[k], _second(table, slots[k], summits, rows[k]))
    first = np.maximum(first, 1)
    few = np.pad(PRESSED_NODES, (0, len(PRESSED_NODES_JOINED) - len(PRESSED_NODES)), "edge")
    steps = np.where(joined[:, None], PRESSED_NODES_JOINED, few)
    wanted = np.minimum(first[:, None] + steps, table.nodes)
    wanted[:, 1:][np.diff(wanted, axis=1) == 0] = 0
    u = np.arange(table.nodes + 1) / table.nodes
    found = press(summits, rows, table.reach[slots, None] * u[wanted] ** 2, material)
    # near m = -1 results can be NaN, or forces on no area
    found[~(np.isfinite(found).all(axis=2) & (found[:, :, 1] > 0.0))] = 0.0
    lost = np.flatnonzero(found[:, 0, 0] == 0.0)  # too few elements: values of the expansion
    node = slots[lost], first[lost]
    found[lost, 0, 0], found[lost, 0, 1] = table.force[node], table.area[node]
    if table.centre is not None:
        found[lost, 0, 2:4] = table.centre[node][:, ::-1]
    if table.bearing is not None:
        found[lost, 0, 7] = table.bearing[node]
    kinds, kind = np.unique(np.where(found[:, :, 0] > 0.0, wanted, 0), axis=0, return_inverse=True)
    for group, nodes in enumerate(kinds):
        some, known = np.flatnonzero(kind == group), nodes > 0
        if np.count_nonzero(known) >= FEWEST_PRESSED:
            _join(table, slots[some], nodes[known], found[some][:, known])


def _second(table: LawTable, slot: int, summits: Summits, row: int) -> int:
    """Last node of the law of a joined summit before the second of its summits touches."""
    others = np.setdiff1d(np.flatnonzero(summits.owner == row), row)
    ahead = float(summits.height[row] - summits.height[others].max())
    return int(table.nodes * min(max(ahead, 0.0) / table.reach[slot], 1.0) ** 0.5)


def _join(table: LawTable, slots: Index, nodes: Index, values: Array) -> None:
    """Write the `values` (k, n, 8) of the nodes `nodes` (n,) into the rows `slots` (k,), from the
    first of these nodes on. Beyond the last, rows are scaled to its values.

    A tip that is no paraboloid has another power of u than p: F over that power is interpolated.
    """
    from scipy.interpolate import CubicSpline, PchipInterpolator

    row, begin, last = slots[:, None], int(nodes[0]), int(nodes[-1])
    inside, later = np.arange(begin, last + 1), np.arange(last, table.nodes + 1)
    u, own = nodes / table.nodes, inside / table.nodes
    scale = values[:, -1:, 0] / table.force[row, last]
    table.force[row, later] *= scale
    table.stiffness[row, later] *= scale
    table.area[row, later] *= values[:, -1:, 1] / table.area[row, last]
    smooth = values[:, :, [1, 7, 3, 2]]
    smooth[:, :, :2] /= u[:, None] ** 2
    smooth = PchipInterpolator(nodes, smooth, axis=1)(inside)
    table.area[row, inside] = own**2 * smooth[:, :, 0]
    table.spread[row, inside] = EXPECTED_ERROR
    if table.bearing is not None:
        table.bearing[row, later] *= values[:, -1:, 7] / table.bearing[row, last]
        table.bearing[row, inside] = own**2 * smooth[:, :, 1]
    if table.centre is not None:
        table.centre[row, inside] = smooth[:, :, 2:]
    before = np.arange(max(begin - NODES_BEFORE, 1), begin)
    force = np.hstack((table.force[row, before], values[:, :, 0]))
    nodes = np.append(before, nodes)
    u, p = nodes / table.nodes, np.full(row.shape, table.exponent)
    if nodes[0] == 1:
        tip = np.log(force[:, 1:2] / force[:, :1]) / np.log(u[1] / u[0])
        p = np.where(np.abs(tip - p) > BLUNT_TIP, np.clip(tip, 2.0, 2.0 * p - 2.0), p)
    spline = CubicSpline(nodes, force / u**p, axis=1, bc_type="natural")
    line, rise = spline(inside), spline(inside, 1)
    table.force[row, inside] = own**p * line
    slope = own ** (p - 2) * (p * line + own * table.nodes * rise)
    table.stiffness[row, inside] = slope / (2.0 * table.reach[row])
