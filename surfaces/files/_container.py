"""Open an HDF5 file and find its dataset, with errors of one sentence."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

from surfaces.errors import AsperityError, FileFormatError

from ._probe import survives
from ._schema import DAMAGED, brief, read_header

__all__ = ["HEIGHTS", "find", "naming_damage", "opened", "require_sound"]

HEIGHTS = "heights"

_LISTED = 12
"""Datasets of a file that a message names."""


def opened(path: Path) -> h5py.File:
    """The file, open for reading."""
    if not path.exists():
        raise FileFormatError(f"{path}: no such file")
    if not path.is_file():
        raise FileFormatError(f"{path}: this is not a file")
    try:
        if not h5py.is_hdf5(path):
            raise FileFormatError(f"{path}: this is not an HDF5 file; its signature is missing")
        return h5py.File(path, "r", locking="best-effort")
    except DAMAGED as error:
        if isinstance(error, FileFormatError):
            raise
        raise FileFormatError(
            f"{path}: cannot be opened, truncated or damaged HDF5 ({brief(error)}); "
            "copy the file again from its source"
        ) from error


def require_sound(path: Path, dataset: str | None) -> None:
    """Refuse a file whose metadata hang or crash the HDF5 library."""

    def attempt() -> None:
        with opened(path) as file, naming_damage(path):
            read_header(find(file, path, dataset))

    if path.is_file() and not survives(attempt):
        raise FileFormatError(
            f"{path}: damaged HDF5, its metadata hang or crash the HDF5 library; "
            "copy the file again from its source"
        )


@contextmanager
def naming_damage(path: Path) -> Iterator[None]:
    """Turn what h5py raises on damaged metadata into one sentence."""
    try:
        yield
    except AsperityError:
        raise
    except DAMAGED as error:
        raise FileFormatError(
            f"{path}: damaged HDF5 ({brief(error)}); copy the file again from its source"
        ) from error


def find(file: h5py.File, path: Path, name: str | None) -> h5py.Dataset:
    """The dataset of that name, ``/heights`` if None."""
    wanted = HEIGHTS if name is None else name
    if wanted not in file or not isinstance(file[wanted], h5py.Dataset):
        raise FileFormatError(
            f"{path}: no dataset {wanted!r}; the file holds {_list_arrays(file)}; "
            "name the heights with --dataset (dataset=...)"
        )
    found = file[wanted]
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
