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

_RAYS = 180
"""Directions in which the amplitudes are summed."""

_SPREAD = 2
"""Wave numbers of the map over which a wave counts to either side: as far as a Hann window spreads
it."""


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
    ISO 25178-2:2021, 4.3: amplitudes times wave numbers, integrated along the ray of each degree up
    to the largest full ring. Each wave counts on the rays on both sides of it, in proportion to
    their nearness, up to two pixels of the spectrum away, or a degree where that is more: the few
    longest waves do not decide by the directions in which they happen to lie. Std is the direction
    of the sum of these wave vectors at the largest ray, of equal ones the first; ccw from +x to +y,
    across the lay; NaN of a plane, and where all waves lie beyond.
    """
    degree = np.pi / _RAYS
    rays = degree * np.arange(_RAYS)
    spread_y, spread_x = (_SPREAD * 2.0 * np.pi / length for length in waves.source.size)
    widths = spread_x * np.abs(np.sin(rays)) + spread_y * np.abs(np.cos(rays))
    limit = TIED * np.pi / max(waves.source.spacing)

    def sums(part: slice, density: Array) -> Array:
        qy, qx = wave_numbers(waves, part)
        q, amplitude = np.hypot(qy[:, None], qx), np.sqrt(density) * waves.weight
        held = (q > 0.0) & (q <= limit)
        found = np.zeros((2, _RAYS + 1))
        found[0, _RAYS] = amplitude[q > limit].sum()
        angle = np.arctan2(qy[:, None], qx)[held] % np.pi
        q, amplitude = q[held], amplitude[held]
        below = np.floor(angle / degree).astype(np.int64)
        reach = np.ceil(np.arcsin(np.minimum(np.hypot(spread_y, spread_x) / q, 1.0)) / degree)
        for step in range(_RAYS // 2):  # the rays to either side, from the nearest
            near = reach > step
            if not near.any():
                break
            q, amplitude, angle, below, reach = (
                each[near] for each in (q, amplitude, angle, below, reach)
            )
            for ray in (below - step, below + step + 1):
                away, index = angle - ray * degree, ray % _RAYS
                along, across = q * np.cos(away), q * np.sin(away)
                width = np.maximum(widths[index], along * np.tan(degree))
                share = amplitude * np.maximum(1.0 - np.abs(across) / width, 0.0) / width
                share *= along > _ROUNDING * q  # a wave across a ray points to both its sides
                for total, vector in zip(found, (along, across), strict=True):
                    total[:_RAYS] += np.bincount(index, share * vector, _RAYS)
        return found

    (*along, beyond), across = sum(over_rows(sums, waves.values), np.zeros((2, _RAYS + 1)))
    if degree * sum(along) <= _ROUNDING * beyond:
        return np.nan
    most = int(np.argmax(np.multiply(along, TIED) >= max(along)))
    return float((rays[most] + np.arctan2(across[most], along[most])) % np.pi % np.pi)
