"""Numba kernels that carry a contour on rays to the edge of its basin.

Units inside: one length and one height per profile, modulus 1.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ._directions import FAST, quarters
from ._ellipse_kernels import NODES


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _ray_radius(shape, level, cx, cy):
    """Radius of the contour of the expansion in the direction (cx, cy) from the summit."""
    a, b, x0, y0 = shape[level, 0], shape[level, 1], shape[level, 2], shape[level, 3]
    turn = shape[level, 4]
    tc, ts = math.cos(turn), math.sin(turn)
    ox, oy = -(tc * x0 + ts * y0) / a, (ts * x0 - tc * y0) / b
    dx, dy = (tc * cx + ts * cy) / a, (-ts * cx + tc * cy) / b
    dd = dx * dx + dy * dy
    od = ox * dx + oy * dy
    rest = od * od - dd * (ox * ox + oy * oy - 1)
    if rest <= 0.0 or ox * ox + oy * oy >= 0.98:
        return -1.0
    r = (math.sqrt(rest) - od) / dd
    ex, ey = ox + r * dx, oy + r * dy
    t = quarters(ex, ey) * (NODES - 1)
    i = min(max(int(t), 0), NODES - 2)
    u = t - i
    image = 0
    if ex < 0.0:
        image = 2 if ey < 0.0 else 1
    elif ey < 0.0:
        image = 3
    o = 5 + image * NODES + i
    return r * (1 + shape[level, o] * (1 - u) + shape[level, o + 1] * u)


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def _planform(radius, weight, direction, m, punch, start, inverse, out):
    """Area, stiffness and centre of the planform on rays.

    The stiffness is that of the ellipse of equal area and second moments, times the first
    correction for the other harmonics.
    """
    area, mx, my = 0.0, 0.0, 0.0
    xx, xy, yy = 0.0, 0.0, 0.0
    for p in range(radius.size):
        cx, cy = direction[0, p], direction[1, p]
        r2 = weight[p] * radius[p] * radius[p]
        r3 = r2 * radius[p]
        r4 = r3 * radius[p]
        area += r2
        mx += r3 * cx
        my += r3 * cy
        xx += r4 * cx * cx
        xy += r4 * cx * cy
        yy += r4 * cy * cy
    area *= 0.5
    mx /= 3 * area
    my /= 3 * area
    xx = xx / (4 * area) - mx * mx
    yy = yy / (4 * area) - my * my
    xy = xy / (4 * area) - mx * my
    half = math.sqrt(0.25 * (xx - yy) ** 2 + xy * xy)
    large, small = 0.5 * (xx + yy) + half, max(0.5 * (xx + yy) - half, 1e-12 * (xx + yy))
    inertia = large * small * (4 * math.pi / area) ** 2
    x = (0.5 * math.log(small / large) - start) * inverse
    x = min(max(x, 1.0), punch.size - 2.001)
    i = int(x)
    u = x - i
    k = -u * (u - 1) * (u - 2) / 6 * punch[i - 1]
    k += (u + 1) * (u - 1) * (u - 2) / 2 * punch[i]
    k += -(u + 1) * u * (u - 2) / 2 * punch[i + 1]
    k += (u + 1) * u * (u - 1) / 6 * punch[i + 2]
    k *= (area / math.pi) ** ((1 + m) / 2)
    out[0] = area
    out[1] = k * (1 + (1 - m * m) / 8 * min(max(inertia - 1, 0.0), 1.0))
    out[2] = mx
    out[3] = my


@njit(cache=True, nogil=True)
def basin_space(rays, radii):
    """Working arrays of `fill_one`."""
    return np.empty((2, rays, radii)), np.empty((2, rays)), np.zeros(rays, np.int64)


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def fill_one(
    q, weights, weight, direction, edge, scale, shape, first, levels, m, punch, start, inverse,
    out, space,
):  # fmt: skip
    """Area, stiffness and centre (levels, 4) of the planforms of a profile from level `first` on.

    On every ray the edge operator grows with the approach from its value at the contour
    shape[first], the last trusted one, up to its next crossing of that value, and the ray stops
    at the edge. The root of the operator is linear between equispaced fractions of the ray.
    `scale` is the unit of q.
    Without a trusted contour (first = -1) the operator of every ray is the approach. Below `first`
    only the centres are given.
    """
    curves, rays, cell = space
    squares, roots = curves[0], curves[1]
    radius, speed = rays[0], rays[1]
    begin = max(first, 0)
    cells = weights.shape[1] - 1
    np.dot(q, weights, squares)
    for p in range(edge.size):
        unit = math.sqrt(scale) * edge[p] / cells
        for j in range(cells + 1):
            roots[p, j] = unit * j * math.sqrt(max(squares[p, j], 0.0))
    for p in range(edge.size):
        r = -1.0
        if first >= 0:
            r = _ray_radius(shape, first, direction[0, p], direction[1, p])
        if r <= 0.0:
            r = levels[begin] * math.sqrt(0.5 * (1 + m) / (q[p, 0] * scale))
        radius[p] = min(r, edge[p])
        x = radius[p] / edge[p] * cells
        j = min(int(x), cells - 1)
        speed[p] = 1.0
        if first >= 0:
            speed[p] = (roots[p, j] + (x - j) * (roots[p, j + 1] - roots[p, j])) / levels[begin]
        cell[p] = j
    for level in range(begin):
        out[level, 0] = 0.0
        out[level, 1] = 0.0
        out[level, 2] = shape[level, 2]
        out[level, 3] = shape[level, 3]
    for level in range(begin, levels.size):
        if level > begin:
            for p in range(edge.size):
                y, j = speed[p] * levels[level], cell[p]
                while j < cells and roots[p, j + 1] < y:
                    j += 1
                cell[p] = j
                if j >= cells:
                    radius[p] = edge[p]
                else:
                    low, high = min(roots[p, j], y), roots[p, j + 1]
                    x = j + (y - low) / max(high - low, 1e-300)
                    radius[p] = max(radius[p], edge[p] * x / cells)
        _planform(radius, weight, direction, m, punch, start, inverse, out[level])
