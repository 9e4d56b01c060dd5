"""Eight numbers at once (`vectors`): one lane per profile, or per node of a contour.

A kernel that handles eight profiles reads like that of one. Arrays hold them as eight contiguous
numbers; an index counts such groups. Besides the vectors of eight: their functions, working space,
and rows of eight profiles turned into lanes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba.extending import register_jitable

from surfaces.arrays import Array

from .compiled import QUOTIENTS, inner
from .vector_type import WORD, constant, unary
from .vectors import add, loader, pick, splatter, storer, transposer, where, whole

__all__ = ["LANES", "add", "load", "pick", "splat", "store", "transpose"]


LANES = 8
"""Numbers in a vector."""

load = loader(LANES, grouped=True)
store = storer(grouped=True)
transpose = transposer(LANES, grouped=True)
splat = splatter(LANES)


_INVERSE_FACTORIALS = np.array([1 / math.factorial(k) for k in range(11)])
_SINES = np.array([(-1.0) ** k / math.factorial(2 * k + 1) for k in range(7)])
_COSINES = np.array([(-1.0) ** k / math.factorial(2 * k) for k in range(7)])


@inner()
def spread_rows(source, rows, out, space):
    """Rows of an array of whole groups (`packed`), one in every lane; `space` is eight groups."""
    width = source.shape[1] // LANES
    for k in range(width):
        for lane in range(LANES):
            store(space, lane, load(source, rows[lane] * width + k))
        transpose(space, 0, 1, out, k * LANES, 1)


@inner()
def collect_rows(source, target, rows, count, space):
    """The first `count` lanes as rows of an array of whole groups; `space` is eight groups."""
    width = target.shape[1] // LANES
    for k in range(width):
        transpose(source, k * LANES, 1, space, 0, 1)
        for lane in range(count):
            store(target, rows[lane] * width + k, load(space, lane))


@inner()
def ordered(keys, highest):
    """Places of whole numbers from 0 to `highest` in rising order."""
    begin = np.zeros(highest + 2, np.int64)
    for key in keys:
        begin[key + 1] += 1
    for key in range(highest + 1):
        begin[key + 1] += begin[key]
    order = np.empty(keys.size, np.int64)
    for i in range(keys.size):
        order[begin[keys[i]]] = i
        begin[keys[i]] += 1
    return order


@register_jitable
def in_groups(count: int) -> int:
    """`count` rounded up to whole groups."""
    return -(-count // LANES) * LANES


@register_jitable
def groups(count: int) -> Array:
    """Working space of `count` groups, at the start of a cache line, with any content; compiled
    loops call this too."""
    space = np.empty((count + 1) * LANES)
    first = (-(space.ctypes.data // 8)) % LANES
    return space[first : first + count * LANES]


def packed(values: Array) -> Array:
    """One row per profile, lengthened by zeros to whole groups."""
    rows = np.ascontiguousarray(values).reshape(len(values), math.prod(values.shape[1:]))
    spare = in_groups(rows.shape[1]) - rows.shape[1]
    return np.pad(rows, ((0, 0), (0, spare))) if spare else rows


@inner(fastmath=QUOTIENTS)
def least(a, b):
    """Smaller of two in each lane; the second where the first is not a number."""
    return where(a < b, a, b)


@inner(fastmath=QUOTIENTS)
def most(a, b):
    """Larger of two in each lane; the second where the first is not a number."""
    return where(a > b, a, b)


@inner(fastmath=QUOTIENTS)
def between(value, low, high):
    """Value kept between two; the lower where it is not a number."""
    return least(most(value, low), high)


def _words(value: Any, number: int) -> Any:
    return constant(ir.VectorType(WORD, value.type.count), number)


def _exponent(builder: Any, value: Any) -> Any:
    word = builder.bitcast(value, ir.VectorType(WORD, value.type.count))
    word = builder.lshr(word, _words(value, 52))
    return builder.sitofp(builder.sub(word, _words(value, 1023)), value.type)


def _mantissa(builder: Any, value: Any) -> Any:
    word = builder.bitcast(value, ir.VectorType(WORD, value.type.count))
    word = builder.and_(word, _words(value, (1 << 52) - 1))
    return builder.bitcast(builder.or_(word, _words(value, 1023 << 52)), value.type)


def _power_of_two(builder: Any, value: Any) -> Any:
    word = builder.fptosi(value, ir.VectorType(WORD, value.type.count))
    word = builder.shl(builder.add(word, _words(value, 1023)), _words(value, 52))
    return builder.bitcast(word, value.type)


exponent = unary(_exponent)
"""Whole part of the logarithm to base 2 of positive normal numbers (double precision)."""

mantissa = unary(_mantissa)
"""Number over 2 to the power of its exponent, in [1, 2) (double precision)."""

power_of_two = unary(_power_of_two)
"""2 to the power of whole numbers from -1022 to 1023 (double precision)."""


@inner(fastmath=QUOTIENTS)
def exponential(x):
    """e to the power of every lane, for |x| < 700."""
    n = whole(x * 1.4426950408889634 + 0.5)
    r = x - n * 0.6931471805599453
    s = splat(1.0 / 39916800)
    for k in range(10, -1, -1):
        s = s * r + _INVERSE_FACTORIALS[k]
    return s * power_of_two(n)


@inner(fastmath=QUOTIENTS)
def logarithm(x):
    """Natural logarithm of positive numbers."""
    e, m = exponent(x), mantissa(x)
    above = m > 1.4142135623730951
    e, m = where(above, e + 1.0, e), where(above, 0.5 * m, m)
    z = (m - 1.0) / (m + 1.0)
    q = z * z
    s = splat(2.0 / 17)
    for k in range(15, 0, -2):
        s = s * q + 2.0 / k
    return e * 0.6931471805599453 + z * s


@inner(fastmath=QUOTIENTS)
def sine_cosine(x):
    """Sine and cosine, to rounding for |x| < 1.2 and to 1e-12 for |x| < 2."""
    h = 0.5 * x
    q = h * h
    s, c = splat(0.0), splat(0.0)
    for k in range(6, -1, -1):
        s = s * q + _SINES[k]
        c = c * q + _COSINES[k]
    s *= h
    return 2.0 * s * c, 1.0 - 2.0 * s * s
