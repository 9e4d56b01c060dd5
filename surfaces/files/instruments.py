"""Instrument files: the formats for exchange, SDF (ISO 25178-71) and X3P (-72), and those of makers
through SurfaceTopography, an optional extra."""

from __future__ import annotations

import importlib
import math
import re
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surfaces.errors import FileFormatError
from surfaces.heightmap import HeightMap
from surfaces.numerics.memory import require_memory
from surfaces.units import chosen_unit, metres_per

from ._damage import brief, naming_damage
from ._schema import one_spacing
from .arrays import as_map, require_unnamed

__all__ = ["SDF_SIGNATURES", "read_instrument", "read_sdf", "read_x3p"]

SDF_SIGNATURES = tuple(f"{kind}{family}-".encode() for kind in "abAB" for family in ("ISO", "BCR"))
"""First bytes of an SDF file, text (a) or binary (b)."""

_NUMBER_OF_PYTHON = re.compile(rb"^(?!\s*ManufacID)[^;\r\n]*?(\w*\d_\d\w*)", re.M)
"""What Python takes for a number, such as 1_0, and no file may hold, in text before a comment."""

_FIELD = re.compile(rb"^[ \t]*(\w+)[ \t]*=", re.M)
"""A line of the header of a text SDF that states something."""

_PIP = "python -m pip install 'asperity[formats]'"
_BROKEN_EXTRA = (ImportError, AttributeError, RuntimeError, OSError, ValueError, SyntaxError)


def read_sdf(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Heights [m] from an SDF file, text or binary."""
    import sdfio

    require_unnamed(path, dataset)
    with naming_damage(path):
        file = sdfio.read(path)
    header = file.header
    if not header.z_scale > 0.0:
        raise FileFormatError(f"{path}: Zscale is {header.z_scale}; it must be positive, in m")
    if header.format is sdfio.FileFormat.ASCII:
        parts = path.read_bytes().replace(b"\r", b"\n").split(b"*")
        ((name, count),) = Counter(map(bytes.lower, _FIELD.findall(parts[0]))).most_common(1)
        if count > 1:
            raise FileFormatError(
                f"{path}: its header states {name.decode()} more than once; leave one"
            )
        before_trailer = b"*".join(parts[:2])
        if strange := _NUMBER_OF_PYTHON.search(before_trailer):
            raise FileFormatError(f"{path}: holds {strange[1].decode()!r}, which is no number")
    stated = {"unit": "m", "spacing": (header.y_scale, header.x_scale)}
    return as_map(file.data, path, unit, spacing, stated, format="SDF")


def read_x3p(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Heights [m] of one layer of an X3P file, the first if `dataset` is None."""
    import x3pio

    with naming_damage(path):
        content = x3pio.info(path)
        _require_room(path, content.layer_count * math.prod(content.shape))
        file = x3pio.read(path)
    names = [str(number) for number in range(len(file.layers))]
    if dataset not in (None, *names):
        raise FileFormatError(f"{path}: no layer {dataset!r}; the file holds {', '.join(names)}")
    layer = file.layers[int(dataset or 0)]
    if not isinstance(layer, x3pio.SurfaceLayer) or not layer.is_regular_grid:
        kind = "a profile, points or uneven axes"
        raise FileFormatError(f"{path}: holds {kind}; a height map needs an even grid")
    turn = layer.placement.rotation
    # a slight tilt is left to the levelling, and a turn in the plane changes no contact
    if np.linalg.det(turn) < 0.5 or turn[2, 2] <= 0.0:
        raise FileFormatError(
            f"{path}: its rotation {turn.round(3).tolist()} mirrors the heights or turns them "
            "over, so that it is open what points out of the solid; export it without a rotation"
        )
    # the library takes a metre where the file states no increment
    height, pixel = layer.header.z, layer.spacing[::-1]
    whole = height.data_type in (x3pio.DataType.INT16, x3pio.DataType.INT32)
    stated = {
        "unit": None if whole and height.increment == 1.0 else "m",
        "spacing": None if 1.0 in pixel else pixel,
    }
    return as_map(layer.z, path, unit, spacing, stated, format="X3P")


def _require_room(path: Path, points: int) -> None:
    """Refuse a file of so many points that would not fit, before a library makes room for them."""
    require_memory(32 * points, f"{path}: a map of {points} points", "save a part of it")


def read_instrument(
    path: Path,
    dataset: str | None,
    unit: str | None,
    spacing: ArrayLike | None,
    hint: str = "",
) -> HeightMap:
    """Heights from one channel of an instrument's file: `dataset` is its name, or its number as
    text; the default channel if None.

    The unit of the heights and the spacing (dy, dx) [m] are needed where the file states none. The
    hint, what keeps the file from being read otherwise, is told where this library cannot either.
    """
    library = _library(path, hint)
    errors = library.Exceptions
    with naming_damage(path, hint=hint, also=(errors.ReadFileError,)), np.errstate(all="ignore"):
        try:
            opened = library.open_topography(str(path))
        except errors.CannotDetectFileFormat as error:
            raise FileFormatError(
                f"{path}: not HDF5, npy, npz or rows of numbers, nor a format that "
                f"SurfaceTopography knows, or damaged{hint}"
            ) from error
        with opened as reader:
            channel = _channel(reader, path, dataset, hint)
            # the library uses one unit for heights and lengths
            scale = channel.height_scale_factor
            if scale is not None and not 0.0 < abs(scale) < math.inf:
                raise FileFormatError(
                    f"{path}: the height of one step is {scale} in its header, which tells no "
                    "heights; export it again"
                )
            _require_room(path, math.prod(channel.nb_grid_pts))
            stated = channel.unit if isinstance(channel.unit, str) else None
            chosen = chosen_unit(stated, unit)
            sizes = _sizes(channel, spacing, metres_per(chosen))
            topography = channel.topography(**sizes)
            origin = {"format": str(reader.format()), "channel": str(channel.name)}
            heights = np.ma.filled(np.ma.masked_invalid(topography.heights()), np.nan)
            periodic = bool(topography.is_periodic)
            length_x, length_y = topography.physical_sizes
            instrument = (topography.info.get("instrument") or {}).get("name")
    if instrument:
        origin["instrument"] = str(instrument)
    nx, ny = heights.shape
    pixel = (length_y * metres_per(chosen) / ny, length_x * metres_per(chosen) / nx)
    facts = {"unit": chosen, "spacing": pixel, "periodic": periodic}
    return as_map(heights.T, path, None, None, facts, **origin)


def _sizes(
    channel: Any, spacing: ArrayLike | None, metres: float
) -> dict[str, tuple[float, float]]:
    """What to tell the library about a map whose file does not say how large it is."""
    nx, ny = channel.nb_grid_pts
    if channel.physical_sizes is not None:
        length_x, length_y = channel.physical_sizes
        one_spacing((length_y * metres / ny, length_x * metres / nx), spacing)
        return {}
    dy, dx = one_spacing(None, spacing)
    return {"physical_sizes": (nx * dx / metres, ny * dy / metres)}


def _library(path: Path, hint: str) -> Any:
    try:
        return importlib.import_module("SurfaceTopography")
    except _BROKEN_EXTRA as error:
        text = (
            f"the extra for instrument formats is broken ({type(error).__name__}: {brief(error)}); "
            f"reinstall it with: {_PIP} --force-reinstall"
        )
        if isinstance(error, ModuleNotFoundError) and error.name == "SurfaceTopography":
            text = f"not HDF5, npy, npz or rows of numbers; instrument formats need: {_PIP}{hint}"
        raise FileFormatError(f"{path}: {text}") from error


def _channel(reader: Any, path: Path, name: str | None, hint: str) -> Any:
    channels = list(reader.channels)
    if not channels:
        raise FileFormatError(f"{path}: holds no heights in a unit of length{hint}")
    named = [(known, c) for n, c in enumerate(channels) for known in (c.name, str(n))]
    by_name = dict(reversed(named))  # of one name the first
    channel = reader.default_channel if name is None else by_name.get(name)
    if channel is None:
        names = ", ".join(str(c.name) for c in channels)
        raise FileFormatError(f"{path}: no channel {name!r}; the file holds {names}")
    if len(channel.nb_grid_pts) != 2:
        raise FileFormatError(f"{path}: holds a line of heights; a map needs two axes{hint}")
    return channel
