"""Compiled loops between points and the B-spline mesh.

A mesh line r belongs to the node r - 1, so that the four nodes about a point at p (in steps) are
the lines int(p) to int(p) + 3, modulo the size of the mesh.

Smooth part of the sum in `Interaction`: sources (1 + m_i/2 Laplacian) F_i delta(r - r_i) by
B-spline weights, their convolution, and the gather with the same weights
(docs/development/interaction.md, "Sum over pairs").

Lines and columns are unsigned: a signed index is compiled with a count from the end.
"""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import SUMS, compiled, inner

from ._pair_block_kernels import VARIANCE_CAP


@inner()
def _lines(first, count):
    """Four of the `count` lines or columns of the mesh from the first on, round the seam: the place
    of a point just before it may be rounded to the end of the mesh."""
    last = np.uint64(count)
    a = np.uint64(first) if np.uint64(first) < last else np.uint64(first) - last
    b = a + np.uint64(1) if a + np.uint64(1) < last else a + np.uint64(1) - last
    c = a + np.uint64(2) if a + np.uint64(2) < last else a + np.uint64(2) - last
    d = a + np.uint64(3) if a + np.uint64(3) < last else a + np.uint64(3) - last
    return a, b, c, d


@inner(fastmath=SUMS, forceinline=True)
def _at(py, px):
    """First line and column about a point, and its shares of a step behind the second ones."""
    iy, ix = int(py), int(px)
    return iy, ix, py - iy, px - ix


@inner(fastmath=SUMS, forceinline=True)
def _cubic(t):
    """Cubic B-spline w at the four nodes about a point, a share t of a step behind the second, its
    slopes w' and its bends w'' by the place of the point [steps]."""
    s = 1.0 - t
    value = (
        s * s * s / 6,
        (4 + t * t * (3 * t - 6)) / 6,
        (4 + s * s * (3 * s - 6)) / 6,
        t * t * t / 6,
    )
    slope = -0.5 * s * s, t * (1.5 * t - 2), s * (2 - 1.5 * s), 0.5 * t * t
    bend = s, 3 * t - 2, 1 - 3 * t, t
    return value, slope, bend


@compiled(fastmath=SUMS)
def deposit(y, x, force, variance, dipole, per_step, masses, aside):
    """Spread sources on the meshes `masses` and `aside` (my, mx).

    First mesh: forces with half their variance, up to `VARIANCE_CAP`, times the Laplacian,
    f [(w + half_y w'') w + w half_x w''] along y and x; second mesh: forces times shifts `dipole`
    (n, 2), shift_y w' w + shift_x w w'.
    """
    masses[:] = 0.0
    aside[:] = 0.0
    my, mx = masses.shape
    ny, nx = per_step
    for i in range(np.uint64(y.size)):
        f = force[i]
        if f == 0.0:
            continue
        iy, ix, ty, tx = _at(y[i] * ny, x[i] * nx)
        lines, columns = _lines(iy, my), _lines(ix, mx)
        along, steep, bent = _cubic(ty)
        across, slope, bend = _cubic(tx)
        half = 0.5 * min(variance[i], VARIANCE_CAP)
        half_y, half_x = half * ny * ny, half * nx * nx
        shift_y, shift_x = dipole[i, 0] * ny, dipole[i, 1] * nx
        for a in range(4):
            spread_y, spread_x = f * (along[a] + half_y * bent[a]), f * half_x * along[a]
            moved_y, moved_x = shift_y * steep[a], shift_x * along[a]
            for b in range(4):
                masses[lines[a], columns[b]] += spread_y * across[b] + spread_x * bend[b]
                aside[lines[a], columns[b]] += moved_y * across[b] + moved_x * slope[b]


@inner(fastmath=SUMS, forceinline=True)
def _read(mesh, iy, ix, ty, tx):
    """Value of the spline at the point, its slopes by y and x, and its second slopes [1/steps]."""
    my, mx = mesh.shape
    lines, columns = _lines(iy, my), _lines(ix, mx)
    value_y, slope_y, bend_y = _cubic(ty)
    value_x, slope_x, bend_x = _cubic(tx)
    level, along, across, bent, curved = 0.0, 0.0, 0.0, 0.0, 0.0
    for a in range(4):
        value, slope, bend = 0.0, 0.0, 0.0
        for b in range(4):
            node = mesh[lines[a], columns[b]]
            value += value_x[b] * node
            slope += slope_x[b] * node
            bend += bend_x[b] * node
        level += value_y[a] * value
        along += slope_y[a] * value
        across += value_y[a] * slope
        bent += bend_y[a] * value
        curved += value_y[a] * bend
    return level, along, across, bent, curved


@compiled(fastmath=SUMS)
def gather(rows, y, x, force, variance, own, per_step, scale, size, smooth, aside, near, out):
    """Sum of the mesh part, less what each point does to itself there, and the `near` part (n, 6).

    Into `out`, a `Field`, times `scale` (3): of lengths, of slopes over variance, which footprints
    have `size` times, and of gradients.
    """
    value, slope, tilt, moved, longer = out
    ny, nx = per_step
    f0, f1, f2 = own
    for i in range(np.uint64(rows[0]), np.uint64(rows[1])):
        iy, ix, ty, tx = _at(y[i] * ny, x[i] * nx)
        level, along, across, bent, curved = _read(smooth, iy, ix, ty, tx)
        held = min(variance[i], VARIANCE_CAP)
        bent = 0.5 * (ny * ny * bent + nx * nx * curved)
        level += held * bent - force[i] * (f0 + held * (f1 + 0.25 * held * f2))
        bent = (
            bent - force[i] * (0.5 * f1 + 0.25 * held * f2) if variance[i] < VARIANCE_CAP else 0.0
        )
        value[i] = scale[0] * (level + near[i, 0])
        slope[i] = scale[1] * size[i] * (bent + near[i, 1])
        level = _read(aside, iy, ix, ty, tx)[0]
        tilt[i, 0] = scale[2] * (ny * along + near[i, 2])
        tilt[i, 1] = scale[2] * (nx * across + near[i, 3])
        moved[i] = scale[0] * (level + near[i, 4])
        longer[i] = scale[0] * near[i, 5]


@compiled(fastmath=SUMS)
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
        iy, ix, ty, tx = _at(py, px)
        out[i] = scale * _read(grid, iy, ix, ty, tx)[0]


@compiled(fastmath=SUMS)
def spline(rows, index, y, x, variance, per_step, place, weight):
    """First line and column (n, 2) and the 16 weights (n, 4, 4) of spread forces at the points
    `index`, as `deposit` and `gather` apply them."""
    ny, nx = per_step
    for k in range(np.uint64(rows[0]), np.uint64(rows[1])):
        i = np.uint64(index[k])
        iy, ix, ty, tx = _at(y[i] * ny, x[i] * nx)
        place[k, 0] = iy
        place[k, 1] = ix
        along, _, bent = _cubic(ty)
        across, _, bend = _cubic(tx)
        half = 0.5 * min(variance[k], VARIANCE_CAP)
        half_y, half_x = half * ny * ny, half * nx * nx
        for a in range(4):
            spread_y = along[a] + half_y * bent[a]
            for b in range(4):
                weight[k, a, b] = spread_y * across[b] + half_x * along[a] * bend[b]


@compiled(fastmath=SUMS)
def spread(rows, place, weight, vector, grid):
    """Forces `vector` on the mesh by stored weights."""
    grid[:] = 0.0
    my, mx = grid.shape
    for k in range(np.uint64(rows[0]), np.uint64(rows[1])):
        lines, columns = _lines(place[k, 0], my), _lines(place[k, 1], mx)
        value = np.float32(vector[k])
        for a in range(4):
            for b in range(4):
                grid[lines[a], columns[b]] += value * weight[k, a, b]


@compiled(fastmath=SUMS)
def collect(rows, place, weight, vector, grid, diagonal, near, scale, out):
    """scale (diagonal vector + mesh potential by stored weights + `near`), into `out`."""
    my, mx = grid.shape
    for k in range(np.uint64(rows[0]), np.uint64(rows[1])):
        lines, columns = _lines(place[k, 0], my), _lines(place[k, 1], mx)
        total = np.float32(0.0)
        for a in range(4):
            for b in range(4):
                total += weight[k, a, b] * grid[lines[a], columns[b]]
        out[k] = scale * (diagonal[k] * vector[k] + total + near[k])


@compiled(fastmath=SUMS)
def convolve(masses, high, wide, transfer, out):
    """Circular convolution of `masses` (my, mx) into `out` with an even kernel: waves that are even
    and odd about the middle of the mesh along either side, by products of matrices.

    `high` and `wide` are the `Mesh.waves` along y and x; `transfer` (2, 2, my / 2, mx / 2) is that
    of waves even or odd along x, and along y.
    """
    my, mx = masses.shape
    h, g = my // 2, mx // 2
    part = np.empty((2, 2, h, g), masses.dtype)
    other = np.empty((h, g), masses.dtype)
    for i in range(h):
        for j in range(g):
            near, far = masses[i, j], masses[i, mx - 1 - j]
            low, last = masses[my - 1 - i, j], masses[my - 1 - i, mx - 1 - j]
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
            out[i, j] = (even + across) + (along + both)
            out[i, mx - 1 - j] = (even - across) + (along - both)
            out[my - 1 - i, j] = (even + across) - (along + both)
            out[my - 1 - i, mx - 1 - j] = (even - across) - (along - both)
