"""Compiled loops that turn values over radii into the columns of a law table."""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import compiled, inner

__all__ = ["resample"]


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
