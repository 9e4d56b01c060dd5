"""Compiled evaluation of the contact laws."""

from __future__ import annotations

import math

import numpy as np
from numba import carray, njit

from asperity.interaction.ewald.scratch import BLOCK, COLUMNS, columns, places
from asperity.microcontact.table_kernels import BLUNT, tip_power
from surfaces.numerics.compiled import QUOTIENTS, compiled

NUMBERS = 6
"""What the table holds for each node of a law."""

LANES = BLOCK // 2
"""Contacts of a block."""

ONE, TWO, THREE, FOUR, FIVE = (np.uint64(number) for number in range(1, NUMBERS))

# columns of the scratch
V, D, TOP, J, LEAN, F, K, WORK, M, GROWN, AREA = range(0, 11 * LANES, LANES)

GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(5)


@njit(inline="always")
def _raise(base, power):
    """base^power, the powers of the homogeneous body by products."""
    if power == 3.0:
        return base * base * base
    if power == 2.0:
        return base * base
    return base**power


@njit(inline="always")
def _cubic(left, right, left_slope, right_slope):
    rise = right - left
    return (
        left,
        left_slope,
        3.0 * rise - 2.0 * left_slope - right_slope,
        left_slope + right_slope - 2.0 * rise,
    )


@njit(inline="always")
def _about_zero(c0, c1, c2, c3, j):
    """Coefficients in v of a cubic with these in v - j."""
    e2 = c2 - 3.0 * c3 * j
    e1 = c1 - 2.0 * c2 * j + 3.0 * c3 * j * j
    return c0 - c1 * j + c2 * j * j - c3 * j * j * j, e1, e2, c3


@njit(inline="always")
def _shares(power):
    """What the powers of v in s contribute to the integral of v^(power + 1) s dv."""
    return 1.0 / (power + 2.0), 1.0 / (power + 3.0), 1.0 / (power + 4.0), 1.0 / (power + 5.0)


@njit(inline="always")
def _primitive(e0, e1, e2, e3, shares, factor, v):
    """Integral of F v dv from 0, `factor` being v^power and `shares` those of the power."""
    q0, q1, q2, q3 = shares
    return v * v * factor * (e0 * q0 + v * (e1 * q1 + v * (e2 * q2 + v * (e3 * q3))))


@compiled(fastmath=QUOTIENTS)
def evaluate(
    rows,
    index,
    approach,
    reach,
    power,
    place,
    table,
    force,
    stiffness,
    area,
    energy,
    moment,
    growth,
):
    """Laws at the approaches of the rows [rows[0], rows[1]); `Laws` says what the table holds, and
    `place` where. Zero force where they are not positive.

    Closed contacts are taken in blocks, as pairs are (`_block_kernels`), so that vector
    instructions do all but the ends of each block.
    """
    s = carray(columns(), (COLUMNS * BLOCK,))
    ends = carray(places(), (BLOCK,))
    first = ends[:LANES]
    closed = ends[LANES:]
    nodes = np.int32(table.shape[1])
    flat = table.reshape(-1)
    shares = _shares(power)
    steps = float(table.shape[1] - 1)
    i = rows[0]
    while i < rows[1]:
        count = 0
        while i < rows[1] and count < LANES:
            closed[count] = i
            count += 1 if (approach[i] > 0.0) & (reach[index[i]] > 0.0) else 0
            area[i], force[i], stiffness[i] = 0.0, 0.0, 0.0
            energy[i], moment[i], growth[i] = 0.0, 0.0, 0.0
            i += 1
        for k in range(count):
            row = index[closed[k]]
            d = approach[closed[k]]
            top = reach[row]
            v = math.sqrt(min(d / top, 1.0)) * steps
            j = min(np.int32(v), nodes - np.int32(2))
            first[k] = (place[row] * nodes + j) * np.int32(NUMBERS)
            s[k + V], s[k + D], s[k + TOP], s[k + J] = v, d, top, j
        if power == 3.0:
            for k in range(count):
                s[k + LEAN] = s[k + V]
        else:
            for k in range(count):
                s[k + LEAN] = s[k + V] ** (power - 2.0)
        for k in range(count):
            here = np.uint64(first[k])
            there = here + np.uint64(NUMBERS)
            v, j = s[k + V], s[k + J]
            t = v - j
            lean = s[k + LEAN]
            factor = lean * v * v
            c0, c1, c2, c3 = _cubic(flat[here], flat[there], flat[here + ONE], flat[there + ONE])
            e0, e1, e2, e3 = _about_zero(c0, c1, c2, c3, j)
            level = c0 + t * (c1 + t * (c2 + t * c3))
            slope = power * level + v * (c1 + t * (2.0 * c2 + 3.0 * t * c3))
            # dd/dv = 2 top v / steps^2
            width = 2.0 * s[k + TOP] / (steps * steps)
            s[k + F] = factor * level
            s[k + K] = lean * slope / width
            work = width * _primitive(e0, e1, e2, e3, shares, factor, v)
            s[k + WORK] = flat[here + TWO] + work
            c0, c1, c2, c3 = _cubic(
                flat[here + THREE], flat[there + THREE], flat[here + FOUR], flat[there + FOUR]
            )
            s[k + M] = c0 + t * (c1 + t * (c2 + t * c3))
            bend = c1 + t * (2.0 * c2 + 3.0 * t * c3)
            s[k + GROWN] = bend * level * v / slope if slope > 0.0 else 0.0
            inner = flat[here + FIVE]
            s[k + AREA] = v * v * (inner + t * (flat[there + FIVE] - inner))
        for k in range(count):
            d, over = s[k + D], s[k + D] - s[k + TOP]
            f, stiff, work, m, grown = s[k + F], s[k + K], s[k + WORK], s[k + M], s[k + GROWN]
            v, here = s[k + V], np.uint64(first[k])
            if v < 1.0 and flat[here + THREE] > 0.0:  # a tip that is no paraboloid
                there, rise, wide = here + np.uint64(NUMBERS), flat[here], flat[here + FOUR]
                f = flat[there] * v**rise
                stiff = 0.5 * rise * f / d
                work = f * d / (1.0 + 0.5 * rise)
                m = flat[here + THREE] * v**wide
                grown = m * wide / rise
                s[k + AREA] = flat[there + FIVE] * v ** flat[here + ONE]
            if over > 0.0:
                full = m + grown
                work += over * (f + 0.5 * stiff * over)
                m = (m * f + full * stiff * over) / (f + stiff * over)
                f += stiff * over
                grown = full - m
            j = closed[k]
            area[j] = s[k + AREA]
            force[j] = f
            stiffness[j] = max(stiff, 0.05 * f / d)
            energy[j] = work
            moment[j] = max(m, 0.0)
            growth[j] = grown


@compiled()
def convex(place, force, stack):
    """Replace each row of `force` by the largest convex function below it (lower hull); `stack`
    (nodes,) is scratch."""
    nodes = place.size
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


@njit(inline="always")
def _slope(e0, e1, e2, e3, power, v):
    """dF/dv of F = v^p (e0 + e1 v + e2 v^2 + e3 v^3)."""
    s = e0 + v * (e1 + v * (e2 + v * e3))
    ds = e1 + v * (2.0 * e2 + 3.0 * v * e3)
    return max(_raise(v, power - 1.0) * (power * s + v * ds), 0.0)


@compiled()
def tabulate(reach, force, stiffness, area, power, factor, exponent, scratch, table):
    """Fill the rows of `table` (see `Laws`) from sound nodal values; `scratch` is (3, nodes).

    A footprint has the variance (factor k)^exponent. The moment (1/F) int v dF is integrated by
    Gauss quadrature on each interval, and its slopes are limited so that it grows between the nodes
    too (Fritsch and Carlson 1980). Of a tip that is no paraboloid the first node holds other
    numbers: in the place of s and its slope the exponents of force and area over v, in that of the
    moment and its slope the moment at the next node and the exponent of the moment.
    """
    steps = force.shape[1] - 1
    shares = _shares(power)
    x, g = GAUSS_NODES, GAUSS_WEIGHTS
    moment, bend, fall = scratch[0], scratch[1], scratch[2]
    moment[0], bend[0] = 0.0, 0.0
    for j in range(steps):
        fall[j] = (j + 1.0) ** -power
    for r in range(reach.size):
        width = 2.0 * reach[r] / (steps * steps)
        s0 = 0.0
        d0 = 0.0
        work = 0.0
        load = 0.0
        spread = 0.0
        tip, wide = 0.0, 0.0
        for j in range(steps):
            v = j + 1.0
            s1 = force[r, j + 1] * fall[j]
            d1 = stiffness[r, j + 1] * width * v * fall[j] - power * s1 / v
            if j == 0 and abs(d1) > BLUNT * s1:
                rise = tip_power(force[r, 1], force[r, 2], power)
                wide = exponent * (rise - 2.0)
                variance = _raise(factor * rise * s1 / width, exponent)
                tip = variance * rise / (rise + wide)
                table[r, 0, 0], table[r, 0, 1] = rise, 2.0 * (rise - 2.0) / (power - 2.0)
                table[r, 0, 2] = 0.0
                work, load, spread = width * s1 / (rise + 2.0), s1, tip * s1
                moment[1], bend[1] = tip, (variance - tip) * rise
                table[r, 1, 5] = area[r, 1]
                s0, d0 = s1, (rise - power) * s1
                continue
            if j == 0:
                # straight, through the first node, not below a fifth of its value
                d1 = min(d1, 0.8 * s1)
                s0 = s1 - d1
                d0 = d1
            else:
                # a steeper cubic could pass below zero
                d1 = min(d1, 3.0 * s1)
            c0, c1, c2, c3 = _cubic(s0, s1, d0, d1)
            e0, e1, e2, e3 = _about_zero(c0, c1, c2, c3, j)
            below, above = _raise(float(j), power), _raise(v, power)
            start = width * _primitive(e0, e1, e2, e3, shares, below, float(j))
            table[r, j, 0] = s0
            table[r, j, 1] = d0
            table[r, j, 2] = work - start
            work += width * _primitive(e0, e1, e2, e3, shares, above, v) - start
            for q in range(5):
                t = j + 0.5 * (1.0 + x[q])
                slope = _slope(e0, e1, e2, e3, power, t)
                load += 0.5 * g[q] * slope
                spread += 0.5 * g[q] * slope * _raise(factor * slope / (width * t), exponent)
            moment[j + 1] = spread / load
            slope = _slope(e0, e1, e2, e3, power, v)
            variance = _raise(factor * slope / (width * v), exponent)
            bend[j + 1] = (variance - moment[j + 1]) * slope / load
            table[r, j + 1, 5] = area[r, j + 1] / (v * v)
            s0 = s1
            d0 = d1
        table[r, steps, 0] = s0
        table[r, steps, 1] = d0
        table[r, steps, 2] = work
        table[r, 0, 3] = tip
        table[r, 0, 4] = wide
        table[r, 0, 5] = area[r, 1]
        for j in range(1, steps + 1):
            before = moment[j] - moment[j - 1]
            after = moment[j + 1] - moment[j] if j < steps else before
            table[r, j, 3] = moment[j]
            table[r, j, 4] = min(max(bend[j], 0.0), 3.0 * max(min(before, after), 0.0))
