"""Height maps of rough surfaces: files, synthesis, preparation, statistics, peaks, profiles."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .errors import FileFormatError as FileFormatError
    from .errors import InputError as InputError
    from .errors import SurfaceError as SurfaceError
    from .heightmap import HeightMap as HeightMap

_HOME = {
    "FileFormatError": "errors",
    "HeightMap": "heightmap",
    "InputError": "errors",
    "SurfaceError": "errors",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
