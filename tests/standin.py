"""Law tables with closed forms, for tests that need no fitted profiles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


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


def random_population(n, cell, seed, *, modulus=1.0, m=0.0, filling=0.3, apart=False):
    """Places, heights and laws of `n` summits of random radius; basins overlap at random, or not
    if they are to lie apart (`n` a square number)."""
    rng = np.random.default_rng(seed)
    y, x = rng.uniform(0, cell[0], n), rng.uniform(0, cell[1], n)
    if apart:
        side = int(np.sqrt(n))
        rows, columns = np.divmod(np.arange(n), side)
        y, x = (
            (k + 0.5 + rng.uniform(-0.15, 0.15, n)) * size / side
            for k, size in zip((rows, columns), cell, strict=True)
        )
    spacing = np.sqrt(cell[0] * cell[1] / n)
    radius = 2.0 * spacing * rng.lognormal(0, 0.4, n)
    limit = (0.6 if apart else 1.0) * spacing * rng.uniform(0.2, 0.6, n)
    reach = limit**2 / ((1 + m) * radius)
    height = filling * spacing * rng.normal(size=n)
    return y, x, height, HertzTable(radius, reach, modulus, m)
