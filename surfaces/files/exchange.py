"""Height maps in the formats for exchange between instruments: SDF (ISO 25178-71) and X3P (-72)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surfaces.errors import FileFormatError
from surfaces.heightmap import HeightMap
from surfaces.units import chosen_unit

from ._damage import DAMAGED, damaged
from .arrays import require_unnamed

__all__ = ["SDF_SIGNATURES", "read_sdf", "read_x3p"]

SDF_SIGNATURES = tuple(f"{kind}{family}-".encode() for kind in "abAB" for family in ("ISO", "BCR"))
"""First bytes of an SDF file, text (a) or binary (b)."""


def read_sdf(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Heights [m] from an SDF file, text or binary."""
    import sdfio

    require_unnamed(path, dataset)
    try:
        file = sdfio.read(path)
    except DAMAGED as error:
        raise damaged(path, error) from error
    header = file.header
    return _stated(path, unit, spacing, file.data, (header.y_scale, header.x_scale), "SDF")


def read_x3p(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Heights [m] of one layer of an X3P file, the first if `dataset` is None."""
    import x3pio

    try:
        file = x3pio.read(path)
    except DAMAGED as error:
        raise damaged(path, error) from error
    names = [str(number) for number in range(len(file.layers))]
    if dataset not in (None, *names):
        raise FileFormatError(f"{path}: no layer {dataset!r}; the file holds {', '.join(names)}")
    layer = file.layers[int(dataset or 0)]
    if not isinstance(layer, x3pio.SurfaceLayer) or not layer.is_regular_grid:
        kind = "a profile, points or uneven axes"
        raise FileFormatError(f"{path}: holds {kind}; a height map needs an even grid")
    return _stated(path, unit, spacing, layer.z, layer.spacing[::-1], "X3P")


def _stated(
    path: Path,
    unit: str | None,
    spacing: ArrayLike | None,
    heights: NDArray[np.float64],
    pixel: tuple[float, float],
    kind: str,
) -> HeightMap:
    """The map of a file that states all its lengths in metres."""
    chosen_unit(path, "m", unit)
    if spacing is not None:
        raise FileFormatError(f"{path}: states its pixel size; leave out --spacing")
    origin = {"step": "read", "file": path.name, "format": kind, "unit": "m"}
    return HeightMap(heights, pixel, name=path.stem, history=(origin,))
