"""The first run on a machine: loops compiled in several processes at once.

Numba compiles on one processor and keeps the machine code on disk, from where every later run
takes it. On a machine that has none yet, parts that do not need each other are compiled side by
side, each in a process of its own (`asperity.warmup`).
"""

from __future__ import annotations

import fcntl
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from surfaces._compiled import cache_folder, kept_sources, stamp
from surfaces._threads import available

__all__ = ["CURVE", "compile_ahead", "compiling"]

CURVE = ("contacts", "laws", "basins", "summits")
"""Parts of a contact curve, in an order that shares the work (14, 11, 4 and 8 s) among two or four
processors: each takes every second of them, or one."""

_MESSAGE = "asperity: compiling for this machine, about 30 s, once\n"
_compiled: set[str] = set()


def compile_ahead(*parts: str) -> None:
    """Compile the loops of some parts, as far as the disk does not hold their code.

    Says so in one line on standard error if there is anything to compile. A part that fails is
    left to the run itself, which compiles what it meets.

    Parameters
    ----------
    parts
        Some of "contacts" (their interaction), "laws" (law tables of summits), "summits" (plan,
        peaks and summits of a map), "basins" (basins pressed alone) and "bem" (boundary elements).
    """
    if _missing(parts):
        with _alone():
            missing = _missing(parts)  # another process may have compiled them meanwhile
            if missing and sys.stderr is not None:
                sys.stderr.write(_MESSAGE)
            _compile(missing)
    _compiled.update(parts)


@contextmanager
def compiling(part: str) -> Iterator[None]:
    """Compile a part within this process, which starts no other, and note that it is done."""
    _compiled.update({part, *CURVE})
    yield
    stamps = {str(source): stamp(source) for source in kept_sources()}
    _note(part).write_text(json.dumps(stamps), encoding="utf-8")


def _missing(parts: tuple[str, ...]) -> list[str]:
    return [part for part in parts if part not in _compiled and not _on_disk(part)]


def _on_disk(part: str) -> bool:
    """Whether a part was compiled from files and versions as they are now."""
    try:
        stamps = json.loads(_note(part).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return all(stamp(Path(source)) == found for source, found in stamps.items())


def _note(part: str) -> Path:
    return cache_folder() / f"{part}.json"


@contextmanager
def _alone() -> Iterator[None]:
    """Let one process compile at a time: of several that start together the others wait."""
    with open(cache_folder() / "lock", "w") as lock:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _compile(parts: list[str]) -> None:
    """Compile parts in as many processes as there are processors, each several parts in turn."""
    # a copy of the package in the working folder would be compiled instead of this one
    home = str(Path(__file__).parents[1])
    paths = os.pathsep.join(filter(None, (home, os.environ.get("PYTHONPATH"))))
    keeps = {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(cache_folder().parent)}
    count = min(len(parts), available())
    children = [
        subprocess.Popen(
            [sys.executable, "-P", "-m", f"{__package__}.warmup", *parts[k::count]],
            env=os.environ | keeps,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for k in range(count)
    ]
    try:
        for child in children:
            child.wait()
    finally:  # of an interrupted run; those that have ended are left alone
        for child in children:
            child.terminate()
            child.wait()
