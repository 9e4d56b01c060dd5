"""Numba kernel of the batched law about the optimal ellipse: fit, march, basin and table row."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ._basin_kernels import basin_space, fill_one
from ._directions import FAST
from ._ellipse_kernels import SHAPE, STATES, march_one, march_space
from ._fit_kernels import FITS, fit_one, fit_space
from ._polynomial_kernels import TERMS
from ._row_kernels import carried_on, expanded_levels, resampled, row_space

SMALLEST_RATIO = 1 / 40
"""Least axis ratio of the ellipses on which a summit is fitted."""

_BEYOND, _FILLED = 64, 128


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


@njit(cache=True, nogil=True)
def _finish(columns, state, filling, ends, place, hermite, basin, length, angle, units, n, out):
    """Flags, spread and centre of a table row, and its columns in `units`."""
    _, force, stiffness, area, flags, spread, centre = out
    first, last = ends
    c, s = math.cos(angle) * length, math.sin(angle) * length
    for j in range(place.size):
        i, share = place[j], hermite[j, 8]
        low, high = first <= i <= last, first <= i + 1 <= last
        flag = 0
        if not ((low or share > 0.999) and (high or share < 0.001)):
            flag |= _BEYOND
        if columns[2, j] > 0.999 * basin:
            flag |= _FILLED
        flags[n, j + 1] = flag
        below, above = abs(state[i, 7]) if low else 0.05, abs(state[i + 1, 7]) if high else 0.05
        spread[n, j + 1] = (1 - share) * below + share * above
        x = (1 - share) * filling[i, 2] + share * filling[i + 1, 2]
        y = (1 - share) * filling[i, 3] + share * filling[i + 1, 3]
        centre[n, j + 1, 0], centre[n, j + 1, 1] = c * x - s * y, s * x + c * y
        force[n, j + 1] = columns[0, j] * units[0]
        stiffness[n, j + 1] = columns[1, j] * units[1]
        area[n, j + 1] = columns[2, j] * length * length


@njit(cache=True, nogil=True, error_model="numpy")
def tabulate_rows(
    begin, end, profiles, rules, levels, settings, rows, moments, weights, punch, resampling, out
):  # fmt: skip
    """Table rows of the profiles [begin, end); `ellipse_batch._rules` makes most arguments."""
    phis, angles, all_weights, curvatures, edges, qs, valid = profiles
    radii, rings, image, skews, matrices, members, count, logs = rules
    u, powers, stencils = levels
    m, modulus, most, start, inverse = settings
    nodes, place, hermite = resampling
    reach = out[0]
    rays, p = edges.shape[1], 3 + m
    fitting = fit_space(rays, radii.size, matrices.shape[2], matrices.shape[3])
    marching = march_space(rows.shape[1])
    filling_in = basin_space(rays, weights.shape[1])
    columns, made = row_space(u.size, nodes.size)
    direction, unit, edge = np.empty((2, rays)), np.empty(rays), np.empty(rays)
    wide, coefs = np.empty(2), np.zeros((FITS, TERMS))
    state, shape = np.zeros((u.size, STATES)), np.zeros((u.size, SHAPE))
    filling = np.empty((u.size, 4))
    for i in range(begin, end):
        if not valid[i]:
            continue
        length, height, stretch, number = _frame(
            phis[i], angles[i], all_weights[i], curvatures[i], edges[i], qs[i], skews, direction,
            unit, wide,
        )  # fmt: skip
        if not (length > 0.0 and height > 0.0):
            continue
        basin = 0.0
        for k in range(rays):
            unit[k] *= length
            edge[k] = edges[i, k] / length
            basin += 0.5 * all_weights[i, k] * edge[k] * edge[k]
        fit_one(
            qs[i], edges[i], height, unit, wide, radii, rings, image, matrices[number], members,
            count, coefs, fitting,
        )  # fmt: skip
        if not _usable(coefs):
            continue
        first, last = march_one(
            coefs, logs, edge, stretch, u, most, m, rows, start, inverse, moments, state,
            shape, marching,
        )  # fmt: skip
        fill_one(
            qs[i], weights, all_weights[i], direction, edge, length**2 / height, shape, last, u, m,
            punch, start, inverse, filling, filling_in,
        )  # fmt: skip
        if last >= 0:
            expanded_levels(state, first, last, u, powers, stencils, p, columns)
        carried_on(filling, last, u, basin, p, columns)
        resampled(columns, u, powers, place, hermite, nodes, p, made)
        reach[i] = height
        scale = modulus * length ** (1 + m)
        _finish(
            made, state, filling, (first, last), place, hermite, basin, length, angles[i],
            (scale * height, scale), i, out,
        )  # fmt: skip
