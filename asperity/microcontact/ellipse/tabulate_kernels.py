"""Numba kernel that makes rows of a law table from profiles followed about their ellipses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surfaces.numerics.compiled import compiled, inner
from surfaces.numerics.lanes import LANES, groups, load, ordered, spread_rows

from ._basin_kernels import basin_space, fill
from ._ellipse_kernels import SHAPE_ROW, STATES
from ._row_kernels import carried_on, expanded_levels, marked, resampled, row_space


@inner()
def _write(made, nodes, lane, length, angle, units, n, out):
    """Row n of the table from a lane of the finished rows, in `units`."""
    _, force, stiffness, area, flags, spread, centre = out
    c, s = math.cos(angle) * length, math.sin(angle) * length
    for j in range(nodes):
        k, step = j * LANES + lane, nodes * LANES
        force[n, j + 1] = made[k] * units[0]
        stiffness[n, j + 1] = made[k + step] * units[1]
        area[n, j + 1] = made[k + 2 * step] * length * length
        flags[n, j + 1] = int(made[k + 3 * step])
        spread[n, j + 1] = made[k + 4 * step]
        x, y = made[k + 5 * step], made[k + 6 * step]
        centre[n, j + 1, 0], centre[n, j + 1, 1] = c * x - s * y, s * x + c * y


def table_space(rays: int, samples: int, levels: int, nodes: int) -> tuple[Any, ...]:
    """Working groups of `tabulate_rows`.

    A block; nodes and weights of the rays, frames, scales, states, contours and trusted levels; the
    planforms and what they are made with; the columns and the rows.
    """
    row = -(-rays // LANES) * LANES
    counts = (-(-rays * samples // LANES) * LANES, row, 4 * rays, LANES)
    states = (-(-levels * STATES // LANES) * LANES, SHAPE_ROW, LANES)
    return (
        groups(LANES),
        tuple(map(groups, counts)),
        tuple(map(groups, states)),
        (groups(4 * levels), basin_space(rays, levels)),
        row_space(levels, nodes),
    )


@compiled()
def tabulate_rows(
    begin, profiles, frames, scales, found, levels, m, modulus, weights, punch, resampling, out,
    space,
):  # fmt: skip
    """Table rows of the profiles from `begin` on, of which `frames`, `scales` and `found` tell.

    Profiles of which the trust ends at the same level go together; those whose last scale is zero
    keep rows of zeros.
    """
    _, angles, all_weights, _, _, qs, _, rays, samples = profiles
    u, powers, stencils = levels
    states, shapes, ends = found
    n, p, nodes = len(scales), 3 + m, resampling[0].size
    who, own = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    block, (q, weight, frame, scale), (state, shape, end), (filling, filling_in), lines = space
    columns, made = lines
    keys = np.zeros(n, np.int64)
    for k in range(n):
        keys[k] = 1 + int(ends[k, 1]) if scales[k, LANES - 1] > 0.0 else u.size + 1
    order = ordered(keys, u.size + 1)
    count = 0
    while count < n and keys[order[count]] <= u.size:
        count += 1
    for i in range(0, count, LANES):
        for lane in range(LANES):
            own[lane] = order[min(i + lane, count - 1)]
            who[lane] = begin + own[lane]
        for source, at, target in (
            (qs, who, q), (all_weights, who, weight), (frames, own, frame), (scales, own, scale),
            (states, own, state), (shapes, own, shape), (ends, own, end),
        ):  # fmt: skip
            spread_rows(source, at, target, block)
        first, last = load(end, 0), load(end, 1)
        lengths, basins = load(scale, 0), load(scale, 2)
        fill(
            q, samples, weights, weight, frame, frame[2 * rays * LANES :], rays,
            lengths * lengths / load(scale, 1), shape, state, last, u, m, punch, filling,
            filling_in,
        )  # fmt: skip
        expanded_levels(state, first, last, u, powers, stencils, p, columns)
        carried_on(filling, last, u, basins, p, columns)
        resampled(columns, u, powers, resampling, p, made)
        marked(state, filling, first, last, basins, resampling, made)
        for lane in range(min(LANES, count - i)):
            k = who[lane]
            length, height = scale[lane], scale[LANES + lane]
            out[0][k] = height
            unit = modulus * length ** (1 + m)
            _write(made, nodes, lane, length, angles[k], (unit * height, unit), k, out)
