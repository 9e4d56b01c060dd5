"""Compiled loops over contacts: table evaluation, and tables from values over radii."""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import compiled, inner

__all__ = ["BLUNT", "evaluate_table", "flags_of_table", "resample", "tip_power"]

BLUNT = 0.1
"""Difference of the exponents of force at the first node and of a paraboloid, over the root of the
approach, from which on a tip is no paraboloid: r^2.2, r^1.8, and 1 to 6 % of the summits of random
and measured maps. Down to the tip force and area then are powers."""


@inner()
def tip_power(first, second, p):
    """Exponent of force over the root of the approach at a tip that is no paraboloid, whose is `p`,
    from the forces at the first two nodes: between those of a punch and of a cone."""
    return min(max(math.log2(second / first), 2.0), 2.0 * p - 2.0)


@compiled()
def evaluate_table(rows, approach, reach, force, stiffness, area, p, scale, out):
    """Force, its derivative and area at `approach` into `out` (3, n); see `LawTable`.

    `scale` is u^-p at the nodes, but at the first.
    """
    intervals = force.shape[1] - 1
    for i in range(rows.size):
        row, d = rows[i], approach[i]
        top = reach[row]
        if d <= 0.0 or top <= 0.0:
            continue
        if d >= top:
            out[0, i] = force[row, intervals] + stiffness[row, intervals] * (d - top)
            out[1, i] = stiffness[row, intervals]
            out[2, i] = area[row, intervals]
            continue
        u = math.sqrt(d / top)
        x = u * intervals
        j = min(int(x), intervals - 1)
        x -= j
        step = 1.0 / intervals
        u1 = (j + 1) * step
        s1 = force[row, j + 1] * scale[j + 1]
        g1 = 2.0 * u1 * top * stiffness[row, j + 1] * scale[j + 1] - p * s1 / u1
        b1 = area[row, j + 1] / (u1 * u1)
        if j == 0 and abs(g1) * u1 > BLUNT * s1 and 0.0 < force[row, 1] < force[row, 2]:
            rise = tip_power(force[row, 1], force[row, 2], p)
            out[0, i] = force[row, 1] * x**rise
            out[1, i] = 0.5 * rise * out[0, i] / d
            out[2, i] = area[row, 1] * x ** (2.0 * (rise - 2.0) / (p - 2.0))
            continue
        if j == 0:
            s, g, b = s1 + g1 * (u - u1), g1, b1
        else:
            u0 = j * step
            s0 = force[row, j] * scale[j]
            g0 = 2.0 * u0 * top * stiffness[row, j] * scale[j] - p * s0 / u0
            y = 1.0 - x
            s = s0 * (1.0 + 2.0 * x) * y * y + s1 * x * x * (3.0 - 2.0 * x)
            s += step * x * y * (g0 * y - g1 * x)
            g = 6.0 * x * y * (s1 - s0) / step
            g += g0 * y * (1.0 - 3.0 * x) + g1 * x * (3.0 * x - 2.0)
            b = area[row, j] / (u0 * u0) * y + b1 * x
        power = u * u * u if p == 3.0 else u**p
        out[0, i] = power * s
        out[1, i] = power * (p * s / u + g) / (2.0 * u * top)
        out[2, i] = b * u * u


@compiled()
def flags_of_table(rows, approach, reach, flags, out):
    """Flags of the node at or above `approach` into `out`, the last node's beyond the reach."""
    last = flags.shape[1] - 1
    for i in range(rows.size):
        row = rows[i]
        share = approach[i] / reach[row] if reach[row] > 0.0 else 0.0
        out[i] = flags[row, math.ceil(math.sqrt(min(max(share, 0.0), 1.0)) * last)]


@compiled()
def resample(u, ratios, flags, good, basin, intervals, p):
    """Columns of the law table from values over rising ``u = sqrt(approach)``.

    `ratios` holds force/u^p, area/u^2 and spread, shape (3, peaks, radii); between the radii they
    are cubic through the four nearest. The table of a contact ends where the area reaches
    `basin`, else at its last `good` value.
    """
    peaks = good.size
    reach = np.zeros(peaks)
    values = np.zeros((4, peaks, intervals + 1))
    marks = np.zeros((peaks, intervals + 1), dtype=np.uint8)
    for i in range(peaks):
        last = good[i] - 1
        if last < 3:
            continue
        w, dw = np.empty(4), np.empty(4)
        end, filled = u[i, last], False
        for k in range(last + 1):
            area = ratios[1, i, k] * u[i, k] ** 2
            if area >= basin[i]:
                before = ratios[1, i, k - 1] * u[i, k - 1] ** 2 if k else 0.0
                square = u[i, k - 1] ** 2 if k else 0.0
                share = (basin[i] - before) / (area - before)
                end = math.sqrt(square + share * (u[i, k] ** 2 - square))
                filled = True
                break
        reach[i] = end * end
        base, near = 0, 0
        for j in range(1, intervals + 1):
            x = end * j / intervals
            while base + 4 < good[i] and u[i, base + 2] < x:
                base += 1
            while near < last and u[i, near] < x:
                near += 1
            _lagrange(u[i], base, x, w, dw)
            s, ds, b = 0.0, 0.0, 0.0
            for k in range(4):
                s += w[k] * ratios[0, i, base + k]
                ds += dw[k] * ratios[0, i, base + k]
                b += w[k] * ratios[1, i, base + k]
            power = x ** (p - 2.0)
            values[0, i, j] = max(power * x * x * s, values[0, i, j - 1])
            values[1, i, j] = max(0.5 * power * (p * s + x * ds), 0.5 * values[0, i, j] / (x * x))
            area = min(b * x * x, basin[i]) if filled else b * x * x
            values[2, i, j] = max(area, values[2, i, j - 1])
            values[3, i, j] = ratios[2, i, near]
            marks[i, j] = flags[i, near]
        if filled:
            values[2, i, intervals] = basin[i]
            marks[i, intervals] |= 128
    return reach, values[0], values[1], values[2], marks, values[3]


@inner()
def _lagrange(u, base, x, w, dw):
    """Weights of the value and of the slope at x of the cubic through four nodes."""
    for k in range(4):
        below, product, slope = 1.0, 1.0, 0.0
        for j in range(4):
            if j == k:
                continue
            below *= u[base + k] - u[base + j]
            slope = slope * (x - u[base + j]) + product
            product *= x - u[base + j]
        w[k] = product / below
        dw[k] = slope / below
