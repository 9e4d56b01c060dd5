"""Chunks of heights as `write_blocks` stores them, packed outside the HDF5 library.

The library runs its filters under one lock. These functions do the same to the bytes of a chunk,
and threads may call them at the same time: shuffle and gzip, whose streams end in a checksum.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from isal import isal_zlib as zlib  # the interface of zlib, and twice as fast
from numpy.typing import NDArray

_LEVEL = 2
_SIDE = 256  # largest side of a chunk [pixels]

FILTERS: dict[str, Any] = {
    "compression": "gzip",
    "compression_opts": _LEVEL,
    "shuffle": True,
}
"""Storage of a dataset, as h5py takes it."""


def chunk_of(shape: tuple[int, int]) -> tuple[int, int]:
    """Shape of the chunks of a map of a shape."""
    return min(shape[0], _SIDE), min(shape[1], _SIDE)


def packed(values: NDArray[Any]) -> bytes:
    """Bytes to store of a chunk, whose values are float32 or float64 in the order of a PC."""
    planes = np.ascontiguousarray(values).view(np.uint8).reshape(-1, values.itemsize).T
    return zlib.compress(planes.tobytes(), _LEVEL)
