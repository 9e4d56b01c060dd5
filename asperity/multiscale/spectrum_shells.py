"""The Fourier waves of a map in shells of wave number, and the map of the waves up to a shell."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from surfaces.arrays import Array, Index
from surfaces.heightmap import HeightMap
from surfaces.numerics.compiled import compiled
from surfaces.numerics.parallel import blocks, lines, run, threads
from surfaces.numerics.stored_array import BLOCK_BYTES, Sections, windows
from surfaces.preparation.resampling import Resampled, corner_of

__all__ = ["Shells"]


Waves = NDArray[np.complex128] | Array
Columns = Callable[[int], Iterator[tuple[int, Waves]]]
"""Function of a number of columns that gives the waves of these in blocks: the first column of each
block, and the block."""

MOST_COLUMNS = 32
"""Most columns whose cosine transforms are made at a time."""

LEAST_SIDE_POINTS = 96
"""Least number of points along the shorter side of the grid of the longer waves."""

ROUNDING = 1e-12
"""Relative reduction of the width of a shell. Every second wave along an axis of a map with its
mirror images lies between two shells: with it such a wave belongs to the outer shell whatever the
unit of length."""


@dataclass(frozen=True, eq=False, repr=False)
class Shells:
    """The Fourier waves of a map in shells of equal width in wave number.

    Attributes
    ----------
    hm
        The map, without missing points; one that is not periodic is taken with its mirror images.
    waves
        Gives its real transform, or the cosines of that map and its mirror images, as if from the
        real transform of a map of their own: every column but the first stands for two.
    numbers
        Wave numbers [1/m] of their rows and columns.
    width
        Width [1/m] of a shell.
    sums
        Running sums over the shells (`shell_sums`), shape (n, 5).
    """

    hm: HeightMap
    waves: Columns
    numbers: tuple[Array, Array]
    width: float
    sums: Array

    @classmethod
    def of(cls, hm: HeightMap, m: float) -> Shells:
        """The waves of a map, with the sums for a grading of exponent m."""
        (ny, nx), (dy, dx) = hm.shape, hm.spacing
        if hm.periodic:
            qy, qx = 2.0 * np.pi * fft.fftfreq(ny, dy), 2.0 * np.pi * fft.rfftfreq(nx, dx)
        else:
            qy, qx = np.arange(ny) * np.pi / hm.size[0], np.arange(nx) * np.pi / hm.size[1]
        numbers = np.asarray(qy, float), np.asarray(qx, float)
        width = (1.0 - ROUNDING) * 2.0 * np.pi / max(hm.size)
        waves = _waves(hm, len(numbers[1]))
        return cls(hm, waves, numbers, width, _sums(hm, waves, numbers, width, m))

    def map(self, last: int, points: float) -> Resampled | None:
        """The map of the waves up to the shell `last`, on a grid of `points` per shortest wave.

        None where that would have fewer than `LEAST_SIDE_POINTS` points.
        """
        hm = self.hm
        shortest = 2.0 * np.pi / (self.width * last)
        ny, nx = (
            fft.next_fast_len(int(np.ceil(points * length / shortest)), real=True)
            for length in hm.size
        )
        if min(ny, nx) < LEAST_SIDE_POINTS:
            return None
        rows, width = self._within(last)
        qy, qx = self.numbers[0][rows, None], self.numbers[1][:width]
        square = qy**2 + qx**2
        waves = [block[rows, : width - first] for first, block in self.waves(width)]
        inside = square < ((last + 0.5) * self.width) ** 2
        kept = np.where(inside, np.concatenate(waves, axis=1), 0.0)
        kept *= (ny * nx if hm.periodic else np.sqrt(ny * nx)) / math.prod(hm.shape)
        spacing = hm.size[0] / ny, hm.size[1] / nx
        corner = corner_of(hm, spacing)
        heights = _summed(kept, (ny, nx), corner, hm)
        heights += hm.roughness.mean
        step = {"step": "bandpass", "shortest": shortest, "to": [ny, nx]}
        return Resampled(hm.replace(heights=heights, spacing=spacing, step=step), corner)

    def _within(self, last: int) -> tuple[Index, int]:
        """Rows and number of columns of the waves up to the shell `last`, without those of two
        pixels, which have no phase."""
        ends = np.full(2, (last + 0.5) * self.width)
        (qy, qx), hm = self.numbers, self.hm
        if hm.periodic:
            ends = np.minimum(ends, (1.0 - 1e-9) * np.pi / np.asarray(hm.spacing))
        return np.flatnonzero(np.abs(qy) <= ends[0]), int(np.searchsorted(qx, ends[1], "right"))


def _waves(hm: HeightMap, count: int) -> Columns:
    """The waves of a map, whose transform has `count` columns.

    Rows are transformed first, then columns. Of a map on disk the rows of the transform go to disk
    too, in blocks of columns, and the columns are transformed when they are asked for.
    """
    source, ny = hm.source, hm.shape[0]
    if isinstance(source, np.ndarray):
        waves = _of_columns(hm, _of_rows(hm, source), 0)
        return lambda until: iter([(0, waves)])
    kind = np.complex128 if hm.periodic else np.float64
    stored = Sections((ny, count), max(1, 8 * BLOCK_BYTES // (16 * ny)), kind)

    def part(first: int, last: int) -> None:
        for begin, _, rows in windows(source, first, last):
            stored.write_rows(begin, _of_rows(hm, rows))

    run(part, lines(ny, math.prod(hm.shape)))

    def columns(until: int) -> Iterator[tuple[int, Waves]]:
        for section, (first, _) in enumerate(stored.columns):
            if first < until:
                yield first, _of_columns(hm, stored.read(section), first)

    return columns


def _of_rows(hm: HeightMap, rows: Array) -> Waves:
    """Transforms of some rows of a map."""
    if hm.periodic:
        return np.asarray(fft.rfft(rows, axis=1, workers=threads()))
    return np.asarray(fft.dct(rows, axis=1, norm="ortho", workers=threads()))


def _of_columns(hm: HeightMap, waves: Waves, first: int) -> Waves:
    """Transforms of all columns, from `first` on, of the transforms of all rows."""
    if hm.periodic:
        waves = np.asarray(fft.fft(waves, axis=0, workers=threads(), overwrite_x=True))
    else:
        scale = np.full(waves.shape[1], np.sqrt(0.5 * math.prod(hm.shape)))
        if first == 0:
            scale[0] *= np.sqrt(2.0)

        def part(begin: int, end: int) -> None:  # a cosine transform of far columns waits for them
            some = fft.dct(waves[:, begin:end].copy(), axis=0, norm="ortho", overwrite_x=True)
            np.multiply(some, scale[begin:end], out=waves[:, begin:end])

        run(part, blocks(waves.shape[1], most=MOST_COLUMNS))
    if first == 0:
        waves[0, 0] = 0.0
    return waves


def _sums(
    hm: HeightMap, waves: Columns, numbers: tuple[Array, Array], width: float, m: float
) -> Array:
    """Running sums over the shells."""
    qy, qx = numbers
    count = int(np.hypot(np.abs(qy).max(), qx[-1]) / width + 0.5) + 1
    pairs = np.full(len(qx), 2.0)
    pairs[0] = 1.0
    if hm.periodic and hm.shape[1] % 2 == 0:
        pairs[-1] = 1.0
    total = np.zeros((count, 5))
    for at, block in waves(len(qx)):
        here = slice(at, at + block.shape[1])

        def part(first: int, last: int, block: Waves = block, here: slice = here) -> Array:
            out = np.zeros((count, 5))
            shell_sums(block[first:last], qy[first:last], qx[here], pairs[here], width, m, out)
            return out

        total += np.sum(run(part, blocks(len(qy), 64)), axis=0)
    return np.cumsum(total / math.prod(hm.shape) ** 2, axis=0)


def _summed(
    waves: Waves, shape: tuple[int, int], corner: tuple[float, float], hm: HeightMap
) -> Array:
    """Heights on a grid of the cell of `hm`, from `corner` [m] on, from its lowest waves, of which
    all others are zero."""
    (ny, nx), (rows, width) = shape, waves.shape
    if not hm.periodic:
        waves[:, 1:] *= np.sqrt(2.0)
        lines = fft.idct(waves, n=ny, axis=0, norm="ortho", workers=threads())
        return cast(Array, fft.idct(lines, n=nx, axis=1, norm="ortho", workers=threads()))
    half = rows // 2
    number = np.r_[0 : rows - half, -half:0]
    y, x = (
        np.exp(2j * np.pi * waves * (place / length + 0.5 / new - 0.5 / old))  # pixel centres
        for waves, place, length, new, old in zip(
            (number, np.arange(width)), corner, hm.size, shape, hm.shape, strict=True
        )
    )
    lines = np.zeros((ny, width), complex)
    lines[number] = waves * y[:, None] * x
    lines = fft.ifft(lines, axis=0, workers=threads(), overwrite_x=True)
    return cast(Array, fft.irfft(lines, n=nx, axis=1, workers=threads()))


@compiled()
def shell_sums(
    waves: Waves, qy: Array, qx: Array, pairs: Array, width: float, m: float, out: Array
) -> None:
    """Add to `out` (shells, 5) sums of |h|^2 over the waves of each shell.

    They are those of 1, q^2, q^4, q^(1 - m) and q^(2 - 2 m). `waves` are part of a real transform,
    of wave numbers `qy` and `qx`; `pairs` (columns,) says for how many waves each column stands: 1,
    or 2 with their mirror images. A wave belongs to the shell nearest to q / `width`.
    """
    inverse = 1.0 / width
    for i in range(waves.shape[0]):
        y = qy[i]
        for j in range(waves.shape[1]):
            wave = waves[i, j]
            power = pairs[j] * (wave.real * wave.real + wave.imag * wave.imag)
            x = qx[j]
            square = x * x + y * y
            number = math.sqrt(square)
            root = number
            if m != 0.0 and square > 0.0:
                root = math.exp((1.0 - m) * math.log(number))  # a power slows the loop threefold
            row = out[int(number * inverse + 0.5)]
            row[0] += power
            row[1] += power * square
            row[2] += power * square * square
            row[3] += power * root
            row[4] += power * root * root
