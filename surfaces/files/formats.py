"""Read and write height maps of any format."""

from __future__ import annotations

import codecs
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from surfaces.errors import FileFormatError, InputError, SurfaceError, as_path, require_texts
from surfaces.heightmap import HeightMap, require_map

from .atomic import NOT_HDF5

__all__ = ["read", "write"]

_HDF5 = (".h5", ".hdf5", ".hdf", ".he5")
_TEXT = (".txt", ".csv", ".tsv", ".dat", ".asc", ".xyz")
_PICTURES = (".png", ".tif", ".tiff")
_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_NPY_SIGNATURE = b"\x93NUMPY"


def read(
    path: str | os.PathLike[str],
    *,
    dataset: str | None = None,
    unit: str | None = None,
    spacing: ArrayLike | None = None,
    rows: tuple[int, int] | None = None,
    columns: tuple[int, int] | None = None,
) -> HeightMap:
    """Read a height map, or a rectangle of it, from a file of any known format.

    Parameters
    ----------
    path
        HDF5 (schema 1 or foreign), Zarr (needs the extra ``asperity[zarr]``), npy, npz, mat, text
        (rows of heights, or columns x, y, z), PNG, TIFF, SDF, X3P, or another instrument's file
        (needs the extra ``asperity[formats]``).
    dataset
        HDF5, Zarr: name of the heights, ``/heights`` by default. npz, mat: name of the array. X3P:
        number of the layer. Instrument files: name of the channel.
    unit
        Unit of the heights, needed where the file states none: m, mm, um, nm, ...; or a multiple
        of one, such as 2.5nm for the height of one grey level. Of columns x, y, z that of all.
    spacing
        Pixel size (dy, dx) [m], or one number, needed where the file states none.
    rows, columns
        First and one-past-last pixel of the rectangle; None is all. From HDF5 and Zarr nothing else
        is read, so that the file may be larger than memory.

    Returns
    -------
    HeightMap
        Heights [m]; its history begins with where they came from.

    Raises
    ------
    FileFormatError
        If the file is missing, damaged, of an unknown format, or silent about its units.
    SurfaceError
        If what it holds is no height map.

    Examples
    --------
    >>> import tempfile
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     surfaces.write(hm, f"{folder}/scan.h5")
    ...     print(surfaces.read(f"{folder}/scan.h5", rows=(0, 16)).shape)
    (16, 48)
    """
    path = as_path(path)
    require_texts(dataset=dataset, unit=unit)
    try:
        if not os.path.exists(path):  # names that no system takes do not, either
            raise FileFormatError(f"{path}: no such file")
        if not (path.is_file() or path.is_dir()):
            raise FileFormatError(f"{path}: this is not a file")
        reader = None if path.is_dir() else _reader(path)
        if reader is None:
            from .hdf5 import open as open_hdf5

            with open_hdf5(path, dataset=dataset, unit=unit, spacing=spacing) as file:
                return file.read(rows, columns)
        hm = reader(path, dataset, unit, spacing)
        ny, nx = hm.shape
        rows, columns = (0, ny) if rows is None else rows, (0, nx) if columns is None else columns
        if np.array_equal((rows, columns), ((0, ny), (0, nx))):
            return hm
        from surfaces.preparation.filtering import crop

        return crop(hm, rows, columns)
    except InputError as error:
        if str(error).startswith(str(path)):
            raise
        kind = SurfaceError if isinstance(error, SurfaceError) else FileFormatError
        raise kind(f"{path}: {error}") from error
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read ({error.strerror or error})") from error


def write(hm: HeightMap, path: str | os.PathLike[str], *, dtype: str = "float64") -> None:
    """Write a height map; the format follows the file's suffix.

    Parameters
    ----------
    hm
        The map.
    path
        ``.h5``: schema 1, with everything, the history included. ``.npz``: heights, spacing, unit,
        periodic and name as arrays.
        ``.txt``, ``.csv``: heights [m] below comment lines that state spacing and unit.
    dtype
        HDF5 only: float64, or float32 for half the size.

    Raises
    ------
    InputError
        If the format cannot hold a height map with its units, or the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     surfaces.write(hm, f"{folder}/scan.h5")
    ...     print(surfaces.read(f"{folder}/scan.h5").digest == hm.digest)
    True
    """
    require_map(hm)
    path = as_path(path)
    if path.suffix.lower() in _HDF5:
        from .hdf5_write import write_blocks

        write_blocks(
            path,
            hm.shape,
            hm.spacing,
            (hm.heights,),
            periodic=hm.periodic,
            name=hm.name,
            history=hm.history,
            dtype=dtype,
        )
        return
    if dtype != "float64":
        raise InputError(f"{path}: only .h5 is written as {dtype} (--float32)")
    if path.suffix.lower() in NOT_HDF5:
        from . import arrays

        (arrays.write_npz if path.suffix.lower() == ".npz" else arrays.write_text)(hm, path)
        return
    raise SurfaceError(
        f"{path}: a height map with its units is written as .h5, .npz, .txt or .csv, "
        f"not as {path.suffix or 'a file without suffix'}"
    )


def _reader(
    path: Path,
) -> Callable[[Path, str | None, str | None, ArrayLike | None], HeightMap] | None:
    """What reads a file whole; None if `SurfaceFile` reads it in parts."""
    with path.open("rb") as file:
        head = file.read(8)
    if not head:
        raise FileFormatError(f"{path}: the file is empty")
    suffix = path.suffix.lower()
    if head == _HDF5_SIGNATURE or suffix in _HDF5:
        return None
    from . import arrays, instruments

    if head.removeprefix(codecs.BOM_UTF8).startswith(instruments.SDF_SIGNATURES):
        return instruments.read_sdf
    if suffix == ".x3p":
        return instruments.read_x3p
    if suffix in _PICTURES:
        from .pictures import read_picture

        return read_picture
    if head.startswith(_NPY_SIGNATURE) or suffix == ".npy":
        return arrays.read_npy
    if suffix == ".npz":
        return arrays.read_npz
    if suffix == ".mat":
        from .matlab import read_mat

        return read_mat
    words = arrays.heading(path) if suffix in _TEXT else ""
    if words is None:
        return arrays.read_text
    return partial(instruments.read_instrument, hint=f"; as text, {words}" if words else "")
