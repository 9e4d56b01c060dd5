"""Instrument files through SurfaceTopography, an optional extra."""

from __future__ import annotations

import importlib
import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any
from xml.parsers.expat import ExpatError

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import FileFormatError
from .heightmap import HeightMap
from .units import metres_per

__all__ = ["read_instrument"]

_PIP = "python -m pip install 'asperity[formats]'"
_BROKEN_EXTRA = (ImportError, AttributeError, RuntimeError, OSError, ValueError, SyntaxError)
_DAMAGED = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    EOFError,
    ExpatError,
    LookupError,
    NotImplementedError,
    OSError,
    RuntimeError,
    SyntaxError,
    TypeError,
    ValueError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)
"""What a third-party reader may raise on a file that is damaged or not its own."""


def read_instrument(
    path: Path, dataset: str | None, unit: str | None, spacing: ArrayLike | None
) -> HeightMap:
    """Read one channel of an instrument's file.

    Parameters
    ----------
    path
        The file.
    dataset
        Name of the channel, or its number as text; the default channel if None.
    unit, spacing
        Unit of the heights and pixel size (dy, dx) [m] where the file states none.

    Raises
    ------
    FileFormatError
        If the extra is missing or broken, or the file cannot be read with it.
    """
    library = _library(path)
    try:
        with library.open_topography(str(path)) as reader:
            channel = _channel(reader, path, dataset)
            topography = channel.topography()
            origin = {
                "step": "read",
                "file": path.name,
                "format": str(reader.format()),
                "channel": str(channel.name),
            }
            heights = np.ma.filled(np.ma.masked_invalid(topography.heights()), np.nan)
            stated = {
                "unit": topography.unit if isinstance(topography.unit, str) else None,
                "size": topography.physical_sizes,
                "periodic": bool(topography.is_periodic),
                "instrument": (topography.info.get("instrument") or {}).get("name"),
            }
    except FileFormatError:
        raise
    except _DAMAGED as error:
        raise FileFormatError(
            f"{path}: no reader of SurfaceTopography understands this file "
            f"({type(error).__name__}: {' '.join(str(error).split())[:120]})"
        ) from error
    if stated["instrument"]:
        origin["instrument"] = str(stated["instrument"])
    return _as_map(np.asarray(heights, dtype=np.float64).T, path, unit, spacing, stated, origin)


def _as_map(
    heights: NDArray[np.float64],
    path: Path,
    unit: str | None,
    spacing: ArrayLike | None,
    stated: dict[str, Any],
    origin: dict[str, Any],
) -> HeightMap:
    """The library keeps x first; ours has y first."""
    chosen = stated["unit"] or unit
    if chosen is None:
        raise FileFormatError(f"{path}: states no unit; pass --unit (unit=...), such as --unit um")
    factor = metres_per(chosen)
    if stated["size"] is not None:
        length_x, length_y = stated["size"]
        pixel: Any = (
            length_y * factor / heights.shape[0],
            length_x * factor / heights.shape[1],
        )
    elif spacing is not None:
        pixel = spacing
    else:
        raise FileFormatError(
            f"{path}: states no pixel size; pass --spacing DY DX (spacing=...) in m"
        )
    origin["unit"] = str(chosen)
    return HeightMap(
        heights * factor,
        pixel,
        periodic=stated["periodic"],
        name=path.stem,
        history=(origin,),
    )


def _library(path: Path) -> Any:
    try:
        return importlib.import_module("SurfaceTopography")
    except ModuleNotFoundError as error:
        if error.name != "SurfaceTopography":
            raise FileFormatError(
                f"{path}: the extra for instrument formats is broken ({error}); run {_PIP}"
            ) from error
        raise FileFormatError(
            f"{path}: not HDF5, npy, npz or rows of numbers; instrument formats need: {_PIP}"
        ) from error
    except _BROKEN_EXTRA as error:
        reason = " ".join(str(error).split())[:120]
        raise FileFormatError(
            f"{path}: the extra for instrument formats is broken "
            f"({type(error).__name__}: {reason}); reinstall it with: {_PIP} --force-reinstall"
        ) from error


def _channel(reader: Any, path: Path, name: str | None) -> Any:
    if name is None:
        return reader.default_channel
    channels = list(reader.channels)
    for number, channel in enumerate(channels):
        if name in (channel.name, str(number)):
            return channel
    raise FileFormatError(
        f"{path}: no channel {name!r}; the file holds {', '.join(str(c.name) for c in channels)}"
    )
