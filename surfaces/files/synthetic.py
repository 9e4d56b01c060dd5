"""Synthetic maps straight into a file."""

from __future__ import annotations

import dataclasses
import os
from typing import Any

from surfaces.errors import as_path
from surfaces.random_waves import RandomWaves

from .hdf5_write import write_blocks

__all__ = ["write_self_affine"]


def write_self_affine(
    path: str | os.PathLike[str],
    shape: tuple[int, int],
    size: tuple[float, float],
    *,
    name: str = "",
    dtype: str = "float64",
    **waves: Any,
) -> None:
    """Write the map that `surfaces.self_affine` makes, which may be larger than memory.

    It is made within the limit of `asperity.set_memory`, and within 2 GiB if there is none.

    Parameters
    ----------
    path
        The HDF5 file; an existing one is replaced. The file and a temporary one of 8 bytes per
        point must find room in its folder.
    shape, size
        Number of points (ny, nx) and lengths (Ly, Lx) [m].
    name, dtype
        As in `surfaces.write_blocks`.
    waves
        Further arguments of `surfaces.self_affine`, such as ``hurst`` and ``rms_slope``.

    Raises
    ------
    InputError
        As `surfaces.self_affine`; or if the memory is too little, or the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> import surfaces
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     surfaces.write_self_affine(
    ...         f"{folder}/map.h5", (32, 48), (32e-6, 48e-6), hurst=0.8, rms_slope=0.1
    ...     )
    ...     print(surfaces.read(f"{folder}/map.h5"))
    <HeightMap 'map' 32 x 48, pixel 1e-06 x 1e-06 m, periodic>
    """
    made = RandomWaves(shape, size, **waves)
    step = {"step": "self_affine", **dataclasses.asdict(made)}
    del step["shape"], step["size"]
    write_blocks(
        path,
        made.shape,
        made.spacing,
        made.blocks(as_path(path).parent),
        periodic=True,
        name=name,
        history=(step,),
        dtype=dtype,
    )
