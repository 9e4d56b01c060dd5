"""Laws of single summits by boundary elements on their own basins.

Where few contacts carry the load their laws do not average out, and a summit that has outgrown its
expansion is off by several per cent. Its basin, cut out of the map and pressed alone, is a problem
of some two hundred unknowns.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asperity.bem.kernel import compliance, near_influence
from asperity.material import HalfSpace
from surfaces import _threads

from .flags import Flag
from .table import LawTable

if TYPE_CHECKING:
    from surfaces.peaks.summits import Summits

__all__ = ["press", "put"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

STEPS = np.array([0, 1, 2, 4, 6, 9, 13, 23])
"""Nodes of the table, from the last that the expansion describes on, at which a basin is pressed;
and the last node."""

POINTS = 300.0
"""Elements of the box about the part of a basin above the flat, of which contact takes a third."""

TOLERANCE = 1e-3
"""Work of the gaps that are left, over that of the pressures."""

SPREAD = 0.005
"""Error expected of the force: marks the laws made here."""

FEWEST = 3
"""Nodes pressed with less than which a law stays as it is."""


def press(summits: Summits, rows: Rows, depths: Array, material: HalfSpace) -> Array:
    """Force [N], area [m^2] and centre y, x [m] from the summit of basins pressed alone.

    Parameters
    ----------
    summits
        Summits of a map.
    rows
        Those to press, shape (n,).
    depths
        Approaches [m], shape (n, levels), rising along each row.
    material
        Half-space.

    Returns
    -------
    Array of shape (n, levels, 4); zero where a basin reaches too far, and above.

    Notes
    -----
    The flat presses the surface between the points of the map (its spline) as far as it belongs to
    the basin; the rest is taken away. The grid of rectangular elements lies along the long axis
    of the part of the basin above the flat. The edge of contact lies between elements, where
    pressure and gap of a smooth contact come to zero.
    """
    from ._element_kernels import press_rows

    hm, peaks = summits.hm, summits.peaks
    surface = (
        hm.heights, peaks.labels, summits.owner, hm.periodic, summits.spline.ravel(),
        summits.spline.shape[1], hm.spacing,
    )  # fmt: skip
    tops = (peaks.row, peaks.col, summits.places, summits.height, summits.angle, summits.curvature)
    out = np.zeros((*depths.shape, 4))
    unit = compliance((1.0, 1.0), material)
    rules = unit, material.m, _kernels(material.m), POINTS, TOLERANCE
    _threads.run(
        lambda a, b: press_rows(a, b, rows, surface, tops, depths, *rules, out),
        _threads.blocks(len(rows)),
    )
    return out


@lru_cache(maxsize=4)
def _kernels(m: float) -> NDArray[np.float32]:
    """Displacements by an element of unit area at offsets (row, column), sides as `ASPECTS`."""
    from ._element_kernels import ASPECTS, REACH

    out = np.zeros((len(ASPECTS), REACH, 2 * REACH), np.float32)
    for kernel, aspect in zip(out, ASPECTS, strict=True):
        right = near_influence((REACH, REACH), (aspect**-0.5, aspect**0.5), m)
        kernel[:, REACH:] = right
        kernel[:, 1:REACH] = right[:, :0:-1]
    return out


def put(table: LawTable, slots: Rows, summits: Summits, rows: Rows, material: HalfSpace) -> None:
    """Go on from the expansions of some contacts by their basins pressed alone.

    Parameters
    ----------
    table
        Laws by expansion; nobody else holds it. Up to the last node that its expansion describes a
        row stays as it is; it keeps its reach and its flags.
    slots, rows
        Rows of the table, and the summits that they belong to, shape (n,).
    summits, material
        As in `press`.

    Notes
    -----
    F / u^p and area / u^2 change slowly, u being the root of the approach over the reach: between
    the approaches at which a basin is pressed the first is a cubic spline, whose slope is the
    stiffness, and the second and the centre monotonic cubics.
    """
    if not slots.size:
        return
    beyond = (table.flags[slots] & Flag.BEYOND_RADIUS) > 0
    first = np.maximum(beyond.argmax(axis=1) - 1, 1)
    wanted = np.minimum(first[:, None] + STEPS, table.nodes)
    wanted[:, 1:][np.diff(wanted, axis=1) == 0] = 0
    u = np.arange(table.nodes + 1) / table.nodes
    found = press(summits, rows, table.reach[slots, None] * u[wanted] ** 2, material)
    for slot, begin, nodes, values in zip(slots, first, wanted, found, strict=True):
        known = values[:, 0] > 0.0
        if np.count_nonzero(known) >= FEWEST:
            _join(table, slot, begin, nodes[known], values[known])


def _join(table: LawTable, slot: int, begin: int, nodes: Rows, values: Array) -> None:
    """Put what was found at some nodes in the place of a row, from the node `begin` on."""
    from scipy.interpolate import CubicSpline, PchipInterpolator

    p, u = table.exponent, np.arange(table.nodes + 1) / table.nodes
    force, area, y, x = values.T
    before, end = np.arange(1, begin), int(nodes[-1])
    own, rest = u[begin : end + 1], slice(end, None)
    table.force[slot, rest] *= force[-1] / table.force[slot, end]
    table.stiffness[slot, rest] *= force[-1] / table.force[slot, end]
    table.area[slot, rest] *= area[-1] / table.area[slot, end]
    line = CubicSpline(
        u[np.append(before, nodes)],
        np.append(table.force[slot, before], force) / u[np.append(before, nodes)] ** p,
        bc_type="natural",
    )
    row = slice(begin, end + 1)
    table.force[slot, row] = own**p * line(own)
    slope = own ** (p - 2) * (p * line(own) + own * line(own, 1))
    table.stiffness[slot, row] = slope / (2.0 * table.reach[slot])
    found = np.stack((area / u[nodes] ** 2, x, y), axis=1)
    smooth = PchipInterpolator(u[nodes], found)(own)
    table.area[slot, row] = own**2 * smooth[:, 0]
    table.spread[slot, row] = SPREAD
    if table.centre is not None:
        table.centre[slot, row] = smooth[:, 1:]
