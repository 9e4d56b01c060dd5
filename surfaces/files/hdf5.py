"""Height maps in HDF5, schema 1: open, read in parts.

The layout is described in ``docs/formats.md``.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surfaces.arrays import Array
from surfaces.errors import (
    FileFormatError,
    SurfaceError,
    as_count,
    as_path,
    checked_part,
    checked_spacing,
    require_texts,
)
from surfaces.heightmap import HeightMap
from surfaces.numerics import parallel
from surfaces.numerics.memory import available_bytes, require_memory
from surfaces.numerics.stored_array import spans
from surfaces.units import metres_per

from ._container import find, opened, require_sound
from ._damage import naming_damage
from ._schema import Fault, Header, Packing, plain, read_header
from .stored_map import StoredMap
from .zarr_array import is_zarr, read_zarr

__all__ = ["SurfaceFile", "open", "opened_parts"]

_BLOCK_BYTES = 32 << 20  # read at a time

BYTES_OF_WORK = 64
"""Memory that the work on a map in memory takes [bytes per point]: boundary elements, or the
microcontact model on all of its points."""

_Span = tuple[int, int]  # first and one past the last index


class SurfaceFile:
    """A height map in HDF5 or Zarr, read in parts; closed by ``with`` or `close`.

    Made by `open`. Nothing but the header is read until heights are asked for.

    Attributes
    ----------
    path
        The file.
    shape
        Number of points (ny, nx).
    spacing
        Pixel size (dy, dx) [m].
    unit
        Unit of the stored heights; everything returned is in metres.
    periodic
        Whether the whole map continues across its border.
    history
        What was done to the map so far, as in `HeightMap`.

    Examples
    --------
    >>> import tempfile
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     surfaces.write(hm, f"{folder}/scan.h5")
    ...     with surfaces.open(f"{folder}/scan.h5") as file:
    ...         print(file.read(rows=(0, 8), columns=(0, 12)).shape)
    (8, 12)
    """

    def __init__(self, path: Path, file: Any, dataset: Any, header: Header) -> None:
        self.path = path
        self.shape = header.shape
        self.spacing = header.spacing
        self.unit = header.unit
        self.periodic = header.periodic
        self.name = header.name or path.stem
        self._file = file
        self._dataset = dataset
        self._packing, self._chunks = header.packing, header.chunks
        self.history = header.history
        told = {key for step in header.history for key in step}
        if not header.history or not told.issuperset(header.notes):
            self.history = self._origin(header.notes), *header.history

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def heights(
        self, rows: tuple[int, int] | None = None, columns: tuple[int, int] | None = None
    ) -> Array:
        """Heights [m] of a region, shape (rows, columns); NaN marks missing points.

        Parameters
        ----------
        rows, columns
            First and one-past-last index; None is all.

        Raises
        ------
        SurfaceError
            If the region is empty or outside the map, or does not fit into memory.
        FileFormatError
            If the stored data are damaged.
        """
        (top, bottom), (left, right) = self._bounds(rows, columns)
        shape = (bottom - top, right - left)
        require_memory(
            8 * shape[0] * shape[1],
            f"{self.path}: a map of {shape[0]} x {shape[1]} points",
            "read a region with surfaces.open(path).read(rows, columns), or blocks()",
        )
        heights, packing, metres = np.empty(shape), self._packing, metres_per(self.unit)

        def fill(rows: _Span) -> None:
            with np.errstate(all="ignore"):
                place = heights[rows[0] : rows[1]]
                stored = self._stored((top + rows[0], top + rows[1]), (left, right))
                np.multiply(stored, packing.scale * metres, out=place, dtype=np.float64)
                if packing.offset:
                    place += packing.offset * metres
                for blank in packing.blanks:
                    place[stored == blank] = np.nan

        parallel.each(fill, spans(shape[0], self._rows_per_block(shape[1])))
        return heights

    def blocks(self, rows: int | None = None) -> Iterator[tuple[int, Array]]:
        """Whole rows of the map in turn: index of the first row, and heights [m].

        Parameters
        ----------
        rows
            Rows in one block; by default as many as about 32 MiB hold.

        Raises
        ------
        InputError
            If `rows` is below 1.
        """
        step = self._rows_per_block(self.shape[1]) if rows is None else as_count("rows", rows, 1)
        for start in range(0, self.shape[0], step):
            yield start, self.heights((start, min(start + step, self.shape[0])))

    def read(
        self, rows: tuple[int, int] | None = None, columns: tuple[int, int] | None = None
    ) -> HeightMap:
        """The map, or a region of it as a map that is not periodic.

        What is so large that no work on it would fit into memory stays on disk (`on_disk`).

        Parameters
        ----------
        rows, columns
            First and one-past-last index; None is all.

        Raises
        ------
        SurfaceError, FileFormatError
            If the region is not inside the map, or the heights are damaged.
        """
        (top, bottom), (left, right) = self._bounds(rows, columns)
        try:
            if BYTES_OF_WORK * (bottom - top) * (right - left) > available_bytes():
                return self.on_disk(rows, columns)
            heights = self.heights(rows, columns)
            heights.setflags(write=False)  # or the map would hold a copy
            return HeightMap(heights, self.spacing, **self._facts(rows, columns))
        except SurfaceError as error:
            text = str(error).removeprefix(f"{self.path}: ")
            raise SurfaceError(f"{self.path}: {text}") from error

    def on_disk(
        self, rows: tuple[int, int] | None = None, columns: tuple[int, int] | None = None
    ) -> StoredMap:
        """As `read`, with the heights in a temporary file, read in parts; refused where there is
        no room for it."""
        (top, bottom), (left, right) = self._bounds(rows, columns)
        plain_metres = self._packing == Packing() and metres_per(self.unit) == 1.0
        narrow = self._dataset.dtype == np.float32 and plain_metres
        step = self._rows_per_block(right - left)
        blocks = (
            (first - top, self.heights((first, min(first + step, bottom)), columns))
            for first in range(top, bottom, step)
        )
        return StoredMap.of_blocks(
            blocks,
            (bottom - top, right - left),
            np.float32 if narrow else np.float64,
            self.spacing,
            **self._facts(rows, columns),
        )

    def written(self) -> Iterator[Array]:
        """Heights [m] of all regions that are stored, for what need not know where they are."""
        if self._chunks is None:
            yield from (block for _, block in self.blocks())
            return
        for corner in self._chunks.corners:
            ends = zip(corner, self._chunks.shape, self.shape, strict=True)
            yield self.heights(*((at, min(at + side, n)) for at, side, n in ends))

    def _facts(self, rows: _Span | None, columns: _Span | None) -> dict[str, Any]:
        """What a map of a region is made of beside its heights and spacing."""
        spans = self._bounds(rows, columns)
        whole = spans == ((0, self.shape[0]), (0, self.shape[1]))
        step = {"step": "crop", "rows": [*spans[0]], "columns": [*spans[1]]}
        history = (*self.history, *(() if whole else (step,)))
        return {"periodic": self.periodic and whole, "name": self.name, "history": history}

    def _bounds(self, rows: _Span | None, columns: _Span | None) -> tuple[_Span, _Span]:
        ny, nx = self.shape
        rows, columns = (0, ny) if rows is None else rows, (0, nx) if columns is None else columns
        return checked_part("rows", rows, ny), checked_part("columns", columns, nx)

    def _stored(self, rows: _Span, columns: _Span) -> NDArray[Any]:
        """Heights in the unit of the file."""
        if not self._dataset:
            raise FileFormatError(f"{self.path}: the file is closed; open it again")
        part = f"rows {rows[0]} to {rows[1]} of dataset {self._dataset.name}"
        with naming_damage(self.path, f"{part} are damaged"):
            return np.asarray(self._dataset[slice(*rows), slice(*columns)])

    def _origin(self, notes: Mapping[str, Any]) -> dict[str, Any]:
        """First step of the history of a map, if it carries none that holds these `notes`."""
        step = {"step": "read", "file": self.path.name, "dataset": self._dataset.name}
        step["unit"] = self.unit
        return step | {key: plain(value) for key, value in notes.items()}

    def _rows_per_block(self, columns: int) -> int:
        """Rows of about `_BLOCK_BYTES`, in whole chunks where that is possible."""
        chunk = self._dataset.chunks[0] if self._dataset.chunks else 1
        rows = max(1, _BLOCK_BYTES // (8 * columns))
        return max(chunk, rows - rows % chunk)


def open(
    path: str | os.PathLike[str],
    *,
    dataset: str | None = None,
    unit: str | None = None,
    spacing: ArrayLike | None = None,
) -> SurfaceFile:
    """Open a height map in HDF5 or Zarr for reading in parts.

    Parameters
    ----------
    path, dataset, unit, spacing
        As in `surfaces.read`.

    Raises
    ------
    FileFormatError
        If the file is missing or damaged, or does not hold a height map with its units.

    Examples
    --------
    >>> import tempfile
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     surfaces.write(hm, f"{folder}/scan.h5")
    ...     with surfaces.open(f"{folder}/scan.h5") as file:
    ...         print(file.shape, file.spacing)
    (32, 48) (1e-06, 1e-06)
    """
    path = as_path(path)
    pixel = None if spacing is None else checked_spacing(spacing)
    file, found, header, faults = opened_parts(path, dataset, unit, pixel)
    if header is None:
        file.close()
        raise FileFormatError(f"{path}: {next(f.text for f in faults if f.fatal)}")
    return SurfaceFile(path, file, found, header)


def opened_parts(
    path: Path,
    dataset: str | None = None,
    unit: str | None = None,
    spacing: tuple[float, float] | None = None,
) -> tuple[Any, Any, Header | None, list[Fault]]:
    """What is to be closed, the array, its header and its faults."""
    require_texts(dataset=dataset, unit=unit)
    if is_zarr(path):
        return ExitStack(), *read_zarr(path, dataset, unit, spacing)
    require_sound(path, dataset)
    file = opened(path)
    try:
        with naming_damage(path, "damaged HDF5"):
            found = find(file, path, dataset)
            return file, found, *read_header(found, unit=unit, spacing=spacing)
    except BaseException:
        file.close()
        raise
