"""Height maps of the stress cases: rough ones, and such as no model of summits expects."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from surfaces.arrays import Array
from surfaces.heightmap import HeightMap
from surfaces.synthesis import self_affine

__all__ = ["TEXTURES", "rough", "rough_heights"]


SHAPE = 64, 80
"""Points of every map but for cases about the grid."""

WAVE = 16
"""Points of a wavelength, a ridge or a check."""


def rough_heights(shape: tuple[int, int] = SHAPE, cutoff: float = 8.0) -> Array:
    """Self-affine heights of unit rms slope on unit pixels."""
    size = float(shape[0]), float(shape[1])
    map_ = self_affine(shape, size, hurst=0.8, rms_slope=1.0, cutoff=cutoff, seed=1)
    return map_.heights.copy()


def rough(shape: tuple[int, int] = SHAPE, *, pixel: float = 1e-6, slope: float = 0.1) -> HeightMap:
    """Rough periodic map of square pixels [m] with an rms slope."""
    return HeightMap(pixel * slope * rough_heights(shape), (pixel, pixel), periodic=True)


def _grid() -> tuple[Array, Array]:
    y, x = np.indices(SHAPE, dtype=float)
    return y, x


def _noise() -> Array:
    return np.random.default_rng(5).normal(size=SHAPE)


def _around() -> Array:
    """Distance from the middle of a hill on every square of side `WAVE`, over half of that."""
    y, x = _grid()
    return np.hypot((y + 0.5) % WAVE - WAVE / 2, (x + 0.5) % WAVE - WAVE / 2) * 2 / WAVE


def _spiked(height: float, heights: Array) -> Array:
    heights[20, 30] = heights.mean() + height * heights.std()
    return heights


TEXTURES: dict[str, Callable[[], Any]] = {
    "sharp tips": lambda: -_around(),
    "cusps": lambda: -np.sqrt(_around()),
    "flat tops": lambda: -np.maximum(_around(), 0.5),
    "beads": lambda: np.sqrt(np.maximum(1.0 - _around() ** 2, 0.0)),
    "dimples": lambda: -np.sqrt(np.maximum(1.0 - _around() ** 2, 0.0)),
    "spike of 30 rms": lambda: _spiked(30.0, rough_heights()),
    "spike of 400 rms": lambda: _spiked(400.0, rough_heights()),
    "spike of 300 rms on noise": lambda: _spiked(300.0, _noise()),
    "pit of 2000 rms": lambda: _spiked(-2000.0, rough_heights()),
    "step": lambda: rough_heights() + 50.0 * (_grid()[1] < 40.0),
    "one step, else flat": lambda: 1.0 * (_grid()[1] < 40.0),
    "one pixel, else flat": lambda: 1.0 * (np.hypot(_grid()[0] - 9, _grid()[1] - 9) < 0.5),
    "grating": lambda: 1.0 * (_grid()[1] % WAVE < WAVE / 2),
    "grating of single pixels": lambda: _grid()[1] % 2.0,
    "saw teeth": lambda: _grid()[1] % WAVE,
    "checkerboard": lambda: (_grid()[0] // 8 + _grid()[1] // 8) % 2,
    "checkerboard of single pixels": lambda: (_grid()[0] + _grid()[1]) % 2,
    "ties": lambda: np.tile(rough_heights((16, 16), 4.0), (4, 5)),
    "wave of ridges": lambda: np.cos(2 * np.pi * _grid()[1] / WAVE),
    "wave of hills": lambda: (
        np.cos(2 * np.pi * _grid()[1] / 40) + np.cos(2 * np.pi * _grid()[0] / 32)
    ),
    "shortest wave": lambda: np.cos(np.pi * _grid()[1]) * np.cos(np.pi * _grid()[0]),
    "white noise": _noise,
    "noise of rounding on a flat": lambda: 1.0 + 1e-16 * np.round(10.0 * _noise()),
    "rough to the pixel": lambda: rough_heights(cutoff=2.0),
    "quantized to 3 levels": lambda: np.round(rough_heights() / rough_heights().std()),
    "quantized to 30 levels": lambda: np.round(10 * rough_heights() / rough_heights().std()),
    "clipped": lambda: np.minimum(rough_heights(), 0.5 * rough_heights().std()),
    "clipped, noise of 1e-12": lambda: (
        np.minimum(rough_heights(), 0.5 * rough_heights().std()) + 1e-12 * _noise()
    ),
    "one wide hill, fine waves": lambda: (
        np.cos(2 * np.pi * _grid()[1] / SHAPE[1]) + np.cos(2 * np.pi * _grid()[0] / SHAPE[0])
        + 0.002 * rough_heights()
    ),
    "lay of 20:1": lambda: self_affine(
        SHAPE, (64.0, 80.0), hurst=0.8, rms_slope=1.0, cutoff=6.0, anisotropy=20.0, seed=3
    ).heights,
    "cliff at the seam": lambda: rough_heights() + 2.0 * _grid()[1],
    "tilted": lambda: rough_heights() + 0.5 * _grid()[0],
    "constant": lambda: np.ones(SHAPE),
}  # fmt: skip
"""Heights of unit size on unit pixels, by name."""
