"""The radius a at a prescribed approach: the inverse of D(a) on its rising branch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import bisect

from asperity.errors import ModelRangeError

from .basis import Basis, PowerBasis, TableBasis

__all__ = ["radius_at"]

Array = NDArray[np.float64]

_STEPS = 80
"""Iterations of a root search."""

_FARTHEST = 4.0
"""Radius to which a table is followed, over its last."""


def radius_at(basis: Basis, approach: Array) -> Array:
    """Radius a [m] with D(a) = approach, zero at d <= 0.

    NaN beyond the first zero of D'(a), and beyond four times the last radius of a table.
    """
    scan, d = _scan(basis), np.where(approach > 0, approach, np.nan)
    if not basis.depth(scan[:1])[0] > 0:
        raise ModelRangeError(
            "the mean profile does not rise from its summit, so the approach has no contact; "
            "put the origin at the highest point"
        )
    end = _end(basis, scan)
    if isinstance(basis, PowerBasis):
        low = _positive_root(basis, d)
        if np.isinf(end):
            return np.where(approach > 0, low, 0.0)
        high = np.full_like(low, end)
    else:
        grid = np.append(scan[scan < end], end)
        cell = np.minimum(np.searchsorted(basis.depth(grid), np.nan_to_num(d)), grid.size - 1)
        low, high = np.append(0.0, grid)[cell], grid[cell]
    top = basis.depth(np.array([end]))[0]
    d = np.where(d <= top * (1 + 1e-14), d, np.nan)
    return np.where(approach > 0, _bracketed(basis, d, low, high), 0.0)


def _scan(basis: Basis) -> Array:
    """Radii at which the sign of D' is looked at."""
    if isinstance(basis, TableBasis):
        r = basis.nodes
        inside = np.sort(np.concatenate([r[1:], (r[1:] + r[:-1]) / 2]))
        return np.append(inside, r[-1] * np.linspace(1.02, _FARTHEST, 40))
    pull = np.abs(basis.means * basis.powers)
    rising, falling = basis.means > 0, basis.means < 0
    if not np.any(falling) or not np.any(rising):
        return np.array([1.0])
    ratio = pull[rising][:, None] / pull[falling]
    gap = basis.powers[falling] - basis.powers[rising][:, None]
    with np.errstate(divide="ignore", over="ignore"):
        crossing = ratio ** (1 / np.where(gap == 0, np.inf, gap))
    return np.geomspace(1e-3 * crossing.min(), 1e3 * crossing.max(), 3000)


def _end(basis: Basis, scan: Array) -> float:
    """Radius [m] at which D' first vanishes, or to which a table is followed; infinite for a
    power-law body that only rises."""
    turned = np.flatnonzero(basis.depth(scan, 1) <= 0)
    if turned.size == 0:
        return float(scan[-1]) if isinstance(basis, TableBasis) else np.inf
    first = int(turned[0])
    low = scan[first - 1] if first else scan[0] / 8
    return float(bisect(lambda a: basis.depth(np.array([a]), 1)[0], low, scan[first]))


def _positive_root(basis: PowerBasis, d: Array) -> Array:
    """Root of the rising terms alone: exact without falling ones, else a lower bound."""
    rising = basis.means > 0
    powers = basis.powers[rising]
    factor = basis.depth_factors[rising]
    log_terms = np.log(factor) - np.log(d)[..., None]
    x = np.min(-log_terms / powers, axis=-1)
    for _ in range(_STEPS if powers.size > 1 else 0):
        share = np.exp(log_terms + powers * x[..., None])
        total = share.sum(axis=-1)
        step = np.log(total) * total / (share @ powers)
        x = x - step
        if np.nanmax(np.abs(step), initial=0.0) < 1e-15 * np.nanmax(np.abs(x), initial=1.0):
            break
    with np.errstate(over="ignore"):
        return np.asarray(np.exp(x))


def _bracketed(basis: Basis, d: Array, low: Array, high: Array) -> Array:
    """Newton steps on D(a) = d, replaced by bisection where they leave the bracket."""
    low, high = low.copy(), high.copy()
    known = np.isfinite(d)
    a = np.where(known, (low + high) / 2, np.nan)
    for _ in range(_STEPS):
        safe = np.where(known, a, 1.0 * np.nanmax(high))
        error = basis.depth(safe) - d
        low, high = np.where(error < 0, safe, low), np.where(error > 0, safe, high)
        slope = basis.depth(safe, 1) / safe
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = safe - error / slope
        inside = (newton >= low) & (newton <= high)
        following = np.where(inside, newton, (low + high) / 2)
        moved = np.where(known, np.abs(following - a), 0.0)
        a = np.where(known, following, np.nan)
        if np.all(moved <= 4e-16 * np.nan_to_num(a)):
            break
    return a
