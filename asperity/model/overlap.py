"""Overlap of flat and surface between the contacts, where no summit tells of it.

Contacts grow from summits. A plane under a few hills, or the ground about them, has none: the flat
comes down on it, and the contacts, which carry all of the load, go on as if it did not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import fft

from asperity.halfspace.influence import compliance, near_influence, symbol_quadrant
from surfaces.arrays import Array, Index
from surfaces.preparation.resampling import block_means

if TYPE_CHECKING:
    from asperity.halfspace.material import HalfSpace
    from surfaces.heightmap import HeightMap

__all__ = ["Blocks"]

BLOCKS = 64
"""Blocks along a side of the map, at most. With 32 or 128 the overlap changes by a tenth."""

WINDOW = 1.0
"""Standard deviation [blocks] of the Gaussian over which gaps are averaged: single blocks that hold
a contact close by up to the error of its load."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """A surface by the mean heights of its blocks.

    Attributes
    ----------
    heights
        Mean heights of the blocks above the mean plane [m], shape (by, bx).
    place
        Flat index of the block under each summit, shape (n,).
    transfer
        Displacement [m] over load on a block [N], of the waves of blocks that are padded with as
        many on a free half-space.
    padded
        Shape of these blocks.
    about
        Weights of the blocks about each row (by, by) and each column (bx, bx), by which gaps are
        averaged: a Gaussian of `WINDOW`.
    """

    heights: Array
    place: Index
    transfer: Array
    padded: tuple[int, int]
    about: tuple[Array, Array]

    @classmethod
    def of(
        cls, hm: HeightMap, mean: float, y: Array, x: Array, material: HalfSpace, *, wraps: bool
    ) -> Blocks:
        """Blocks of a map with its mean plane at the height `mean` [m] and summits at y, x [m]."""
        shape = min(hm.shape[0], BLOCKS), min(hm.shape[1], BLOCKS)
        spacing = hm.size[0] / shape[0], hm.size[1] / shape[1]
        row, col = (
            np.floor(at / step).astype(np.int64) for at, step in zip((y, x), spacing, strict=True)
        )
        row, col = (
            at % n if wraps else np.clip(at, 0, n - 1)
            for at, n in zip((row, col), shape, strict=True)
        )
        padded = shape if wraps else (2 * shape[0], 2 * shape[1])
        rows, cols = (np.abs(fft.fftfreq(n, 1.0 / n)).astype(np.int64) for n in padded)
        if wraps:
            half = np.arange(shape[1] // 2 + 1)
            transfer = symbol_quadrant(shape, spacing, material.m - 1.0, 1.0)[rows[:, None], half]
        else:
            near = np.pad(near_influence(shape, spacing, material.m), ((0, 1), (0, 1)))
            transfer = fft.rfft2(near[rows[:, None], cols]).real
        transfer *= compliance(spacing, material) / (spacing[0] * spacing[1])
        heights, place = block_means(hm.source, shape) - mean, row * shape[1] + col
        about = _window(shape[0], wraps=wraps), _window(shape[1], wraps=wraps)
        return cls(heights, place, transfer, padded, about)

    def gaps(self, force: Array, separation: float) -> Array:
        """Mean gaps [m] about each block, shape (by, bx), under forces [N] on the summits, (n,)."""
        ny, nx = self.heights.shape
        load = np.bincount(self.place, force, ny * nx).reshape(ny, nx)
        waves = fft.rfft2(load, s=self.padded) * self.transfer
        displaced = fft.irfft2(waves, s=self.padded)[:ny, :nx]
        rows, columns = self.about
        return np.asarray(rows @ (separation - self.heights + displaced) @ columns.T)

    def overlap(self, force: Array, separation: float, contact_share: float) -> float:
        """How far the flat passes through the surface beside contacts with the forces [N], (n,),
        which cover the `contact_share` of it [-]: 0 where it does not.

        Notes
        -----
        The mean gap about a place of a real surface is nowhere negative. Added up are the volume of
        negative gaps over that of positive ones, which is 1 where the mean gap vanishes, and the
        area of negative gaps over that of the contacts and their blocks, less 1.
        """
        gap = self.gaps(force, separation)
        between, beyond = (float(np.maximum(part, 0.0).sum()) for part in (gap, -gap))
        known = contact_share + len(np.unique(self.place[force > 0.0])) / gap.size
        wider = float(np.mean(gap < 0.0)) / known - 1.0
        return (beyond / between if between > 0.0 else np.inf) + max(wider, 0.0)


def _window(count: int, *, wraps: bool) -> Array:
    """Weights of `count` blocks about each of them, (count, count), of the sum 1."""
    away = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    away = np.minimum(away, count - away) if wraps else away
    weight = np.exp(-0.5 * np.square(away / WINDOW))
    return np.asarray(weight / weight.sum(axis=1, keepdims=True))
