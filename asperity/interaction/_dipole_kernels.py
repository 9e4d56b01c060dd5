"""Compiled loops of the deflection: gradients of the field, and the field of shifted forces."""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(inline="always")
def _weights(t, w, d):  # type: ignore[no-untyped-def]
    """Cubic B-spline weights w of the four nodes about a point, and their first derivatives d."""
    s = 1.0 - t
    w[0] = s * s * s / 6.0
    w[1] = (3.0 * t - 6.0) * t * t / 6.0 + 4.0 / 6.0
    w[2] = (3.0 * s - 6.0) * s * s / 6.0 + 4.0 / 6.0
    w[3] = t * t * t / 6.0
    d[0] = -0.5 * s * s
    d[1] = (1.5 * t - 2.0) * t
    d[2] = 0.5 + (1.0 - 1.5 * t) * t
    d[3] = 0.5 * t * t


@njit(cache=True, nogil=True)
def mesh_gradient(rows, y, x, per_step, grid, out):  # type: ignore[no-untyped-def]
    """Gradient (n, 2) of the mesh potential at the points."""
    my, mx = grid.shape
    wy, dy, wx, dx = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    for i in range(rows[0], rows[1]):
        iy = int(y[i] * per_step[0])
        ix = int(x[i] * per_step[1])
        _weights(y[i] * per_step[0] - iy, wy, dy)
        _weights(x[i] * per_step[1] - ix, wx, dx)
        along_y = 0.0
        along_x = 0.0
        for a in range(4):
            row = (iy + a - 1 + my) % my
            for b in range(4):
                value = grid[row, (ix + b - 1 + mx) % mx]
                along_y += dy[a] * wx[b] * value
                along_x += wy[a] * dx[b] * value
        out[i, 0] = per_step[0] * along_y
        out[i, 1] = per_step[1] * along_x


@njit(cache=True, nogil=True)
def deposit_dipoles(rows, y, x, dipole, per_step, grid):  # type: ignore[no-untyped-def]
    """Spread force times shift (n, 2) on the mesh."""
    grid[:] = 0.0
    my, mx = grid.shape
    wy, dy, wx, dx = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    for i in range(rows[0], rows[1]):
        along_y = dipole[i, 0] * per_step[0]
        along_x = dipole[i, 1] * per_step[1]
        if along_y == 0.0 and along_x == 0.0:
            continue
        iy = int(y[i] * per_step[0])
        ix = int(x[i] * per_step[1])
        _weights(y[i] * per_step[0] - iy, wy, dy)
        _weights(x[i] * per_step[1] - ix, wx, dx)
        for a in range(4):
            row = (iy + a - 1 + my) % my
            for b in range(4):
                value = along_y * dy[a] * wx[b] + along_x * wy[a] * dx[b]
                grid[row, (ix + b - 1 + mx) % mx] += value


@njit(cache=True, nogil=True)
def near_gradient(  # type: ignore[no-untyped-def]
    rows,
    y,
    x,
    size,
    wrap,
    force,
    spread,
    moment,
    ptr,
    col,
    pair,
    shape,
    power,
    far,
    scale,
    pull,
    out,
):
    """Gradient of the near field at the loaded points, into `out` (n, 2).

    `spread` is the mean variance of a contact as receiver and as source, `moment` that as source.
    `pull` (k) keeps dN/dr / r of each pair with a loaded point, for `near_dipoles`.
    """
    nodes = shape.shape[0] - 1
    out[:] = 0.0
    for i in range(rows[0], rows[1]):
        loaded = force[i] != 0.0
        for k in range(ptr[i], ptr[i + 1]):
            j = col[k]
            if not loaded and force[j] == 0.0:
                continue
            dy = y[i] - y[j]
            dx = x[i] - x[j]
            if wrap:
                dy -= size[0] * round(dy / size[0])
                dx -= size[1] * round(dx / size[1])
            both = spread[i] + spread[j]
            inverse = 1.0 / (pair[k, 0] + both)
            w = both * inverse * nodes
            c = min(int(w), nodes - 1)
            root = math.sqrt(inverse) if power == 1.0 else inverse ** (0.5 * power)
            place = pair[k, 0] * scale
            e = min(int(place), far.shape[0] - 2)
            t = place - e
            value = (shape[c, 2] + (w - c) * (shape[c + 1, 2] - shape[c, 2])) * root * inverse
            value -= far[e, 3] + t * (far[e + 1, 3] - far[e, 3])
            bend = 0.5 * (far[e, 4] + t * (far[e + 1, 4] - far[e, 4]))
            pull[k] = value
            here = force[j] * (value - moment[j] * bend)
            there = force[i] * (value - moment[i] * bend)
            out[i, 0] += here * dy
            out[i, 1] += here * dx
            out[j, 0] -= there * dy
            out[j, 1] -= there * dx


@njit(cache=True, nogil=True)
def near_dipoles(rows, y, x, size, wrap, dipole, ptr, col, pull, out):  # type: ignore[no-untyped-def]
    """Near field of forces times shifts (n, 2), into `out` (n)."""
    out[:] = 0.0
    for i in range(rows[0], rows[1]):
        py = dipole[i, 0]
        px = dipole[i, 1]
        here = py != 0.0 or px != 0.0
        total = 0.0
        for k in range(ptr[i], ptr[i + 1]):
            j = col[k]
            if not here and dipole[j, 0] == 0.0 and dipole[j, 1] == 0.0:
                continue
            dy = y[i] - y[j]
            dx = x[i] - x[j]
            if wrap:
                dy -= size[0] * round(dy / size[0])
                dx -= size[1] * round(dx / size[1])
            total -= pull[k] * (dipole[j, 0] * dy + dipole[j, 1] * dx)
            out[j] += pull[k] * (py * dy + px * dx)
        out[i] += total
