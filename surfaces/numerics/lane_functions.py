"""Functions of eight numbers at once (`lanes`), compiled into the kernels that use them."""

from __future__ import annotations

import math

import numpy as np

from .compiled import QUOTIENTS, inner
from .lanes import splat
from .vectors import exponent, mantissa, power_of_two, where, whole

_INVERSE_FACTORIALS = np.array([1 / math.factorial(k) for k in range(11)])
_SINES = np.array([(-1.0) ** k / math.factorial(2 * k + 1) for k in range(7)])
_COSINES = np.array([(-1.0) ** k / math.factorial(2 * k) for k in range(7)])


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
    """Sine and cosine for |x| < 2."""
    h = 0.5 * x
    q = h * h
    s, c = splat(0.0), splat(0.0)
    for k in range(6, -1, -1):
        s = s * q + _SINES[k]
        c = c * q + _COSINES[k]
    s *= h
    return 2.0 * s * c, 1.0 - 2.0 * s * s
