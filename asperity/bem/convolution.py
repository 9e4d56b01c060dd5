"""Convolution of the whole grid with an even kernel by Fourier transforms.

A large grid is transformed in blocks that fit in the cache: rows, then, for a few columns at a
time, forward transform, multiplication and backward transform in one pass, then rows again. Rows of
padding exist in those blocks only.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics import parallel

from . import _grid_kernels
from .transform import FFTWTransform, ScipyTransform, prefers_fftw

__all__ = ["Convolution", "plan"]

_ROWS = 16
"""Rows transformed at a time."""

_COLUMNS = 32
"""Columns transformed at a time."""

_LARGEST_WHOLE = {False: 1400 * 1400, True: 440 * 440}
"""Points up to which one whole transform is faster than blocks, by whether the grid is padded."""


class Convolution(Protocol):
    """A planned convolution on buffers that it owns.

    Attributes
    ----------
    values
        Input, shape (ny, nx or more), kept; columns beyond nx are zero.
    grid
        Output, shape (ny, nx or more); columns beyond nx are scratch.
    """

    values: NDArray[Any]
    grid: NDArray[Any]

    def apply(self, symbol: NDArray[Any]) -> None:
        """Convolve `values` into `grid`.

        `symbol` is real and even, divided by the number of points of the transform; its quadrant
        of frequencies from zero on is given, shape (padded ny // 2 + 1, padded nx // 2 + 1).
        """


def plan(
    shape: tuple[int, int],
    padded: tuple[int, int],
    *,
    dtype: Any = np.float64,
) -> Convolution:
    """The convolution that is faster for a grid (ny, nx) and its padded shape, by float64 or 32.

    The limits come from single passes timed on two cores: whole transforms are faster below
    1400 x 1400; padded, blocks are from 440 x 440 on, and take half the memory. Of lengths that
    FFTW is slow at, whole transforms (by scipy) are as fast as blocks at any size.
    """
    whole = shape[0] * shape[1] <= _LARGEST_WHOLE[padded != shape]
    kind: Callable[..., Convolution] = FFTWTransform if whole else _Blocked
    kind = kind if prefers_fftw(padded) else ScipyTransform
    return kind(shape, padded, np.dtype(dtype))


class _Blocked:
    """Rows and columns in blocks, on all threads."""

    def __init__(
        self,
        shape: tuple[int, int],
        padded: tuple[int, int],
        dtype: np.dtype[Any],
    ) -> None:
        ny, nx = self._shape = shape
        self._half = padded[1] // 2 + 1
        self.values = np.zeros((ny, nx), dtype)
        self._lines = [_Lines(padded, dtype) for _ in range(parallel.threads())]
        self._spectrum = np.zeros((ny, self._half), self._lines[0].half.dtype)
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

    def __init__(self, padded: tuple[int, int], dtype: np.dtype[Any]) -> None:
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
