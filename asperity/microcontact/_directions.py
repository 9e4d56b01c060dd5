"""Place of a direction among the rays of a summit, without an arctangent."""

from __future__ import annotations

from numba import njit

FAST = {"contract", "reassoc", "nsz", "arcp"}
"""Rearranged sums; infinities and NaN keep their meaning."""


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy", inline="always")
def quarters(x, y):
    """Angle of (|x|, |y|) over a quarter turn, right to 5e-5."""
    ax, ay = abs(x), abs(y)
    z = ay / max(ax + ay, 1e-300) - 0.5
    q = z * z
    return 0.5 + z * (1.27223736 + q * (-1.6356908 + q * (2.97934497 - q * 3.17613357)))


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy", inline="always")
def place(x, y, rays):
    """Angle of (x, y) in steps between `rays` equispaced rays, from 0 to `rays`."""
    turn = 0.25 * rays * quarters(x, y)
    if x < 0.0:
        turn = 0.5 * rays - turn
    if y < 0.0:
        turn = rays - turn
    return turn
