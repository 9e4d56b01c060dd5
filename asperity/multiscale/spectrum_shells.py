"""The waves of a map in shells of equal wave number, and the map of those of the inner shells."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from surfaces.heightmap import HeightMap
from surfaces.numerics.parallel import blocks, run, threads

__all__ = ["Shells"]

Array = NDArray[np.float64]
Waves = NDArray[np.complex128] | Array

FEWEST = 96
"""Least points of the shorter side of the grid of the longer waves."""


@dataclass(frozen=True, eq=False, repr=False)
class Shells:
    """The waves of a map told apart by their numbers, on the map stretched if it has lay.

    Attributes
    ----------
    hm
        The map, without missing points; one that is not periodic is taken with its mirror images.
    waves
        Its real transform, or the cosines of that map and its mirror images, as if from the real
        transform of a map of their own: every column but the first stands for two.
    numbers
        Wave numbers [1/m] of their rows and columns.
    stretch
        Map of (qy, qx) to the numbers by which waves are told apart, shape (2, 2).
    width
        Width [1/m] of a shell.
    sums
        Running sums over the shells (`shell_sums`), shape (n, 8).
    """

    hm: HeightMap
    waves: Waves
    numbers: tuple[Array, Array]
    stretch: Array
    width: float
    sums: Array

    @classmethod
    def of(cls, hm: HeightMap, m: float) -> Shells:
        """The waves of a map that is not stretched, with the sums for a grading of exponent m."""
        (ny, nx), (dy, dx) = hm.shape, hm.spacing
        waves: Waves
        if hm.periodic:
            waves = np.asarray(fft.rfft2(hm.heights, workers=threads()))
            qy, qx = 2.0 * np.pi * fft.fftfreq(ny, dy), 2.0 * np.pi * fft.rfftfreq(nx, dx)
        else:
            waves = fft.dctn(hm.heights, norm="ortho", workers=threads())
            waves *= np.sqrt(hm.heights.size)
            waves[:, 1:] *= np.sqrt(0.5)
            qy, qx = np.arange(ny) * np.pi / hm.size[0], np.arange(nx) * np.pi / hm.size[1]
        waves[0, 0] = 0.0
        numbers = np.asarray(qy, float), np.asarray(qx, float)
        plain = cls(hm, waves, numbers, np.eye(2), 2.0 * np.pi / max(hm.size), np.empty((0, 8)))
        return plain.stretched(np.eye(2), m)

    @property
    def reach(self) -> Array:
        """Largest qy and qx of the waves of number 1."""
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(self.stretch @ self.stretch))))

    def stretched(self, stretch: Array, m: float) -> Shells:
        """The same waves told apart on a map that is stretched."""
        from ._spectrum_kernels import shell_sums

        hm, (qy, qx) = self.hm, self.numbers
        (yy, xy), (_, xx) = stretch @ stretch
        highest = np.abs(qy).max()
        longest = np.sqrt(yy * highest**2 + 2.0 * abs(xy) * highest * qx[-1] + xx * qx[-1] ** 2)
        count = int(longest / self.width + 0.5) + 1
        even = hm.periodic and hm.shape[1] % 2 == 0
        metric = float(xx), float(xy), float(yy)

        def part(first: int, last: int) -> Array:
            out = np.zeros((count, 8))
            rows = self.waves[first:last], qy[first:last]
            shell_sums(*rows, qx, self.width, even, metric, m, out)
            return out

        found = np.sum(run(part, blocks(len(qy), 64)), axis=0) / hm.heights.size**2
        if not hm.periodic:
            found[:, 5] = 0.0  # mirror images have both signs of qx qy
        return replace(self, stretch=stretch, sums=np.cumsum(found, axis=0))

    def inner(self, last: int) -> Shells:
        """Those with no waves beyond the shell `last` but in the corners; the sums stay."""
        rows, width = self._within(last)
        qy, qx = self.numbers
        waves = self.waves[rows, :width]
        return replace(self, waves=waves, numbers=(qy[rows], qx[:width].copy()))

    def map(self, last: int, points: float) -> HeightMap | None:
        """The map of the waves up to the shell `last`, on a grid of `points` per shortest wave.

        None where that would have fewer than `FEWEST` points.
        """
        hm = self.hm
        shortest = 2.0 * np.pi / (self.width * last * self.reach)
        ny, nx = (
            fft.next_fast_len(int(np.ceil(points * length / wave)), real=True)
            for length, wave in zip(hm.size, shortest, strict=True)
        )
        if min(ny, nx) < FEWEST:
            return None
        rows, width = self._within(last)
        qy, qx = self.numbers[0][rows, None], self.numbers[1][:width]
        (yy, xy), (_, xx) = self.stretch @ self.stretch
        square = yy * qy**2 + xx * qx**2
        if xy:
            square += (2.0 * xy * qy) * qx
        kept = np.where(square < ((last + 0.5) * self.width) ** 2, self.waves[rows, :width], 0.0)
        kept *= ny * nx / hm.heights.size if hm.periodic else np.sqrt(ny * nx) / hm.heights.size
        heights = _summed(kept, (ny, nx), hm)
        heights += hm.roughness.mean
        length = float(np.sqrt(np.prod(shortest)))
        step = {"step": "bandpass", "shortest": length, "to": [ny, nx]}
        return hm.replace(heights=heights, spacing=(hm.size[0] / ny, hm.size[1] / nx), step=step)

    def _within(self, last: int) -> tuple[NDArray[np.int64], int]:
        """Rows and number of columns of the waves up to the shell `last`, without those of two
        pixels, which have no phase."""
        ends = (last + 0.5) * self.width * self.reach
        (qy, qx), hm = self.numbers, self.hm
        if hm.periodic:
            ends = np.minimum(ends, (1.0 - 1e-9) * np.pi / np.asarray(hm.spacing))
        return np.flatnonzero(np.abs(qy) <= ends[0]), int(np.searchsorted(qx, ends[1], "right"))


def _summed(waves: Waves, shape: tuple[int, int], hm: HeightMap) -> Array:
    """Heights on a grid of the cell of `hm` from its lowest waves, of which all others are zero."""
    (ny, nx), (rows, width) = shape, waves.shape
    if not hm.periodic:
        waves[:, 1:] *= np.sqrt(2.0)
        lines = fft.idct(waves, n=ny, axis=0, norm="ortho", workers=threads())
        return cast(Array, fft.idct(lines, n=nx, axis=1, norm="ortho", workers=threads()))
    half = rows // 2
    number = np.r_[0 : rows - half, -half:0]
    # pixel centres: the other grid begins another half pixel from the border
    y = np.exp(1j * np.pi * (1.0 / ny - 1.0 / hm.shape[0]) * number)
    x = np.exp(1j * np.pi * (1.0 / nx - 1.0 / hm.shape[1]) * np.arange(width))
    lines = np.zeros((ny, width), complex)
    lines[number] = waves * y[:, None] * x
    lines = fft.ifft(lines, axis=0, workers=threads(), overwrite_x=True)
    return cast(Array, fft.irfft(lines, n=nx, axis=1, workers=threads()))
