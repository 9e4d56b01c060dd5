"""Height maps in Zarr: an array with the attributes of schema 1, or a group that holds one."""

from __future__ import annotations

import base64
import math
import os
import re
import struct
from pathlib import Path
from typing import Any

from surfaces.errors import FileFormatError

from ._container import HEIGHTS
from ._damage import brief, naming_damage
from ._schema import Chunks, Fault, Header, array_faults, header_of

__all__ = ["is_zarr", "read_zarr"]

_PLACE = re.compile(r"(?:^|/|\.)(\d+)[./](\d+)$")
"""End of the name of a chunk: its row and its column among the chunks."""

_MARKS = ("zarr.json", ".zarray", ".zgroup")


def is_zarr(path: Path) -> bool:
    """Whether a folder is a Zarr array or group."""
    return any(os.path.isfile(path / mark) for mark in _MARKS)


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
    with naming_damage(path, "damaged Zarr"):
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
        chunks = None if any(fault.fatal for fault in faults) else _chunks(found, path)
        return found, *header_of(
            found, _attributes(found), faults, chunks, unit=unit, spacing=spacing
        )


def _chunks(array: Any, path: Path) -> Chunks | None:
    """The chunks of an array, or its shards, if some are not stored.

    The library would look for each by its name, which takes forever where few of many are stored.
    """
    folder, sides = path / array.path, array.shards or array.chunks
    ny, nx = (-(-n // side) for n, side in zip(array.shape, sides, strict=True))
    names = (_PLACE.search(file.relative_to(folder).as_posix()) for file in folder.rglob("*[0-9]"))
    places = ((int(name[1]), int(name[2])) for name in names if name)
    corners = [(sides[0] * i, sides[1] * j) for i, j in places if i < ny and j < nx]
    return None if len(corners) == ny * nx else Chunks(sides, corners, ny * nx, _fill(array))


def _fill(array: Any) -> float:
    return 0.0 if array.fill_value is None else float(array.fill_value)


def _attributes(array: Any) -> dict[str, Any]:
    """The attributes, with the number of a missing point as xarray hides it: in the fill value of
    an array of format 2, as base64 of a double in format 3."""
    found = dict(array.attrs)
    if array.metadata.zarr_format == 2 and "_ARRAY_DIMENSIONS" in found:
        found.setdefault("_FillValue", math.nan if array.fill_value is None else _fill(array))
    elif isinstance(coded := found.get("_FillValue"), str):
        (found["_FillValue"],) = struct.unpack("<d", base64.b64decode(coded))
    return found
