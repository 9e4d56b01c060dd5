"""Squared discrete Fourier transform of a map, in memory or by sections on disk."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from surfaces.errors import SurfaceError
from surfaces.heightmap import HeightMap, require_full, require_map
from surfaces.numerics import parallel
from surfaces.numerics.memory import room_for
from surfaces.numerics.stored_array import Sections, spans
from surfaces.preparation.levelling import level

from .heights import extent
from .rows import in_memory, rows_of

__all__ = ["Density", "density_of", "over_sections", "wave_numbers"]

Array = NDArray[np.float64]
Result = TypeVar("Result")

_WORK = 120
"""Bytes for each wave of a section, those of what is found from it included."""


class Density(Protocol):
    """Spectral density of the half of the waves with qx >= 0, in the order of the transform."""

    @property
    def source(self) -> HeightMap:
        """The map."""
        ...

    @property
    def hann(self) -> bool:
        """Whether the map is windowed."""
        ...

    def sections(self) -> Iterator[list[tuple[slice, Array]]]:
        """Columns of the half spectrum and their density [m^4], shape (ny, columns), in lists."""
        ...

    def along(self, axis: int) -> Array | None:
        """Mean density [m^3] of windowed profiles along an axis; None if there is no window."""
        ...


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

    Parameters
    ----------
    hm
        The map, without missing points; one on disk must be periodic.

    Raises
    ------
    SurfaceError
        If points are missing, or a map on disk is not periodic.
    InputError
        If the memory is too little.
    """
    require_map(hm)
    if in_memory(hm):
        return _whole(hm)
    if not hm.periodic:
        raise SurfaceError(
            "the map is not periodic, and a spectrum by blocks needs a periodic one: raise the "
            "limit of memory (--memory), or crop the map"
        )
    require_full(hm, "a power spectrum")
    (ny, nx), mean = hm.shape, extent(hm).mean
    room = room_for(4 * _WORK * ny, f"the spectrum of {ny} x {nx} points")
    modes = Sections((ny, nx // 2 + 1), room // (_WORK * ny), np.complex128)
    row = 0
    for block in rows_of(hm):
        modes.write_rows(row, fft.rfft(block - mean, workers=parallel.threads()))
        row += len(block)
    return _OnDisk(hm, modes)


@dataclass(frozen=True)
class _InMemory:
    source: HeightMap
    hann: bool
    heights: Array = field(repr=False)
    density: Array = field(repr=False)

    def sections(self) -> Iterator[list[tuple[slice, Array]]]:
        yield [(slice(0, self.density.shape[1]), self.density)]

    def along(self, axis: int) -> Array | None:
        if not self.hann:
            return None
        count, step = self.source.shape[axis], self.source.spacing[axis]
        lines, window = np.moveaxis(self.heights, axis, -1), _hann(count)
        lines = (lines - (lines @ window / window.sum())[:, None]) * window
        modes = np.abs(fft.rfft(lines, axis=-1)) ** 2
        return np.asarray(modes.mean(axis=0) * step / count)


@dataclass(frozen=True)
class _OnDisk:
    source: HeightMap
    modes: Sections
    hann: bool = False

    def sections(self) -> Iterator[list[tuple[slice, Array]]]:
        workers = parallel.threads()
        for section, (left, _) in enumerate(self.modes.columns):
            rows = self.modes.read(section)
            modes = fft.fft(rows, axis=0, overwrite_x=True, workers=workers)
            parts = spans(modes.shape[1], -(-modes.shape[1] // workers))
            yield [
                (slice(left + a, left + b), _squared(modes[:, a:b], self.source)) for a, b in parts
            ]

    def along(self, axis: int) -> None:
        return None


def _whole(hm: HeightMap) -> _InMemory:
    require_full(hm, "a power spectrum")
    hann = not hm.periodic
    heights = level(hm, "plane").heights if hann else hm.heights - hm.heights.mean()
    windowed = heights
    if hann:
        window = _hann(hm.shape[0])[:, None] * _hann(hm.shape[1])[None, :]
        windowed = (heights - np.sum(window * heights) / np.sum(window)) * window
    return _InMemory(hm, hann, heights, _squared(fft.rfft2(windowed), hm))


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
