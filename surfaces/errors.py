"""Errors of both packages, and arguments of the wrong type, refused in one sentence.

Each message says what is wrong, where, and how to mend it.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

__all__ = ["AsperityError", "FileFormatError", "InputError", "SurfaceError", "as_number", "as_path"]


class AsperityError(Exception):
    """Base class of every error that these packages raise on purpose."""


class InputError(AsperityError, ValueError):
    """An argument is outside what the function accepts."""


class SurfaceError(InputError):
    """A height map cannot be used as asked."""


class FileFormatError(InputError):
    """A file does not hold what its format promises."""


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
