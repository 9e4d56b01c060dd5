"""Files that appear only when they are complete, folders for them, and what their names say."""

from __future__ import annotations

import contextlib
import os
import stat
import threading
import zlib
from collections.abc import Iterator
from pathlib import Path

from surfaces.errors import InputError, as_path

__all__ = ["NOT_HDF5", "make_folder", "replacing", "require_replaceable"]

NOT_HDF5 = (".npz", ".txt", ".csv")
"""Suffixes of maps that are written in other formats than HDF5."""


def require_replaceable(path: str | os.PathLike[str]) -> Path:
    """Where a file of this name is written: links are followed.

    Raises
    ------
    InputError
        If the name cannot be one, or stands for what a file must not replace: a folder, a device,
        a pipe.
    """
    target = Path(os.path.realpath(as_path(path)))  # which does not mind links in a circle
    if os.fspath(path).endswith("/"):
        raise InputError(f"{path}: cannot be written, it is the name of a folder")
    try:
        if not stat.S_ISREG(target.stat().st_mode):
            kind = "folder" if target.is_dir() else "device or a pipe"
            raise InputError(f"{path}: cannot be written, it is a {kind}")
    except FileNotFoundError:
        pass
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error
    return target


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Temporary file beside `path` that takes its place when the block ends without an error.

    Raises
    ------
    InputError
        If either cannot be written; what stood at `path` is then untouched.
    """
    target = require_replaceable(path)
    name, writer = zlib.crc32(os.fsencode(target.name)), f"{os.getpid()}-{threading.get_ident()}"
    part = target.with_name(f".{name:x}.{writer}.part")
    try:
        part.touch()
        yield part
        os.replace(part, target)
    except (OSError, RuntimeError) as error:  # the second where HDF5 closes a file on a full disk
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise InputError(f"{path}: cannot be written ({reason})") from error
    finally:
        with contextlib.suppress(OSError):
            part.unlink()


def make_folder(folder: str | os.PathLike[str]) -> None:
    """Make a folder for results, with those around it, where it does not exist.

    Raises
    ------
    InputError
        If it cannot be made.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from error
