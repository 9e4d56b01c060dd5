"""Compiled loops over the bytes of a chunk."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surfaces.numerics.compiled import compiled

__all__ = ["fletcher", "unshuffle"]


@compiled()
def fletcher(data: NDArray[np.uint8]) -> tuple[np.uint64, np.uint64]:
    """Sum of the 16-bit words of an even number of bytes, highest byte first, and of all sums on
    the way; 64 bits hold those of 2^24 words."""
    low, high, count = np.uint64(0), np.uint64(0), data.size // 2
    for i in range(count):
        word = np.uint64(data[2 * i]) << np.uint64(8) | np.uint64(data[2 * i + 1])
        low += word
        high += np.uint64(count - i) * word
    return low, high


@compiled()
def unshuffle(planes: NDArray[np.uint8], words: NDArray[Any]) -> None:
    """Whole numbers `words` (n,) from their bytes, lowest first, shape (bytes of a word, n)."""
    count = planes.shape[0]
    for i in range(words.size):
        words[i] = planes[count - 1, i]
    for k in range(count - 2, -1, -1):
        for i in range(words.size):
            words[i] = words[i] << 8 | planes[k, i]
