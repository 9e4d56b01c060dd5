"""Sums of random waves with a self-affine spectrum, in memory or through a file beside."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from surfaces.arrays import Array, Index
from surfaces.numerics import parallel
from surfaces.numerics.memory import require_memory, room_for
from surfaces.numerics.stored_array import Sections, spans

from .errors import LONGEST_LENGTH, SHORTEST_LENGTH, InputError, as_count, as_number, as_numbers

__all__ = ["RandomWaves", "checked_shape", "checked_size"]

Waves = NDArray[np.complex128]

_EDGE = 1e-9
"""Relative tolerance of the band edges, below the spacing of wave numbers."""

_TILE = 2**16
"""Waves that one thread makes at a time: they fit its cache."""

_ROWS = 256
"""Rows of a block: the chunks of a file are as high."""


@dataclass(frozen=True)
class RandomWaves:
    """Waves of a periodic self-affine map: known amplitudes, random phases; all checked.

    The parameters are those of `surfaces.self_affine`. Wave (i, j) of the half spectrum
    (ny, nx//2 + 1) has the phase that the generator draws as number i (nx//2 + 1) + j, so that any
    rectangle of waves can be made without the others.
    """

    shape: tuple[int, int]
    size: tuple[float, float]
    hurst: float
    rms_slope: float | None = None
    rms_height: float | None = None
    rolloff: float | None = None
    cutoff: float | None = None
    anisotropy: float = 1.0
    angle: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", checked_shape(self.shape))
        object.__setattr__(self, "size", checked_size(self.size))
        for name in ("rms_slope", "rms_height", "rolloff", "cutoff"):
            if getattr(self, name) is not None:
                as_number(name, getattr(self, name))
        for name in ("hurst", "angle", "anisotropy", "seed"):
            as_number(name, getattr(self, name))
        hurst, anisotropy, angle, seed = self.hurst, self.anisotropy, self.angle, self.seed
        _check(0.0 <= hurst <= 1.0, f"hurst is {hurst}; it must lie between 0 and 1")
        _check(
            1.0 <= anisotropy < np.inf,
            f"anisotropy is {anisotropy}; it must be at least 1, and finite",
        )
        _check(np.isfinite(angle), f"angle is {angle}; it must be a number of radians")
        _check(
            isinstance(seed, int | np.integer) and seed >= 0,
            f"seed is {seed}; it must be a whole number, not negative",
        )
        for name, wavelength in (("rolloff", self.rolloff), ("cutoff", self.cutoff)):
            _check(
                wavelength is None or wavelength > 0.0,
                f"{name} is {wavelength}; it must be a positive wavelength in m",
            )
        _check(
            (self.rms_slope is None) != (self.rms_height is None),
            "give either rms_slope (--rms-slope) or rms_height (--rms-height), and not both",
        )
        _check(
            0.0 < self._target <= LONGEST_LENGTH,
            f"the rms value is {self._target}; it must be positive and finite",
        )

    @property
    def spacing(self) -> tuple[float, float]:
        """Pixel size (dy, dx) [m]."""
        return self.size[0] / self.shape[0], self.size[1] / self.shape[1]

    def heights(self) -> Array:
        """The map [m], read-only, shape (ny, nx); takes 17 bytes per point."""
        ny, nx = self.shape
        require_memory(
            17 * ny * nx,
            f"a map of {ny} x {nx} points",
            "make it smaller, or straight in a file: surfaces.write_self_affine(path, ...), "
            "surface generate --memory 2GiB",
        )
        heights = self._along_x(self._columns((0, nx // 2 + 1), self._scale()))
        heights -= heights.mean()
        heights.setflags(write=False)
        return heights

    def blocks(self, folder: Path) -> Iterator[Array]:
        """The map [m] in blocks of rows, made within the limit of memory.

        The sums of the waves along y go through a file without a name in `folder`, of 8 bytes per
        point.

        Raises
        ------
        InputError
            If the memory does not hold a block, or the folder the file.
        """
        ny, nx = self.shape
        half, least = nx // 2 + 1, max(16 * ny, 40 * min(ny, _ROWS) * nx)
        room = room_for(least, f"a map of {ny} x {nx} points")
        stored = Sections((ny, half), room // (16 * ny), np.complex128, folder)
        scale = self._scale()
        for section, columns in enumerate(stored.columns):
            stored.write(section, 0, self._columns(columns, scale))
        for first, last in spans(ny, max(_ROWS, room // (40 * nx) // _ROWS * _ROWS)):
            waves = np.empty((last - first, half), np.complex128)
            for section, columns in enumerate(stored.columns):
                waves[:, slice(*columns)] = stored.read(section, first, last)
            yield self._along_x(waves)

    @property
    def _target(self) -> float:
        """Rms height [m] or slope [-] that is asked for."""
        return float((self.rms_slope if self.rms_height is None else self.rms_height) or 0.0)

    def _scale(self) -> float:
        """Amplitude of the discrete transform [m] for an unscaled amplitude of one."""
        count = self.shape[0] * (self.shape[1] // 2 + 1)
        power: float = sum(parallel.each(self._power, spans(count, _TILE)))
        _check(power > 0.0, "no wave lies between the cut-off and the size of the cell")
        _check(power < np.inf, f"anisotropy is {self.anisotropy}; no calculation holds such waves")
        return self._target / float(np.sqrt(power)) * (self.shape[0] * self.shape[1])

    def _power(self, waves: tuple[int, int]) -> float:
        """Mean square of unscaled waves with these numbers: of heights, or slopes if asked for."""
        place = np.divmod(np.arange(*waves), self.shape[1] // 2 + 1)
        fy, fx = self._frequencies(*place)
        with np.errstate(over="ignore", invalid="ignore"):
            # all but those of the first column stand for two conjugate waves
            power = np.where(fx == 0.0, 1.0, 2.0) * self._amplitude(*place) ** 2
            if self.rms_height is None:
                power = power * (2.0 * np.pi) ** 2 * (fy**2 + fx**2)
        return float(power.sum())

    def _columns(self, columns: tuple[int, int], scale: float) -> Waves:
        """Sums along y of the waves of some columns of the half spectrum."""
        ny, (left, right) = self.shape[0], columns
        waves = np.empty((ny, right - left), np.complex128)

        def fill(rows: tuple[int, int]) -> None:
            place = np.arange(*rows)[:, None], np.arange(*columns)[None, :]
            amplitude = self._amplitude(*place) * scale
            waves[slice(*rows)] = amplitude * np.exp(1j * self._phases(rows, columns))

        parallel.each(fill, spans(ny, max(1, _TILE // (right - left))))
        if left == 0:
            above = np.arange(1, (ny + 1) // 2)
            waves[ny - above, 0] = waves[above, 0].conj()
        return np.asarray(fft.ifft(waves, axis=0, overwrite_x=True, workers=parallel.threads()))

    def _along_x(self, waves: Waves) -> Array:
        """Rows of the map [m] from the sums of their waves along y."""
        return np.asarray(fft.irfft(waves, self.shape[1], axis=1, workers=parallel.threads()))

    def _frequencies(self, row: Index, column: Index) -> tuple[Array, Array]:
        """Frequencies [1/m] of waves of the half spectrum along y and x."""
        ny = self.shape[0]
        whole = np.asarray(np.fft.fftfreq(ny, 1.0 / ny), np.float64)
        return whole[row] / self.size[0], column / self.size[1]

    def _phases(self, rows: tuple[int, int], columns: tuple[int, int]) -> Array:
        """Uniform phases of a rectangle of the half spectrum."""
        half, width = self.shape[1] // 2 + 1, columns[1] - columns[0]
        bits = np.random.PCG64(self.seed)
        bits.advance(rows[0] * half + columns[0])
        draws, phase = np.random.Generator(bits), np.empty((rows[1] - rows[0], width))
        for row in phase:
            draws.random(out=row)
            bits.advance(half - width)
        phase *= 2.0 * np.pi
        return phase

    def _amplitude(self, row: Index, column: Index) -> Array:
        """Unscaled amplitudes of waves; those of the mean and of the Nyquist lines are zero."""
        fy, fx = self._frequencies(row, column)
        if self.anisotropy == 1.0:
            k = np.hypot(fy, fx)
        else:
            stretch, angle = np.sqrt(self.anisotropy), self.angle
            along = (fx * np.cos(angle) + fy * np.sin(angle)) * stretch
            across = (fy * np.cos(angle) - fx * np.sin(angle)) / stretch
            k = np.hypot(along, across)
        k[(row == 0) & (column == 0)] = np.inf
        flat = k
        if self.rolloff is not None:
            k_rolloff = 1.0 / self.rolloff
            flat = np.where(k < k_rolloff * (1.0 - _EDGE), k_rolloff, k)
        amplitude: Array = flat ** (-(1.0 + self.hurst))
        if self.cutoff is not None:
            amplitude[k > (1.0 + _EDGE) / self.cutoff] = 0.0
        for wave, n in zip((row, column), self.shape, strict=True):
            if n % 2 == 0:
                amplitude[np.broadcast_to(wave == n // 2, k.shape)] = 0.0
        return amplitude


def checked_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Numbers of points (ny, nx), each at least 3."""
    counts = as_numbers("shape", shape)
    _check(counts.shape == (2,), f"shape is {shape}; give the numbers of points (ny, nx)")
    ny, nx = (as_count("shape", count, 3) for count in counts.tolist())
    return ny, nx


def checked_size(size: tuple[float, float]) -> tuple[float, float]:
    """Lengths (Ly, Lx) [m], both positive."""
    lengths = as_numbers("size", size)
    _check(lengths.shape == (2,), f"size is {size}; give the lengths (Ly, Lx) in m")
    ly, lx = lengths.tolist()
    _check(
        SHORTEST_LENGTH <= min(ly, lx) and max(ly, lx) <= LONGEST_LENGTH,
        f"size is {tuple(size)}; both (Ly, Lx) must be positive lengths in m, from "
        f"{SHORTEST_LENGTH:g} to {LONGEST_LENGTH:g}",
    )
    return ly, lx


def _check(holds: bool | np.bool_, message: str) -> None:
    if not holds:
        raise InputError(message)
