"""Convolution of the whole grid with an even kernel by Fourier transforms.

A large grid is transformed in blocks that fit in the cache: rows, then, for a few columns at a
time, forward transform, multiplication and backward transform in one pass, then rows again. Rows of
padding exist in those blocks only. A small grid is transformed as a whole.
"""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from surfaces.numerics import parallel

from . import _grid_kernels

__all__ = ["Convolution", "FFTWTransform", "ScipyTransform", "plan", "prefers_fftw"]

Shape = tuple[int, int]

_ROWS = 16
"""Rows transformed at a time."""

_COLUMNS = 32
"""Columns transformed at a time."""

_LARGEST_WHOLE = {False: 1400 * 1400, True: 440 * 440}
"""Points up to which one whole transform is faster than blocks, by whether the grid is padded."""

_FACTORS = 2 * 3 * 5 * 7 * 11 * 13
"""Product of the prime factors of the lengths for which FFTW is faster than scipy."""

_ONE_THREAD = 160 * 160
"""Points up to which a transform runs on one thread."""

_home: int | None = None
"""Process in which FFTW first ran on threads: one forked from it lacks them, and would wait."""


def _threads(padded: Shape) -> int:
    """Threads of a whole transform: one in processes forked from the one that has them."""
    global _home
    count = parallel.threads() if math.prod(padded) > _ONE_THREAD else 1
    if count > 1 and _home is None:
        _home = os.getpid()
    return count if _home == os.getpid() else 1


def _scale(spectrum: NDArray[Any], symbol: NDArray[Any]) -> None:
    """Multiply a half spectrum by an even symbol."""
    parts = spectrum.view(symbol.dtype)
    parallel.by_rows(_grid_kernels.multiply, parts.shape, parts, symbol)


class Convolution:
    """A planned convolution on buffers that it owns.

    Parameters
    ----------
    shape, padded
        Points that hold values, (ny, nx), and points of the transform.
    dtype
        float64 or float32.

    Attributes
    ----------
    values
        Input, shape (ny, nx or more), kept; columns beyond nx are zero.
    grid
        Output, shape (ny, nx or more); columns beyond nx are scratch.
    """

    values: NDArray[Any]
    grid: NDArray[Any]

    def __init__(self, shape: Shape, padded: Shape, dtype: np.dtype[Any]) -> None:
        raise NotImplementedError

    def apply(self, symbol: NDArray[Any]) -> None:
        """Convolve `values` into `grid`.

        `symbol` is real and even, divided by the number of points of the transform; its quadrant
        of frequencies from zero on is given, shape (padded ny // 2 + 1, padded nx // 2 + 1).
        """
        raise NotImplementedError


def plan(shape: Shape, padded: Shape, *, dtype: Any = np.float64) -> Convolution:
    """The convolution that is faster for a grid (ny, nx) and its padded shape, by float64 or 32.

    The limits come from single passes timed on two cores: whole transforms are faster below
    1400 x 1400; padded, blocks are from 440 x 440 on, and take half the memory. Of lengths that
    FFTW is slow at, whole transforms (by scipy) are as fast as blocks at any size.
    """
    whole = shape[0] * shape[1] <= _LARGEST_WHOLE[padded != shape]
    kind: type[Convolution] = FFTWTransform if whole else _Blocked
    kind = kind if prefers_fftw(padded) else ScipyTransform
    return kind(shape, padded, np.dtype(dtype))


def prefers_fftw(shape: Shape) -> bool:
    """Whether FFTW (estimated plans) is faster than scipy on this shape.

    Measured on two cores: FFTW wins by 1.1-2.5 for lengths with factors up to 13, scipy by 3-4
    for prime lengths (511 x 509: 6.3 against 24 ms).
    """
    # a length below 2**64 with these factors alone divides their product to the power of 64
    return all(pow(_FACTORS, 64, n) == 0 for n in shape)


class FFTWTransform(Convolution):
    """FFTW pair whose output lies in the buffer of the spectrum."""

    def __init__(self, shape: Shape, padded: Shape, dtype: np.dtype[Any]) -> None:
        import pyfftw

        rows, (ny, nx) = shape[0], padded
        threads = _threads(padded)
        complex_type = np.result_type(dtype, np.complex64)
        self.values = pyfftw.zeros_aligned((rows, nx), dtype)
        self._spectrum = pyfftw.zeros_aligned((ny, nx // 2 + 1), complex_type)
        self.grid = self._spectrum.view(dtype)[:rows]

        def planned(a: Any, b: Any, axes: tuple[int, ...], direction: str) -> Any:
            flags = ("FFTW_ESTIMATE", *(() if a is self.values else ("FFTW_DESTROY_INPUT",)))
            return pyfftw.FFTW(a, b, axes=axes, direction=direction, flags=flags, threads=threads)

        out, used = self.grid[:, :nx], self._spectrum[:rows]
        if rows == ny:
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
        self._spectrum[len(self.values) :] = 0.0
        for stage in self._forward:
            stage.execute()
        _scale(self._spectrum, symbol)
        for stage in self._backward:
            stage.execute()


class ScipyTransform(Convolution):
    """Pair of scipy.fft."""

    def __init__(self, shape: Shape, padded: Shape, dtype: np.dtype[Any]) -> None:
        rows, nx = shape[0], padded[1]
        self.values, self.grid = np.zeros((rows, nx), dtype), np.zeros((rows, nx), dtype)
        self._padded, self._workers = padded, _threads(padded)

    def apply(self, symbol: NDArray[Any]) -> None:
        ny, nx = self._padded
        how: Any = {"workers": self._workers, "overwrite_x": True}
        spectrum = scipy.fft.rfft(self.values, axis=1, workers=self._workers)
        spectrum = scipy.fft.fft(spectrum, n=ny, axis=0, **how)
        _scale(spectrum, symbol)
        spectrum = scipy.fft.ifft(spectrum, axis=0, norm="forward", **how)[: len(self.grid)]
        self.grid[:] = scipy.fft.irfft(spectrum, n=nx, axis=1, norm="forward", **how)


class _Blocked(Convolution):
    """Rows and columns in blocks, on all threads."""

    def __init__(self, shape: Shape, padded: Shape, dtype: np.dtype[Any]) -> None:
        self._shape, self._half = shape, padded[1] // 2 + 1
        self.values = np.zeros(shape, dtype)
        self._lines = [_Lines(padded, dtype) for _ in range(parallel.threads())]
        self._spectrum = np.zeros((shape[0], self._half), self._lines[0].half.dtype)
        self.grid = self._spectrum.view(dtype)

    def apply(self, symbol: NDArray[Any]) -> None:
        ny = self._shape[0]
        self._each(self._forward_rows, -(-ny // _ROWS))
        self._each(lambda *part: self._columns(symbol, *part), -(-self._half // _COLUMNS))
        self._each(self._backward_rows, -(-ny // _ROWS))

    def _each(self, stage: Any, count: int) -> None:
        """Do a stage for a range of blocks on each thread."""
        n = len(self._lines)
        parts = [(i, count * i // n, count * (i + 1) // n) for i in range(n)]
        parallel.each(lambda part: stage(self._lines[part[0]], part[1], part[2]), parts)

    def _forward_rows(self, lines: _Lines, start: int, stop: int) -> None:
        ny, nx = self._shape
        lines.rows[:, nx:] = 0.0
        for y in range(start * _ROWS, min(stop * _ROWS, ny), _ROWS):
            block = self.values[y : y + _ROWS]
            lines.rows[: len(block), :nx] = block
            lines.forward_rows()
            self._spectrum[y : y + _ROWS] = lines.half[: len(block)]

    def _columns(self, symbol: NDArray[Any], lines: _Lines, start: int, stop: int) -> None:
        ny = self._shape[0]
        for x in range(start * _COLUMNS, min(stop * _COLUMNS, self._half), _COLUMNS):
            count = min(_COLUMNS, self._half - x)
            lines.columns[:count, :ny] = self._spectrum[:, x : x + count].T
            lines.columns[:, ny:] = 0.0
            lines.forward_columns()
            _grid_kernels.scale_columns(symbol, x, count, lines.columns.view(symbol.dtype))
            lines.backward_columns()
            self._spectrum[:, x : x + count] = lines.columns[:count, :ny].T

    def _backward_rows(self, lines: _Lines, start: int, stop: int) -> None:
        ny, nx = self._shape
        for y in range(start * _ROWS, min(stop * _ROWS, ny), _ROWS):
            block = self._spectrum[y : y + _ROWS]
            lines.half[: len(block)] = block
            lines.backward_rows()
            self.grid[y : y + _ROWS, :nx] = lines.rows[: len(block), :nx]


class _Lines:
    """Transforms of a block of rows (count, nx) or of columns, each a line (count, ny), by FFTW.

    Rows go from `rows` to `half` and back, which destroys `half`; columns stay in their place.
    """

    def __init__(self, padded: Shape, dtype: np.dtype[Any]) -> None:
        import pyfftw

        ny, nx = padded
        complex_type = np.result_type(dtype, np.complex64)
        self.rows = pyfftw.zeros_aligned((_ROWS, nx), dtype)
        self.half = pyfftw.zeros_aligned((_ROWS, nx // 2 + 1), complex_type)
        self.columns = pyfftw.zeros_aligned((_COLUMNS, ny), complex_type)

        def planned(a: Any, b: Any, direction: str) -> Any:
            flags = ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT")
            return pyfftw.FFTW(a, b, axes=(1,), direction=direction, flags=flags).execute

        self.forward_rows = planned(self.rows, self.half, "FFTW_FORWARD")
        self.backward_rows = planned(self.half, self.rows, "FFTW_BACKWARD")
        self.forward_columns = planned(self.columns, self.columns, "FFTW_FORWARD")
        self.backward_columns = planned(self.columns, self.columns, "FFTW_BACKWARD")
