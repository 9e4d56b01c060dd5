"""Every fault of a height-map file, told at once."""

from __future__ import annotations

import os
from collections.abc import Iterator

import numpy as np

from surfaces.errors import AsperityError, as_path

from ._schema import Fault
from .hdf5 import SurfaceFile, opened_parts

__all__ = ["Fault", "validate"]


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

    Examples
    --------
    >>> import tempfile
    >>> import surfaces
    >>> hm = surfaces.self_affine((32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1, cutoff=8e-6)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     surfaces.write(hm, f"{folder}/scan.h5")
    ...     print(surfaces.validate(f"{folder}/scan.h5"))
    []
    """
    path = as_path(path)
    try:
        file, found, header, faults = opened_parts(path, dataset)
        with file:
            if header is not None:
                faults += _height_faults(SurfaceFile(path, file, found, header))
    except AsperityError as error:
        return [Fault(str(error).removeprefix(f"{path}: "))]
    return faults


def _height_faults(file: SurfaceFile) -> Iterator[Fault]:
    infinite = present = 0
    for block in file.written():
        infinite += int(np.count_nonzero(np.isinf(block)))
        present += int(np.count_nonzero(np.isfinite(block)))
    if infinite:
        yield Fault(f"{infinite} heights are infinite; mark missing points with NaN")
    if not present:
        yield Fault("every point of the height map is missing (NaN)")
