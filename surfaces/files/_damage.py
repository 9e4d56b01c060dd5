"""What libraries raise on a file that is damaged or not as its format says, and how it is told."""

from __future__ import annotations

import struct
import zipfile
import zlib
from pathlib import Path
from tokenize import TokenError
from xml.parsers.expat import ExpatError

from surfaces.errors import FileFormatError

__all__ = ["DAMAGED", "damaged"]

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
    TokenError,
    TypeError,
    ValueError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)
"""Errors of NumPy, zipfile and the readers of instruments' files, by experience with mutated files;
those of HDF5 are in `_schema`."""


def damaged(path: Path, error: Exception, hint: str = "") -> FileFormatError:
    """One sentence about a file of which a library raised an error."""
    reason = " ".join(f"{type(error).__name__}: {error}".split())[:120]
    return FileFormatError(f"{path}: damaged, or not as its format says ({reason}){hint}")
