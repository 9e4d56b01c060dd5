"""Reuse of idle memory for temporary arrays.

Fresh memory is dear: the operating system clears it page by page, which on large grids takes as
long as the arithmetic.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Scratch"]

_ALIGNMENT = 64
"""Bytes, one cache line."""


class Scratch:
    """Arrays carved from others that are not in use.

    Parameters
    ----------
    idle
        Contiguous arrays whose contents are not needed while the carved ones live.
    """

    def __init__(self, *idle: NDArray[Any]) -> None:
        self._left = [array.reshape(-1).view(np.uint8) for array in idle]

    def zeros(self, shape: tuple[int, ...], dtype: Any = np.float64) -> NDArray[Any]:
        """Array of zeros, aligned to 64 bytes; from fresh memory if nothing idle is long enough."""
        size = math.prod(shape) * np.dtype(dtype).itemsize
        for i, left in enumerate(self._left):
            skip = -left.ctypes.data % _ALIGNMENT
            if skip + size <= left.size:
                self._left[i] = left[skip + size :]
                array: NDArray[Any] = left[skip : skip + size].view(dtype).reshape(shape)
                array[...] = 0
                return array
        fresh = np.zeros(size + _ALIGNMENT, np.uint8)
        skip = -fresh.ctypes.data % _ALIGNMENT
        made: NDArray[Any] = fresh[skip : skip + size].view(dtype).reshape(shape)
        return made
