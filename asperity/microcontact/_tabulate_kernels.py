"""Numba kernel of the batched law about the optimal ellipse: fit, march, basin and table row."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ._basin_kernels import basin_space, fill
from ._ellipse_kernels import SHAPE, STATES, march, march_space
from ._fit_kernels import FITS, fit_one, fit_space
from ._lanes import FAST, LANES, groups, load, spread_rows
from ._polynomial_kernels import TERMS
from ._row_kernels import carried_on, expanded_levels, marked, resampled, row_space

SMALLEST_RATIO = 1 / 40
"""Least axis ratio of the ellipses on which a summit is fitted."""


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _frame(phi, angle, weight, curvature, edge, q, skews, direction, unit, wide):
    """Length, height, ratio of the rays and number of the base ellipse of a profile.

    Fills the directions of the rays in the axes of the summit, the lengths of the rays in the
    ellipse of semi-axes `wide` (product 1) and these. The ellipse has about the axis ratio
    ``(k2/k1)**0.63`` of the Hertzian contact; the largest fit reaches 1.1 times the rms distance
    of the basin edge in units of it.
    """
    rays = phi.size
    ray = rays // 8
    stretch = math.tan(2 * math.pi * ray / rays) / math.tan(phi[ray] - angle)
    ratio = 1.0
    if curvature[0] > 0.0:
        ratio = min(max((curvature[1] / curvature[0]) ** 0.63, SMALLEST_RATIO), 1.0)
    step = math.log(skews[1] / skews[0])
    number = int(math.log(1 / (ratio * stretch * skews[0])) / step + 0.5)
    number = min(max(number, 0), skews.size - 1)
    wide[0] = math.sqrt(skews[number] * stretch)
    wide[1] = 1.0 / wide[0]
    square, top = 0.0, 0.0
    for p in range(rays):
        turn = phi[p] - angle
        cx, cy = math.cos(turn), math.sin(turn)
        direction[0, p], direction[1, p] = cx, cy
        unit[p] = 1.0 / math.sqrt((cx * wide[1]) ** 2 + (cy * wide[0]) ** 2)
        square += (edge[p] / unit[p]) ** 2
        top = max(top, q[p, q.shape[1] - 1] * edge[p] * edge[p])
    return 1.1 * math.sqrt(square / rays), 2.0 * top, stretch, number


@njit(cache=True, nogil=True)
def _usable(coefs):
    """Whether a fit is finite and its smallest ellipse rises across the ridge."""
    for s in range(coefs.shape[0]):
        for r in range(coefs.shape[1]):
            if not math.isfinite(coefs[s, r]):
                return False
    return coefs[coefs.shape[0] - 1, 5] > 0.0


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
def tabulate_rows(
    begin, end, profiles, rules, levels, settings, rows, moments, weights, punch, resampling, out
):  # fmt: skip
    """Table rows of the profiles [begin, end); `ellipse_batch._rules` makes most arguments."""
    phis, angles, all_weights, curvatures, edges, qs, valid, rows_of_q = profiles
    radii, rings, image, skews, matrices, members, count, logs = rules
    u, powers, stencils = levels
    m, modulus, steps, grid, start, inverse = settings
    reach = out[0]
    rays, samples, p = edges.shape[1], qs.shape[2], 3 + m
    fitting = fit_space(rays, radii.size, matrices.shape[2], matrices.shape[3])
    marching = march_space()
    filling_in = basin_space(rays, u.size)
    columns, made = row_space(u.size, resampling[0].size)
    unit, wide, coefs = np.empty(rays), np.empty(2), np.zeros((FITS, TERMS))
    direction, edge = np.empty((2, rays)), np.empty(rays)
    who, scales = np.zeros(LANES, np.int64), groups(4)
    fits, directions, edge_lanes = groups(FITS * TERMS), groups(2 * rays), groups(rays)
    q, weight_lanes, block = groups(rows_of_q.shape[1]), groups(rays), groups(LANES)
    state, shape, filling = groups(u.size * STATES), groups(SHAPE), groups(4 * u.size)
    taken = 0
    for i in range(begin, end):
        if valid[i]:
            length, height, stretch, number = _frame(
                phis[i], angles[i], all_weights[i], curvatures[i], edges[i], qs[i], skews,
                direction, unit, wide,
            )  # fmt: skip
            if length > 0.0 and height > 0.0:
                basin = 0.0
                for k in range(rays):
                    unit[k] *= length
                    edge[k] = edges[i, k] / length
                    basin += 0.5 * all_weights[i, k] * edge[k] * edge[k]
                fit_one(
                    qs[i], edges[i], height, unit, wide, radii, rings, image, matrices[number],
                    members, count, coefs, fitting,
                )  # fmt: skip
                if _usable(coefs):
                    for lane in range(taken, LANES):
                        for k in range(FITS * TERMS):
                            fits[k * LANES + lane] = coefs[k // TERMS, k % TERMS]
                        for k in range(rays):
                            edge_lanes[k * LANES + lane] = edge[k]
                            directions[k * LANES + lane] = direction[0, k]
                            directions[(rays + k) * LANES + lane] = direction[1, k]
                            weight_lanes[k * LANES + lane] = all_weights[i, k]
                        who[lane] = i
                        scales[lane], scales[LANES + lane] = length, height
                        scales[2 * LANES + lane], scales[3 * LANES + lane] = basin, stretch
                    taken += 1
        if taken < LANES and (i + 1 < end or taken == 0):
            continue
        first, last = march(
            fits, logs[1], FITS, edge_lanes, rays, load(scales, 3), u, steps, m, rows, grid,
            moments, state, shape, marching,
        )  # fmt: skip
        spread_rows(rows_of_q, who, q, block)
        lengths, basins = load(scales, 0), load(scales, 2)
        fill(
            q, samples, weights, weight_lanes, directions, edge_lanes, rays,
            lengths * lengths / load(scales, 1), shape, state, last, u, m, punch, start, inverse,
            filling, filling_in,
        )  # fmt: skip
        expanded_levels(state, first, last, u, powers, stencils, p, columns)
        carried_on(filling, last, u, basins, p, columns)
        resampled(columns, u, powers, resampling, p, made)
        marked(state, filling, first, last, basins, resampling, made)
        for lane in range(taken):
            n = who[lane]
            length, height = scales[lane], scales[LANES + lane]
            reach[n] = height
            scale = modulus * length ** (1 + m)
            units = (scale * height, scale)
            _write(made, resampling[0].size, lane, length, angles[n], units, n, out)
        taken = 0
