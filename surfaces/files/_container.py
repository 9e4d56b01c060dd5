"""Open an HDF5 file and find its dataset, with errors of one sentence.

Damaged files can hang or crash the HDF5 library, which no exception handler can catch: its oldest
formats and its global heaps (where it keeps attributes of variable length) carry no checksum. HDF5
calls are tried in a child process first, under a time limit; only if it survives does this process
do them. Small files of a later format with sound heaps need no child, which would cost as much as
reading them.
"""

from __future__ import annotations

import os
import struct
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
from h5py import _objects

from surfaces.errors import FileFormatError

from ._damage import DAMAGED, brief, naming_damage
from ._schema import read_header

HEIGHTS = "heights"

CPU_SECONDS = 3
"""Processor time after which an attempt hangs."""

_MOST_SEARCHED = 16 << 20
"""Size of a file [bytes] up to which its heaps are looked for."""

_SUPERBLOCK = struct.Struct("<8x3s")
_CHECKSUMMED = (b"\2\10\10", b"\3\10\10")
"""Versions of the superblock with checksums, and its addresses and lengths of eight bytes."""

_HEAP = b"GCOL"

_LISTED = 12
"""Datasets of a file that a message names."""


def opened(path: Path) -> h5py.File:
    """The file, open for reading."""
    if not os.path.exists(path):
        raise FileFormatError(f"{path}: no such file")
    if not path.is_file():
        raise FileFormatError(
            f"{path}: this is not a file; of a folder give the maps in it, such as {path / '*.h5'}"
        )
    with naming_damage(path, "cannot be opened, truncated or damaged HDF5"):
        if not h5py.is_hdf5(path):
            raise FileFormatError(
                f"{path}: this is not an HDF5 file, its signature is missing; only HDF5 is checked "
                "and read in parts: let a file of another format end as it does (.csv, .npy), and "
                "make it HDF5 with asperity surface convert"
            )
        return h5py.File(path, "r", locking="best-effort")


def require_sound(path: Path, dataset: str | None) -> None:
    """Refuse a file whose metadata hang or crash the HDF5 library."""

    def attempt() -> None:
        with opened(path) as file, naming_damage(path, "damaged HDF5"):
            read_header(find(file, path, dataset))

    if os.path.isfile(path) and not _is_sound(path) and not survives(attempt, CPU_SECONDS):
        raise FileFormatError(
            f"{path}: damaged HDF5, its metadata hang or crash the HDF5 library; "
            "copy the file again from its source"
        )


def find(file: h5py.File, path: Path, name: str | None) -> h5py.Dataset:
    """The dataset of that name, ``/heights`` if None."""
    wanted = HEIGHTS if name is None else name
    link = file.get(wanted, getlink=True)
    try:
        found = file[wanted] if wanted in file else None
    except DAMAGED as error:
        if not isinstance(link, h5py.SoftLink | h5py.ExternalLink):
            raise
        raise FileFormatError(
            f"{path}: dataset {wanted!r} is a link to {link.path!r} that leads nowhere "
            f"({brief(error)}); name the heights with --dataset (dataset=...)"
        ) from error
    if not isinstance(found, h5py.Dataset):
        if isinstance(file.get("curves"), h5py.Group):
            raise FileFormatError(
                f"{path}: this holds the results of a run and no height map; give the map"
            )
        raise FileFormatError(
            f"{path}: no dataset {wanted!r}; the file holds {_list_arrays(file)}; "
            "name the heights with --dataset (dataset=...)"
        )
    if Path(found.file.filename) != Path(file.filename):
        raise FileFormatError(f"{path}: dataset {wanted!r} is a link into another file; open that")
    return found


def _list_arrays(file: h5py.File) -> str:
    """Names, shapes and types of the datasets of a file, for a message."""
    found: list[str] = []

    def visit(name: str, item: Any) -> bool | None:
        if isinstance(item, h5py.Dataset):
            found.append(f"{name} {item.shape} {item.dtype}")
        return True if len(found) > _LISTED else None

    file.visititems(visit)
    if len(found) > _LISTED:
        found[_LISTED:] = ["..."]
    return ", ".join(found) or "no dataset"


def _is_sound(path: Path) -> bool:
    """Whether a small file has checksums on its metadata, and heaps that end where they say."""
    if path.stat().st_size > _MOST_SEARCHED:
        return False
    content = path.read_bytes()
    if len(content) < _SUPERBLOCK.size or _SUPERBLOCK.unpack_from(content)[0] not in _CHECKSUMMED:
        return False
    heap = content.find(_HEAP)
    while heap >= 0 and _heap_is_sound(content, heap):
        heap = content.find(_HEAP, heap + 1)
    return heap < 0


def _heap_is_sound(content: bytes, start: int) -> bool:
    """Whether the objects of a global heap, and the free space behind them, fill it.

    Layout in the HDF5 file format specification, version 3.0, section III.E.
    """
    if start + 16 > len(content):
        return False
    (size,) = struct.unpack_from("<8xQ", content, start)
    place, end = start + 16, start + size
    while place + 16 <= end <= len(content):
        index, length = struct.unpack_from("<H6xQ", content, place)
        if index == 0:
            return bool(place + length == end)
        place += 16 + -(-length // 8) * 8
    return bool(place <= end <= len(content))


def survives(attempt: Callable[[], object], seconds: int) -> bool:
    """Whether `attempt` comes to an end, by return or exception, within so many `seconds`.

    The limit is on processor time: an endless loop spends it, a slow disk does not. Where
    processes cannot be forked the answer is always True. The child owns the lock of h5py, which
    is taken before the fork, so that no other thread of the parent can hold it there; other threads
    of the parent do no harm, and the warning of Python 3.12 and later about them is not for users.
    """
    if not hasattr(os, "fork"):
        return True
    import resource

    with _objects.phil, warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
        if child == 0:
            try:
                resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
                attempt()
            finally:
                os._exit(0)
    _, status = os.waitpid(child, 0)
    return os.WIFEXITED(status)
