"""Height maps in MATLAB files: a matrix whose rows lie along x, one for each y, as it is shown."""

from __future__ import annotations

import math
from pathlib import Path

from numpy.typing import ArrayLike

from surfaces.errors import FileFormatError
from surfaces.heightmap import HeightMap
from surfaces.numerics.memory import require_memory

from ._container import survives
from ._damage import naming_damage
from .arrays import named_map

__all__ = ["read_mat"]

_HDF5_BASED = b"MATLAB 7.3"


def read_mat(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Heights from one matrix; variables ``unit`` and ``spacing`` beside it are used."""
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import MatReadError

    with path.open("rb") as file:
        if file.read(len(_HDF5_BASED)) == _HDF5_BASED:
            raise FileFormatError(f"{path}: is of MATLAB 7.3; save it with -v7")
    with naming_damage(path, also=(NameError, MatReadError)):
        shapes = {name: shape for name, shape, _ in whosmat(path)}
        points = max(map(math.prod, shapes.values()), default=0)
        require_memory(32 * points, f"{path}: its largest matrix", "save a part of it")
        seconds = 3 + (path.stat().st_size >> 20)
        if not survives(lambda: loadmat(path), seconds):  # SciPy's reader trusts what it reads
            raise FileFormatError(f"{path}: damaged, it crashes the library; copy it again")
        return named_map([*shapes], loadmat(path, squeeze_me=True), path, dataset, unit, spacing)
