"""Arguments of the wrong type, refused in one sentence."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from .errors import InputError

__all__ = ["as_number", "as_path"]


def as_number(name: str, value: Any) -> float:
    """The argument called `name` as a float; what is no single real number is refused."""
    try:
        if isinstance(value, str | bytes):
            raise TypeError
        return float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {value!r}; it must be a number") from None


def as_path(path: str | os.PathLike[str]) -> Path:
    """The path of a file; what is none is refused."""
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"the path of a file is a text or a path, not {type(path).__name__}")
    return Path(path)
