"""HDF5 files of one polar profile, and profiles cut from a height map."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surfaces.arrays import Array
from surfaces.errors import FileFormatError, InputError
from surfaces.heightmap import HeightMap
from surfaces.polar import PolarProfile

from ._damage import naming_damage
from .formats import read

__all__ = ["read_profile"]


def read_profile(
    path: str | Path,
    *,
    dataset: str | None = None,
    unit: str | None = None,
    spacing: ArrayLike | None = None,
) -> PolarProfile:
    """Read a profile file, or the highest peak of a height-map file.

    Parameters
    ----------
    path
        HDF5 file with ``r`` [m] (n_r,), ``phi`` [rad] (n_phi,) and ``f`` [m] (n_r, n_phi), or any
        surface file that `surfaces.read` takes; a map that is not periodic loses its tilt first.
    dataset, unit, spacing
        As in `surfaces.read`; a file for which one of them is given is a surface file.

    Raises
    ------
    FileFormatError
        If the file cannot be read or lacks one of the three datasets.
    """
    import h5py

    name = Path(path).name
    stated = dataset is None and unit is None and spacing is None
    if stated and Path(path).is_file():
        try:
            with naming_damage(Path(name), "cannot be read", "; is it cut off?"):
                if h5py.is_hdf5(path):
                    with h5py.File(path, "r") as file:
                        if "heights" not in file:
                            keys = ("r", "phi", "f", *(["edge"] if "edge" in file else []))
                            return PolarProfile(*(_column(file, key, name) for key in keys))
        except InputError as error:
            text = str(error).removeprefix(f"{name}: ")
            raise FileFormatError(f"{name}: {text}") from error
    return _highest_peak(read(path, dataset=dataset, unit=unit, spacing=spacing), name)


def _column(file: Any, key: str, name: str) -> Array:
    if key not in file:
        raise FileFormatError(
            f"{name}: no dataset {key!r}; a profile file holds r, phi and f, a surface file heights"
        )
    return np.asarray(file[key], dtype=float)


def _highest_peak(hm: HeightMap, name: str) -> PolarProfile:
    from surfaces.peaks.segmentation import segment
    from surfaces.peaks.summits import fit_profiles
    from surfaces.preparation.levelling import level

    hm = level(hm, "plane")
    peaks = segment(hm)
    if len(peaks) == 0:
        raise FileFormatError(f"{name}: the map has no peak")
    return fit_profiles(hm, peaks, rays=32, nodes=33).profile(0)
