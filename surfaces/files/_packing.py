"""Chunks of heights as `write_blocks` stores them, packed and unpacked outside the HDF5 library.

The library runs its filters under one lock. These functions do the same to the bytes of a chunk,
and threads may call them at the same time: shuffle, gzip, and a Fletcher checksum behind it.
"""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from surfaces.numerics.compiled import compiled

from ._damage import DAMAGED

try:  # the interface of zlib, and twice as fast
    from isal import isal_zlib as _deflate
except ImportError:
    import zlib as _deflate  # type: ignore[no-redef]

zlib: Any = _deflate

_LEVEL = 2
_SIDE = 256  # largest side of a chunk [pixels]
_CHECK = 4  # bytes of the checksum

FILTERS: dict[str, Any] = {
    "compression": "gzip",
    "compression_opts": _LEVEL,
    "shuffle": True,
    "fletcher32": True,
}
"""Storage of a dataset, as h5py takes it."""


def chunk_of(shape: tuple[int, int]) -> tuple[int, int]:
    """Shape of the chunks of a map of a shape."""
    return min(shape[0], _SIDE), min(shape[1], _SIDE)


def has_packed_chunks(dataset: h5py.Dataset) -> bool:
    """Whether the chunks of a dataset are stored as `packed` packs them."""
    if not isinstance(dataset, h5py.Dataset):
        return False
    filters = dataset.id.get_create_plist()
    codes = [filters.get_filter(index)[0] for index in range(filters.get_nfilters())]
    return (
        codes == [h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_FLETCHER32]
        and dataset.dtype.str in ("<f4", "<f8")
        and dataset.chunks == chunk_of(dataset.shape)
    )


def packed(values: NDArray[Any]) -> bytes:
    """Bytes to store of a chunk, whose values are float32 or float64 in the order of a PC."""
    planes = np.ascontiguousarray(values).view(np.uint8).reshape(-1, values.itemsize).T
    body: bytes = zlib.compress(planes.tobytes(), _LEVEL)
    return body + _checksum(body)


def unpacked(
    dataset: h5py.Dataset, rows: tuple[int, int], columns: tuple[int, int]
) -> NDArray[Any] | None:
    """Values of a region inside one chunk; None if it is missing, damaged or packed otherwise."""
    (ny, nx), itemsize = dataset.chunks, dataset.dtype.itemsize
    top, left = rows[0] - rows[0] % ny, columns[0] - columns[0] % nx
    try:
        skipped, stored = dataset.id.read_direct_chunk((top, left))
        body = memoryview(stored)[:-_CHECK]
        if skipped or stored[-_CHECK:] != _checksum(body):
            return None
        planes = np.frombuffer(zlib.decompress(body, bufsize=itemsize * ny * nx), np.uint8)
    except (zlib.error, *DAMAGED):
        return None
    if planes.size != itemsize * ny * nx:
        return None
    numbers = np.empty((ny * nx, itemsize), np.uint8)
    for place, plane in enumerate(planes.reshape(itemsize, -1)):
        numbers[:, place] = plane  # a transposed copy takes three times as long
    values: NDArray[Any] = numbers.view(dataset.dtype).reshape(ny, nx)
    return values[rows[0] - top : rows[1] - top, columns[0] - left : columns[1] - left]


def _checksum(body: bytes | memoryview) -> bytes:
    """Fletcher's checksum of 16-bit words, highest byte first, as HDF5 stores it.

    The sum of the words and the sum of all sums on the way, modulo 65535, where a whole number of
    turns is 65535 and nothing but zeros is 0.
    """
    even = body if len(body) % 2 == 0 else bytes(body) + b"\0"
    sums = _fletcher(np.frombuffer(even, np.uint8))
    low, high = ((int(total) - 1) % 65535 + 1 if total else 0 for total in sums)
    return (high << 16 | low).to_bytes(_CHECK, "little")


@compiled()
def _fletcher(data: NDArray[np.uint8]) -> tuple[np.uint64, np.uint64]:
    """Sum of the 16-bit words of an even number of bytes, highest byte first, and of all sums on
    the way; 64 bits hold those of 2^24 words."""
    low, high, count = np.uint64(0), np.uint64(0), data.size // 2
    for i in range(count):
        word = np.uint64(data[2 * i]) << np.uint64(8) | np.uint64(data[2 * i + 1])
        low += word
        high += np.uint64(count - i) * word
    return low, high
