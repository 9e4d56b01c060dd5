"""Squared discrete Fourier transform of a map, in memory or by sections on disk."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from surfaces.heightmap import HeightMap, require_full
from surfaces.numerics import parallel
from surfaces.numerics.memory import room_for
from surfaces.numerics.stored_array import Sections, blocks_of, spans
from surfaces.preparation.levelling import level

from .rows import in_memory

__all__ = ["Density", "density_of", "over_sections", "wave_numbers"]

Array = NDArray[np.float64]
Result = TypeVar("Result")

_WORK = 120
"""Bytes for each wave of a section, those of what is found from it included."""


@dataclass(frozen=True)
class Density:
    """Spectral density of the half of the waves with qx >= 0, in the order of the transform.

    Attributes
    ----------
    source
        The map, less its plane if it is windowed.
    hann
        Whether it is windowed.
    whole
        Density [m^4] of a map in memory, shape (ny, nx // 2 + 1).
    rows
        Transforms of the rows of a map on disk.
    """

    source: HeightMap
    hann: bool
    whole: Array | None = field(default=None, repr=False)
    rows: Sections | None = field(default=None, repr=False)

    def sections(self) -> Iterator[list[tuple[slice, Array]]]:
        """Columns of the half spectrum and their density [m^4], shape (ny, columns), in lists."""
        if self.whole is not None:
            yield [(slice(0, self.whole.shape[1]), self.whole)]
        if self.rows is None:
            return
        workers = parallel.threads()
        for section, (left, _) in enumerate(self.rows.columns):
            rows = self.rows.read(section)
            modes = fft.fft(rows, axis=0, overwrite_x=True, workers=workers)
            parts = spans(modes.shape[1], -(-modes.shape[1] // workers))
            yield [
                (slice(left + a, left + b), _squared(modes[:, a:b], self.source)) for a, b in parts
            ]

    def along(self, axis: int) -> Array | None:
        """Mean density [m^3] of windowed profiles along an axis; None if there is no window."""
        if not self.hann:
            return None
        if axis == 1:
            return _along(axis, self.source, (rows for _, rows in blocks_of(self.source.source)))
        if in_memory(self.source):
            return _along(axis, self.source, [self.source.heights.T])
        columns = Sections(self.source.shape, _width(*self.source.shape), np.float64)
        for begin, rows in blocks_of(self.source.source):
            columns.write_rows(begin, rows)
        sections = (columns.read(section).T for section in range(len(columns.columns)))
        return _along(axis, self.source, sections)


def over_sections(function: Callable[[slice, Array], Result], waves: Density) -> Iterator[Result]:
    """What a function finds in sections of a density, in order; in threads if they are many."""
    for parts in waves.sections():
        yield from parallel.each(lambda part: function(*part), parts)


def wave_numbers(waves: Density, columns: slice) -> tuple[Array, Array]:
    """Wave numbers qy (ny,), and qx of some columns of the half spectrum [rad/m]."""
    (ny, nx), (dy, dx) = waves.source.shape, waves.source.spacing
    return 2.0 * np.pi * fft.fftfreq(ny, dy), 2.0 * np.pi * fft.rfftfreq(nx, dx)[columns]


def density_of(hm: HeightMap) -> Density:
    """Density of a map, less its mean; windowed, less its plane, if it is not periodic.

    Raises
    ------
    SurfaceError
        If points are missing, or the disk has no room for a map on disk.
    InputError
        If the memory is too little.
    """
    require_full(hm, "a power spectrum")
    hann = not hm.periodic
    source = level(hm, "plane") if hann else hm
    along_y, along_x = (_hann(n) if hann else np.ones(n) for n in hm.shape)
    if in_memory(hm):
        window, heights = np.outer(along_y, along_x), source.heights
        windowed = (heights - np.sum(window * heights) / np.sum(window)) * window
        return Density(source, hann, _squared(fft.rfft2(windowed), source))
    (ny, nx), workers = hm.shape, parallel.threads()
    modes = Sections((ny, nx // 2 + 1), _width(ny, nx), np.complex128)
    weighted = (
        float(along_y[begin : begin + len(rows)] @ (rows @ along_x))
        for begin, rows in blocks_of(source.source)
    )
    mean = sum(weighted) / float(along_y.sum() * along_x.sum())
    for begin, rows in blocks_of(source.source):
        windowed = (rows - mean) * along_y[begin : begin + len(rows), None] * along_x
        modes.write_rows(begin, fft.rfft(windowed, overwrite_x=True, workers=workers))
    return Density(source, hann, rows=modes)


def _width(ny: int, nx: int) -> int:
    """Columns of a section of a map on disk."""
    return room_for(4 * _WORK * ny, f"the spectrum of {ny} x {nx} points") // (_WORK * ny)


def _along(axis: int, source: HeightMap, blocks: Iterable[Array]) -> Array:
    """Mean density [m^3] of windowed profiles along an axis, the rows of some blocks."""
    count, step = source.shape[axis], source.spacing[axis]
    window, total = _hann(count), np.zeros(count // 2 + 1)
    for block in blocks:
        lines = (block - (block @ window / window.sum())[:, None]) * window
        total += (np.abs(fft.rfft(lines, axis=-1)) ** 2).sum(axis=0)
    return np.asarray(total * step / (count * source.shape[1 - axis]))


def _squared(modes: NDArray[np.complex128], hm: HeightMap) -> Array:
    """Density [m^4] of the modes of a map."""
    (ny, nx), (dy, dx) = hm.shape, hm.spacing
    density: Array = np.square(modes.real) + np.square(modes.imag)
    density *= (dy * dx) ** 2 / (ny * dy * nx * dx)
    return density


def _hann(count: int) -> Array:
    """Periodic Hann window of mean square one."""
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * (np.arange(count) + 0.5) / count)
    return np.asarray(window / np.sqrt(np.mean(window**2)))
