"""Compiled loops of the interaction sum: cell lists, B-spline mesh, near pairs, tangent."""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(inline="always")
def _weights(t, w, c):  # type: ignore[no-untyped-def]
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


@njit(cache=True, nogil=True)
def half_list(y, x, start, cells, size, wrap, cut, rows, ptr, far, far_scale, col, pair):  # type: ignore[no-untyped-def]
    """Pairs of points closer than sqrt(cut) for the rows [rows[0], rows[1]) of cells.

    Points are sorted by cell, bounded by `start`; `size` is the extent (Ly, Lx) and `wrap` says
    whether it repeats. With empty `col`, counts the pairs i < j of each i into ptr[i + 1]; else
    fills `col` and `pair` (r^2, f, Laplacian f, Laplacian^2 f) from ptr[i] on.
    """
    ncy, ncx = cells
    fill = col.size > 0
    for cy in range(rows[0], rows[1]):
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
                            if fill:
                                col[k] = j
                                pair[k, 0] = r2
                                place = r2 * far_scale
                                c = min(int(place), far.shape[0] - 2)
                                t = place - c
                                for q in range(3):
                                    pair[k, q + 1] = far[c, q] + t * (far[c + 1, q] - far[c, q])
                                k += 1
                            count += 1
                if not fill:
                    ptr[i + 1] = count


@njit(cache=True, nogil=True)
def deposit(rows, y, x, force, variance, cap, per_step, grid):  # type: ignore[no-untyped-def]
    """Spread forces with half their variance, up to `cap`, times the Laplacian on the mesh."""
    grid[:] = 0.0
    my, mx = grid.shape
    wy, cy, wx, cx = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    for i in range(rows[0], rows[1]):
        if force[i] == 0.0:
            continue
        py = y[i] * per_step[0]
        px = x[i] * per_step[1]
        iy = int(py)
        ix = int(px)
        _weights(py - iy, wy, cy)
        _weights(px - ix, wx, cx)
        half = 0.5 * min(variance[i], cap)
        hy = half * per_step[0] ** 2
        hx = half * per_step[1] ** 2
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


@njit(cache=True, nogil=True)
def gather(rows, y, x, per_step, grid, out):  # type: ignore[no-untyped-def]
    """Mesh potential (column 0) and half its Laplacian (column 1) at the points."""
    my, mx = grid.shape
    wy, cy, wx, cx = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    for i in range(rows[0], rows[1]):
        py = y[i] * per_step[0]
        px = x[i] * per_step[1]
        iy = int(py)
        ix = int(px)
        _weights(py - iy, wy, cy)
        _weights(px - ix, wx, cx)
        value = 0.0
        bent_y = 0.0
        bent_x = 0.0
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
            bent_y += cy[a] * p
            bent_x += wy[a] * q
        out[i, 0] = value
        out[i, 1] = 0.5 * (per_step[0] ** 2 * bent_y + per_step[1] ** 2 * bent_x)


@njit(cache=True, nogil=True)
def near_field(rows, force, variance, cap, ptr, col, pair, shape, power, out):  # type: ignore[no-untyped-def]
    """Near pairs of the rows, both ways: v0 and v1 added into `out` (n, 2).

    The energy of the pair (i, j) is F_i F_j N(r; m_i, m_j); v0_i = sum F_j N and
    v1_i = sum F_j dN/dm_i. The smooth part that is subtracted takes variances up to `cap` only,
    as the mesh does.
    """
    nodes = shape.shape[0] - 1
    out[:] = 0.0
    for i in range(rows[0], rows[1]):
        a0 = 0.0
        a1 = 0.0
        loaded = force[i] != 0.0
        vi = min(variance[i], cap)
        fi = 1.0 if variance[i] < cap else 0.0
        for k in range(ptr[i], ptr[i + 1]):
            j = col[k]
            if not loaded and force[j] == 0.0:
                continue
            vj = min(variance[j], cap)
            fj = 1.0 if variance[j] < cap else 0.0
            spread = variance[i] + variance[j]
            inverse = 1.0 / (pair[k, 0] + spread)
            w = spread * inverse * nodes
            c = min(int(w), nodes - 1)
            t = w - c
            scale = math.sqrt(inverse) if power == 1.0 else inverse ** (0.5 * power)
            bend = 0.5 * pair[k, 2]
            cross = 0.25 * pair[k, 3]
            value = (
                (shape[c, 0] + t * (shape[c + 1, 0] - shape[c, 0])) * scale
                - pair[k, 1]
                - (vi + vj) * bend
                - vi * vj * cross
            )
            slope = (shape[c, 1] + t * (shape[c + 1, 1] - shape[c, 1])) * scale * inverse
            a0 += force[j] * value
            a1 += force[j] * (slope - fi * (bend + vj * cross))
            out[j, 0] += force[i] * value
            out[j, 1] += force[i] * (slope - fj * (bend + vi * cross))
        out[i, 0] += a0
        out[i, 1] += a1


@njit(cache=True, nogil=True)
def tangent_list(rows, ptr, col, pair, rank, variance, cap, shape, power, k, tptr, tcol, tval):  # type: ignore[no-untyped-def]
    """Pairs of active points (rank >= 0) of the rows and their tangent values, from place k on."""
    nodes = shape.shape[0] - 1
    for i in range(rows[0], rows[1]):
        if rank[i] < 0:
            continue
        vi = min(variance[i], cap)
        tptr[rank[i], 0] = k
        for e in range(ptr[i], ptr[i + 1]):
            j = col[e]
            if rank[j] < 0:
                continue
            vj = min(variance[j], cap)
            spread = variance[i] + variance[j]
            inverse = 1.0 / (pair[e, 0] + spread)
            w = spread * inverse * nodes
            c = min(int(w), nodes - 1)
            scale = math.sqrt(inverse) if power == 1.0 else inverse ** (0.5 * power)
            tcol[k] = rank[j]
            tval[k] = (
                (shape[c, 0] + (w - c) * (shape[c + 1, 0] - shape[c, 0])) * scale
                - pair[e, 1]
                - 0.5 * (vi + vj) * pair[e, 2]
                - 0.25 * vi * vj * pair[e, 3]
            )
            k += 1
        tptr[rank[i], 1] = k


@njit(cache=True, nogil=True)
def near_tangent(rows, tptr, tcol, tval, v, out):  # type: ignore[no-untyped-def]
    """Near pairs of the tangent matrix times v, both ways."""
    out[:] = 0.0
    for i in range(rows[0], rows[1]):
        total = 0.0
        for k in range(tptr[i, 0], tptr[i, 1]):
            j = tcol[k]
            total += tval[k] * v[j]
            out[j] += tval[k] * v[i]
        out[i] += total


@njit(cache=True, nogil=True)
def advance(length, stiffness, direction, image, solution, residual):  # type: ignore[no-untyped-def]
    """One step of conjugate gradients; returns residual . stiffness residual."""
    product = 0.0
    for i in range(solution.size):
        solution[i] += length * direction[i]
        residual[i] -= length * image[i]
        product += stiffness[i] * residual[i] * residual[i]
    return product


@njit(cache=True, nogil=True)
def redirect(ratio, stiffness, residual, direction):  # type: ignore[no-untyped-def]
    """New direction: scaled residual plus `ratio` times the old one."""
    for i in range(direction.size):
        direction[i] = stiffness[i] * residual[i] + ratio * direction[i]


@njit(cache=True, nogil=True)
def dot(a, b):  # type: ignore[no-untyped-def]
    """Scalar product, in one thread."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total
