"""Compiled interpolation of law tables: every solver evaluates laws by these two kernels.

With v = K sqrt(d / reach), so that node j lies at v = j, and p = 3 + m:

- Force: F = v^p s(v). s is a cubic Hermite polynomial in v between nodes, and linear in the first
  interval. A Hertz contact has constant s and is exact at any grading.
- Area: area/v^2 is linear in v, bounded by the area of the next node: an area never falls.
- Energy: int F dd of this F, in closed form.
- Moment of the footprint: m = (1/F) int w dF, where an increment of force at the stiffness k has
  the variance w = (factor k)^exponent (docs/development/half_space.md). m is an increasing cubic
  Hermite polynomial with dm/dF = (w - m)/F at the nodes.
- Beyond the reach the contact is a flat punch: area and stiffness are constant.

A tip that is no paraboloid (`BLUNT_TIP`) has powers of v in the first interval: force, area and
moment are those of the first node times v to the exponents in `tips`. These exponents are zero for
all other contacts.
"""

from __future__ import annotations

import math

import numpy as np
from numba import carray, types

from surfaces.arrays import Array
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
    "empty_columns",
    "evaluate",
    "tabulate",
]

FORCE, FORCE_SLOPE, ENERGY, MOMENT, MOMENT_SLOPE, AREA = range(6)
"""Columns of node j: s and ds/dv; the constant of the energy in [j, j + 1]; m and dm/dv; area/v^2.
"""

NODE_COLUMNS = 6
"""Number of these columns."""

TIP_COLUMNS = 3
"""Exponents of v in force, area and moment of a tip that is no paraboloid."""

BLUNT_TIP = 0.1
"""Least difference between d ln F/d ln v at the first node and p of a tip that is no paraboloid:
that of r^2.2 or r^1.8. 1 to 6 % of the summits of random and measured maps exceed it."""

LEAST_SLOPE = 0.05
"""Least stiffness over F/d."""

BLOCK = 256
"""Contacts of a block."""

COLUMNS = 10
_V, _NODE, _TOP, _LOWER, _F, _STIFF, _WORK, _M, _GROWN, _SPOT = range(0, COLUMNS * BLOCK, BLOCK)
"""Offsets of the working arrays of a block on the stack."""

_FORCE, _FORCE_SLOPE, _ENERGY, _MOMENT, _MOMENT_SLOPE, _AREA = (
    np.uint64(column) for column in range(NODE_COLUMNS)
)
"""The columns of a node as unsigned integers: signed offsets prevent vector instructions."""

_columns, _places = on_stack(types.float64, COLUMNS * BLOCK), on_stack(types.int32, 2 * BLOCK)

_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(5)


@inner(fastmath=QUOTIENTS)
def _power(base, exponent):
    """base^exponent, by products for the exponents 2 and 3 of the homogeneous body."""
    if exponent == 3.0:
        return base * base * base
    if exponent == 2.0:
        return base * base
    return base**exponent


@inner(fastmath=QUOTIENTS)
def _hermite(left, right, left_slope, right_slope):
    """Coefficients in t = v - j of the cubic Hermite polynomial of these end values and slopes."""
    rise = right - left
    return (
        left,
        left_slope,
        3.0 * rise - 2.0 * left_slope - right_slope,
        left_slope + right_slope - 2.0 * rise,
    )


@inner(fastmath=QUOTIENTS)
def _shares(power):
    """1/(power + 2 + k), k = 0 ... 3: the integral of v^(power + 1 + k) over v^(power + 2 + k)."""
    return 1.0 / (power + 2.0), 1.0 / (power + 3.0), 1.0 / (power + 4.0), 1.0 / (power + 5.0)


@inner(fastmath=QUOTIENTS)
def _force_integral(c0, c1, c2, c3, j, shares, factor, v):
    """Integral of v^(power + 1) s dv from 0 to v, for the cubic s of these coefficients in v - j;
    `factor` is v^power, and `shares` is `_shares(power)`."""
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
    """Evaluate the laws of the contacts rows[0] ... rows[1] - 1, at table row `place[index]`.

    Fills F, dF/dd, area, int F dd, moment m and growth F dm/dF; zeros for open contacts and those
    without a law. Closed contacts are evaluated in blocks, so that the polynomials become vector
    instructions.
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
            # the variance m + grown of an increment must not be negative; the cubics can make it so
            # where a law hardly rises
            m = max(m, 0.0)
            energy[n], moment[n], growth[n] = work, m, max(grown, -m)


@inner()
def _slope(c0, c1, c2, c3, j, power, v):
    """dF/dv of F = v^power s(v), at least 0, for the cubic s of these coefficients in v - j."""
    t = v - j
    level = c0 + t * (c1 + t * (c2 + t * c3))
    bend = c1 + t * (2.0 * c2 + 3.0 * t * c3)
    return max(_power(v, power - 1.0) * (power * level + v * bend), 0.0)


@inner()
def _tip_exponents(force, area, power, exponent):
    """Exponents of v in force, area and moment of a tip that is no paraboloid, from nodes 1 and 2.

    The exponent of the force is kept between 2 (punch) and 2 p - 2 (cone). An elastic contact with
    F ~ v^e on the radius a has dF/dd ~ a^(p - 2), so the area goes as v^(2 (e - 2)/(p - 2)) and the
    moment as v^(exponent (e - 2)). At the hardness the area grows faster, at most as the force.
    """
    rise = min(max(math.log2(force[2] / force[1]), 2.0), 2.0 * power - 2.0)
    spot = 2.0 * (rise - 2.0) / (power - 2.0)
    if area[2] > area[1]:
        spot = max(spot, min(math.log2(area[2] / area[1]), rise))
    return rise, spot, exponent * (rise - 2.0)


@compiled()
def tabulate(reach, force, stiffness, area, power, factor, exponent, coupled, table, tips):
    """Fill the rows of `table` (n, K + 1, NODE_COLUMNS) and `tips` (n, TIP_COLUMNS) from the nodes.

    `factor` and `exponent` give the variance (factor k)^exponent of an increment of force at the
    stiffness k. The moment is integrated by Gauss quadrature on each interval; its slopes are
    limited so that it increases between the nodes too (Fritsch and Carlson 1980). If `coupled`,
    slopes of s are limited so that the force stays positive between the nodes, and the stiffness is
    continuous at the end of a tip, as the coupled solve needs.
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
                # three assignments: a tuple assigned to the row takes 1 s more to compile
                tips[r, 0], tips[r, 1], tips[r, 2] = rise, spot, wide
                variance = _power(factor * rise * s1 / width, exponent)
                moment[1] = variance * rise / (rise + wide)
                bend[1] = (variance - moment[1]) * rise
                work, load, spread = width * s1 / (rise + 2.0), s1, moment[1] * s1
                s0, d0 = s1, (rise - power) * s1 if coupled else d1
                continue
            if j == 0:
                # s is linear through node 1, and at v = 0 not below a fifth of its value there
                d1 = min(d1, 0.8 * s1) if coupled else d1
                s0, d0 = s1 - d1, d1
            else:
                # with a larger slope the cubic could become negative
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


def empty_columns(count: int, intervals: int, stored: bool = False) -> tuple[Array, Array]:
    """Empty `table` and `tips` of `count` contacts for `tabulate`; in files if `stored`."""
    shapes = (count, intervals + 1, NODE_COLUMNS), (count, TIP_COLUMNS)
    table, tips = (zeros(shape, np.float64, stored) for shape in shapes)
    return table, tips
