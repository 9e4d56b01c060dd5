"""Files that appear only when they are complete."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from .errors import InputError

__all__ = ["replacing"]


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Temporary file beside `path` that takes its place when the block ends without an error.

    Raises
    ------
    InputError
        If either cannot be written; what stood at `path` is then untouched.
    """
    target = Path(path)
    part = target.parent / f".{target.name}.{os.getpid()}.part"
    try:
        part.touch()
        yield part
        os.replace(part, target)
    except OSError as error:
        reason = error.strerror or " ".join(str(error).split())
        raise InputError(f"{path}: cannot be written ({reason})") from error
    finally:
        with contextlib.suppress(OSError):
            part.unlink()
