"""Convolution by one real transform pair, planned once."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from surfaces.numerics.parallel import by_rows, threads

from ._grid_kernels import multiply

__all__ = ["FFTWTransform", "ScipyTransform", "prefers_fftw"]

_FACTORS = 2 * 3 * 5 * 7 * 11 * 13
"""Product of the prime factors of the lengths for which FFTW is faster than scipy."""

_ONE_THREAD = 160 * 160
"""Points up to which a transform runs on one thread."""

_home: int | None = None
"""Process in which FFTW first ran on threads: one forked from it lacks them, and would wait."""


def _own(count: int) -> int:
    """As many threads in the process that has them, one in those forked from it."""
    global _home
    if count > 1 and _home is None:
        _home = os.getpid()
    return count if _home == os.getpid() else 1


def prefers_fftw(shape: tuple[int, int]) -> bool:
    """Whether FFTW (estimated plans) is faster than scipy on this shape.

    Measured on two cores: FFTW wins by 1.1-2.5 for lengths with factors up to 13, scipy by 3-4
    for prime lengths (511 x 509: 6.3 against 24 ms).
    """
    # a length below 2**64 with these factors alone divides their product to the power of 64
    return all(pow(_FACTORS, 64, n) == 0 for n in shape)


class _Whole:
    """What both kinds of a planned pair of transforms of a whole grid share, see
    `convolution.Convolution`: `shape` points that hold values, and `padded` of the transform, in
    float64 or float32."""

    values: NDArray[Any]
    grid: NDArray[Any]

    def __init__(
        self,
        shape: tuple[int, int],
        padded: tuple[int, int],
        dtype: np.dtype[Any],
    ) -> None:
        self._padded = padded
        self._threads = _own(threads()) if math.prod(padded) > _ONE_THREAD else 1
        self._plan((shape[0], padded[1]), dtype)

    def _plan(self, rows: tuple[int, int], dtype: np.dtype[Any]) -> None:
        """Set `values` and `grid`, and what the transforms need."""
        raise NotImplementedError

    def _scale(self, spectrum: NDArray[Any], symbol: NDArray[Any]) -> None:
        """Multiply a half spectrum by an even symbol."""
        parts = spectrum.view(self.values.dtype)
        by_rows(multiply, parts.shape, parts, symbol)


class FFTWTransform(_Whole):
    """FFTW pair whose output lies in the buffer of the spectrum."""

    def _plan(self, rows: tuple[int, int], dtype: np.dtype[Any]) -> None:
        import pyfftw

        (ny, nx), count = self._padded, rows[0]
        complex_type = np.result_type(dtype, np.complex64)
        self.values = pyfftw.zeros_aligned(rows, dtype)
        self._spectrum = pyfftw.zeros_aligned((ny, nx // 2 + 1), complex_type)
        self.grid = self._spectrum.view(dtype)[:count]

        def planned(a: Any, b: Any, axes: tuple[int, ...], direction: str) -> Any:
            flags = ("FFTW_ESTIMATE", *(() if a is self.values else ("FFTW_DESTROY_INPUT",)))
            return pyfftw.FFTW(
                a, b, axes=axes, direction=direction, flags=flags, threads=self._threads
            )

        out, used = self.grid[:, :nx], self._spectrum[:count]
        if count == ny:
            self._forward = [planned(self.values, used, (0, 1), "FFTW_FORWARD")]
            self._backward = [planned(used, out, (0, 1), "FFTW_BACKWARD")]
        else:
            columns = (self._spectrum, self._spectrum, (0,))
            self._forward = [
                planned(self.values, used, (1,), "FFTW_FORWARD"),
                planned(*columns, "FFTW_FORWARD"),
            ]
            self._backward = [
                planned(*columns, "FFTW_BACKWARD"),
                planned(used, out, (1,), "FFTW_BACKWARD"),
            ]

    def apply(self, symbol: NDArray[Any]) -> None:
        """Convolve `values` into `grid`."""
        self._spectrum[len(self.values) :] = 0.0
        for stage in self._forward:
            stage.execute()
        self._scale(self._spectrum, symbol)
        for stage in self._backward:
            stage.execute()


class ScipyTransform(_Whole):
    """Pair of scipy.fft."""

    def _plan(self, rows: tuple[int, int], dtype: np.dtype[Any]) -> None:
        self.values, self.grid = np.zeros(rows, dtype), np.zeros(rows, dtype)

    def apply(self, symbol: NDArray[Any]) -> None:
        """Convolve `values` into `grid`."""
        ny, nx = self._padded
        how: Any = {"workers": self._threads, "overwrite_x": True}
        spectrum = scipy.fft.rfft(self.values, axis=1, workers=self._threads)
        spectrum = scipy.fft.fft(spectrum, n=ny, axis=0, **how)
        self._scale(spectrum, symbol)
        spectrum = scipy.fft.ifft(spectrum, axis=0, norm="forward", **how)[: len(self.grid)]
        self.grid[:] = scipy.fft.irfft(spectrum, n=nx, axis=1, norm="forward", **how)
