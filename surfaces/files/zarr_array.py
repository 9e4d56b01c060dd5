"""Height maps in Zarr: an array with the attributes of schema 1, or a group that holds one."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from surfaces.errors import FileFormatError

from ._container import HEIGHTS
from ._damage import brief, naming_damage
from ._schema import Fault, Header, array_faults, header_of

__all__ = ["is_zarr", "read_zarr"]

_MARKS = ("zarr.json", ".zarray", ".zgroup")


def is_zarr(path: Path) -> bool:
    """Whether a folder is a Zarr array or group."""
    return any((path / mark).is_file() for mark in _MARKS)


def read_zarr(
    path: Path, dataset: str | None, unit: str | None, spacing: tuple[float, float] | None
) -> tuple[Any, Header | None, list[Fault]]:
    """The array, its header, which is None if a fault is fatal, and all its faults.

    Raises
    ------
    FileFormatError
        If the library is missing, or what it opens is damaged or holds no such array.
    """
    try:
        import zarr
    except (ImportError, RuntimeError, OSError) as error:
        raise FileFormatError(
            f"{path}: Zarr needs a library ({brief(error)}): python -m pip install 'asperity[zarr]'"
        ) from error
    with naming_damage(path, "damaged Zarr", "folder"):
        found: Any = zarr.open(path, mode="r")
        if isinstance(found, zarr.Group):
            names = ", ".join(sorted(found.array_keys())) or "no array"
            wanted = HEIGHTS if dataset is None else dataset
            found = found.get(wanted)
            if not isinstance(found, zarr.Array):
                raise FileFormatError(
                    f"{path}: no array {wanted!r}; the group holds {names}; name the heights with "
                    "--dataset (dataset=...)"
                )
        faults = list(array_faults(found))
        stored, fill = found.nchunks_initialized, found.fill_value
        shards = found.shards or found.chunks  # shards are stored whole, also at the borders
        sides = zip(found.shape, shards, found.chunks, strict=True)
        expected = math.prod(-(-n // shard) * (shard // chunk) for n, shard, chunk in sides)
        if stored != expected and not (found.dtype.kind == "f" and np.isnan(fill)):
            faults.append(Fault(f"dataset {found.name} holds {stored} of its {expected} chunks"))
        return found, *header_of(found, dict(found.attrs), faults, unit=unit, spacing=spacing)
