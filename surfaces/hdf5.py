"""Height maps in HDF5, schema 1: open, read in parts, write without half-written files, validate.

The layout is described in ``docs/hdf5.md``.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._memory import require_memory
from ._probe import survives
from ._schema import DAMAGED, SCHEMA, Fault, Header, brief, read_header
from .errors import AsperityError, FileFormatError, InputError, SurfaceError
from .heightmap import HeightMap
from .units import metres_per

__all__ = ["Fault", "SurfaceFile", "open", "validate", "write_blocks"]

_BLOCK_BYTES = 32 << 20
_CHUNK = 256
_DATASET = "heights"


class SurfaceFile:
    """A height map in an HDF5 file, read in parts; closed by ``with`` or `close`.

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
    """

    def __init__(self, path: Path, file: h5py.File, dataset: h5py.Dataset, header: Header) -> None:
        self.path = path
        self.shape = header.shape
        self.spacing = header.spacing
        self.unit = header.unit
        self.periodic = header.periodic
        self.name = header.name or path.stem
        self.history = header.history
        self._notes = header.notes
        self._file = file
        self._dataset = dataset

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def heights(
        self, rows: tuple[int, int] | None = None, columns: tuple[int, int] | None = None
    ) -> NDArray[np.float64]:
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
        top, bottom = _bounds(rows, self.shape[0], "rows")
        left, right = _bounds(columns, self.shape[1], "columns")
        shape = (bottom - top, right - left)
        require_memory(
            8 * shape[0] * shape[1],
            f"{self.path}: a region of {shape[0]} x {shape[1]} points",
            "read smaller regions with surfaces.open(path).blocks()",
        )
        heights = np.empty(shape)
        step = self._rows_per_block(shape[1])
        for start in range(top, bottom, step):
            stop = min(start + step, bottom)
            try:
                with np.errstate(all="ignore"):
                    heights[start - top : stop - top] = self._dataset[start:stop, left:right]
            except DAMAGED as error:
                raise FileFormatError(
                    f"{self.path}: rows {start} to {stop} of dataset {self._dataset.name} are "
                    f"damaged ({brief(error)}); copy the file again from its source"
                ) from error
        with np.errstate(all="ignore"):
            heights *= metres_per(self.unit)
        return heights

    def blocks(self, rows: int | None = None) -> Iterator[tuple[int, NDArray[np.float64]]]:
        """Whole rows of the map in turn: index of the first row, and heights [m].

        Parameters
        ----------
        rows
            Rows in one block; by default as many as about 32 MiB hold.
        """
        step = self._rows_per_block(self.shape[1]) if rows is None else rows
        if step < 1:
            raise InputError(f"rows is {rows}; a block needs at least one row")
        for start in range(0, self.shape[0], step):
            yield start, self.heights((start, min(start + step, self.shape[0])))

    def read(
        self, rows: tuple[int, int] | None = None, columns: tuple[int, int] | None = None
    ) -> HeightMap:
        """The map, or a region of it as a map that is not periodic.

        Parameters
        ----------
        rows, columns
            First and one-past-last index; None is all.
        """
        top, bottom = _bounds(rows, self.shape[0], "rows")
        left, right = _bounds(columns, self.shape[1], "columns")
        whole = (bottom - top, right - left) == self.shape
        history = list(self.history) or [self._origin()]
        if not whole:
            history.append({"step": "crop", "rows": [top, bottom], "columns": [left, right]})
        require_memory(
            24 * (bottom - top) * (right - left),
            f"{self.path}: a map of {bottom - top} x {right - left} points",
            "read a region with surfaces.open(path).read(rows, columns)",
        )
        try:
            return HeightMap(
                self.heights((top, bottom), (left, right)),
                self.spacing,
                periodic=self.periodic and whole,
                name=self.name,
                history=tuple(history),
            )
        except FileFormatError:
            raise
        except SurfaceError as error:
            raise SurfaceError(f"{self.path}: {error}") from error

    def _origin(self) -> dict[str, Any]:
        """First step of the history of a map that carries none."""
        step = {"step": "read", "file": self.path.name, "dataset": self._dataset.name}
        step["unit"] = self.unit
        return step | {key: _plain(value) for key, value in self._notes.items()}

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
    """Open a height map in HDF5 for reading in parts.

    Parameters
    ----------
    path
        The file.
    dataset
        Name of the heights inside it; ``/heights`` by default.
    unit
        Unit of the heights, needed where the file states none.
    spacing
        Pixel size (dy, dx) [m], or one number, needed where the file states none.

    Raises
    ------
    FileFormatError
        If the file is missing or damaged, or does not hold a height map with its units.
    """
    path, pixel = Path(path), _pair(spacing)
    _require_sound(path, dataset)
    file = _opened(path)
    try:
        with _naming_damage(path):
            found = _find(file, path, dataset)
            header, faults = read_header(found, unit=unit, spacing=pixel)
        if header is None:
            raise FileFormatError(f"{path}: {next(f.text for f in faults if f.fatal)}")
        return SurfaceFile(path, file, found, header)
    except BaseException:
        file.close()
        raise


def validate(path: str | os.PathLike[str], *, dataset: str | None = None) -> list[Fault]:
    """Every fault of a height-map file, heights included; an empty list if there is none.

    Parameters
    ----------
    path
        An HDF5 file.
    dataset
        Name of the heights inside it; ``/heights`` by default.

    Notes
    -----
    The heights are read block by block, so that the file may be larger than memory.
    """
    path = Path(path)
    try:
        _require_sound(path, dataset)
        file = _opened(path)
    except FileFormatError as error:
        return [Fault(str(error).removeprefix(f"{path}: "))]
    with file:
        try:
            with _naming_damage(path):
                found = _find(file, path, dataset)
                header, faults = read_header(found)
            if header is not None:
                faults += _height_faults(SurfaceFile(path, file, found, header))
        except AsperityError as error:
            return [Fault(str(error).removeprefix(f"{path}: "))]
    return faults


def write_blocks(
    path: str | os.PathLike[str],
    shape: tuple[int, int],
    spacing: tuple[float, float],
    blocks: Iterable[ArrayLike],
    *,
    periodic: bool = False,
    name: str = "",
    history: Iterable[Mapping[str, Any]] = (),
    dtype: str = "float64",
) -> None:
    """Write a map of any size from blocks of rows; the file appears only when it is complete.

    Parameters
    ----------
    path
        The file; an existing one is replaced.
    shape
        Number of points (ny, nx).
    spacing
        Pixel size (dy, dx) [m].
    blocks
        Heights [m] in blocks of whole rows, in order.
    periodic, name, history
        As in `HeightMap`.
    dtype
        float64, or float32 for half the size.

    Raises
    ------
    SurfaceError
        If the blocks do not fill the shape, or the file cannot be written.
    """
    path = Path(path)
    steps = [dict(step) for step in history]
    with _replacing(path) as part, h5py.File(part, "w", libver=("v110", "v110")) as file:
        heights = file.create_dataset(
            _DATASET,
            shape,
            dtype,
            chunks=(min(shape[0], _CHUNK), min(shape[1], _CHUNK)),
            compression="gzip",
            compression_opts=2,
            shuffle=True,
            fletcher32=True,
            fillvalue=np.nan,
        )
        heights.attrs["schema"] = SCHEMA
        heights.attrs["spacing"] = np.asarray(spacing, dtype=np.float64)
        heights.attrs["unit"] = "m"
        heights.attrs["periodic"] = bool(periodic)
        heights.attrs["name"] = name
        heights.attrs["history"] = json.dumps(steps, default=_plain)
        for key in ("source", "instrument"):
            values = [str(step[key]) for step in steps if key in step]
            if values:
                heights.attrs[key] = values[0]
        for row, rows in _whole_chunks(blocks, shape):
            heights[row : row + len(rows)] = rows


def list_arrays(file: h5py.File, limit: int = 12) -> str:
    """Names, shapes and types of the datasets of a file, for a message."""
    found: list[str] = []

    def visit(name: str, item: Any) -> bool | None:
        if isinstance(item, h5py.Dataset):
            found.append(f"{name} {item.shape} {item.dtype}")
        return True if len(found) > limit else None

    file.visititems(visit)
    if len(found) > limit:
        found[limit:] = ["..."]
    return ", ".join(found) or "no dataset"


def _whole_chunks(
    blocks: Iterable[ArrayLike], shape: tuple[int, int]
) -> Iterator[tuple[int, NDArray[np.float64]]]:
    """Blocks cut anew so that each chunk is compressed once, with their first rows; all checked."""
    held, written = np.empty((0, shape[1])), 0
    for block in blocks:
        rows = np.asarray(block, dtype=np.float64)
        row = written + len(held)
        if rows.ndim != 2 or rows.shape[1] != shape[1] or row + len(rows) > shape[0]:
            raise SurfaceError(f"block at row {row} has shape {rows.shape} in a map of {shape}")
        held = np.concatenate([held, rows]) if len(held) else rows
        whole = len(held) - len(held) % _CHUNK
        if whole:
            yield written, held[:whole]
            held, written = held[whole:], written + whole
    if written + len(held) != shape[0]:
        raise SurfaceError(
            f"the blocks hold {written + len(held)} of {shape[0]} rows; give all of them"
        )
    if len(held):
        yield written, held


def _opened(path: Path) -> h5py.File:
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


def _require_sound(path: Path, dataset: str | None) -> None:
    """Refuse a file whose metadata hang or crash the HDF5 library."""

    def attempt() -> None:
        with _opened(path) as file, _naming_damage(path):
            read_header(_find(file, path, dataset))

    if path.is_file() and not survives(attempt):
        raise FileFormatError(
            f"{path}: damaged HDF5, its metadata hang or crash the HDF5 library; "
            "copy the file again from its source"
        )


@contextmanager
def _naming_damage(path: Path) -> Iterator[None]:
    """Turn what h5py raises on damaged metadata into one sentence."""
    try:
        yield
    except AsperityError:
        raise
    except DAMAGED as error:
        raise FileFormatError(
            f"{path}: damaged HDF5 ({brief(error)}); copy the file again from its source"
        ) from error


def _find(file: h5py.File, path: Path, name: str | None) -> h5py.Dataset:
    wanted = _DATASET if name is None else name
    if wanted not in file or not isinstance(file[wanted], h5py.Dataset):
        raise FileFormatError(
            f"{path}: no dataset {wanted!r}; the file holds {list_arrays(file)}; "
            "name the heights with --dataset (dataset=...)"
        )
    found = file[wanted]
    if Path(found.file.filename) != Path(file.filename):
        raise FileFormatError(f"{path}: dataset {wanted!r} is a link into another file; open that")
    return found


def _height_faults(file: SurfaceFile) -> Iterator[Fault]:
    infinite = present = 0
    for _, block in file.blocks():
        infinite += int(np.count_nonzero(np.isinf(block)))
        present += int(np.count_nonzero(np.isfinite(block)))
    if infinite:
        yield Fault(f"{infinite} heights are infinite; mark missing points with NaN")
    if not present:
        yield Fault("every point of the height map is missing (NaN)")


def _bounds(span: tuple[int, int] | None, count: int, what: str) -> tuple[int, int]:
    if span is None:
        return 0, count
    start, stop = span
    if not 0 <= start < stop <= count:
        raise SurfaceError(f"{what} {start} to {stop} are not inside the map's 0 to {count}")
    return int(start), int(stop)


def _pair(spacing: ArrayLike | None) -> tuple[float, float] | None:
    if spacing is None:
        return None
    try:
        dy, dx = (float(d) for d in np.broadcast_to(np.asarray(spacing, dtype=np.float64), (2,)))
    except (TypeError, ValueError):
        raise InputError(f"spacing is {spacing!r}; give the pixel size (dy, dx) in m") from None
    return dy, dx


@contextmanager
def _replacing(path: Path) -> Iterator[Path]:
    """A temporary file beside `path` that takes its place if nothing goes wrong."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield part
        os.replace(part, path)
    except OSError as error:
        raise SurfaceError(f"{path}: cannot be written ({brief(error)})") from error
    finally:
        part.unlink(missing_ok=True)


def _plain(value: Any) -> Any:
    """A NumPy value as plain Python, for JSON."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else str(value)
