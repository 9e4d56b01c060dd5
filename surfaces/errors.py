"""Errors of both packages; each message says what is wrong, where, and how to mend it."""

from __future__ import annotations

__all__ = ["AsperityError", "FileFormatError", "InputError", "SurfaceError"]


class AsperityError(Exception):
    """Base class of every error that these packages raise on purpose."""


class InputError(AsperityError, ValueError):
    """An argument is outside what the function accepts."""


class SurfaceError(InputError):
    """A height map cannot be used as asked."""


class FileFormatError(InputError):
    """A file does not hold what its format promises."""
