"""Height maps in MATLAB files: a matrix whose rows lie along x, one for each y, as it is shown."""

from __future__ import annotations

import math
from pathlib import Path

from numpy.typing import ArrayLike

from surfaces.errors import FileFormatError, InputError
from surfaces.heightmap import HeightMap
from surfaces.numerics.memory import require_memory

from ._container import survives
from ._damage import DAMAGED, damaged
from .arrays import named_map

__all__ = ["read_mat"]


def read_mat(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Heights from one matrix; variables ``unit`` and ``spacing`` beside it are used."""
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import MatReadError

    try:
        shapes = {name: shape for name, shape, _ in whosmat(path)}
        points = max(map(math.prod, shapes.values()), default=0)
        require_memory(32 * points, f"{path}: its largest matrix", "save a part of it")
        seconds = 3 + (path.stat().st_size >> 20)
        if not survives(lambda: loadmat(path), seconds):  # SciPy's reader trusts what it reads
            raise FileFormatError(f"{path}: damaged, it crashes the library; copy it again")
        return named_map([*shapes], loadmat(path, squeeze_me=True), path, dataset, unit, spacing)
    except InputError:
        raise
    except NotImplementedError as error:
        raise FileFormatError(f"{path}: is of MATLAB 7.3; save it with -v7") from error
    except (*DAMAGED, NameError, MatReadError) as error:
        raise damaged(path, error) from error
