"""Compiled loops that continue contours beyond their expansion, on rays to the edges of the basins.

Each ray grows with its edge operator, e(a) ~ d, and the force is the integral of the stiffness of
the planform, k = k_ellipse [1 + (1 - m^2)/4 sum (n - 1) e_n^2] (docs/development/laws.md, "Bounded
by the basin").

Units inside: one length and one height per profile, modulus 1. Arrays are groups of eight numbers,
one per profile (`surfaces.numerics.lanes`).
"""

from __future__ import annotations

import math

from surfaces.numerics.compiled import QUOTIENTS, inner
from surfaces.numerics.lanes import (
    LANES,
    between,
    exponential,
    groups,
    least,
    load,
    logarithm,
    most,
    pick,
    sine_cosine,
    splat,
    store,
)
from surfaces.numerics.vectors import entries, root, some, where, whole

from ._contour_kernels import NODES, place

CELLS = 24
"""Number of cells of a ray; in each the square root of the edge operator is linear."""

MOST_UNEVEN = 1.0
"""Largest sum (n - 1) e_n^2 that the correction of the stiffness uses."""


@inner(fastmath=QUOTIENTS)
def _ray_radius(shape, cx, cy):
    """Radii of the contours of the expansion in the directions (cx, cy) from the summits, or -1."""
    a, b = load(shape, 0), load(shape, 1)
    x0, y0, turn = load(shape, 2), load(shape, 3), load(shape, 4)
    ts, tc = sine_cosine(turn)
    ox, oy = -(tc * x0 + ts * y0) / a, (ts * x0 - tc * y0) / b
    dx, dy = (tc * cx + ts * cy) / a, (tc * cy - ts * cx) / b
    dd, od, oo = dx * dx + dy * dy, ox * dx + oy * dy, ox * ox + oy * oy
    rest = od * od - dd * (oo - 1.0)
    r = (root(most(rest, splat(0.0))) - od) / dd
    ex, ey = ox + r * dx, oy + r * dy
    t = place(where(ex < 0.0, -ex, ex), where(ey < 0.0, -ey, ey), 4) * (NODES - 1.0)
    i = between(whole(t), splat(0.0), splat(NODES - 2.0))
    image = where(ex < 0.0, where(ey < 0.0, splat(2.0), 1.0), where(ey < 0.0, splat(3.0), 0.0))
    i += 5.0 + image * NODES
    near, far = pick(shape, i), pick(shape, i + 1.0)
    r *= 1.0 + near + (t - (i - 5.0 - image * NODES)) * (far - near)
    return where((rest > 0.0) & (oo < 0.98), r, -1.0)


@inner(fastmath=QUOTIENTS)
def _unevenness(radius, rays, lobes):
    """sum (n - 1) e_n^2 over the harmonics n > 2 of the radii, of amplitudes e_n over the mean: the
    correlations of the radii over lags of 0, 1, 2 ... rays, times the weights `lobes`."""
    found, square = splat(0.0), splat(0.0)
    for p in range(rays):
        r = load(radius, p)
        square += r * r
        for lag in range(lobes.size):
            found += lobes[lag] * r * load(radius, (p + lag) % rays)
    return found / square


@inner(fastmath=QUOTIENTS)
def _planform(radius, weight, direction, rays, m, punch, out, place_):
    """Area, stiffness and centre of planforms on rays, in four groups of `out`.

    `punch` holds the stiffnesses of unit punches over the logarithm of their axis ratio, the first
    of these logarithms, the inverse of their step, and the weights of `_unevenness`.

    The stiffness is that of the ellipse of equal area and second moments, times
    1 + (1 - m^2)/4 sum (n - 1) e_n^2 for the other harmonics, of amplitudes e_n over the radius of
    the ellipse. Afterwards `radius` is in units of the radius of the ellipse.
    """
    area, mx, my = splat(0.0), splat(0.0), splat(0.0)
    xx, xy, yy = splat(0.0), splat(0.0), splat(0.0)
    for p in range(rays):
        r, cx, cy = load(radius, p), load(direction, p), load(direction, rays + p)
        r2 = load(weight, p) * r * r
        r3 = r2 * r
        r4x, r4y = r3 * r * cx, r3 * r * cy
        area += r2
        mx += r3 * cx
        my += r3 * cy
        xx += r4x * cx
        xy += r4x * cy
        yy += r4y * cy
    area *= 0.5
    unit = 1.0 / area
    mx, my = mx * unit * (1 / 3), my * unit * (1 / 3)
    xx, yy = 0.25 * xx * unit - mx * mx, 0.25 * yy * unit - my * my
    xy = 0.25 * xy * unit - mx * my
    mean, bend = 0.5 * (xx + yy), 0.5 * (xx - yy)
    half = root(bend * bend + xy * xy)
    large, small = mean + half, most(mean - half, 2e-12 * mean)
    stiffness, start, inverse, lobes = punch
    x = (0.5 * logarithm(small / large) - start) * inverse
    x = between(x, splat(0.0), splat(stiffness.size - 1.0))
    i = between(whole(x), splat(1.0), splat(stiffness.size - 3.0))
    u = x - i
    k = entries(stiffness, i - 1.0) * (u * (u - 1.0) * (u - 2.0) * (-1 / 6))
    k += entries(stiffness, i) * ((u + 1.0) * (u - 1.0) * (u - 2.0) * 0.5)
    k -= entries(stiffness, i + 1.0) * ((u + 1.0) * u * (u - 2.0) * 0.5)
    k += entries(stiffness, i + 2.0) * ((u + 1.0) * u * (u - 1.0) * (1 / 6))
    k *= exponential((0.5 + 0.5 * m) * logarithm(area * (1 / math.pi)))
    store(out, place_, area)
    unit = 1.0 / (large * small)
    for p in range(rays):
        cx, cy = load(direction, p), load(direction, rays + p)
        square = (yy * cx * cx - 2.0 * xy * cx * cy + xx * cy * cy) * unit
        store(radius, p, load(radius, p) * root(most(square, splat(0.0))))
    excess = between(_unevenness(radius, rays, lobes), splat(0.0), splat(MOST_UNEVEN))
    store(out, place_ + 1, k * (1.0 + (1 - m * m) / 4 * excess))
    store(out, place_ + 2, mx)
    store(out, place_ + 3, my)


@inner(fastmath=QUOTIENTS)
def _operator(q, first, nodes, weights, unit, out):
    """Edge operator at the ends of the cells of a ray with nodes q[first : first + nodes]."""
    for j in range(CELLS + 1):
        total = splat(0.0)
        for k in range(nodes):
            total += weights[k, j] * load(q, first + k)
        store(out, j, most(total, splat(0.0)) * (unit * (1.0 * j**2)))


@inner(fastmath=QUOTIENTS)
def fill(
    q, nodes, weights, weight, direction, edge, rays, scale, shape, last, levels, m, punch, out
):  # fmt: skip
    """Area, stiffness and centre (levels, 4) of planforms from the levels `last` on.

    `shape` is the last trusted contour. From there on the edge operator at the end of each ray
    grows in proportion to the approach: a ray reaches to the first radius at which its operator
    has this value, at most to the edge of the basin. The square root of the operator is linear
    between equispaced fractions of the ray. `scale` is the unit of q. Without a trusted contour
    (last = -1) the operator of every ray equals the approach.
    """
    square, rising, radius = groups(CELLS + 1), groups(CELLS + 1), groups(levels.size * rays)
    begin = most(last, splat(0.0))
    earliest = 0
    while not some(begin <= 1.0 * earliest):
        earliest += 1
    known = last >= 0.0
    level_begin = entries(levels, begin)
    for p in range(rays):
        length = load(edge, p)
        unit = scale * length * length * (1 / CELLS**2)
        _operator(q, p * nodes, nodes, weights, unit, square)
        r = _ray_radius(shape, load(direction, p), load(direction, rays + p))
        tip = level_begin * root((0.5 + 0.5 * m) / (load(q, p * nodes) * scale))
        r = least(where(known & (r > 0.0), r, tip), length)
        x = r / length * CELLS
        cell = least(whole(x), splat(CELLS - 1.0))
        low, high = root(pick(square, cell)), root(pick(square, cell + 1.0))
        speed = where(known, (low + (x - cell) * (high - low)) / level_begin, 1.0)
        top = splat(-1.0)
        for j in range(1, CELLS + 1):
            top = where(cell < j, most(load(square, j), top), top)
            store(rising, j, top)
        for level in range(earliest, levels.size):
            y = speed * levels[level]
            y2 = y * y
            below = splat(0.0)
            for j in range(1, CELLS + 1):
                below += where(load(rising, j) < y2, splat(1.0), 0.0)
            j = least(below, splat(CELLS - 1.0))
            low, high = root(least(pick(square, j), y2)), root(pick(square, j + 1.0))
            x = (j + (y - low) / most(high - low, splat(1e-300))) * (1 / CELLS)
            reached = where(below >= CELLS, length, most(r, length * x))
            r = where(begin < 1.0 * level, reached, r)
            store(radius, level * rays + p, r)
    for level in range(earliest, levels.size):
        _planform(
            radius[level * rays * LANES :], weight, direction, rays, m, punch, out,
            4 * level,
        )  # fmt: skip
