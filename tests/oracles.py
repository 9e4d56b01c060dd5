"""Dense reference of the interaction: every pair, every image, to about ten digits."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import gamma, gammaincc, roots_jacobi

from asperity.interaction.footprint import Footprints

__all__ = ["dense_matrix", "periodic_interaction", "self_image"]

QUADRATURE = 80
"""Nodes of the integral over the Ewald parameter."""


def dense_matrix(
    y: NDArray[np.float64],
    x: NDArray[np.float64],
    variance: NDArray[np.float64],
    cell: tuple[float, float],
    boundary: str,
    footprints: Footprints,
) -> NDArray[np.float64]:
    """Displacement [m/N] of footprint i by a unit force on footprint j, shape (n, n).

    Parameters
    ----------
    y, x
        Places [m], shape (n,).
    variance
        Variance per axis [m^2] of each footprint, shape (n,), positive.
    cell
        Cell (Ly, Lx) [m].
    boundary
        "periodic" or "free".
    footprints
        Kernel of the half-space.

    Returns
    -------
    matrix
        The diagonal holds the footprint's action on itself, images included. Memory and time grow
        as n^2: this is the judge of `Interaction`, not its rival.
    """
    spread = variance[:, None] + variance[None, :]
    dy, dx = y[:, None] - y[None, :], x[:, None] - x[None, :]
    if boundary == "free":
        return footprints.interaction(np.hypot(dy, dx), spread)
    return periodic_interaction(dy, dx, spread, cell, footprints)


def periodic_interaction(
    dy: NDArray[np.float64],
    dx: NDArray[np.float64],
    spread: NDArray[np.float64],
    cell: tuple[float, float],
    footprints: Footprints,
) -> NDArray[np.float64]:
    """Zero-mean displacement [m/N] by a Gaussian and all its images.

    Notes
    -----
    Ewald sum with the Gaussian kept: q^(m-1) = int_0^inf t^(-(1+m)/2) exp(-q^2 t) dt / Gamma, split
    at T. Above T the sum over wave vectors of Lambda(q) exp(-q^2 S^2/2) Q((1-m)/2, q^2 T) converges
    like exp(-q^2 T); below T each t gives images exp(-r^2 / (4 (t + S^2/2))) / (4 pi (t + S^2/2)),
    integrated by Gauss-Jacobi quadrature. Points (S = 0) are admitted where r > 0.
    """
    m, a = footprints.m, (1 - footprints.m) / 2
    short, area = min(cell), cell[0] * cell[1]
    split = (0.16 * short) ** 2
    total = _waves(dy, dx, spread, cell, footprints, split)
    node, weight = roots_jacobi(QUADRATURE, 0.0, -(1 + m) / 2)
    t = split * (1 + node) / 2
    weight = weight * (split / 2) ** a / gamma(a) * footprints.symbol
    reach = 0.5 * spread
    far = 6.5 * math.sqrt(split + float(np.max(reach)))
    counts = [math.ceil(far / side + 0.5) for side in cell]
    for ky in range(-counts[0], counts[0] + 1):
        for kx in range(-counts[1], counts[1] + 1):
            r2 = (dy + ky * cell[0]) ** 2 + (dx + kx * cell[1]) ** 2
            for tn, wn in zip(t, weight, strict=True):
                width = tn + reach
                total = total + wn * np.exp(-r2 / (4 * width)) / (4 * math.pi * width)
    # what the images add to the mean: each t contributes its weight over the area
    return np.asarray(total - weight.sum() / area)


def self_image(cell: tuple[float, float], footprints: Footprints) -> float:
    """Displacement [m/N] at a point force by its images: the zero-mean periodic kernel minus the
    free one at r = 0; -1.2415 / (E* L) for a square cell of side L and m = 0."""
    m, p = footprints.m, footprints.power
    a = (1 - m) / 2
    zero, area = np.zeros(1), cell[0] * cell[1]
    split = (0.16 * min(cell)) ** 2
    waves = float(_waves(zero, zero, zero, cell, footprints, split)[0])
    factor = footprints.symbol / gamma(a)
    total = (
        waves - factor * split ** (-p / 2) * 2 / p / (4 * math.pi) - factor * split**a / a / area
    )
    node, weight = roots_jacobi(QUADRATURE, 0.0, -p / 2)
    t = split * (1 + node) / 2
    weight = weight * (split / 2) ** a * factor / (4 * math.pi * t)
    counts = [math.ceil(6.5 * math.sqrt(split) / side) for side in cell]
    for ky in range(-counts[0], counts[0] + 1):
        for kx in range(-counts[1], counts[1] + 1):
            r2 = (ky * cell[0]) ** 2 + (kx * cell[1]) ** 2
            if r2 > 0:
                total += float(weight @ np.exp(-r2 / (4 * t)))
    return float(total)


def _waves(
    dy: NDArray[np.float64],
    dx: NDArray[np.float64],
    spread: NDArray[np.float64],
    cell: tuple[float, float],
    footprints: Footprints,
    split: float,
) -> NDArray[np.float64]:
    """1/area sum over q != 0 of Lambda(q) exp(-q^2 S^2/2) Q((1-m)/2, q^2 T) cos(q r)."""
    m = footprints.m
    top = 6.0 / math.sqrt(split)
    ny, nx = (math.ceil(top * side / (2 * math.pi)) for side in cell)
    total = np.zeros(np.broadcast(dy, dx, spread).shape)
    for ky in range(-ny, ny + 1):
        for kx in range(0, nx + 1):
            qy, qx = 2 * math.pi * ky / cell[0], 2 * math.pi * kx / cell[1]
            q2 = qy * qy + qx * qx
            if not 0 < q2 <= top * top:
                continue
            twice = 2.0 if kx else 1.0
            symbol = twice * footprints.symbol * q2 ** ((m - 1) / 2)
            symbol *= float(gammaincc((1 - m) / 2, q2 * split))
            total += symbol * np.exp(-0.5 * q2 * spread) * np.cos(qy * dy + qx * dx)
    return total / (cell[0] * cell[1])
