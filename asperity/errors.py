"""Errors of the mechanics, beside those of `surfaces.errors`."""

from __future__ import annotations

from surfaces.errors import AsperityError, FileFormatError, InputError, SurfaceError

__all__ = [
    "AsperityError",
    "ConvergenceError",
    "FileFormatError",
    "InputError",
    "ModelRangeError",
    "SurfaceError",
]


class ConvergenceError(AsperityError, RuntimeError):
    """A solver stopped before it reached its tolerance and the caller asked for an answer."""


class ModelRangeError(AsperityError, ValueError):
    """The approximate model does not hold at the point that was asked for."""
