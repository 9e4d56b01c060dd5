"""Slow reference implementations of what is compiled, and closed forms, without that code."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gamma, gammaincc, roots_jacobi

from asperity.halfspace.footprint import Footprints, _pair_shape
from asperity.microcontact.law_table import LawTable


def periodic_displacement(pressure, spacing, modulus, m):
    """u of a periodic pressure from the symbol, written out again."""
    ny, nx = pressure.shape
    qy = 2 * np.pi * np.fft.fftfreq(ny, spacing[0])[:, None]
    qx = 2 * np.pi * np.fft.rfftfreq(nx, spacing[1])[None, :]
    q = np.hypot(qy, qx)
    q[0, 0] = 1.0
    compliance = 2 ** (1 - m) * np.pi / gamma((1 + m) / 2) ** 2 / modulus * q ** (m - 1)
    compliance[0, 0] = 0.0
    return np.fft.irfft2(np.fft.rfft2(pressure) * compliance, s=pressure.shape)


def polonsky_keer(heights, spacing, mean, *, modulus=1.0, m=0.0, tolerance=1e-9, longest=3000):
    """Pressure [Pa] by the textbook method (Polonsky and Keer 1999): cold, no preconditioner."""
    pressure = np.full(heights.shape, float(mean))
    direction = np.zeros_like(pressure)
    old, restart = 1.0, 0.0
    rms = heights.std()
    for _ in range(longest):
        contact = pressure > 0
        gap = periodic_displacement(pressure, spacing, modulus, m) - heights
        gap -= gap[contact].mean()
        error = (pressure * np.abs(gap)).sum() / (pressure.sum() * rms)
        if max(error, -gap.min() / rms) < tolerance:
            break
        norm = (gap[contact] ** 2).sum()
        direction = np.where(contact, gap + restart * norm / old * direction, 0.0)
        old = norm
        response = periodic_displacement(direction, spacing, modulus, m)
        response -= response[contact].mean()
        step = (gap * direction)[contact].sum() / (response * direction)[contact].sum()
        pressure = np.maximum(np.where(contact, pressure - step * direction, pressure), 0.0)
        inside = (pressure == 0) & (gap < 0)
        restart = 0.0 if inside.any() else 1.0
        pressure[inside] -= step * gap[inside]
        pressure *= mean / pressure.mean()
    return pressure


def axisymmetric(k, depth):
    """Radius and force of the body r^k on a half-space of unit modulus (Galin, Sneddon)."""
    unit = np.sqrt(np.pi) * gamma(k / 2 + 1) / gamma((k + 1) / 2)
    radius = (depth / unit) ** (1 / k)
    return radius, 2 * radius * depth * k / (k + 1)


@dataclass(frozen=True)
class HertzTable:
    """Round paraboloids of radius R, flat punches beyond `reach`.

    F = 4 E a^(1+m) d / ((1+m)(3+m)) with a^2 = (1+m) R d, dF/dd = 2 E a^(1+m) / (1+m).
    """

    radius: NDArray[np.float64]
    reach: NDArray[np.float64]
    modulus: float = 1.0
    m: float = 0.0
    nodes: int = 12

    def __len__(self):
        return len(self.reach)

    def rows(self, index):
        nothing = np.zeros((len(index), self.nodes + 1))
        values = (column[index] for column in (self.reach, *self._grid))
        return LawTable(*values, nothing.astype(np.uint8), nothing, 3.0 + self.m)

    def _law(self, d, index):
        """Force, stiffness, area at approaches d of the contacts `index`, basins without limit."""
        p = 1 + self.m
        a2 = p * self.radius[index] * d
        stiffness = 2 * self.modulus * a2 ** (p / 2) / p
        return stiffness * d * 2 / (2 + p), stiffness, np.pi * a2

    @property
    def _grid(self):
        u2 = (np.arange(self.nodes + 1) / self.nodes) ** 2
        return self._law(self.reach[:, None] * u2, np.arange(len(self.reach))[:, None])

    @property
    def force(self):
        return self._grid[0]

    @property
    def stiffness(self):
        return self._grid[1]

    @property
    def area(self):
        return self._grid[2]

    def evaluate(self, index, approach):
        inside = np.minimum(approach, self.reach[index])
        force, stiffness, area = self._law(np.maximum(inside, 0.0), index)
        return force + stiffness * (approach - inside), stiffness, area


def neighbors_of(i, j, shape, periodic):
    for di in (-1, 0, 1):
        for dj in (-1, 0, 1):
            row, col = i + di, j + dj
            if periodic:
                row, col = row % shape[0], col % shape[1]
            if (di or dj) and 0 <= row < shape[0] and 0 <= col < shape[1]:
                yield row, col, di, dj


def flood(hm, above=-np.inf):
    """Pixels in descending height, one by one: summits, labels and saddles (no equal heights)."""
    h = hm.heights
    labels = np.full(h.shape, -1)
    group, summits, saddle, parent = [], [], [], []

    def find(a):
        while group[a] != a:
            a = group[a]
        return a

    for p in np.argsort(-h, axis=None):
        i, j = divmod(int(p), h.shape[1])
        if h[i, j] < above:
            break
        flooded = [
            ((h[r, c] - h[i, j]) / np.hypot(di * hm.spacing[0], dj * hm.spacing[1]), labels[r, c])
            for r, c, di, dj in neighbors_of(i, j, h.shape, hm.periodic)
            if labels[r, c] >= 0
        ]
        if not flooded:
            labels[i, j] = len(group)
            group.append(len(group))
            summits.append((i, j))
            saddle.append(None)
            parent.append(-1)
            continue
        labels[i, j] = max(flooded)[1]
        roots = sorted({find(label) for _, label in flooded})
        for root in roots[1:]:
            group[root], saddle[root], parent[root] = roots[0], h[i, j], roots[0]
    lowest = h[labels >= 0].min()
    return summits, labels, [lowest if s is None else s for s in saddle], parent


def labels_by_hand(contact, periodic):
    """Flood fill over edges and corners, one pixel at a time."""
    ny, nx = contact.shape
    labels = np.zeros(contact.shape, int)
    count = 0
    for start in zip(*np.nonzero(contact), strict=True):
        if labels[start]:
            continue
        count += 1
        todo = [start]
        while todo:
            i, j = todo.pop()
            if periodic:
                i, j = i % ny, j % nx
            if not (0 <= i < ny and 0 <= j < nx) or not contact[i, j] or labels[i, j]:
                continue
            labels[i, j] = count
            todo += [(i + di, j + dj) for di in (-1, 0, 1) for dj in (-1, 0, 1)]
    return labels, count


def edges_by_hand(contact, periodic):
    """Pixel edges between contact and no contact; the border of a map that does not repeat is
    none."""
    around = np.pad(contact, 1, mode="wrap" if periodic else "edge")
    edges = np.count_nonzero(np.diff(around[1:-1], axis=1)) + np.count_nonzero(
        np.diff(around[:, 1:-1], axis=0)
    )
    if periodic:  # the seam was counted on both sides
        edges -= np.count_nonzero(contact[0] != contact[-1])
        edges -= np.count_nonzero(contact[:, 0] != contact[:, -1])
    return edges


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
        return free_interaction(footprints, np.hypot(dy, dx), spread)
    return periodic_interaction(dy, dx, spread, cell, footprints)


def free_interaction(
    footprints: Footprints, distance: ArrayLike, variance: ArrayLike
) -> NDArray[np.float64]:
    """Displacement g(r; S^2) [m/N] of one Gaussian by another, free half-space.

    Parameters
    ----------
    footprints
        Kernel of the half-space.
    distance
        Distance r [m].
    variance
        Sum S^2 of the two variances [m^2]; r and S must not both vanish.
    """
    r2, spread = np.broadcast_arrays(np.square(np.asarray(distance, float)), variance)
    reach = r2 + spread
    shape, _, _ = _pair_shape(footprints.m, spread / reach)
    return np.asarray(footprints.point * shape * reach ** (-footprints.power / 2))


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
