"""Compiled loops between points and the B-spline mesh.

A mesh line r belongs to the node r - 1, so that the four nodes about a point at p (in steps) are
the lines int(p) to int(p) + 3, modulo the size of the mesh.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(inline="always")
def _weights(t, w, d, c):  # type: ignore[no-untyped-def]
    """Cubic B-spline weights of the four nodes about a point, their first and second slopes."""
    s = 1.0 - t
    w[0] = s * s * s / 6.0
    w[1] = (3.0 * t - 6.0) * t * t / 6.0 + 4.0 / 6.0
    w[2] = (3.0 * s - 6.0) * s * s / 6.0 + 4.0 / 6.0
    w[3] = t * t * t / 6.0
    d[0] = -0.5 * s * s
    d[1] = (1.5 * t - 2.0) * t
    d[2] = 0.5 + (1.0 - 1.5 * t) * t
    d[3] = 0.5 * t * t
    c[0] = s
    c[1] = 3.0 * t - 2.0
    c[2] = 1.0 - 3.0 * t
    c[3] = t


@njit(cache=True, nogil=True)
def deposit(rows, y, x, force, variance, cap, dipole, per_step, grid):  # type: ignore[no-untyped-def]
    """Spread sources on the meshes `grid` (1 or 2, my, mx).

    First mesh: forces with half their variance, up to `cap`, times the Laplacian; second mesh, if
    there is one: forces times shifts `dipole` (n, 2).
    """
    grid[:] = 0.0
    moves = grid.shape[0] > 1
    my, mx = grid.shape[1:]
    ny, nx = per_step
    wy, dy, cy, wx, dx, cx = np.empty((6, 4))
    for i in range(rows[0], rows[1]):
        f = force[i]
        if f == 0.0:
            continue
        iy = int(y[i] * ny)
        ix = int(x[i] * nx)
        _weights(y[i] * ny - iy, wy, dy, cy)
        _weights(x[i] * nx - ix, wx, dx, cx)
        half = 0.5 * min(variance[i], cap)
        inner = ix + 4 <= mx
        for a in range(4):
            row = (iy + a) % my
            value = f * (wy[a] + half * ny * ny * cy[a])
            bent = f * half * nx * nx * wy[a]
            if inner:
                for b in range(4):
                    grid[0, row, ix + b] += value * wx[b] + bent * cx[b]
            else:
                for b in range(4):
                    grid[0, row, (ix + b) % mx] += value * wx[b] + bent * cx[b]
            if moves:
                along = dipole[i, 0] * ny * dy[a]
                across = dipole[i, 1] * nx * wy[a]
                for b in range(4):
                    grid[1, row, (ix + b) % mx] += along * wx[b] + across * dx[b]


@njit(cache=True, nogil=True)
def gather(rows, y, x, force, variance, cap, own, per_step, grid, part, out):  # type: ignore[no-untyped-def]
    """Sum of the mesh part, less what each point does to itself there, and the near `part`s.

    Into `out` (n, 6): v0, v1, the gradient by y and x, and the field of the shifts; the last three
    only if there is a second mesh.
    """
    moves = grid.shape[0] > 1
    my, mx = grid.shape[1:]
    ny, nx = per_step
    f0, f1, f2 = own
    wy, dy, cy, wx, dx, cx = np.empty((6, 4))
    for i in range(rows[0], rows[1]):
        iy = int(y[i] * ny)
        ix = int(x[i] * nx)
        _weights(y[i] * ny - iy, wy, dy, cy)
        _weights(x[i] * nx - ix, wx, dx, cx)
        value = 0.0
        bent = 0.0
        along = 0.0
        across = 0.0
        moved = 0.0
        inner = ix + 4 <= mx
        for a in range(4):
            row = (iy + a) % my
            p = 0.0
            q = 0.0
            s = 0.0
            for b in range(4):
                column = ix + b if inner else (ix + b) % mx
                here = grid[0, row, column]
                p += wx[b] * here
                q += cx[b] * here
                s += dx[b] * here
                if moves:
                    moved += wy[a] * wx[b] * grid[1, row, column]
            value += wy[a] * p
            bent += ny * ny * cy[a] * p + nx * nx * wy[a] * q
            along += dy[a] * p
            across += wy[a] * s
        held = min(variance[i], cap)
        bent *= 0.5
        value += held * bent - force[i] * (f0 + held * (f1 + 0.25 * held * f2))
        slope = bent - force[i] * (0.5 * f1 + 0.25 * held * f2) if variance[i] < cap else 0.0
        for c in range(part.shape[0]):
            value += part[c, i, 0]
            slope += part[c, i, 1]
        out[i, 0] = value
        out[i, 1] = slope
        if moves:
            along *= ny
            across *= nx
            longer = 0.0
            for c in range(part.shape[0]):
                along += part[c, i, 2]
                across += part[c, i, 3]
                moved += part[c, i, 4]
                longer += part[c, i, 5]
            out[i, 2] = along
            out[i, 3] = across
            out[i, 4] = moved
            out[i, 5] = longer


@njit(cache=True, nogil=True)
def sample(y, x, per_step, grid, out):  # type: ignore[no-untyped-def]
    """Mesh potential at any points."""
    my, mx = grid.shape
    wy, dy, cy, wx, dx, cx = np.empty((6, 4))
    for i in range(y.size):
        iy = int(y[i] * per_step[0])
        ix = int(x[i] * per_step[1])
        _weights(y[i] * per_step[0] - iy, wy, dy, cy)
        _weights(x[i] * per_step[1] - ix, wx, dx, cx)
        value = 0.0
        for a in range(4):
            row = (iy + a) % my
            for b in range(4):
                value += wy[a] * wx[b] * grid[row, (ix + b) % mx]
        out[i] = value


@njit(cache=True, nogil=True)
def spline(rows, index, y, x, variance, cap, per_step, place, weight):  # type: ignore[no-untyped-def]
    """First line and column (n, 2) and the 16 weights (n, 4, 4) of spread forces at the points
    `index`, as `deposit` and `gather` apply them."""
    ny, nx = per_step
    wy, dy, cy, wx, dx, cx = np.empty((6, 4))
    for k in range(rows[0], rows[1]):
        i = index[k]
        iy = int(y[i] * ny)
        ix = int(x[i] * nx)
        _weights(y[i] * ny - iy, wy, dy, cy)
        _weights(x[i] * nx - ix, wx, dx, cx)
        half = 0.5 * min(variance[k], cap)
        place[k, 0] = iy
        place[k, 1] = ix
        for a in range(4):
            value = wy[a] + half * ny * ny * cy[a]
            bent = half * nx * nx * wy[a]
            for b in range(4):
                weight[k, a, b] = value * wx[b] + bent * cx[b]


@njit(cache=True, nogil=True)
def spread(rows, place, weight, vector, grid):  # type: ignore[no-untyped-def]
    """Forces `vector` on the mesh by stored weights."""
    grid[:] = 0.0
    my, mx = grid.shape
    for k in range(rows[0], rows[1]):
        value = np.float32(vector[k])
        iy = place[k, 0]
        ix = place[k, 1]
        if ix + 4 <= mx:
            for a in range(4):
                row = iy + a if iy + a < my else iy + a - my
                for b in range(4):
                    grid[row, ix + b] += value * weight[k, a, b]
        else:
            for a in range(4):
                row = iy + a if iy + a < my else iy + a - my
                for b in range(4):
                    grid[row, (ix + b) % mx] += value * weight[k, a, b]


@njit(cache=True, nogil=True)
def collect(rows, place, weight, vector, grid, diagonal, part, scale, out):  # type: ignore[no-untyped-def]
    """scale (diagonal vector + mesh potential by stored weights + near `part`s), into `out`."""
    my, mx = grid.shape
    for k in range(rows[0], rows[1]):
        iy = place[k, 0]
        ix = place[k, 1]
        total = np.float32(0.0)
        if ix + 4 <= mx:
            for a in range(4):
                row = iy + a if iy + a < my else iy + a - my
                for b in range(4):
                    total += weight[k, a, b] * grid[row, ix + b]
        else:
            for a in range(4):
                row = iy + a if iy + a < my else iy + a - my
                for b in range(4):
                    total += weight[k, a, b] * grid[row, (ix + b) % mx]
        value = diagonal[k] * vector[k] + total
        for c in range(part.shape[0]):
            value += part[c, k]
        out[k] = scale * value


@njit(cache=True, nogil=True)
def smooth_symbol(qy, qx, along, across, power, table, scale, out):  # type: ignore[no-untyped-def]
    """Product of `along`, `across` and q^-power times the table, read at scale q^power."""
    last = table.size - 2
    for a in range(qy.size):
        for b in range(qx.size):
            q2 = qy[a] * qy[a] + qx[b] * qx[b]
            rising = math.sqrt(q2) if power == 1.0 else q2 ** (0.5 * power)
            place = rising * scale
            if place >= last + 1 or q2 == 0.0:
                out[a, b] = 0.0
                continue
            c = int(place)
            share = table[c] + (place - c) * (table[c + 1] - table[c])
            out[a, b] = along[a] * across[b] * share / rising
