"""Height maps of rough surfaces: files, synthesis, preparation, statistics, peaks, profiles."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .errors import FileFormatError as FileFormatError
    from .errors import InputError as InputError
    from .errors import SurfaceError as SurfaceError
    from .heightmap import HeightMap as HeightMap
    from .peaks import Peaks as Peaks
    from .polar import PolarProfile as PolarProfile
    from .polar import PolynomialProfile as PolynomialProfile
    from .polar import PowerLawProfile as PowerLawProfile
    from .polar import PowerSumProfile as PowerSumProfile
    from .segmentation import segment as segment
    from .synthesis import self_affine as self_affine

_HOME = {
    "FileFormatError": "errors",
    "HeightMap": "heightmap",
    "InputError": "errors",
    "Peaks": "peaks",
    "PolarProfile": "polar",
    "PolynomialProfile": "polar",
    "PowerLawProfile": "polar",
    "PowerSumProfile": "polar",
    "SurfaceError": "errors",
    "segment": "segmentation",
    "self_affine": "synthesis",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
