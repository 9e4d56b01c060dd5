"""What libraries raise on a file that is damaged or not as its format says, and how it is told."""

from __future__ import annotations

import re
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tokenize import TokenError
from xml.parsers.expat import ExpatError

from surfaces.errors import AsperityError, FileFormatError

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

_OF_HDF5 = re.compile(r"\W*(?:Unable to|Can't) [^(]*\((.*)\)")


@contextmanager
def naming_damage(
    path: Path,
    what: str = "damaged, or not as its format says",
    hint: str = "; copy it again from its source",
    also: tuple[type[Exception], ...] = (),
) -> Iterator[None]:
    """Turn what a library raises on a damaged file, or `also` raises, into one sentence about it,
    which ends with a hint."""
    try:
        yield
    except AsperityError:
        raise
    except (BlockingIOError, PermissionError) as error:
        why = "no permission"
        if isinstance(error, BlockingIOError):
            why = "another program is writing it; wait, or close it there"
        raise FileFormatError(f"{path}: cannot be read, {why}") from error
    except DAMAGED + also as error:
        raise FileFormatError(f"{path}: {what} ({brief(error)}){hint}") from error


def brief(error: BaseException) -> str:
    """The reason of an error on one line; that of HDF5 stands in brackets behind what it did."""
    text = " ".join(str(error).split())
    inside = _OF_HDF5.match(text)
    return (inside[1] if inside else text)[:120] or type(error).__name__
