"""Compiled loops of the interaction sum: cell lists, B-spline mesh, near pairs, tangent."""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange


@njit(inline="always")
def _weights(t, w, c):
    """Cubic B-spline weights w of the four nodes about a point, and their second derivatives c."""
    s = 1.0 - t
    w[0] = s * s * s / 6.0
    w[1] = (3.0 * t - 6.0) * t * t / 6.0 + 4.0 / 6.0
    w[2] = (3.0 * s - 6.0) * s * s / 6.0 + 4.0 / 6.0
    w[3] = t * t * t / 6.0
    c[0] = s
    c[1] = 3.0 * t - 2.0
    c[2] = 1.0 - 3.0 * t
    c[3] = t


@njit(inline="always")
def _lookup(table, place, column):
    i = int(place)
    if i > table.shape[0] - 2:
        i = table.shape[0] - 2
    t = place - i
    return table[i, column] + t * (table[i + 1, column] - table[i, column])


@njit(cache=True, nogil=True)
def half_list(y, x, start, cells, size, wrap, far, far_scale):
    """Pairs closer than 1/far_scale nodes allow: CSR rows i < j of points sorted by cell.

    `start` (cells + 1) bounds the points of each cell; `size` is the cell (Ly, Lx) and `wrap`
    says whether it repeats; the cut-off is one where r^2 * far_scale reaches the last far node.
    Returns ptr (n + 1), col (k) and pair (k, 4): r^2, f, Laplacian f, Laplacian^2 f.
    """
    n = y.size
    cut = (far.shape[0] - 1) / far_scale
    ncy, ncx = cells
    ptr = np.zeros(n + 1, np.int64)
    col = np.empty(0, np.int32)
    pair = np.empty((0, 4), np.float32)
    for fill in range(2):
        if fill == 1:
            for i in range(n):
                ptr[i + 1] += ptr[i]
            col = np.empty(ptr[n], np.int32)
            pair = np.empty((ptr[n], 4), np.float32)
        for cy in range(ncy):
            for cx in range(ncx):
                home = cy * ncx + cx
                for i in range(start[home], start[home + 1]):
                    k = ptr[i]
                    count = 0
                    for oy in range(-1, 2):
                        by = cy + oy
                        if ncy == 1:
                            if oy != 0:
                                continue
                        elif by < 0 or by >= ncy:
                            if not wrap:
                                continue
                            by = (by + ncy) % ncy
                        for ox in range(-1, 2):
                            bx = cx + ox
                            if ncx == 1:
                                if ox != 0:
                                    continue
                            elif bx < 0 or bx >= ncx:
                                if not wrap:
                                    continue
                                bx = (bx + ncx) % ncx
                            other = by * ncx + bx
                            for j in range(max(start[other], i + 1), start[other + 1]):
                                dy = abs(y[i] - y[j])
                                dx = abs(x[i] - x[j])
                                if wrap:
                                    dy = min(dy, size[0] - dy)
                                    dx = min(dx, size[1] - dx)
                                r2 = dy * dy + dx * dx
                                if r2 >= cut:
                                    continue
                                if fill == 1:
                                    col[k] = j
                                    pair[k, 0] = r2
                                    for q in range(3):
                                        pair[k, q + 1] = _lookup(far, r2 * far_scale, q)
                                    k += 1
                                count += 1
                    if fill == 0:
                        ptr[i + 1] = count
    return ptr, col, pair


@njit(cache=True, nogil=True)
def deposit(y, x, force, variance, per_step, grid):
    """Spread forces with half their variance times the Laplacian on the mesh (periodic)."""
    grid[:] = 0.0
    my, mx = grid.shape
    wy, cy, wx, cx = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    for i in range(y.size):
        if force[i] == 0.0:
            continue
        py = y[i] * per_step[0]
        px = x[i] * per_step[1]
        iy = int(py)
        ix = int(px)
        _weights(py - iy, wy, cy)
        _weights(px - ix, wx, cx)
        hy = 0.5 * variance[i] * per_step[0] ** 2
        hx = 0.5 * variance[i] * per_step[1] ** 2
        for a in range(4):
            row = iy + a - 1
            if row < 0:
                row += my
            elif row >= my:
                row -= my
            value = force[i] * (wy[a] + hy * cy[a])
            bent = force[i] * hx * wy[a]
            for b in range(4):
                column = ix + b - 1
                if column < 0:
                    column += mx
                elif column >= mx:
                    column -= mx
                grid[row, column] += value * wx[b] + bent * cx[b]


@njit(cache=True, nogil=True, parallel=True)
def field(y, x, force, variance, per_step, grid, ptr, col, pair, bounds, shape, power, part, out):
    """Displacement and half its Laplacian at every point: mesh plus near pairs.

    `part` (chunks, n, 2) is work space, `out` (n, 2) receives v0 and v1: the energy
    of the pair (i, j) is F_i F_j N(r; m_i, m_j), and v0_i = sum F_j N, v1_i = sum F_j dN/dm_i.
    """
    my, mx = grid.shape
    nodes = shape.shape[0] - 1
    for c in prange(bounds.size - 1):
        part[c] = 0.0
        for i in range(bounds[c], bounds[c + 1]):
            a0 = 0.0
            a1 = 0.0
            for k in range(ptr[i], ptr[i + 1]):
                j = col[k]
                if force[i] == 0.0 and force[j] == 0.0:
                    continue
                spread = variance[i] + variance[j]
                reach = pair[k, 0] + spread
                w = spread / reach * nodes
                if power == 1.0:
                    scale = 1.0 / math.sqrt(reach)
                else:
                    scale = reach ** (-0.5 * power)
                cross = 0.25 * pair[k, 3]
                value = (
                    _lookup(shape, w, 0) * scale
                    - pair[k, 1]
                    - 0.5 * spread * pair[k, 2]
                    - variance[i] * variance[j] * cross
                )
                slope = _lookup(shape, w, 1) * scale / reach - 0.5 * pair[k, 2]
                a0 += force[j] * value
                a1 += force[j] * (slope - variance[j] * cross)
                part[c, j, 0] += force[i] * value
                part[c, j, 1] += force[i] * (slope - variance[i] * cross)
            part[c, i, 0] += a0
            part[c, i, 1] += a1
        wy, cy, wx, cx = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
        for i in range(bounds[c], bounds[c + 1]):
            py = y[i] * per_step[0]
            px = x[i] * per_step[1]
            iy = int(py)
            ix = int(px)
            _weights(py - iy, wy, cy)
            _weights(px - ix, wx, cx)
            value = 0.0
            bent = 0.0
            for a in range(4):
                row = iy + a - 1
                if row < 0:
                    row += my
                elif row >= my:
                    row -= my
                p = 0.0
                q = 0.0
                for b in range(4):
                    column = ix + b - 1
                    if column < 0:
                        column += mx
                    elif column >= mx:
                        column -= mx
                    p += wx[b] * grid[row, column]
                    q += cx[b] * grid[row, column]
                value += wy[a] * p
                bent += per_step[0] ** 2 * cy[a] * p + per_step[1] ** 2 * wy[a] * q
            out[i, 0] = value + 0.5 * variance[i] * bent
            out[i, 1] = 0.5 * bent
    for c in range(bounds.size - 1):
        for i in range(y.size):
            out[i, 0] += part[c, i, 0]
            out[i, 1] += part[c, i, 1]


@njit(cache=True, nogil=True)
def tangent_list(ptr, col, pair, rank, variance, shape, power, tptr, tcol, tval):
    """Pairs of active points (rank >= 0) and their tangent values; returns their number."""
    nodes = shape.shape[0] - 1
    k = 0
    for i in range(rank.size):
        if rank[i] < 0:
            continue
        for e in range(ptr[i], ptr[i + 1]):
            j = col[e]
            if rank[j] < 0:
                continue
            spread = variance[i] + variance[j]
            reach = pair[e, 0] + spread
            if power == 1.0:
                scale = 1.0 / math.sqrt(reach)
            else:
                scale = reach ** (-0.5 * power)
            tcol[k] = rank[j]
            tval[k] = (
                _lookup(shape, spread / reach * nodes, 0) * scale
                - pair[e, 1]
                - 0.5 * spread * pair[e, 2]
                - 0.25 * variance[i] * variance[j] * pair[e, 3]
            )
            k += 1
        tptr[rank[i] + 1] = k
    return k


@njit(cache=True, nogil=True, parallel=True)
def tangent(y, x, variance, per_step, grid, tptr, tcol, tval, bounds, diagonal, v, part, out):
    """out = (diagonal + near pairs + mesh) v over the active points."""
    my, mx = grid.shape
    for c in prange(bounds.size - 1):
        part[c] = 0.0
        for i in range(bounds[c], bounds[c + 1]):
            total = 0.0
            for k in range(tptr[i], tptr[i + 1]):
                j = tcol[k]
                total += tval[k] * v[j]
                part[c, j] += tval[k] * v[i]
            part[c, i] += total
        wy, cy, wx, cx = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
        for i in range(bounds[c], bounds[c + 1]):
            py = y[i] * per_step[0]
            px = x[i] * per_step[1]
            iy = int(py)
            ix = int(px)
            _weights(py - iy, wy, cy)
            _weights(px - ix, wx, cx)
            hy = 0.5 * variance[i] * per_step[0] ** 2
            hx = 0.5 * variance[i] * per_step[1] ** 2
            value = 0.0
            for a in range(4):
                row = iy + a - 1
                if row < 0:
                    row += my
                elif row >= my:
                    row -= my
                p = 0.0
                q = 0.0
                for b in range(4):
                    column = ix + b - 1
                    if column < 0:
                        column += mx
                    elif column >= mx:
                        column -= mx
                    p += wx[b] * grid[row, column]
                    q += cx[b] * grid[row, column]
                value += (wy[a] + hy * cy[a]) * p + hx * wy[a] * q
            out[i] = value + diagonal[i] * v[i]
    for c in range(bounds.size - 1):
        for i in range(out.size):
            out[i] += part[c, i]
