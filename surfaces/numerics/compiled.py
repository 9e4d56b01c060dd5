"""How loops are compiled, in one place, and where their machine code is kept.

The machine code is kept on disk, threads run beside it, and no wrapper for callers in C is made:
nobody calls it, and it took a twentieth of the compilation. Numbers are divided as numpy divides
them: a test of each divisor, with its exception, would be compiled too.

Each installation, with its versions of numpy and Numba and its processor, has a folder of its own,
and code is used as long as its sources stay as they were. By itself Numba would notice a change of
the file that holds the loop, but neither a new numpy, whose results are compiled in as constants,
nor a change of a loop or a constant in another file.
"""

from __future__ import annotations

import atexit
import functools
import hashlib
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import llvmlite.binding
import numba
import numpy as np
from numba import njit

from surfaces.errors import InputError

__all__ = [
    "BORROWING",
    "EXTREMES",
    "QUOTIENTS",
    "SUMS",
    "cache_folder",
    "compiled",
    "inner",
    "kept_sources",
    "stamp",
]

SUMS = {"reassoc", "contract", "nsz"}
"""What a loop may do with sums: take terms in another order, fuse products into them, and forget
the sign of zero. Infinities and NaN keep their meaning."""

QUOTIENTS = SUMS | {"arcp"}
"""What a loop may do with sums and quotients: `SUMS`, and multiply by the inverse in place of a
division."""

EXTREMES = SUMS | {"nnan"}
"""What a loop over numbers, none of them NaN, may do with sums, the least and the largest."""

BORROWING: dict[str, Any] = {"_nrt": False}
"""Options of a loop that makes no array: it counts no references to those of its caller. Each count
is an atomic operation, and they made the rays of summits three times as slow."""

_SHARED: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True}
_IMPORTS = re.compile(r"^from (\.*)([\w.]*) import (?:\(([^)]*)\)|(.*))", re.MULTILINE)
_config: Any = numba.config
_loops: list[Any] = []

if _config.DISABLE_JIT:
    raise InputError("NUMBA_DISABLE_JIT is set and the loops run compiled only; unset it")


def compiled(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Decorator of a compiled loop; takes further options of `numba.njit`."""

    own = functools.partial(njit, cache=True, nogil=True, **_SHARED, **options)

    def compile_when_called(function: Callable[..., Any]) -> Any:
        chosen, _config.CACHE_DIR = _config.CACHE_DIR, str(cache_folder())
        try:
            loop: Any = own(function)
        finally:
            _config.CACHE_DIR = chosen
        # kept code with another stamp is not used, and written over; the version is read first, and
        # the rest names classes of arguments that may have moved since
        kept = loop._cache._cache_file
        kept._version = kept._source_stamp = stamp(Path(function.__code__.co_filename))
        _loops.append(loop)
        return loop

    return compile_when_called


inner = functools.partial(njit, no_cpython_wrapper=True, **_SHARED)
"""Decorator of a loop that compiled loops alone call. They hold its code, which is kept with
theirs; no wrapper for callers in Python is made, which took up to half of its compilation."""


@functools.cache
def cache_folder() -> Path:
    """Folder of the compiled code: in NUMBA_CACHE_DIR, or beside this file, or the user's.

    Where none of them can be written, a temporary one, for this process and those that it starts.
    """
    chosen = _config.CACHE_DIR
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    for place in [Path(chosen)] if chosen else [Path(__file__).parent / "__pycache__", user]:
        folder = place / _name()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError:
            continue
        return folder
    temporary = tempfile.mkdtemp(prefix="asperity-")
    atexit.register(shutil.rmtree, temporary, ignore_errors=True)
    folder = Path(temporary, _name())
    folder.mkdir()
    return folder


def _name() -> str:
    """Name of the folder of this installation."""
    binding = llvmlite.binding
    own = [__file__, sys.version, np.__version__, numba.__version__]
    own += [binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten()]
    return f"asperity-{_digest(own)[:16]}"


def kept_sources() -> list[Path]:
    """Files of the loops that this process has compiled or loaded."""
    return sorted({Path(loop.py_func.__code__.co_filename) for loop in _loops if loop.overloads})


@functools.cache
def stamp(source: Path) -> str:
    """Digest of a file and all that it imports of its packages."""
    found: dict[Path, str] = {}
    left = [source]
    while left:
        file = left.pop()
        if file not in found and file.is_file():
            found[file], imports = _read(file)
            left += imports
    return _digest(found[file] for file in sorted(found))


def _digest(parts: Iterable[str]) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


@functools.cache
def _read(file: Path) -> tuple[str, list[Path]]:
    """Text of a file, and the files that it may import."""
    text, imports = file.read_text(encoding="utf-8"), []
    for dots, module, several, one in _IMPORTS.findall(text):
        top = file.parents[len(dots) - 1] if dots else Path(__file__).parents[2]
        place = top.joinpath(*module.split("."))
        names = [name.split(" as ")[0].strip() for name in (several or one).split(",")]
        imports += [place.with_suffix(".py")] if module else []
        imports += [place / f"{name}.py" for name in names if name.isidentifier()]
    return text, imports
