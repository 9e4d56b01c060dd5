"""Slow and obvious twins of what is compiled, and closed forms; they use nothing of that code."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gamma


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
    def exponent(self):
        return 3.0 + self.m

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
    """Flood fill, one pixel at a time."""
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
            todo += [(i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)]
    return labels, count


def edges_by_hand(contact, periodic):
    """Pixel edges between contact and no contact, which surrounds a map that does not repeat."""
    around = np.pad(contact, 1, mode="wrap" if periodic else "constant")
    edges = np.count_nonzero(np.diff(around[1:-1], axis=1)) + np.count_nonzero(
        np.diff(around[:, 1:-1], axis=0)
    )
    if periodic:  # the seam was counted on both sides
        edges -= np.count_nonzero(contact[0] != contact[-1])
        edges -= np.count_nonzero(contact[:, 0] != contact[:, -1])
    return edges
