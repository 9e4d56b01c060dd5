"""Compiled loops between points and the B-spline mesh.

A mesh line r belongs to the node r - 1, so that the four nodes about a point at p (in steps) are
the lines int(p) to int(p) + 3, modulo the size of the mesh.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from surfaces._compiled import compiled

FAST = {"reassoc", "contract", "nsz"}


@njit(inline="always")
def _weights(t):
    """Cubic B-spline weights of the four nodes about a point, their first and second slopes."""
    s = 1.0 - t
    w = (
        s * s * s / 6.0,
        (3.0 * t - 6.0) * t * t / 6.0 + 4.0 / 6.0,
        (3.0 * s - 6.0) * s * s / 6.0 + 4.0 / 6.0,
        t * t * t / 6.0,
    )
    d = (-0.5 * s * s, (1.5 * t - 2.0) * t, 0.5 + (1.0 - 1.5 * t) * t, 0.5 * t * t)
    return w, d, (s, 3.0 * t - 2.0, 1.0 - 3.0 * t, t)


@njit(inline="always")
def _lines(first, count):
    """Four lines of the mesh from the first on."""
    a = np.uint64(first)
    last = np.uint64(count)
    b = a + np.uint64(1) if a + np.uint64(1) < last else a + np.uint64(1) - last
    c = a + np.uint64(2) if a + np.uint64(2) < last else a + np.uint64(2) - last
    d = a + np.uint64(3) if a + np.uint64(3) < last else a + np.uint64(3) - last
    return a, b, c, d


@compiled(fastmath=FAST)
def deposit(rows, y, x, force, variance, cap, dipole, per_step, grid):
    """Spread sources on the meshes `grid` (1 or 2, my, mx).

    First mesh: forces with half their variance, up to `cap`, times the Laplacian; second mesh, if
    there is one: forces times shifts `dipole` (n, 2).
    """
    grid[:] = 0.0
    moves = grid.shape[0] > 1
    my, mx = grid.shape[1:]
    ny, nx = per_step
    one = np.uint64(1)
    for i in range(rows[0], rows[1]):
        f = force[i]
        if f == 0.0:
            continue
        iy = int(y[i] * ny)
        ix = int(x[i] * nx)
        wy, dy, cy = _weights(y[i] * ny - iy)
        wx, dx, cx = _weights(x[i] * nx - ix)
        lines = _lines(iy, my)
        columns = _lines(ix, mx)
        half = 0.5 * min(variance[i], cap)
        for a in range(4):
            value = f * (wy[a] + half * ny * ny * cy[a])
            bent = f * half * nx * nx * wy[a]
            for b in range(4):
                grid[0, lines[a], columns[b]] += value * wx[b] + bent * cx[b]
        if moves:
            along = dipole[i, 0] * ny
            across = dipole[i, 1] * nx
            for a in range(4):
                for b in range(4):
                    change = along * dy[a] * wx[b] + across * wy[a] * dx[b]
                    grid[one, lines[a], columns[b]] += change


@compiled(fastmath=FAST)
def gather(
    rows,
    y,
    x,
    force,
    variance,
    cap,
    own,
    per_step,
    scale,
    grid,
    part,
    value,
    slope,
    tilt,
    moved,
    longer,
):
    """Sum of the mesh part, less what each point does to itself there, and the near `part`s.

    Into `value`, `slope`, `tilt` (n, 2), `moved` and `longer`, times `scale` (3): of lengths, of
    slopes over variance, and of gradients; the last three
    only if there is a second mesh.
    """
    moves = grid.shape[0] > 1
    my, mx = grid.shape[1:]
    ny, nx = per_step
    f0, f1, f2 = own
    one = np.uint64(1)
    for i in range(rows[0], rows[1]):
        iy = int(y[i] * ny)
        ix = int(x[i] * nx)
        wy, dy, cy = _weights(y[i] * ny - iy)
        wx, dx, cx = _weights(x[i] * nx - ix)
        lines = _lines(iy, my)
        columns = _lines(ix, mx)
        level, bent, along, across, other = 0.0, 0.0, 0.0, 0.0, 0.0
        for b in range(4):
            p, q, r = 0.0, 0.0, 0.0
            for a in range(4):
                here = grid[0, lines[a], columns[b]]
                p += wy[a] * here
                q += cy[a] * here
                r += dy[a] * here
            level += wx[b] * p
            bent += ny * ny * wx[b] * q + nx * nx * cx[b] * p
            along += wx[b] * r
            across += dx[b] * p
        held = min(variance[i], cap)
        bent *= 0.5
        level += held * bent - force[i] * (f0 + held * (f1 + 0.25 * held * f2))
        bent = bent - force[i] * (0.5 * f1 + 0.25 * held * f2) if variance[i] < cap else 0.0
        for c in range(part.shape[0]):
            level += part[c, i, 0]
            bent += part[c, i, 1]
        value[i] = scale[0] * level
        slope[i] = scale[1] * bent
        if moves:
            for b in range(4):
                p = 0.0
                for a in range(4):
                    p += wy[a] * grid[one, lines[a], columns[b]]
                other += wx[b] * p
            along *= ny
            across *= nx
            extra = 0.0
            for c in range(part.shape[0]):
                along += part[c, i, 2]
                across += part[c, i, 3]
                other += part[c, i, 4]
                extra += part[c, i, 5]
            tilt[i, 0] = scale[2] * along
            tilt[i, 1] = scale[2] * across
            moved[i] = scale[0] * other
            longer[i] = scale[0] * extra


@compiled(fastmath=FAST)
def sample(y, x, origin, unit, size, wrap, per_step, scale, grid, out):
    """`scale` times the mesh potential at any points, which lie at (y - origin[0]) / unit in a cell
    of this `size`; beyond one that does not repeat, zero."""
    my, mx = grid.shape
    high, wide = size
    for i in range(y.size):
        py = (y[i] - origin[0]) / unit
        px = (x[i] - origin[1]) / unit
        if wrap:
            py -= math.floor(py / high) * high
            px -= math.floor(px / wide) * wide
        out[i] = 0.0
        if not (0.0 <= py <= high and 0.0 <= px <= wide):
            continue
        py = min(py * per_step[0], my - 1e-9) if wrap else py * per_step[0]
        px = min(px * per_step[1], mx - 1e-9) if wrap else px * per_step[1]
        iy = int(py)
        ix = int(px)
        wy, _, _ = _weights(py - iy)
        wx, _, _ = _weights(px - ix)
        lines = _lines(iy, my)
        columns = _lines(ix, mx)
        value = 0.0
        for a in range(4):
            for b in range(4):
                value += wy[a] * wx[b] * grid[lines[a], columns[b]]
        out[i] = scale * value


@compiled(fastmath=FAST)
def spline(rows, index, y, x, variance, cap, per_step, place, weight):
    """First line and column (n, 2) and the 16 weights (n, 4, 4) of spread forces at the points
    `index`, as `deposit` and `gather` apply them."""
    ny, nx = per_step
    for k in range(rows[0], rows[1]):
        i = index[k]
        iy = int(y[i] * ny)
        ix = int(x[i] * nx)
        wy, _, cy = _weights(y[i] * ny - iy)
        wx, _, cx = _weights(x[i] * nx - ix)
        half = 0.5 * min(variance[k], cap)
        place[k, 0] = iy
        place[k, 1] = ix
        for a in range(4):
            value = wy[a] + half * ny * ny * cy[a]
            bent = half * nx * nx * wy[a]
            for b in range(4):
                weight[k, a, b] = value * wx[b] + bent * cx[b]


@compiled()
def spread(rows, place, weight, vector, grid):
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


@compiled()
def collect(rows, place, weight, vector, grid, diagonal, part, scale, out):
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


@compiled(fastmath=FAST)
def convolve(masses, high, wide, transfer, out):
    """Circular convolution of `masses` (count, my, mx) into `out` with an even kernel: waves that
    are even and odd about the middle of the mesh along either side, by products of matrices.

    `high` and `wide` are the `Mesh.waves` along y and x; `transfer` (2, 2, my / 2, mx / 2) is that
    of waves even or odd along x, and along y.
    """
    count, my, mx = masses.shape
    h, g = my // 2, mx // 2
    part = np.empty((2, 2, h, g), masses.dtype)
    other = np.empty((h, g), masses.dtype)
    for k in range(count):
        for i in range(h):
            for j in range(g):
                near, far = masses[k, i, j], masses[k, i, mx - 1 - j]
                low, last = masses[k, my - 1 - i, j], masses[k, my - 1 - i, mx - 1 - j]
                part[0, 0, i, j] = (near + far) + (low + last)
                part[1, 0, i, j] = (near - far) + (low - last)
                part[0, 1, i, j] = (near + far) - (low + last)
                part[1, 1, i, j] = (near - far) - (low - last)
        for b in range(2):
            for a in range(2):
                # a product of arrays, or another shape of one, would take 1 s each to compile
                one = part[b, a]
                np.dot(high[0, a], one, other)
                np.dot(other, wide[1, b], one)
                for i in range(h):
                    for j in range(g):
                        one[i, j] *= transfer[b, a, i, j]
                np.dot(one, wide[0, b], other)
                np.dot(high[1, a], other, one)
        for i in range(h):
            for j in range(g):
                even, across = part[0, 0, i, j], part[1, 0, i, j]
                along, both = part[0, 1, i, j], part[1, 1, i, j]
                out[k, i, j] = (even + across) + (along + both)
                out[k, i, mx - 1 - j] = (even - across) + (along - both)
                out[k, my - 1 - i, j] = (even + across) - (along + both)
                out[k, my - 1 - i, mx - 1 - j] = (even - across) - (along - both)


@compiled()
def smooth_symbol(qy, qx, along, across, power, table, scale, out):
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
