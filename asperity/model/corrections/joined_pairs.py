"""Pairs of contacts that join while they carry much of the load: one contact replaces them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asperity.microcontact.basin_bem.press import press
from asperity.microcontact.hertz import curvature_ratios
from surfaces.arrays import Array, Index

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from asperity.model.law_rows import LoadShares
    from asperity.parameters import Parameters
    from surfaces.peaks.summits import Summits

__all__ = ["join"]

TIED = 1e-6
"""Relative difference of approaches up to which pairs join together: rounding parts none."""


def join(
    summits: Summits, shares: LoadShares, material: HalfSpace, parameters: Parameters
) -> tuple[Summits, Array, Array]:
    """Join the summits whose contacts grow together while they carry much of the load.

    If boundary elements cannot press a joined group, because it reaches too far, the pairs of the
    group that join last, all those of a lattice, are left apart, and the rest is tried again.

    Returns
    -------
    summits, curvature, angle
        The summits, and the shapes of their contacts: principal curvatures [1/m], shape (n, 2), and
        direction of the long axis [rad], (n,). A joined contact has the curvatures of the summit
        whose Hertz contact has the same second moments.
    """
    pairs, approach, low = _joining(summits, shares, parameters)
    while len(pairs):
        one = summits.joined(pairs, low)
        roots, slot = np.unique(one.owner[pairs[:, 0]], return_inverse=True)
        depth = np.zeros(len(roots))
        np.maximum.at(depth, slot, approach.max(axis=1))
        found = press(one, roots, depth[:, None] * np.array([1.0, 2.0]), material)[:, -1]
        far = found[:, 0] == 0.0
        if not far.any():
            return one, *_forms(one, roots, found[:, 4:7].T, material.m)
        kept = ~far[slot] | (approach.max(axis=1) < (1.0 - TIED) * depth[slot])
        pairs, approach, low = pairs[kept], approach[kept], low[kept]
    return summits, summits.curvature, summits.angle


def _joining(
    summits: Summits, shares: LoadShares, parameters: Parameters
) -> tuple[Index, Array, Array]:
    """Pairs of summits that join while they carry much of the load, (k, 2); the approaches [m] of
    both as they join, (k, 2); the height [m] down to which their basins count as one, (k,)."""
    bounds = parameters.joined_pairs
    pairs = summits.owner[summits.peaks.neighbors]
    top, low = summits.height[pairs], summits.peaks.passes
    flat = low - (parameters.spots.joined - 1.0) * (top.mean(axis=1) - low)
    some = summits.valid[pairs].all(axis=1) & (pairs[:, 0] != pairs[:, 1])
    some &= (flat > shares.lowest) & (flat < top.min(axis=1))
    pairs, low, flat, approach = pairs[some], low[some], flat[some], (top - flat[:, None])[some]
    load = np.sum(shares.weight[pairs] * approach**1.5, axis=1)
    some = load > bounds.share * shares.load(flat)
    pairs, approach, low = pairs[some], approach[some], low[some]
    return pairs, approach, low - bounds.slack * approach.mean(axis=1)


def _forms(summits: Summits, rows: Index, moments: Array, m: float) -> tuple[Array, Array]:
    """Principal curvatures [1/m] and directions [rad] of all summits; the contacts of the summits
    `rows` have the second moments yy, xx, yx, shape (3, k), of their area.

    The moments are as the squares of the half-axes, of which a Hertz contact has the ratio of its
    curvatures. The geometric mean of the curvatures stays. Moments of no area change nothing.
    """
    curvature, angle = summits.curvature.copy(), summits.angle.copy()
    yy, xx, yx = moments
    mean, skew = 0.5 * (yy + xx), np.hypot(0.5 * (yy - xx), yx)
    wide = mean > skew
    rows, yy, xx, yx, mean, skew = (array[wide] for array in (rows, yy, xx, yx, mean, skew))
    steep = np.sqrt(curvature_ratios(np.sqrt((mean - skew) / (mean + skew)), m))
    middle = np.sqrt(np.prod(curvature[rows], axis=1))
    curvature[rows] = np.stack((middle * steep, middle / steep), axis=1)
    angle[rows] = 0.5 * np.arctan2(2.0 * yx, xx - yy)
    return curvature, angle
