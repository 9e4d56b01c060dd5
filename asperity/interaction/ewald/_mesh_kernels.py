"""Compiled loops between points and the B-spline mesh.

A mesh line r belongs to the node r - 1, so that the four nodes about a point at p (in steps) are
the lines int(p) to int(p) + 3, modulo the size of the mesh.

Smooth part of the sum in `Interaction`: sources (1 + m_i/2 Laplacian) F_i delta(r - r_i) by
B-spline weights, their convolution, and the gather with the same weights
(docs/development/interaction.md, "Sum over pairs").
"""

from __future__ import annotations

import math

import numpy as np
from numba import carray, njit

from surfaces.numerics.compiled import SUMS, compiled, inner

from ._mesh_vector_kernels import add_moved, add_spread, add_stored, read, read_stored, set_stored
from ._pair_block_kernels import VARIANCE_CAP, doubles, floats

NODES, SIZE = np.uint64(4), np.uint64(16)
# lines of a patch on its own
PATCH = (np.uint64(0), np.uint64(4), np.uint64(8), np.uint64(12))


@inner()
def _lines(first, count):
    """Four lines of the mesh from the first on."""
    a = np.uint64(first)
    last = np.uint64(count)
    b = a + np.uint64(1) if a + np.uint64(1) < last else a + np.uint64(1) - last
    c = a + np.uint64(2) if a + np.uint64(2) < last else a + np.uint64(2) - last
    d = a + np.uint64(3) if a + np.uint64(3) < last else a + np.uint64(3) - last
    return a, b, c, d


@inner()
def _places(lines, first, width):
    """First of the four nodes from line `first` across on, on each of the lines."""
    a, b, c, d = lines
    return a * width + first, b * width + first, c * width + first, d * width + first


@njit(inline="always")
def _at(py, px):
    """First line and column about a point, and its shares of a step."""
    iy, ix = int(py), int(px)
    return np.uint64(iy), np.uint64(ix), (py - iy, px - ix)


@njit(inline="always")
def _add_patch(mesh, lines, first, patch):
    """Add a patch of 4 by 4 nodes that reaches over the seam."""
    columns = _lines(first, mesh.shape[1])
    for a in range(4):
        for b in range(4):
            mesh[lines[a], columns[b]] += patch[4 * a + b]


@njit(inline="always")
def _copy_patch(mesh, lines, first, patch):
    """Copy 4 by 4 nodes that lie about the seam."""
    columns = _lines(first, mesh.shape[1])
    for a in range(4):
        for b in range(4):
            patch[4 * a + b] = mesh[lines[a], columns[b]]


@compiled(fastmath=SUMS)
def deposit(y, x, force, variance, dipole, per_step, masses, aside):
    """Spread sources on the meshes `masses` and `aside` (my, mx).

    First mesh: forces with half their variance, up to `VARIANCE_CAP`, times the Laplacian; second
    mesh: forces times shifts `dipole` (n, 2).
    """
    masses[:] = 0.0
    aside[:] = 0.0
    patch = carray(doubles(), (16,))
    other = carray(floats(), (16,))
    my, mx = masses.shape
    width = np.uint64(mx)
    ny, nx = per_step
    for i in range(np.uint64(y.size)):
        f = force[i]
        if f == 0.0:
            continue
        iy, ix, at = _at(y[i] * ny, x[i] * nx)
        lines = _lines(iy, my)
        half = 0.5 * min(variance[i], VARIANCE_CAP)
        spread = (half * ny * ny, half * nx * nx)
        shifted = (dipole[i, 0] * ny, dipole[i, 1] * nx)
        if ix + NODES <= width:
            places = _places(lines, ix, width)
            add_spread(masses, places, at, spread, f)
            add_moved(aside, places, at, shifted)
            continue
        patch[:] = 0.0
        add_spread(patch, PATCH, at, spread, f)
        _add_patch(masses, lines, ix, patch)
        other[:] = 0.0
        add_moved(other, PATCH, at, shifted)
        _add_patch(aside, lines, ix, other)


@njit(inline="always")
def _read(mesh, iy, ix, at, patch):
    """`read` about a point of a mesh that repeats; `patch` is scratch."""
    lines = _lines(iy, mesh.shape[0])
    width = np.uint64(mesh.shape[1])
    if ix + NODES <= width:
        return read(mesh, _places(lines, ix, width), at)
    _copy_patch(mesh, lines, ix, patch)
    return read(patch, PATCH, at)


@compiled(fastmath=SUMS)
def gather(rows, y, x, force, variance, own, per_step, scale, size, smooth, aside, near, out):
    """Sum of the mesh part, less what each point does to itself there, and the `near` part (n, 6).

    Into `out`, a `Field`, times `scale` (3): of lengths, of slopes over variance, which footprints
    have `size` times, and of gradients.
    """
    value, slope, tilt, moved, longer = out
    patch = carray(doubles(), (16,))
    other = carray(floats(), (16,))
    ny, nx = per_step
    f0, f1, f2 = own
    for i in range(np.uint64(rows[0]), np.uint64(rows[1])):
        iy, ix, at = _at(y[i] * ny, x[i] * nx)
        level, along, across, bent, curved = _read(smooth, iy, ix, at, patch)
        held = min(variance[i], VARIANCE_CAP)
        bent = 0.5 * (ny * ny * bent + nx * nx * curved)
        level += held * bent - force[i] * (f0 + held * (f1 + 0.25 * held * f2))
        bent = (
            bent - force[i] * (0.5 * f1 + 0.25 * held * f2) if variance[i] < VARIANCE_CAP else 0.0
        )
        value[i] = scale[0] * (level + near[i, 0])
        slope[i] = scale[1] * size[i] * (bent + near[i, 1])
        level = _read(aside, iy, ix, at, other)[0]
        tilt[i, 0] = scale[2] * (ny * along + near[i, 2])
        tilt[i, 1] = scale[2] * (nx * across + near[i, 3])
        moved[i] = scale[0] * (level + near[i, 4])
        longer[i] = scale[0] * near[i, 5]


@compiled(fastmath=SUMS)
def sample(y, x, origin, unit, size, wrap, per_step, scale, grid, out):
    """`scale` times the mesh potential at any points, which lie at (y - origin[0]) / unit in a cell
    of this `size`; beyond one that does not repeat, zero."""
    patch = carray(doubles(), (16,))
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
        iy, ix, at = _at(py, px)
        out[i] = scale * _read(grid, iy, ix, at, patch)[0]


@compiled(fastmath=SUMS)
def spline(rows, index, y, x, variance, per_step, place, weight):
    """First line and column (n, 2) and the 16 weights (n, 4, 4) of spread forces at the points
    `index`, as `deposit` and `gather` apply them."""
    ny, nx = per_step
    for k in range(np.uint64(rows[0]), np.uint64(rows[1])):
        i = np.uint64(index[k])
        iy, ix, at = _at(y[i] * ny, x[i] * nx)
        half = 0.5 * min(variance[k], VARIANCE_CAP)
        place[k, 0] = iy
        place[k, 1] = ix
        set_stored(weight, SIZE * k, at, (half * ny * ny, half * nx * nx))


@compiled()
def spread(rows, place, weight, vector, grid):
    """Forces `vector` on the mesh by stored weights."""
    grid[:] = 0.0
    patch = carray(floats(), (16,))
    my, mx = grid.shape
    width = np.uint64(mx)
    for k in range(np.uint64(rows[0]), np.uint64(rows[1])):
        ix = np.uint64(place[k, 1])
        lines = _lines(place[k, 0], my)
        first = SIZE * k
        value = np.float32(vector[k])
        if ix + NODES <= width:
            add_stored(grid, _places(lines, ix, width), weight, first, value)
        else:
            patch[:] = 0.0
            add_stored(patch, PATCH, weight, first, value)
            _add_patch(grid, lines, ix, patch)


@compiled()
def collect(rows, place, weight, vector, grid, diagonal, near, scale, out):
    """scale (diagonal vector + mesh potential by stored weights + `near`), into `out`."""
    patch = carray(floats(), (16,))
    my, mx = grid.shape
    width = np.uint64(mx)
    for k in range(np.uint64(rows[0]), np.uint64(rows[1])):
        ix = np.uint64(place[k, 1])
        lines = _lines(place[k, 0], my)
        first = SIZE * k
        if ix + NODES <= width:
            total = read_stored(grid, _places(lines, ix, width), weight, first)
        else:
            _copy_patch(grid, lines, ix, patch)
            total = read_stored(patch, PATCH, weight, first)
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
