"""Compiled evaluation of the contact laws."""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def evaluate(approach, reach, power, table, force, stiffness, area, energy, moment, growth):
    """Laws at the given approaches; `Laws` says what the rows of `table` hold."""
    steps = table.shape[1]
    for i in range(approach.size):
        d = approach[i]
        if d <= 0.0 or reach[i] <= 0.0:
            continue
        v = math.sqrt(min(d, reach[i]) / reach[i]) * steps
        j = min(int(v), steps - 1)
        row = table[i, j]
        factor = v * v * v if power == 3.0 else v**power
        s = row[0] + v * (row[1] + v * (row[2] + v * row[3]))
        ds = row[1] + v * (2.0 * row[2] + 3.0 * v * row[3])
        f = factor * s
        # dd/dv = 2 reach v / steps^2
        width = 2.0 * reach[i] / (steps * steps)
        slope = factor * (power * s + v * ds)
        k = slope / (width * max(v * v, 1e-200))
        q = power + 2.0
        series = row[0] / q + v * (
            row[1] / (q + 1.0) + v * (row[2] / (q + 2.0) + v * row[3] / (q + 3.0))
        )
        work = row[4] + width * factor * v * v * series
        t = v - j
        m = row[5] + t * (row[6] + t * (row[7] + t * row[8]))
        bend = row[6] + t * (2.0 * row[7] + 3.0 * t * row[8])
        grown = bend * f * v / slope if slope > 0.0 else 0.0
        if d > reach[i]:
            over = d - reach[i]
            full = m + grown
            work += over * (f + 0.5 * k * over)
            m = (m * f + full * k * over) / (f + k * over)
            f += k * over
            grown = full - m
        area[i] = v * v * (row[9] + t * (row[10] - row[9]))
        force[i] = f
        stiffness[i] = max(k, 0.05 * f / d)
        energy[i] = work
        moment[i] = max(m, 0.0)
        growth[i] = grown


@njit(cache=True, nogil=True)
def convex(place, force):
    """Replace each row of `force` by the largest convex function below it (lower hull)."""
    nodes = place.size
    stack = np.empty(nodes, np.int64)
    for row in force:
        top = 0
        for j in range(nodes):
            while top >= 2:
                a, b = stack[top - 2], stack[top - 1]
                lower = (row[b] - row[a]) * (place[j] - place[b])
                if lower < (row[j] - row[b]) * (place[b] - place[a]):
                    break
                top -= 1
            stack[top] = j
            top += 1
        for k in range(top - 1):
            a, b = stack[k], stack[k + 1]
            for j in range(a + 1, b):
                t = (place[j] - place[a]) / (place[b] - place[a])
                row[j] = (1.0 - t) * row[a] + t * row[b]
