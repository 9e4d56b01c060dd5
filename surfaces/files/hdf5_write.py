"""Write height maps of any size in HDF5, schema 1; a file appears only when it is complete."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike

from surfaces.arrays import Array
from surfaces.errors import (
    InputError,
    SurfaceError,
    as_choice,
    as_numbers,
    as_path,
    as_text,
    as_truth,
    checked_history,
    checked_range,
    checked_spacing,
    shown,
)
from surfaces.numerics import parallel
from surfaces.random_waves import checked_shape

from ._container import HEIGHTS
from ._packing import FILTERS, chunk_of, packed
from ._schema import SCHEMA, plain
from .atomic import NOT_HDF5, replacing

__all__ = ["write_blocks"]


ROUNDED = 1e-4
"""Largest change of heights by float32 over their range: without an offset it is 3e-8."""


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
    InputError
        If the shape or the spacing is that of no map, the blocks do not fill it or hold infinities,
        the dtype is another, or the file cannot be written or is named as another format.
    SurfaceError
        If float32 would change them by more than 1e-4 of their range, as with a large offset.

    Examples
    --------
    >>> import tempfile
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     blocks = (hm.heights[i : i + 8] for i in range(0, 32, 8))
    ...     surfaces.write_blocks(f"{folder}/scan.h5", hm.shape, hm.spacing, blocks)
    ...     print(surfaces.read(f"{folder}/scan.h5").shape)
    (32, 48)
    """
    as_choice("dtype", dtype, ("float64", "float32"))
    shape = checked_shape(shape)
    path = as_path(path)
    if path.suffix.lower() in NOT_HDF5:
        raise InputError(f"{path}: blocks are written as HDF5 alone; call the file .h5")
    spacing = checked_spacing(spacing)
    steps = checked_history(history)
    try:
        told = json.dumps(steps, default=plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise SurfaceError(f"history cannot be stored as JSON ({error}); simplify it") from error
    with replacing(path) as part, h5py.File(part, "w", libver=("v110", "v110")) as file:
        heights = file.create_dataset(
            HEIGHTS,
            shape,
            dtype,
            chunks=chunk_of(shape),
            fillvalue=np.nan,
            **FILTERS,
        )
        heights.attrs["schema"] = SCHEMA
        heights.attrs["spacing"] = np.asarray(spacing, dtype=np.float64)
        heights.attrs["unit"] = "m"
        heights.attrs["periodic"] = as_truth("periodic", periodic)
        heights.attrs["name"] = as_text(name)
        heights.attrs["history"] = told
        for key in ("source", "instrument"):
            values = [as_text(step[key]) for step in steps if key in step]
            if values:
                heights.attrs[key] = values[0]
        for row, rows in _whole_chunks(blocks, shape, heights):
            _write_rows(heights, row, rows)


def _write_rows(heights: h5py.Dataset, row: int, rows: Array) -> None:
    """Write whole rows of chunks that begin at a row; threads pack the chunks."""
    ny, nx = heights.chunks

    def pack(corner: tuple[int, int]) -> bytes:
        part = rows[corner[0] - row :, corner[1] :][:ny, :nx]
        chunk = np.full((ny, nx), np.nan, heights.dtype)
        with np.errstate(over="ignore"):
            chunk[: part.shape[0], : part.shape[1]] = part
        return packed(chunk)

    for start in range(row, row + len(rows), ny):
        corners = [(start, column) for column in range(0, rows.shape[1], nx)]
        for corner, stored in zip(corners, parallel.each(pack, corners), strict=True):
            heights.id.write_direct_chunk(corner, stored)


def _whole_chunks(
    blocks: Iterable[ArrayLike], shape: tuple[int, int], heights: h5py.Dataset
) -> Iterator[tuple[int, Array]]:
    """Blocks, checked and cut anew so that each chunk of `heights` is compressed once, with their
    first rows."""
    side = heights.chunks[0]
    held, written = np.empty((0, shape[1])), 0
    low, high, rounded = np.nan, np.nan, 0.0
    if not isinstance(blocks, Iterable):
        raise InputError(f"blocks is {shown(blocks)}; give the heights in blocks of whole rows")
    for block in blocks:
        row = written + len(held)
        rows = as_numbers(f"block at row {row}", block, finite=False, copy=False)
        if np.isinf(rows).any():
            raise SurfaceError(f"block at row {row} holds infinite heights; mark missing with NaN")
        low = float(np.fmin.reduce(rows, axis=None, initial=low))
        high = float(np.fmax.reduce(rows, axis=None, initial=high))
        if heights.dtype != rows.dtype:
            with np.errstate(over="ignore"):
                lost = np.abs(rows - rows.astype(heights.dtype))
            rounded = float(np.fmax.reduce(lost, axis=None, initial=rounded))
        if rows.ndim != 2 or rows.shape[1] != shape[1] or row + len(rows) > shape[0]:
            raise SurfaceError(f"block at row {row} has shape {rows.shape} in a map of {shape}")
        held = np.concatenate([held, rows]) if len(held) else rows
        whole = len(held) - len(held) % side
        if whole:
            yield written, held[:whole]
            held, written = held[whole:], written + whole
        held = held.copy()  # the caller may fill the next block into the same array
    if written + len(held) != shape[0]:
        raise SurfaceError(
            f"the blocks hold {written + len(held)} of {shape[0]} rows; give all of them"
        )
    checked_range(low, high, ())
    if rounded > ROUNDED * (high - low) > 0.0:
        raise SurfaceError(
            f"{heights.dtype} would change heights of {max(low, high, key=abs):.3g} m by up to "
            f"{rounded:.1g} m, {100 * rounded / (high - low):.1g} % of their range: level the map, "
            "or write float64"
        )
    if len(held):
        yield written, held
