"""What libraries raise on a file that is damaged or not as its format says, and how it is told."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tokenize import TokenError
from xml.parsers.expat import ExpatError

from surfaces.errors import AsperityError, FileFormatError

__all__ = ["DAMAGED", "brief", "damaged", "naming_damage"]

DAMAGED = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    EOFError,
    ExpatError,
    LookupError,
    OSError,
    RuntimeError,
    SyntaxError,
    SystemError,
    TokenError,
    TypeError,
    ValueError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)
"""Errors of NumPy, h5py, zipfile and the readers of instruments' files, by experience with mutated
files."""


def damaged(path: Path, error: Exception, hint: str = "") -> FileFormatError:
    """One sentence about a file of which a library raised an error."""
    reason = " ".join(f"{type(error).__name__}: {error}".split())[:120]
    return FileFormatError(f"{path}: damaged, or not as its format says ({reason}){hint}")


@contextmanager
def naming_damage(path: Path, what: str, thing: str = "file") -> Iterator[None]:
    """Turn what a library raises on a damaged file into one sentence about it."""
    try:
        yield
    except AsperityError:
        raise
    except DAMAGED as error:
        raise FileFormatError(
            f"{path}: {what} ({brief(error)}); copy the {thing} again from its source"
        ) from error


def brief(error: BaseException) -> str:
    """The reason inside a message of h5py or Zarr, on one line."""
    text = " ".join(str(error).split())
    inner = text[text.find("(") + 1 : text.rfind(")")] if "(" in text else text
    return inner[:120] or type(error).__name__
