"""Errors of both packages, and arguments that cannot be used, refused in one sentence.

Each message says what is wrong, where, and how to mend it.
"""

from __future__ import annotations

import math
import os
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from surfaces.arrays import Array

__all__ = [
    "LARGEST_NUMBER",
    "LONGEST_LENGTH",
    "SHORTEST_LENGTH",
    "AsperityError",
    "FileFormatError",
    "InputError",
    "SurfaceError",
    "as_choice",
    "as_count",
    "as_number",
    "as_numbers",
    "as_path",
    "as_places",
    "as_positive",
    "as_sizes",
    "as_text",
    "as_truth",
    "checked_heights",
    "checked_history",
    "checked_part",
    "checked_range",
    "checked_spacing",
    "checked_span",
    "require_kind",
    "require_texts",
    "shown",
]

SHORTEST_LENGTH, LONGEST_LENGTH = 1e-35, 1e35
"""Range of lengths [m] in which squares of areas and fourth powers of slopes neither overflow nor
lose digits, so that results do not depend on the unit."""

LARGEST_NUMBER = 1e100
"""Largest number, and inverse of the smallest, whose squares and powers do not overflow."""

SLIMMEST_PIXEL = 1e3
"""Largest ratio of the pixel sizes: with a larger one, which no instrument has, one of both is in
another unit."""


class AsperityError(Exception):
    """Base class of every error that these packages raise on purpose."""


class InputError(AsperityError, ValueError):
    """An argument is outside what the function accepts."""


class SurfaceError(InputError):
    """A height map cannot be used as asked."""


class FileFormatError(InputError):
    """A file does not hold what its format promises."""


def as_number(name: str, value: Any) -> float:
    """The argument called `name` as a float. Refused are all but single real numbers, and also
    booleans: True is not 1 Pa."""
    try:
        if isinstance(value, str | bytes | bool | np.bool_) or np.ndim(value):
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} is {shown(value)}; it must be a number") from None


def as_positive(name: str, value: Any) -> float:
    """The argument called `name` as a positive float whose powers do not overflow."""
    number = as_number(name, value)
    if not 1 / LARGEST_NUMBER <= number <= LARGEST_NUMBER:
        raise InputError(f"{name} is {shown(value)}; it must be positive and finite")
    return number


def as_numbers(name: str, values: Any, *, finite: bool = True, copy: bool = True) -> Array:
    """The argument called `name` as an array of real numbers of any shape; masked ones become NaN.
    With `finite` others are refused. Without `copy` the array given may be returned itself."""
    try:
        given = np.ma.asarray(values)
        mixed = isinstance(values, list | tuple) and any(isinstance(one, bool) for one in values)
        if given.dtype.kind in "bcmMSU" or mixed:
            raise TypeError
        array = np.ma.filled(given.astype(np.float64, copy=copy), np.nan)
    except (TypeError, ValueError, OverflowError):
        raise InputError(
            f"{name} is {shown(values)}; it must be a number or an array of numbers"
        ) from None
    if finite and not np.isfinite(array).all():
        raise InputError(f"{name} is {shown(values)}; it must be finite")
    return np.asarray(array)


def as_places(x: Any, y: Any) -> tuple[Array, Array]:
    """Coordinates x and y as arrays of one shape. Shapes that do not fit together are refused."""
    across, along = as_numbers("x", x), as_numbers("y", y)
    try:
        across, along = np.broadcast_arrays(across, along)
    except ValueError:
        raise InputError(
            f"x and y have the shapes {across.shape} and {along.shape}; give as many of each"
        ) from None
    return across, along


def as_sizes(name: str, values: Any) -> Array:
    """The argument called `name` as an array of any shape, of numbers that are zero or whose powers
    do not overflow."""
    array = as_numbers(name, values)
    size = np.abs(array[array != 0])
    if np.any((size < 1 / LARGEST_NUMBER) | (size > LARGEST_NUMBER)):
        raise InputError(
            f"{name} is {shown(values)}; give numbers from {1 / LARGEST_NUMBER:g} to "
            f"{LARGEST_NUMBER:g}, or zero"
        )
    return array


def as_count(name: str, value: Any, least: int) -> int:
    """The argument called `name` as a whole number, at least `least`."""
    number = as_number(name, value)
    if not (least <= number <= 2**53 and number == int(number)):
        raise InputError(f"{name} is {shown(value)}; give a whole number, at least {least}")
    return int(number)


def as_choice(name: str, value: Any, choices: Collection[str]) -> str:
    """The argument called `name` as one of a few names."""
    if not isinstance(value, str) or value not in choices:
        raise InputError(f"{name} is {shown(value)}; choose one of {', '.join(choices)}")
    return value


def as_truth(name: str, value: Any) -> bool:
    """The argument called `name` as True or False."""
    if not isinstance(value, bool | np.bool_):
        raise SurfaceError(f"{name} is {shown(value)}; it must be True or False")
    return bool(value)


def shown(value: Any) -> str:
    """What was given, by a caller or a file, on one line of a message and short."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def require_kind(value: object, kind: type, source: str) -> None:
    """Refuse what is no object of a kind, and say how to make one."""
    if not isinstance(value, kind):
        raise InputError(f"{kind.__name__} is needed, not {shown(value)}: {source}")


def require_texts(**given: Any) -> None:
    """Refuse what is neither a text nor None, of arguments by their names."""
    for name, value in given.items():
        if not isinstance(value, str | None):
            raise InputError(f"{name} is {shown(value)}; give a text, or leave it out")


def as_text(value: Any) -> str:
    """A name as text that every file can hold; characters that are no text become "?"."""
    return str(value).encode(errors="replace").decode().replace("\0", "?")


def as_path(path: str | os.PathLike[str]) -> Path:
    """The path of a file; anything but a text or a path is refused."""
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"the path of a file is a text or a path, not {type(path).__name__}")
    if "\0" in str(path):
        raise InputError(f"{shown(path)} is no path: it holds a zero byte")
    return Path(path)


def checked_heights(heights: Any) -> Array:
    """Heights [m] as a read-only array (ny, nx), masked entries as NaN.

    A writable array is copied.
    """
    try:
        rows = isinstance(heights, list | tuple)  # of which some may be masked
        given = np.ma.asarray(heights) if rows else np.asanyarray(heights)
        if given.dtype.kind not in "fiuO":
            raise TypeError(f"they are of type {given.dtype}")
        if isinstance(given, np.ma.MaskedArray):
            given = np.ma.filled(given.astype(np.float64), np.nan)
        array = np.asarray(given, dtype=np.float64, order="C")
        # what is no array of numpy may hand out the one that it keeps
        if (array.flags.writeable and array is given) or not array.flags.owndata:
            array = array.copy()
    except (TypeError, ValueError, OverflowError) as error:
        raise SurfaceError(f"heights are not an array of real numbers: {error}") from error
    if array.ndim != 2 or min(array.shape) < 3:
        raise SurfaceError(
            f"heights have shape {array.shape}; a height map needs two axes of at least 3 points "
            "(a profile line makes a map with a perfect lay: numpy.tile(line, (rows, 1)))"
        )
    checked_range(
        float(np.fmin.reduce(array, axis=None)), float(np.fmax.reduce(array, axis=None)), array
    )
    array.setflags(write=False)
    return array


def checked_range(low: float, high: float, heights: Any) -> None:
    """Refuse heights [m], (ny, nx), whose lowest and highest are NaN, infinite or out of range."""
    if math.isnan(low):
        raise SurfaceError("every point of the height map is missing (NaN)")
    if math.isinf(low) or math.isinf(high):
        counts = [np.count_nonzero(np.isinf(heights[row])) for row in range(len(heights))]
        row = int(np.argmax(np.greater(counts, 0)))
        col = int(np.argmax(np.isinf(heights[row])))
        raise SurfaceError(
            f"heights[{row}, {col}] is infinite ({sum(counts)} of {heights.size} points); mark "
            "missing points with NaN"
        )
    if max(abs(low), abs(high)) > LONGEST_LENGTH or 0.0 < high - low < SHORTEST_LENGTH:
        raise SurfaceError(
            f"heights reach from {low:.4g} to {high:.4g} m, which no calculation can hold; "
            "check their unit"
        )


def checked_history(history: Any) -> tuple[dict[str, Any], ...]:
    """The history of a map as a tuple of mappings, one for each step."""
    try:
        return tuple(dict(step) for step in history)
    except (TypeError, ValueError):
        raise SurfaceError(
            f"history is {shown(history)}; it is a sequence of mappings, one per step"
        ) from None


def checked_spacing(spacing: Any) -> tuple[float, float]:
    """Pixel size (dy, dx) [m], both positive and finite, from a pair or one number."""
    try:
        pair = np.broadcast_to(as_numbers("spacing", spacing, finite=False), (2,))
    except ValueError:
        raise SurfaceError(
            f"spacing is {shown(spacing)}; give the pixel size (dy, dx) in m"
        ) from None
    if not ((pair >= SHORTEST_LENGTH) & (pair <= LONGEST_LENGTH)).all():
        raise SurfaceError(
            f"spacing is {tuple(pair.tolist())}; both pixel sizes (dy, dx) must be positive "
            f"lengths in m, from {SHORTEST_LENGTH:g} to {LONGEST_LENGTH:g}"
        )
    if pair.max() > SLIMMEST_PIXEL * pair.min():
        raise SurfaceError(
            f"spacing is {tuple(pair.tolist())}; one pixel size (dy, dx) is more than "
            f"{SLIMMEST_PIXEL:g} times the other: give both in m"
        )
    return float(pair[0]), float(pair[1])


def checked_part(name: str, part: tuple[int, int], count: int) -> tuple[int, int]:
    """First row or column of a part of a map with so many, and one past its last."""
    ends = as_numbers(name, part, finite=False)
    if ends.shape != (2,) or not 0 <= ends[0] < ends[1] <= count or np.any(ends % 1):
        raise SurfaceError(
            f"{name} {shown(part)} are not inside 0 to {count}; give two whole numbers, first and "
            "one past last"
        )
    return int(ends[0]), int(ends[1])


def checked_span(
    name: str, span: tuple[float, float] | None, places: Array, length: float
) -> tuple[int, int]:
    """First pixel whose centre lies in a span [m], and one past the last."""
    ends = as_numbers(name, (0.0, length) if span is None else span, finite=False)
    slack = 1e-9 * length
    if ends.shape != (2,) or not -slack <= ends[0] < ends[1] <= length + slack:
        raise SurfaceError(
            f"{name} is {shown(span)}; give two places from 0 to {length:.6g} m, rising"
        )
    first, last = np.searchsorted(places, ends)
    if last - first < 3:
        raise SurfaceError(f"{name} is {span} m, which holds fewer than three pixels")
    return int(first), int(last)
