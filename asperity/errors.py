"""What may be wrong with an answer: errors, warnings that are given once, flags of a contact."""

from __future__ import annotations

import functools
import sys
import warnings
from collections.abc import Callable, Iterable
from contextvars import ContextVar
from enum import IntFlag
from typing import ParamSpec, TypeVar

from surfaces.errors import AsperityError, FileFormatError, InputError, SurfaceError

__all__ = [
    "INVALID",
    "AsperityError",
    "ContactWarning",
    "ConvergenceError",
    "FileFormatError",
    "Flag",
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


class Flag(IntFlag):
    """Validity bits of a contact; 0 means that nothing was found wrong.

    `CONTOUR_DOUBTFUL`: min a(phi)/a < 0.5 or max |a(phi) - a|/a > 0.5; or the law "harmonic" or
    "paper" expects half the force as an error, or the mean profile of a table pierces the free
    surface beside the contact (error not known); or area or stiffness of "harmonic" left half to
    twice those of the circle and were kept there. `CONTOUR_NEGATIVE`: some a(phi) <= 0.
    `TURNING`: the approach is no rising function of the radius here (D' <= 0), no solution.
    `NEGATIVE_GAP`: f < 0 inside the contact (a higher neighbor). `RAY_TURNS`: f falls along a ray
    inside the contact. `SECOND_SUMMIT`: another summit stands inside {f < d}. `BEYOND_RADIUS`: of
    one profile, the contact leaves the sampled radius on some ray, or lies within the first; in a
    law table, the expansion of the law does not hold there. `FILLED`: the contact covers its whole
    basin.
    """

    CONTOUR_DOUBTFUL = 1
    CONTOUR_NEGATIVE = 2
    TURNING = 4
    NEGATIVE_GAP = 8
    RAY_TURNS = 16
    SECOND_SUMMIT = 32
    BEYOND_RADIUS = 64
    FILLED = 128


INVALID = Flag.CONTOUR_NEGATIVE | Flag.TURNING | Flag.NEGATIVE_GAP | Flag.SECOND_SUMMIT


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
