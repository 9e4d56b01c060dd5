"""Squared discrete Fourier transform of a map, in memory or on disk as the map is, and the
direction of its waves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from surfaces.arrays import Array
from surfaces.heightmap import HeightMap, require_full
from surfaces.numerics import parallel
from surfaces.numerics.memory import Transform, along_both
from surfaces.numerics.parallel import over_rows
from surfaces.numerics.stored_array import Blocks, Source, blocks_of, windows
from surfaces.preparation.levelling import level

__all__ = ["TIED", "Density", "density_of", "texture_direction", "wave_numbers"]


TIED = 1.0 + 1e-9
"""Ratio of equal numbers in two units: waves on the limit of a ring fall to the same side."""

_ROUNDING = 1e-7
"""Share of all amplitudes that is rounding."""


@dataclass(frozen=True)
class Density:
    """Spectral density of the half of the waves with qx >= 0, in the order of the transform.

    Attributes
    ----------
    source
        The map, less its plane if it is windowed.
    hann
        Whether it is windowed.
    values
        Density [m^4], shape (ny, nx // 2 + 1); stays on disk if the map does.
    """

    source: HeightMap
    hann: bool
    values: Source = field(repr=False)

    @property
    def weight(self) -> Array:
        """Waves that a mode of each column stands for, (nx // 2 + 1,): of q and -q, one where the
        column holds both."""
        count = self.source.shape[1]
        column = np.arange(count // 2 + 1)
        return np.where((column == 0) | (2 * column == count), 1.0, 2.0)

    def along(self, axis: int) -> Array:
        """Mean density [m^3] of windowed profiles along an axis."""
        source, (ny, nx) = self.source.source, self.source.shape
        count, step = self.source.shape[axis], self.source.spacing[axis]
        window, workers = _hann(count), parallel.threads()

        def power(profiles: NDArray[Any]) -> NDArray[Any]:
            lines = (profiles - (profiles @ window / window.sum())[:, None]) * window
            modes = fft.rfft(lines, axis=1, workers=workers)
            return np.asarray(np.square(modes.real) + np.square(modes.imag))

        if axis == 1:
            total = sum(power(rows).sum(axis=0) for _, rows in blocks_of(source))
        else:
            change = Transform(
                nx,
                lambda rows: rows,
                lambda _, columns: power(columns.T).T,
                lambda powers: powers.sum(axis=1, keepdims=True),
            )
            total = along_both(blocks_of(source), source, (ny // 2 + 1, 1), change)[:, 0]
        return np.asarray(total * step / (count * self.source.shape[1 - axis]))


def wave_numbers(waves: Density, rows: slice) -> tuple[Array, Array]:
    """Wave numbers qy of some rows of the half spectrum, and qx (nx // 2 + 1,) [rad/m]."""
    (ny, nx), (dy, dx) = waves.source.shape, waves.source.spacing
    return 2.0 * np.pi * fft.fftfreq(ny, dy)[rows], 2.0 * np.pi * fft.rfftfreq(nx, dx)


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
    (ny, nx), workers = hm.shape, parallel.threads()
    along_y, along_x = (_hann(n) if hann else np.ones(n) for n in hm.shape)
    weighted = (
        float(along_y[begin:end] @ (rows @ along_x)) for begin, end, rows in windows(source.source)
    )
    mean = sum(weighted) / float(along_y.sum() * along_x.sum())

    def windowed() -> Blocks:
        for begin, end, rows in windows(source.source):
            yield begin, (rows - mean) * along_y[begin:end, None] * along_x

    def squared(_: slice, waves: NDArray[Any]) -> NDArray[Any]:
        modes = fft.fft(waves, axis=0, overwrite_x=True, workers=workers)
        density: Array = np.square(modes.real) + np.square(modes.imag)
        density *= hm.area / hm.source.size**2
        return density

    def rows(heights: NDArray[Any]) -> NDArray[Any]:
        return np.asarray(fft.rfft(heights, overwrite_x=True, workers=workers))

    half = nx // 2 + 1
    change = Transform(half, rows, squared, np.real)
    return Density(source, hann, along_both(windowed(), source.source, (ny, half), change))


def _hann(count: int) -> Array:
    """Periodic Hann window of mean square one."""
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * (np.arange(count) + 0.5) / count)
    return np.asarray(window / np.sqrt(np.mean(window**2)))


def texture_direction(waves: Density) -> float:
    """Texture direction Std [rad], 0 to pi: where the angular amplitude spectrum is largest.

    Notes
    -----
    ISO 25178-2:2021, 4.3: amplitudes of all waves up to the largest full ring, summed over sectors
    of one degree; the mean direction in the largest, of equal ones the first. It is that of the
    wave vectors, ccw from +x to +y, across the lay; NaN of a plane, and where all waves lie beyond.
    """

    def sectors(part: slice, density: Array) -> Array:
        qy, qx = wave_numbers(waves, part)
        q, angle = np.hypot(qy[:, None], qx), np.arctan2(qy[:, None], qx) % np.pi
        amplitude = np.sqrt(density) * waves.weight
        amplitude[q == 0.0] = 0.0
        sector = np.round(np.degrees(angle)).astype(np.int64)
        angle -= np.radians(sector)
        sector %= 180
        sector[q > TIED * np.pi / max(waves.source.spacing)] = 180
        values = amplitude, amplitude * angle
        return np.stack([np.bincount(sector.ravel(), v.ravel(), 181) for v in values])

    (*total, beyond), moment = sum(over_rows(sectors, waves.values), np.zeros((2, 181)))
    most = int(np.argmax(np.multiply(total, TIED) >= max(total)))
    if sum(total) <= _ROUNDING * beyond:
        return np.nan
    return float((np.radians(most) + moment[most] / total[most]) % np.pi % np.pi)
