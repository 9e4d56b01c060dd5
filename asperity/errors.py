"""Errors of the mechanics, beside those of `surfaces.errors`, and warnings, each given once."""

from __future__ import annotations

import functools
import sys
import warnings
from collections.abc import Callable, Iterable
from contextvars import ContextVar
from typing import ParamSpec, TypeVar

from surfaces.errors import AsperityError, FileFormatError, InputError, SurfaceError

__all__ = [
    "AsperityError",
    "ContactWarning",
    "ConvergenceError",
    "FileFormatError",
    "InputError",
    "ModelRangeError",
    "SurfaceError",
    "cautious",
    "warn_once",
]

P = ParamSpec("P")
R = TypeVar("R")

_RUNNING: ContextVar[tuple[set[str], ...]] = ContextVar("running", default=())
"""For each solver that runs, the innermost last: what it has told."""


class ConvergenceError(AsperityError, RuntimeError):
    """A solver stopped before it reached its tolerance and the caller asked for an answer."""


class ModelRangeError(AsperityError, ValueError):
    """The approximate model does not hold at the point that was asked for."""


class ContactWarning(UserWarning):
    """A reason to doubt an answer: each with its number, and what would help."""


def cautious(solver: Callable[P, R]) -> Callable[P, R]:
    """Make a solver warn of what its result holds in ``settings["warnings"]``.

    A solver that runs inside another is silent: that one has its result.
    """

    @functools.wraps(solver)
    def called(*args: P.args, **kwargs: P.kwargs) -> R:
        token = _RUNNING.set((*_RUNNING.get(), set()))
        try:
            result = solver(*args, **kwargs)
            warn_once(getattr(result, "settings", {}).get("warnings", ()))
        finally:
            _RUNNING.reset(token)
        return result

    return called


def warn_once(sentences: Iterable[str]) -> None:
    """Warn of each sentence that the solver called by the user has not told yet."""
    if len(_RUNNING.get()) != 1:
        return
    (told,) = _RUNNING.get()
    for text in sentences:
        if text not in told:
            told.add(text)
            warnings.warn(text, ContactWarning, stacklevel=_frames_inside())


def _frames_inside() -> int:
    """Frames from `warn_once` up to the line outside this package that called it."""
    frame, count = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("asperity."):
        frame, count = frame.f_back, count + 1
    return count
