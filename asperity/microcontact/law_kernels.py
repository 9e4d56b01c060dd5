"""The one compiled evaluation of tabulated contact laws.

With v = K sqrt(d / reach), node j at v = j, the force is F = v^p s(v). Between nodes s is a cubic
Hermite polynomial in v, linear in the first interval, so that a Hertzian contact is exact at any
grading; area/v^2 is linear in v, as far as the area does not exceed that of the next node: an area
never falls. The energy int F dd follows in closed form. The moment
m = (1/F) int variance dF is a growing cubic Hermite polynomial with the slope
dm/dF = (variance - m)/F at the nodes, an increment at the stiffness k being spread with the
variance (factor k)^exponent (docs/development/half_space.md). Beyond the reach the contact is a
flat punch.

A tip that is no paraboloid (`BLUNT_TIP`) has powers of v instead in the first interval: force, area
and moment are those of the first node times v to the exponents in `tips`, which are zero for all
other contacts.
"""

from __future__ import annotations

import math

import numpy as np
from numba import carray, types
from numpy.typing import NDArray

from surfaces.numerics.compiled import QUOTIENTS, compiled, inner
from surfaces.numerics.memory import zeros
from surfaces.numerics.vectors import on_stack

__all__ = [
    "AREA",
    "BLUNT_TIP",
    "ENERGY",
    "FORCE",
    "FORCE_SLOPE",
    "MOMENT",
    "MOMENT_SLOPE",
    "NODE_COLUMNS",
    "TIP_COLUMNS",
    "convex",
    "empty_columns",
    "evaluate",
    "tabulate",
]

FORCE, FORCE_SLOPE, ENERGY, MOMENT, MOMENT_SLOPE, AREA = range(6)
"""Columns of a node j: s and ds/dv; the constant of the energy in [j, j + 1]; the moment and dm/dv;
area/v^2."""

NODE_COLUMNS = 6
"""Columns of a node."""

TIP_COLUMNS = 3
"""Exponents over v of force, area and moment of a tip that is no paraboloid."""

BLUNT_TIP = 0.1
"""Difference of the exponents of force at the first node and of a paraboloid, over the root of the
approach, from which on a tip is no paraboloid: r^2.2, r^1.8, and 1 to 6 % of the summits of random
and measured maps. Down to the tip force and area then are powers."""

LEAST_SLOPE = 0.05
"""Least stiffness over F/d."""

BLOCK = 256
"""Contacts of a block."""

COLUMNS = 10
_V, _NODE, _TOP, _LOWER, _F, _STIFF, _WORK, _M, _GROWN, _SPOT = range(0, COLUMNS * BLOCK, BLOCK)
"""Where the numbers of the contacts of a block begin."""

_FORCE, _FORCE_SLOPE, _ENERGY, _MOMENT, _MOMENT_SLOPE, _AREA = (
    np.uint64(column) for column in range(NODE_COLUMNS)
)
"""Columns of a node without a sign: places that may be negative are no vector instructions."""

_columns, _places = on_stack(types.float64, COLUMNS * BLOCK), on_stack(types.int32, 2 * BLOCK)

_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(5)


@inner(fastmath=QUOTIENTS)
def _power(base, exponent):
    """base^exponent, the powers of the homogeneous body by products."""
    if exponent == 3.0:
        return base * base * base
    if exponent == 2.0:
        return base * base
    return base**exponent


@inner(fastmath=QUOTIENTS)
def _hermite(left, right, left_slope, right_slope):
    """Coefficients in v - j of the cubic with these values and slopes at j and j + 1."""
    rise = right - left
    return (
        left,
        left_slope,
        3.0 * rise - 2.0 * left_slope - right_slope,
        left_slope + right_slope - 2.0 * rise,
    )


@inner(fastmath=QUOTIENTS)
def _shares(power):
    """Integral of v^(power + 1 + k) dv over its v^(power + 2 + k), k = 0 ... 3."""
    return 1.0 / (power + 2.0), 1.0 / (power + 3.0), 1.0 / (power + 4.0), 1.0 / (power + 5.0)


@inner(fastmath=QUOTIENTS)
def _force_integral(c0, c1, c2, c3, j, shares, factor, v):
    """Integral of v^(power + 1) s dv from 0, for the cubic s of these coefficients in v - j;
    `factor` is v^power and `shares` those of the power."""
    q0, q1, q2, q3 = shares
    e0 = c0 - j * (c1 - j * (c2 - j * c3))
    e1 = c1 - j * (2.0 * c2 - 3.0 * j * c3)
    e2 = c2 - 3.0 * j * c3
    return v * v * factor * (e0 * q0 + v * (e1 * q1 + v * (e2 * q2 + v * (c3 * q3))))


@compiled(fastmath=QUOTIENTS)
def evaluate(
    rows,
    index,
    approach,
    reach,
    power,
    place,
    table,
    tips,
    force,
    stiffness,
    area,
    energy,
    moment,
    growth,
):
    """Laws at the approaches of the contacts [rows[0], rows[1]), of table row `place[index]`.

    Fills F, dF/dd, the area, int F dd, the moment m and its growth F dm/dF; zeros where there is no
    approach or no law. Closed contacts are taken in blocks: polynomials of a block, whose results
    stand on the stack, become vector instructions.
    """
    nodes, shares = np.int32(table.shape[1]), _shares(power)
    steps, flat = float(table.shape[1] - 1), table.reshape(-1)
    unit = 2.0 / (steps * steps)
    s = carray(_columns(), (COLUMNS * BLOCK,))
    ends = carray(_places(), (2 * BLOCK,))
    first, closed = ends[:BLOCK], ends[BLOCK:]
    i = rows[0]
    while i < rows[1]:
        count = 0
        while i < rows[1] and count < BLOCK:
            closed[count] = i
            count += 1 if (approach[i] > 0.0) & (reach[index[i]] > 0.0) else 0
            area[i], force[i], stiffness[i] = 0.0, 0.0, 0.0
            energy[i], moment[i], growth[i] = 0.0, 0.0, 0.0
            i += 1
        for k in range(count):
            d, top = approach[closed[k]], reach[index[closed[k]]]
            v = math.sqrt(min(d / top, 1.0)) * steps
            j = min(np.int32(v), nodes - np.int32(2))
            first[k] = (place[index[closed[k]]] * nodes + j) * np.int32(NODE_COLUMNS)
            s[k + _V], s[k + _NODE], s[k + _TOP] = v, j, top
        if power == 3.0:
            for k in range(count):
                s[k + _LOWER] = s[k + _V]
        else:
            for k in range(count):
                s[k + _LOWER] = s[k + _V] ** (power - 2.0)
        for k in range(count):
            left = np.uint64(first[k])
            right = left + np.uint64(NODE_COLUMNS)
            v, j, lower = s[k + _V], s[k + _NODE], s[k + _LOWER]
            t, width, factor = v - j, s[k + _TOP] * unit, lower * v * v  # dd/dv = width v
            c0, c1, c2, c3 = _hermite(
                flat[left + _FORCE],
                flat[right + _FORCE],
                flat[left + _FORCE_SLOPE],
                flat[right + _FORCE_SLOPE],
            )
            level = c0 + t * (c1 + t * (c2 + t * c3))
            slope = power * level + v * (c1 + t * (2.0 * c2 + 3.0 * t * c3))
            work = width * _force_integral(c0, c1, c2, c3, j, shares, factor, v)
            s[k + _WORK] = flat[left + _ENERGY] + work
            s[k + _F] = factor * level
            s[k + _STIFF] = lower * slope / width
            c0, c1, c2, c3 = _hermite(
                flat[left + _MOMENT],
                flat[right + _MOMENT],
                flat[left + _MOMENT_SLOPE],
                flat[right + _MOMENT_SLOPE],
            )
            bend = c1 + t * (2.0 * c2 + 3.0 * t * c3)
            s[k + _M] = c0 + t * (c1 + t * (c2 + t * c3))
            s[k + _GROWN] = bend * level * v / slope if slope > 0.0 else 0.0
            spot, after = flat[left + _AREA], flat[right + _AREA]
            s[k + _SPOT] = min(v * v * (spot + t * (after - spot)), (j + 1.0) * (j + 1.0) * after)
        for k in range(count):
            n, d, v, top = closed[k], approach[closed[k]], s[k + _V], s[k + _TOP]
            f, stiff, work = s[k + _F], s[k + _STIFF], s[k + _WORK]
            m, grown, spot = s[k + _M], s[k + _GROWN], s[k + _SPOT]
            if v < 1.0 and tips[place[index[n]], 0] > 0.0:
                row = place[index[n]]
                rise, spread = tips[row, 0], tips[row, 2]
                f = table[row, 1, FORCE] * v**rise
                stiff = 0.5 * rise * f / d
                work = f * d / (1.0 + 0.5 * rise)
                m = table[row, 1, MOMENT] * v**spread
                grown = m * spread / rise
                spot = table[row, 1, AREA] * v ** tips[row, 1]
            over = d - top
            if over > 0.0:
                full = m + grown
                work += over * (f + 0.5 * stiff * over)
                m = (m * f + full * stiff * over) / (f + stiff * over)
                f += stiff * over
                grown = full - m
            area[n], force[n], stiffness[n] = spot, f, max(stiff, LEAST_SLOPE * f / d)
            # the footprint of an increment has a variance m + grown; between nodes of a law that
            # hardly rises the cubics can make it negative
            m = max(m, 0.0)
            energy[n], moment[n], growth[n] = work, m, max(grown, -m)


@inner()
def _slope(c0, c1, c2, c3, j, power, v):
    """dF/dv of F = v^power s(v), for the cubic s of these coefficients in v - j."""
    t = v - j
    level = c0 + t * (c1 + t * (c2 + t * c3))
    bend = c1 + t * (2.0 * c2 + 3.0 * t * c3)
    return max(_power(v, power - 1.0) * (power * level + v * bend), 0.0)


@inner()
def _tip_exponents(force, area, power, exponent):
    """Exponents over v of force, area and moment of a tip that is no paraboloid, from the values at
    the first two nodes: that of force lies between those of a punch and of a cone.

    The area of an elastic tip grows as the force tells, and at the hardness in proportion to it.
    """
    rise = min(max(math.log2(force[2] / force[1]), 2.0), 2.0 * power - 2.0)
    spot = 2.0 * (rise - 2.0) / (power - 2.0)
    if area[2] > area[1]:
        spot = max(spot, min(math.log2(area[2] / area[1]), rise))
    return rise, spot, exponent * (rise - 2.0)


@compiled()
def tabulate(reach, force, stiffness, area, power, factor, exponent, coupled, table, tips):
    """Fill the rows of `table` (n, K + 1, NODE_COLUMNS) and `tips` (n, TIP_COLUMNS) from the nodes.

    An increment of force at the stiffness k is spread with the variance (factor k)^exponent.

    The moment is integrated by Gauss quadrature on each interval, and its slopes are limited so
    that it grows between the nodes too (Fritsch and Carlson 1980). If `coupled`, what
    the coupled problem needs: slopes of s with which the force stays positive between the nodes,
    and the stiffness is continuous where the powers of a tip end.
    """
    steps, shares = force.shape[1] - 1, _shares(power)
    moment, bend = np.zeros(steps + 1), np.zeros(steps + 1)
    table[:] = 0.0
    tips[:] = 0.0
    for r in range(reach.size):
        width = 2.0 * reach[r] / (steps * steps)
        s0, d0, work, load, spread, most = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(steps):
            v = j + 1.0
            s1 = force[r, j + 1] / _power(v, power)
            d1 = stiffness[r, j + 1] * width * v / _power(v, power) - power * s1 / v
            most = max(most, area[r, j + 1])
            table[r, j + 1, AREA] = most / (v * v)
            if j == 0 and abs(d1) > BLUNT_TIP * s1 and 0.0 < force[r, 1] < force[r, 2]:
                rise, spot, wide = _tip_exponents(force[r], area[r], power, exponent)
                # one by one: a row filled by a tuple takes 1 s more to compile
                tips[r, 0], tips[r, 1], tips[r, 2] = rise, spot, wide
                variance = _power(factor * rise * s1 / width, exponent)
                moment[1] = variance * rise / (rise + wide)
                bend[1] = (variance - moment[1]) * rise
                work, load, spread = width * s1 / (rise + 2.0), s1, moment[1] * s1
                s0, d0 = s1, (rise - power) * s1 if coupled else d1
                continue
            if j == 0:
                # straight, through the first node, not below a fifth of its value
                d1 = min(d1, 0.8 * s1) if coupled else d1
                s0, d0 = s1 - d1, d1
            else:
                # a steeper cubic could pass below zero
                d1 = min(d1, 3.0 * s1) if coupled else d1
            c0, c1, c2, c3 = _hermite(s0, s1, d0, d1)
            below, above = _power(float(j), power), _power(v, power)
            start = width * _force_integral(c0, c1, c2, c3, j, shares, below, float(j))
            table[r, j, FORCE] = s0
            table[r, j, FORCE_SLOPE] = d0
            table[r, j, ENERGY] = work - start
            work += width * _force_integral(c0, c1, c2, c3, j, shares, above, v) - start
            for q in range(_GAUSS_NODES.size):
                t = j + 0.5 * (1.0 + _GAUSS_NODES[q])
                slope = _slope(c0, c1, c2, c3, j, power, t)
                part = 0.5 * _GAUSS_WEIGHTS[q] * slope
                load += part
                spread += part * _power(factor * slope / (width * t), exponent)
            slope = _slope(c0, c1, c2, c3, j, power, v)
            variance = _power(factor * slope / (width * v), exponent)
            moment[j + 1] = spread / load
            bend[j + 1] = (variance - moment[j + 1]) * slope / load
            s0, d0 = s1, d1
        table[r, 0, AREA] = table[r, 1, AREA]
        table[r, steps, FORCE] = s0
        table[r, steps, FORCE_SLOPE] = d0
        table[r, steps, ENERGY] = work
        for j in range(1, steps + 1):
            before = moment[j] - moment[j - 1]
            after = moment[j + 1] - moment[j] if j < steps else before
            table[r, j, MOMENT] = moment[j]
            table[r, j, MOMENT_SLOPE] = min(max(bend[j], 0.0), 3.0 * max(min(before, after), 0.0))


def empty_columns(
    count: int, intervals: int, stored: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """`table` and `tips` of so many contacts, to be filled by `tabulate`; in files if `stored`."""
    shapes = (count, intervals + 1, NODE_COLUMNS), (count, TIP_COLUMNS)
    table, tips = (zeros(shape, np.float64, stored) for shape in shapes)
    return table, tips


@compiled()
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
