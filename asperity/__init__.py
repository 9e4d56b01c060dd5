"""How much of a rough surface touches, at what load and separation, and how far to trust it."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .errors import ConvergenceError as ConvergenceError
    from .errors import InputError as InputError
    from .errors import ModelRangeError as ModelRangeError
    from .material import HalfSpace as HalfSpace

__version__ = "0.1.0"

_HOME = {
    "ConvergenceError": "errors",
    "HalfSpace": "material",
    "InputError": "errors",
    "ModelRangeError": "errors",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
