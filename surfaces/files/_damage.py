"""What libraries raise on a file that is damaged or not as its format says, and how it is told."""

from __future__ import annotations

import struct
import zipfile
import zlib
from pathlib import Path
from tokenize import TokenError
from xml.parsers.expat import ExpatError

from surfaces.errors import FileFormatError

__all__ = ["DAMAGED", "brief", "damaged"]

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


def brief(error: BaseException) -> str:
    """The reason inside a message of h5py or Zarr, on one line."""
    text = " ".join(str(error).split())
    inner = text[text.find("(") + 1 : text.rfind(")")] if "(" in text else text
    return inner[:120] or type(error).__name__
